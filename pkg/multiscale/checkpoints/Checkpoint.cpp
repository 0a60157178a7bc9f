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

	[[noreturn]] void refuse(const std::string& file, const std::string& why) { throw std::invalid_argument("checkpoint '" + file + "' " + why); }

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

	const std::map<std::string, std::string>& classLayouts()
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

	std::string toText(const CheckpointHeader& h)
	{
		std::ostringstream text;
		text << firstLine << "\nformat " << h.format << "\nwritten " << h.written << "\nstep " << h.step << "\ntime " << std::setprecision(17) << h.time
		     << "\nbytes " << h.bytes << "\nparts " << h.parts << "\nchecksum " << hexadecimal(h.checksum) << "\n";
		for (const auto& [name, layout] : h.classes)
			text << "class " << name << " " << layout << "\n";
		text << "end\n";
		if (text.str().size() > headerLength) throw std::logic_error("the header of a checkpoint is too short for its classes");
		return text.str();
	}

	CheckpointHeader readHeader(const std::string& file, std::istream& stream)
	{
		std::string text(headerLength, '\0');
		stream.read(&text[0], headerLength);
		const bool ours = text.compare(0, std::strlen(firstLine), firstLine) == 0;
		if (!ours) refuse(file, "is not a checkpoint: give a file that talik.checkpoint wrote; other scenes are loaded by O.load");
		if (std::size_t(stream.gcount()) < headerLength) refuse(file, "is truncated: take an earlier one");
		CheckpointHeader   h;
		std::istringstream lines(text.substr(std::strlen(firstLine)));
		std::string        key;
		while (lines >> key && key != "end") {
			if (key == "format") lines >> h.format;
			else if (key == "step") lines >> h.step;
			else if (key == "time") lines >> h.time;
			else if (key == "bytes") lines >> h.bytes;
			else if (key == "parts") lines >> h.parts;
			else if (key == "checksum") lines >> std::hex >> h.checksum >> std::dec;
			else if (key == "written") std::getline(lines >> std::ws, h.written);
			else if (key == "class") {
				std::string name, layout;
				lines >> name >> layout;
				h.classes[name] = layout;
			}
		}
		if (h.format != currentFormat)
			refuse(file,
			       "has format " + std::to_string(h.format) + ", written " + h.written + "; this Talik reads format "
			               + std::to_string(currentFormat) + ": resume it with the version that wrote it");
		if (key != "end") refuse(file, "is damaged in its first lines: take an earlier one");
		return h;
	}

	// ---- reading --------------------------------------------------------------------------------------------------------

	/// Reads what follows the header, piece by piece.
	template <class Piece> void overScene(std::istream& stream, std::uint64_t bytes, Piece&& piece)
	{
		std::vector<char> buffer(std::size_t(1) << 20);
		while (bytes > 0 && stream) {
			stream.read(buffer.data(), std::streamsize(std::min<std::uint64_t>(buffer.size(), bytes)));
			piece(buffer.data(), std::size_t(stream.gcount()));
			bytes -= std::uint64_t(stream.gcount());
		}
	}

	void requireWhole(const std::string& file, const CheckpointHeader& h, std::istream& stream)
	{
		const std::uint64_t length = std::filesystem::file_size(file);
		if (length < headerLength + h.bytes)
			refuse(file,
			       "is truncated, " + std::to_string(length) + " of " + std::to_string(headerLength + h.bytes)
			               + " bytes are there: take an earlier one");
		if (length > headerLength + h.bytes) refuse(file, "is longer than what was written: take an earlier one");
		Checksum checksum;
		overScene(stream, h.bytes, [&](const char* data, std::size_t count) { checksum.process_bytes(data, count); });
		if (checksum.checksum() != h.checksum) refuse(file, "is damaged, its checksum does not fit: take an earlier one");
	}

	/// Classes of the checkpoint that have other attributes here. Archives name the classes of what they hold.
	std::string changedClasses(const CheckpointHeader& h, std::istream& stream)
	{
		std::vector<std::pair<std::string, bool>> changed;
		for (const auto& [name, layout] : h.classes) {
			const auto here = classLayouts().find(name);
			if (here == classLayouts().end() || here->second != layout) changed.push_back({ name, false });
		}
		if (changed.empty()) return "";
		std::string tail; // a name may lie across two pieces
		overScene(stream, h.parts, [&](const char* data, std::size_t count) {
			tail.append(data, count);
			for (auto& [name, held] : changed)
				held = held || tail.find("yade::" + name) != std::string::npos;
			tail.erase(0, tail.size() > 256 ? tail.size() - 256 : 0);
		});
		std::string names;
		for (const auto& [name, held] : changed)
			if (held) names += (names.empty() ? "" : ", ") + name;
		return names;
	}

	std::ifstream openFile(const std::string& file)
	{
		std::error_code error;
		if (!std::filesystem::exists(file, error)) refuse(file, "does not exist: give a file that talik.checkpoint wrote");
		if (!std::filesystem::is_regular_file(file, error)) refuse(file, "is not a file: give one that talik.checkpoint wrote");
		std::ifstream stream(file, std::ios::binary);
		if (!stream) refuse(file, std::string("cannot be read (") + std::strerror(errno) + "): give a file of yours");
		return stream;
	}

} // namespace

std::vector<std::string>& checkpointClasses()
{
	static std::vector<std::string> names;
	return names;
}

namespace {
	/// Behind the archive, by each rank what it has. Returns the checksum of the whole.
	std::uint64_t writeParts(AtomicFile& file, const CheckpointParts& parts, CheckpointHeader& h)
	{
		constexpr std::uint64_t page = 4096;
		h.parts                      = (file.bytes() + page - 1) / page * page;
		h.bytes                      = h.parts + parts.bytes();
		file.extend(h.bytes);
		PartSum sum;
		try {
			sum.add(parts.write({ file.path(), headerLength + h.parts, headerLength + h.bytes }));
		} catch (const std::runtime_error& problem) {
			file.fail(problem.what());
		}
		return sum.checksum(file.checksum(), h.bytes - file.bytes());
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
	CheckpointHeader h;
	h.checksum = writeParts(beside, parts, h);
	h.format   = currentFormat;
	h.step     = scene->iter;
	h.time     = scene->time;
	h.written  = now();
	h.classes  = classLayouts();
	beside.commit(toText(h));
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

CheckpointHeader inspectCheckpoint(const std::string& file)
{
	std::ifstream          stream = openFile(file);
	const CheckpointHeader h      = readHeader(file, stream);
	requireWhole(file, h, stream);
	return h;
}

boost::shared_ptr<Scene> readCheckpoint(const std::string& file)
{
	const CheckpointHeader h      = inspectCheckpoint(file);
	std::ifstream          stream = openFile(file);
	stream.seekg(headerLength);
	const std::string changed = changedClasses(h, stream);
	if (!changed.empty())
		refuse(file,
		       "was written " + h.written + " by a Talik in which " + changed + " had other attributes: resume it with that version, or start anew");
	stream.clear();
	stream.seekg(headerLength);
	const CheckpointParts::Source  parts { std::make_shared<PartedFile>(file, PartedFile::For::reading), headerLength + h.parts };
	const CheckpointParts::Reading large(parts);
	try {
		boost::archive::binary_iarchive archive(stream);
		boost::shared_ptr<Scene>        scene;
		archive >> boost::serialization::make_nvp("scene", scene);
		return scene;
	} catch (const boost::archive::archive_exception& problem) {
		refuse(file, std::string("cannot be read (") + problem.what() + "): resume it with the YADE and the plugins that wrote it");
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
