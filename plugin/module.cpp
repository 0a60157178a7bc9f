// SPDX-License-Identifier: GPL-2.0-or-later
/// Entry of the Python module talik._talik: checks the running YADE, registers our classes into it, hands out what needs C++.
#include "InterfaceCheck.hpp"
#include "ShearTest.hpp"

#include <boost/python/numpy.hpp>
#include <core/Omega.hpp>
#include <core/Scene.hpp>
#include <omp.h>
#include <pkg/common/OpenGLRenderer.hpp>
#include <pkg/multiscale/checkpoints/Checkpoint.hpp>
#include <pkg/multiscale/engine/MpmEngine.hpp>
#include <pkg/python/HeldObject.hpp>
#include <pkg/python/StepGate.hpp>
#include <pkg/ranks/Communicator.hpp>
#include <pkg/rve/open/ScenePacking.hpp>
#include <pkg/rve/packed/PackedStepView.hpp>
#include <sstream>

TALIK_STOCK_POINTER(yade::Serializable, pointer_iserializer, binary_iarchive)
TALIK_STOCK_POINTER(yade::Serializable, pointer_oserializer, binary_oarchive)

namespace py = boost::python;
using namespace yade;

namespace talik {

namespace {

	[[noreturn]] void raise(PyObject* type, const std::string& message)
	{
		PyErr_SetString(type, message.c_str());
		py::throw_error_already_set();
		throw std::logic_error(message);
	}

	/// Names announced by our sources that YADE's class database does not hold yet.
	std::list<std::string> unregisteredClasses()
	{
		std::list<std::string> names;
		const auto&            known = Omega::instance().getDynlibsDescriptor();
		for (const auto& name : ClassFactory::instance().pluginClasses)
			if (!known.count(name)) names.push_back(name);
		return names;
	}

	/// loadPlugins registers every announced class: without the exchange all of stock YADE would be registered twice.
	void registerIntoRunningYade(std::list<std::string> ours)
	{
		auto& announced = ClassFactory::instance().pluginClasses;
		auto  all       = announced;
		announced.swap(ours);
		Omega::instance().loadPlugins({});
		announced.swap(all);
	}

	/// Of YADE's own classes those by which scenes and engines hold what a script gave them, ours among it.
	void holdScriptsObjects()
	{
		HeldPointer<Serializable>::registerOnce();
		HeldPointer<Engine>::registerOnce();
		HeldPointer<Scene>::registerOnce();
		HeldPointer<Body>::registerOnce();
	}

	py::list registerClasses()
	{
		const std::string mismatch = interfaceMismatch();
		if (!mismatch.empty()) raise(PyExc_ImportError, mismatch);
		const auto ours = unregisteredClasses();
		holdScriptsObjects();
		if (!ours.empty()) registerIntoRunningYade(ours);
		checkpointClasses().insert(checkpointClasses().end(), ours.begin(), ours.end());
		return listOf(ours);
	}

	void refuseWhileRunning(const char* what)
	{
		if (Omega::instance().isRunning()) raise(PyExc_RuntimeError, std::string(what) + " needs a paused simulation: call O.pause() first.");
	}

	/// Steps in Python's own thread, of which O.running says nothing.
	int stepsUnderWay = 0;
	struct StepUnderWay {
		StepUnderWay() { ++stepsUnderWay; }
		~StepUnderWay() { stepsUnderWay--; }
	};

	py::object callAsStep(const py::object& step)
	{
		const StepUnderWay underWay;
		return step();
	}

	/// The gate is left whatever the call ends with, an interrupt from the keyboard too.
	py::object callBetweenSteps(const py::object& function, const py::tuple& positional, const py::dict& named)
	{
		const StepGate gate;
		return py::object(py::handle<>(PyObject_Call(function.ptr(), positional.ptr(), named.ptr())));
	}

	/// Makes another Scene the current one of O and returns the former; the 3-D view follows.
	shared_ptr<Scene> exchangeScene(const shared_ptr<Scene>& scene)
	{
		refuseWhileRunning("Changing the current scene");
		if (!scene) raise(PyExc_ValueError, "exchangeScene: the scene is None; give a Scene.");
		Omega&                      omega = Omega::instance();
		std::lock_guard<std::mutex> undrawn(omega.renderMutex);
		const shared_ptr<Scene>     former = omega.getScene();
		omega.setScene(scene);
		return former;
	}

	/// Stock YADE writes beyond the storage of a scene that is stepped by more threads than it was made with.
	void refuseFewerThreads(const shared_ptr<Scene>& scene)
	{
		if (!scene) raise(PyExc_ValueError, "refuseFewerThreads: the scene is None; give a Scene.");
		if (scene->forces.getNumAllocatedThreads() >= omp_get_max_threads()) return;
		raise(PyExc_RuntimeError,
		      "The scene was made to be stepped by fewer threads than O has: show a copy, as OpenRveSample.open() or RveSkeleton.scene(id) give it, or "
		      "start yade with -j1.");
	}

	std::string bytesOf(const py::object& bytes)
	{
		char*      data = nullptr;
		Py_ssize_t size = 0;
		if (PyBytes_AsStringAndSize(bytes.ptr(), &data, &size) < 0) py::throw_error_already_set();
		return std::string(data, std::size_t(size));
	}

	py::object asBytes(const std::string& bytes) { return py::object(py::handle<>(PyBytes_FromStringAndSize(bytes.data(), Py_ssize_t(bytes.size())))); }

	/// Everything that YADE saves of a scene: equal bytes mean that nothing was done to it.
	py::object sceneBytes(const shared_ptr<Scene>& scene)
	{
		if (!scene) raise(PyExc_ValueError, "sceneBytes: the scene is None; give a Scene.");
		return asBytes(sceneToBytes(scene));
	}

	/// One object with all that it holds, as YADE archives it.
	py::object objectToBytes(const shared_ptr<Serializable>& object)
	{
		if (!object) raise(PyExc_ValueError, "objectToBytes: the object is None.");
		std::ostringstream stream;
		{
			boost::archive::binary_oarchive archive(stream);
			archive << boost::serialization::make_nvp("object", object);
		}
		return asBytes(stream.str());
	}

	shared_ptr<Serializable> objectFromBytes(const py::object& bytes)
	{
		std::istringstream              stream(bytesOf(bytes));
		boost::archive::binary_iarchive archive(stream);
		shared_ptr<Serializable>        object;
		archive >> boost::serialization::make_nvp("object", object);
		return object;
	}

	shared_ptr<Scene> readScene(const py::object& content, bool xml) { return sceneFromFile(bytesOf(content), xml); }

	shared_ptr<Scene> emptyScene()
	{
		shared_ptr<Scene> scene(new Scene);
		scene->fillDefaultTags();
		return scene;
	}

	/// One OpenMP thread for the code in its scope.
	struct SingleThread {
		const int before = omp_get_max_threads();
		SingleThread() { omp_set_num_threads(1); }
		~SingleThread() { omp_set_num_threads(before); }
	};

	void renewRenderer(const shared_ptr<OpenGLRenderer>& renderer)
	{
		if (!renderer) raise(PyExc_ValueError, "renewRenderer: the renderer is None; give yade.qt.Renderer().");
		std::lock_guard<std::mutex> undrawn(Omega::instance().renderMutex);
		renderer->init();
	}

	struct WithoutInterpreterLock {
		PyThreadState* const state = PyEval_SaveThread();
		~WithoutInterpreterLock() { PyEval_RestoreThread(state); }
	};

	Communicator& requireCommunicator()
	{
		if (!jobCommunicator()) raise(PyExc_RuntimeError, "this process has no other ranks: start it by mpirun -n N yade -n -x scene.py");
		return *jobCommunicator();
	}

	py::tuple openRanks()
	{
		openJobTalk();
		return jobCommunicator() ? py::make_tuple(jobCommunicator()->rank(), jobCommunicator()->count()) : py::make_tuple(0, 1);
	}

	/// Descriptions of all ranks, by which they are called in errors from now on.
	py::list describeRanks(const py::object& own, const std::string& name)
	{
		Communicator& communicator = requireCommunicator();
		const auto    everybody    = [&](const std::string& bytes) {
                        return communicator.ranks().exchange(std::vector<std::string>(std::size_t(communicator.count()), bytes));
		};
		communicator.describe(everybody(name));
		py::list all;
		for (const auto& bytes : everybody(bytesOf(own)))
			all.append(asBytes(bytes));
		return all;
	}

	void meetRanks(const std::string& purpose)
	{
		Communicator&                communicator = requireCommunicator();
		const StepGate               gate;
		const WithoutInterpreterLock unlocked;
		communicator.meet(purpose);
	}

	py::dict rankTraffic()
	{
		const RankTraffic sent = requireCommunicator().ranks().traffic();
		py::dict          d;
		TALIK_PUT_MEMBERS(d, sent, (messages)(bytes)(waited)(polling))
		return d;
	}

	/// What would end the whole process is said before it does.
	void refuseToAbort(const Scene& scene)
	{
		const std::string reason = reasonAgainstRunning(scene, false);
		if (!reason.empty()) raise(PyExc_RuntimeError, "The scene cannot run: " + reason + ".");
	}

	/// Small scenes lose by YADE's threads, and by sleeping until O.run has ended; and one thread gives the same bits for every -j.
	void runSerially(long steps)
	{
		refuseWhileRunning("runSerially");
		if (steps < 0) raise(PyExc_ValueError, "runSerially: steps is " + std::to_string(steps) + "; it must be at least 0.");
		const auto scene = Omega::instance().getScene();
		refuseToAbort(*scene);
		const SingleThread serial;
		const StepUnderWay underWay;
		if (steps > 0) scene->moveToNextTimeStep(); // lets go of former engines, which Python may own
		const WithoutInterpreterLock unlocked;
		for (long step = 1; step < steps; ++step)
			scene->moveToNextTimeStep();
	}

} // namespace
} // namespace talik

BOOST_PYTHON_MODULE(_talik)
{
	using namespace talik;
	py::numpy::initialize();
	py::def("registerClasses", registerClasses,
	        "Check that the running YADE is the one this module was built for, register our classes into it and return the names of "
	        "all of them. ImportError when YADE differs.");
	py::def(
	        "ownClasses", +[] { return listOf(checkpointClasses()); }, "Names of our classes.");
	py::def("exchangeScene", exchangeScene, py::arg("scene"), "Make *scene* the current scene of O and return the former one. Refused while O runs.");
	py::def(
	        "sameObject", +[](const shared_ptr<Serializable>& first, const shared_ptr<Serializable>& second) { return first == second; },
	        (py::arg("first"), py::arg("second")), "True if both are the same C++ object: Python may hold it by several names.");
	py::def("refuseFewerThreads", refuseFewerThreads, py::arg("scene"), "RuntimeError if O could not run a Scene with all of its threads.");
	py::def("sceneBytes", sceneBytes, py::arg("scene"), "Everything that YADE saves of a Scene, as bytes.");
	py::def(
	        "timeStepForIce", +[](const shared_ptr<Scene>& scene) { return timeStepForIce(*scene); }, py::arg("scene"),
	        "Time step [s] with which a Scene stays stable when full ice saturation stiffens its contacts: its own, lowered where it is too long.");
	py::def("objectToBytes", objectToBytes, py::arg("object"), "An object of YADE or Talik with all that it holds, as bytes.");
	py::def("objectFromBytes", objectFromBytes, py::arg("bytes"), "The object back. Only for bytes that are known to be whole.");
	py::def("readScene", readScene, (py::arg("content"), py::arg("xml")),
	        "The Scene in the bytes of a file of O.save, unpacked; O is left alone, and no label is made a name.");
	py::def(
	        "checkpointLayouts",
	        +[] {
		        py::dict layouts;
		        for (const auto& [name, layout] : checkpointLayouts())
			        layouts[name] = layout;
		        return layouts;
	        },
	        "Digests of the attributes of our classes, by their names.");
	py::def("checksumOfFile", checksumOfFile, (py::arg("file"), py::arg("from"), py::arg("bytes")),
	        "Checksum of a part of a file, as checkpoints have it.");
	py::def("readCheckpoint", readCheckpoint, (py::arg("file"), py::arg("parts")), "The Scene in a checkpoint that is whole, see talik._checkpointfile.");
	py::def(
	        "setSceneFile", +[](const std::string& file) { Omega::instance().sceneFile = file; }, py::arg("file"),
	        "The name of the file that O.reload reads, as O.save and O.load set it.");
	py::def("emptyScene", emptyScene, "A new Scene without bodies and engines, not yet the current one.");
	py::def("runSerially", runSerially, py::arg("steps"),
	        "Advance the current scene in the calling thread and with one thread: same bits whatever yade -j says. Refused while O runs.");
	py::def(
	        "refuseToAbort", +[] { refuseToAbort(*Omega::instance().getScene()); },
	        "RuntimeError if the next step would end the process on an assert of stock YADE: bodies without material or state, cells shorter than bodies, "
	        "contacts without functor.");
	py::def("callAsStep", callAsStep, py::arg("step"),
	        "Call *step*, a function that advances the current scene in the calling thread; stepUnderWay() is True meanwhile.");
	py::def("callBetweenSteps", callBetweenSteps, (py::arg("function"), py::arg("positional"), py::arg("named")),
	        "function(*positional, **named) while no engine of ours is at work: waits for the end of its step, and lets the next one wait.");
	py::def(
	        "setRunWaitedFor", +[](bool waited) { MpmEngine::runWaitedFor = waited; }, py::arg("waited"),
	        "Whether Python waits for the end of the run and takes its error, which YADE need not log then.");
	py::def(
	        "stepUnderWay", +[] { return stepsUnderWay > 0; },
	        "True inside of O.step() and runSerially(): for what an engine of the scene calls. During O.run see O.running.");
	py::def("renewRenderer", renewRenderer, py::arg("renderer"),
	        "Let the 3-D view look for drawing functors again: it does so itself only when it is made.");
	py::def(
	        "vectors", +[] { return stepKernel<2>({}, false).name; },
	        "The vectors by which packed samples are computed on this processor, see RveSample.path: ranks need the same.");
	py::def("knowsRanks", knowsRanks, "False in a module that was built without Open MPI.");
	py::def("openRanks", openRanks, "Join the other processes of mpirun. Returns rank and number of ranks, (0, 1) for a process that is alone.");
	py::def("describeRanks", describeRanks, (py::arg("own"), py::arg("name")),
	        "Collective: the bytes *own* of all ranks as a list; errors call each rank by its *name*.");
	py::def("meetRanks", meetRanks, py::arg("purpose"),
	        "Collective: wait for all ranks at the same place of the script, and answer their questions meanwhile.");
	py::def("rankTraffic", rankTraffic, "Dictionary: messages, bytes sent, seconds waited and processor seconds of waiting, of this rank.");
	py::def(
	        "endJob", +[](int status) { requireCommunicator().ranks().endJob(status); }, py::arg("status"), "End all processes of the job.");
	exposeShearTests();
	py::def(
	        "currentScene", +[] { return Omega::instance().getScene(); }, "The Scene that O acts on now.");
}
