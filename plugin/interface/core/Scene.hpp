// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/BodyContainer.hpp>
#include <core/Cell.hpp>
#include <core/Engine.hpp>
#include <core/ForceContainer.hpp>
#include <core/InteractionContainer.hpp>
#include <core/Material.hpp>

namespace yade {
class DisplayParameters;
class EnergyTracker;
class OpenGLRenderer;

/// One simulation: bodies, interactions, engines, cell.
class Scene : public Serializable {
	const unsigned hostNameMax = 255;

public:
	ForceContainer forces;

private:
	Eigen::Matrix<Real, 10, 1> SpeedElements;

public:
	shared_ptr<OpenGLRenderer> renderer;
	boost::posix_time::ptime   prevTime;
	Real                       dt;
	long                       iter;
	bool                       subStepping;
	int                        subStep;
	Real                       time;
	Real                       speed;
	long                       stopAtIter;
	Real                       stopAtTime;
	bool                       isPeriodic;
	bool                       trackEnergy;
	bool                       doSort;
	bool                       runInternalConsistencyChecks;
	Body::id_t                 selectedBody;
	int                        subdomain;
	shared_ptr<Shape>          subD;
	vector<string>             tags;
	vector<shared_ptr<Engine>> engines, _nextEngines;

	shared_ptr<BodyContainer>             bodies;
	shared_ptr<InteractionContainer>      interactions;
	shared_ptr<EnergyTracker>             energy;
	vector<shared_ptr<Material>>          materials;
	shared_ptr<Bound>                     bound;
	shared_ptr<Cell>                      cell;
	vector<shared_ptr<Serializable>>      miscParams;
	vector<shared_ptr<DisplayParameters>> dispParams;

	Scene();
	virtual ~Scene();
	TALIK_STOCK_OVERRIDES()

	void fillDefaultTags();
	void moveToNextTimeStep();

private:
	friend struct SceneLayout;
};
} // namespace yade
TALIK_STOCK_HELD(Scene)
