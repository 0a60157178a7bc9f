// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <boost/date_time/posix_time/ptime.hpp>
#include <lib/base/Math.hpp>
#include <lib/base/Singleton.hpp>
#include <mutex>

namespace yade {
class Scene;
class ThreadRunner;

struct DynlibDescriptor {
	std::set<string> baseClasses;
	bool             isSerializable;
};

/// Stands for ThreadWorker and SimulationFlow, of which only the size matters.
struct SimulationFlowStorage {
	void* table;
	bool  flags[8];
};

/// The running YADE: its scenes and its class database.
class Omega : public Singleton<Omega> {
	shared_ptr<ThreadRunner>           simulationLoop;
	SimulationFlowStorage              simulationFlow_;
	std::map<string, DynlibDescriptor> dynlibs;
	vector<shared_ptr<Scene>>          scenes;
	int                                currentSceneNb;
	shared_ptr<Scene>                  sceneAnother;
	boost::posix_time::ptime           startupLocalTime;
	std::map<string, string>           memSavedSimulations;
	std::mutex                         tmpFileCounterMutex;
	long                               tmpFileCounter;
	string                             tmpFileDir;

public:
	string     gdbCrashBatch;
	char**     origArgv;
	int        origArgc;
	std::mutex renderMutex;
	string     sceneFile;
	string     confDir;

	const std::map<string, DynlibDescriptor>& getDynlibsDescriptor() const;
	const shared_ptr<Scene>&                  getScene() const;
	void                                      loadPlugins(vector<string> pluginFiles);
	bool                                      isRunning();
	bool                                      isInheritingFrom_recursive(const string& className, const string& baseClassName);
	/// Replaces the current scene; inline in YADE, too. Only while nothing runs.
	void setScene(const shared_ptr<Scene>& scene) { scenes[currentSceneNb] = scene; }

private:
	friend struct OmegaLayout;
};
} // namespace yade
