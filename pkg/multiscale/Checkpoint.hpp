// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <chrono>
#include <core/GlobalEngine.hpp>
#include <lib/serialization/Serializable.hpp>

namespace yade {

/// Writes the whole scene into a file now and then, on the wall clock, so that a run that was killed goes on from there.
class Checkpoint : public GlobalEngine {
public:
	virtual ~Checkpoint() {};
	void action() override;

	static void                  write(const string& file);
	static shared_ptr<Scene>     read(const string& file);
	static ::boost::python::dict describe(const string& file);

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
