// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <chrono>
#include <core/GlobalEngine.hpp>
#include <core/Scene.hpp>
#include <cstdint>
#include <lib/serialization/Serializable.hpp>
#include <map>
#include <string>
#include <vector>

namespace talik {

/// Names of the classes whose attributes a checkpoint depends on beside those of stock YADE; set when they are registered.
std::vector<std::string>& checkpointClasses();
/// Digest of the attributes of each of them.
const std::map<std::string, std::string>& checkpointLayouts();

/// Writes a scene beside `file` and renames it when it is on the disk whole: whatever happens, `file` is the former checkpoint or the
/// new one. A missing folder is made. Throws std::runtime_error that names file and cause; nothing is left of a failed attempt.
void writeCheckpoint(const std::string& file, const boost::shared_ptr<yade::Scene>& scene);

/// Throws std::invalid_argument naming the file and what may be done when a checkpoint cannot be written there.
void requireWritable(const std::string& file);

/// Checksum of a part of a file.
std::uint64_t checksumOfFile(const std::string& file, std::uint64_t from, std::uint64_t bytes);

/// The scene of a checkpoint that talik._checkpointfile has found whole; its parts begin after so many bytes of what follows the header.
boost::shared_ptr<yade::Scene> readCheckpoint(const std::string& file, std::uint64_t parts);

} // namespace talik

namespace yade {

/// Writes the whole scene into a file now and then, on the wall clock, so that a run that was killed goes on from there.
class Checkpoint : public GlobalEngine {
public:
	virtual ~Checkpoint() {};
	void action() override;

	static void                    write(const string& file);
	static ::boost::python::object read(const string& file);
	static ::boost::python::object describe(const string& file);

private:
	using Clock = std::chrono::steady_clock;
	void start();
	bool isDue() const;
	void tryToWrite();

	bool              started         = false;
	int               signalsAnswered = 0;
	Clock::time_point last;
	long              done = 0, failures = 0;
	string            problem;

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(Checkpoint,GlobalEngine,"Writes the whole scene into a file on a wall-clock interval, at the beginning of a step and "
			"therefore as the first of the engines. The file is replaced only by one that is complete. If it cannot be written (disk full, folder gone) the run goes "
			"on, says so once, and tries again. See talik.checkpoint.keep and talik.resume. Example: "
			"O.engines=[Checkpoint(file='output/slope.checkpoint',every=600),mpm].",
		((string,file,"",,"Where the scene is written; the folder is made if it is missing."))
		((Real,every,600,,"Wall time between the end of one checkpoint and the next [s], >= 0; 0: in every step."))
		((int,onSignal,0,,"A signal upon which the scene is written at once, too, as a batch system sends it before the time limit of a job: signal.SIGUSR1 or "
				"signal.SIGUSR2 of Python; 0: none."))
		,/*ctor*/ ,
		/*py*/
		.def("write",&Checkpoint::write,(::boost::python::arg("file")),"Write the current scene now. RuntimeError while O runs, or if the file cannot be "
				"written.").staticmethod("write")
		.def("read",&Checkpoint::read,(::boost::python::arg("file")),"The Scene in a checkpoint; see talik.resume. ValueError for a missing, foreign, truncated or "
				"damaged file and for one of a version that cannot be read.").staticmethod("read")
		.def("describe",&Checkpoint::describe,(::boost::python::arg("file")),"Dictionary with format, written, step, time, bytes of a checkpoint that is whole; "
				"ValueError otherwise.").staticmethod("describe")
		.def_readonly("written",&Checkpoint::done,"Checkpoints written since the engine started.")
		.def_readonly("failures",&Checkpoint::failures,"Attempts that failed since the engine started.")
		.def_readonly("problem",&Checkpoint::problem,"Why the last attempt failed; empty if it did not.")
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(Checkpoint);

} // namespace yade
