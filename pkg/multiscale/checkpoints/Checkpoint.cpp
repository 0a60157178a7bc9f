// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <lib/factory/ClassFactory.hpp>
#include <pkg/base/SavedBytes.hpp>
#include <pkg/multiscale/checkpoints/Checkpoint.hpp>
#include <pkg/multiscale/checkpoints/CheckpointParts.hpp>
#include <pkg/python/ScriptValues.hpp>
#include <pkg/python/StepGate.hpp>
#include <pkg/ranks/Communicator.hpp>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <sstream>

namespace py = boost::python;

namespace talik {
using yade::Scene;

namespace {
	constexpr int         currentFormat = 3;
	constexpr std::size_t headerLength  = 4096;
	const char            firstLine[]   = "Talik checkpoint";

	/// A step that has only begun is written as not begun; in a periodic scene the cell has moved already, there it stays begun.
	/// The measured speed of the run is left out: equal states give equal files.
	class BetweenSteps {
	public:
		explicit BetweenSteps(Scene& s)
		        : scene(s)
		        , subStep(s.subStep)
		        , speed(s.speed)
		{
			if (!s.isPeriodic && !s.subStepping) s.subStep = -1;
			s.speed = 0;
		}
		~BetweenSteps()
		{
			scene.subStep = subStep;
			scene.speed   = speed;
		}

	private:
		Scene&           scene;
		const int        subStep;
		const yade::Real speed;
	};

	// ---- classes --------------------------------------------------------------------------------------------------------

	/// Names of all tags of an XML archive, in their order.
	std::string tags(const std::string& xml)
	{
		std::string names;
		for (std::size_t at = xml.find('<'); at != std::string::npos; at = xml.find('<', at + 1))
			if (std::isalpha(static_cast<unsigned char>(xml[at + 1]))) names.append(xml, at, xml.find_first_of(" >\t\n", at) - at);
		return names;
	}

	std::string layoutOf(const std::string& name)
	{
		const auto instance = boost::dynamic_pointer_cast<yade::Serializable>(yade::ClassFactory::instance().createShared(name));
		if (!instance) return "";
		boost::shared_ptr<Scene> scene(new Scene);
		scene->miscParams.push_back(instance);
		std::ostringstream xml;
		{
			boost::archive::xml_oarchive archive(xml);
			archive << boost::serialization::make_nvp("scene", scene);
		}
		const std::string  text  = xml.str();
		const std::size_t  first = text.find("<miscParams");
		const std::string  names = tags(text.substr(first, text.find("</miscParams>") - first));
		boost::crc_32_type digest;
		digest.process_bytes(names.data(), names.size());
		return hexadecimal(digest.checksum()).substr(8);
	}

} // namespace

const std::map<std::string, std::string>& checkpointLayouts()
{
	static const std::map<std::string, std::string> layouts = [] {
		std::map<std::string, std::string> found;
		for (const auto& name : checkpointClasses()) {
			const std::string layout = layoutOf(name);
			if (!layout.empty()) found[name] = layout;
		}
		return found;
	}();
	return layouts;
}

namespace {
	// ---- header ---------------------------------------------------------------------------------------------------------

	std::string now()
	{
		const std::time_t clock = std::time(nullptr);
		std::tm           parts {};
		gmtime_r(&clock, &parts);
		char text[32];
		std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &parts);
		return text;
	}

	/// First part of a checkpoint, plain text of fixed length: what follows, how many bytes, and after how many of them, the archive of the scene, parts
	/// begin, see CheckpointParts. talik._checkpointfile reads it.
	std::string headerOf(const Scene& scene, std::uint64_t bytes, std::uint64_t parts, std::uint64_t checksum)
	{
		std::ostringstream text;
		text << firstLine << "\nformat " << currentFormat << "\nwritten " << now() << "\nstep " << scene.iter << "\ntime " << std::setprecision(17)
		     << scene.time << "\nbytes " << bytes << "\nparts " << parts << "\nchecksum " << hexadecimal(checksum) << "\n";
		for (const auto& [name, layout] : checkpointLayouts())
			text << "class " << name << " " << layout << "\n";
		text << "end\n";
		if (text.str().size() > headerLength) throw std::logic_error("the header of a checkpoint is too short for its classes");
		return text.str();
	}

} // namespace

std::vector<std::string>& checkpointClasses()
{
	static std::vector<std::string> names;
	return names;
}

namespace {
	/// Behind the archive, by each rank what it has, after so many bytes of the whole. Returns the checksum of the whole.
	std::uint64_t writeParts(AtomicFile& file, const CheckpointParts& parts, std::uint64_t begin)
	{
		const std::uint64_t whole = begin + parts.bytes();
		file.extend(whole);
		PartSum sum;
		try {
			sum.add(parts.write({ file.path(), headerLength + begin, headerLength + whole }));
		} catch (const std::runtime_error& problem) {
			file.fail(problem.what());
		}
		return sum.checksum(file.checksum(), whole - file.bytes());
	}
} // namespace

void writeCheckpoint(const std::string& file, const boost::shared_ptr<Scene>& scene)
{
	AtomicFile      beside("checkpoint", file, headerLength, bool(jobCommunicator()));
	CheckpointParts parts;
	try {
		const CheckpointParts::Writing  large(parts);
		const BetweenSteps              whole(*scene);
		boost::archive::binary_oarchive archive(beside);
		boost::shared_ptr<Scene>        held = scene;
		archive << boost::serialization::make_nvp("scene", held);
	} catch (const boost::archive::archive_exception& problem) {
		beside.fail(beside.problem() ? std::strerror(beside.problem()) : problem.what());
	}
	if (!beside.flush()) beside.fail(std::strerror(beside.problem()));
	constexpr std::uint64_t page     = 4096;
	const std::uint64_t     begin    = (beside.bytes() + page - 1) / page * page;
	const std::uint64_t     checksum = writeParts(beside, parts, begin);
	beside.commit(headerOf(*scene, begin + parts.bytes(), begin, checksum));
}

void requireWritable(const std::string& file)
{
	if (file.empty()) throw std::invalid_argument("Checkpoint.file is empty: give the name of a file, e.g. 'output/slope.checkpoint'.");
	std::error_code error;
	if (std::filesystem::is_directory(file, error))
		throw std::invalid_argument("Checkpoint.file is '" + file + "', a folder: give the name of a file in it.");
	try {
		const AtomicFile probe("checkpoint", file, headerLength);
		if (probe.problem()) probe.fail(std::strerror(probe.problem()));
	} catch (const std::runtime_error& problem) {
		throw std::invalid_argument("Checkpoint.file is '" + file + "': " + problem.what() + "; choose a file in a folder of yours.");
	}
}

std::uint64_t checksumOfFile(const std::string& file, std::uint64_t from, std::uint64_t bytes)
{
	std::ifstream     stream(file, std::ios::binary);
	std::vector<char> buffer(std::size_t(1) << 20);
	Checksum          checksum;
	stream.seekg(std::streamoff(from));
	while (bytes > 0 && stream) {
		stream.read(buffer.data(), std::streamsize(std::min<std::uint64_t>(buffer.size(), bytes)));
		checksum.process_bytes(buffer.data(), std::size_t(stream.gcount()));
		bytes -= std::uint64_t(stream.gcount());
	}
	return checksum.checksum();
}

boost::shared_ptr<Scene> readCheckpoint(const std::string& file, std::uint64_t begin)
{
	std::ifstream stream(file, std::ios::binary);
	stream.seekg(headerLength);
	const CheckpointParts::Source  parts { std::make_shared<PartedFile>(file, PartedFile::For::reading), headerLength + begin };
	const CheckpointParts::Reading large(parts);
	try {
		boost::archive::binary_iarchive archive(stream);
		boost::shared_ptr<Scene>        scene;
		archive >> boost::serialization::make_nvp("scene", scene);
		return scene;
	} catch (const boost::archive::archive_exception& problem) {
		throw std::invalid_argument(
		        "checkpoint '" + file + "' cannot be read (" + problem.what() + "): resume it with the YADE and the plugins that wrote it");
	}
}

} // namespace talik

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
	if (!(every >= 0)) throw std::invalid_argument("Checkpoint.every is " + talik::asText(every) + ": give 0 or more seconds.");
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
		++done;
	} catch (const std::runtime_error& failure) {
		++failures;
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

py::object Checkpoint::read(const string& file) { return py::import("talik._checkpointfile").attr("read")(file); }
py::object Checkpoint::describe(const string& file) { return py::import("talik._checkpointfile").attr("describe")(file); }

} // namespace yade
