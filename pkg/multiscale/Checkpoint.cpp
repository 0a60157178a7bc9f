// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <csignal>
#include <iostream>
#include <pkg/multiscale/Checkpoint.hpp>
#include <pkg/multiscale/CheckpointFile.hpp>
#include <pkg/ranks/RankTalk.hpp>
#include <pkg/rve/open/StepGate.hpp>

namespace py = boost::python;

namespace yade {
YADE_PLUGIN((Checkpoint));

namespace {
	volatile std::sig_atomic_t signalsSoFar = 0;

	extern "C" void countSignal(int) { signalsSoFar = signalsSoFar + 1; }

	void listenTo(int number)
	{
		struct sigaction listening {};
		listening.sa_handler = countSignal;
		listening.sa_flags   = SA_RESTART; // files that are being read or written do not notice
		sigaction(number, &listening, nullptr);
	}
} // namespace

void Checkpoint::start()
{
	if (!(every >= 0)) throw std::invalid_argument("Checkpoint.every is " + boost::lexical_cast<string>(every) + ": give 0 or more seconds.");
	if (onSignal != 0 && onSignal != SIGUSR1 && onSignal != SIGUSR2)
		throw std::invalid_argument(
		        "Checkpoint.onSignal is " + std::to_string(onSignal) + ": give signal.SIGUSR1, signal.SIGUSR2, or 0 for none; others end a process.");
	if (scene->engines.empty() || scene->engines.front().get() != this)
		throw std::invalid_argument(
		        "Checkpoint is not the first of O.engines: put it first, or use talik.checkpoint.keep(file); later engines find a step half done.");
	if (talik::isFirstRank()) talik::requireWritable(file);
	if (onSignal != 0) listenTo(onSignal);
	signalsAnswered = signalsSoFar;
	started         = true;
	last            = Clock::now();
}

bool Checkpoint::isDue() const
{
	const bool asked = onSignal != 0 && signalsSoFar != signalsAnswered;
	return asked || every == 0 || std::chrono::duration<double>(Clock::now() - last).count() >= every;
}

void Checkpoint::action()
{
	const talik::StepGate gate;
	if (!started) start();
	if (!talik::isFirstRank()) return; // the first one asks the others for what it lacks
	if (!isDue()) return;
	signalsAnswered = signalsSoFar;
	tryToWrite();
	last = Clock::now();
}

void Checkpoint::tryToWrite()
{
	const bool saidBefore = !problem.empty();
	try {
		talik::writeCheckpoint(file, Omega::instance().getScene());
		problem.clear();
		done++;
	} catch (const std::runtime_error& failure) {
		failures++;
		problem = failure.what();
		if (!saidBefore) std::cerr << problem << "; the run goes on and tries again." << std::endl;
	}
}

void Checkpoint::write(const string& file)
{
	if (Omega::instance().isRunning())
		throw std::runtime_error("Checkpoint.write needs a paused simulation: call O.pause() first, or use talik.checkpoint.keep(file).");
	if (!talik::isFirstRank()) return;
	talik::requireWritable(file);
	talik::writeCheckpoint(file, Omega::instance().getScene());
}

shared_ptr<Scene> Checkpoint::read(const string& file) { return talik::readCheckpoint(file); }

py::dict Checkpoint::describe(const string& file)
{
	const auto header = talik::inspectCheckpoint(file);
	py::dict   d;
	d["format"]  = header.format;
	d["written"] = header.written;
	d["step"]    = header.step;
	d["time"]    = header.time;
	d["bytes"]   = header.bytes;
	return d;
}

} // namespace yade
