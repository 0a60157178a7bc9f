// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Scene.hpp>
#include <pkg/rve/packed/PackedState.hpp>

namespace yade {
class IceBondMat;
}

namespace talik {

/// Calls it with the bodies that were not erased, ascending by id.
template <class Visitor> void forBodies(const yade::Scene& scene, Visitor&& visit)
{
	for (std::size_t id = 0; id < scene.bodies->size(); ++id)
		if (const auto& body = (*scene.bodies)[id]) visit(*body);
}

/// The engines of the next step.
inline const auto& enginesNow(const yade::Scene& scene) { return scene._nextEngines.empty() ? scene.engines : scene._nextEngines; }

/// Parts of a scene as objects of Python: its cell, None where it is not periodic; the bodies that were not erased; the engines of the next step.
boost::python::object cellOf(const yade::Scene& scene);
boost::python::list   bodiesOf(const yade::Scene& scene);
boost::python::list   enginesOf(const yade::Scene& scene);

/// Why the next step of a scene would end the whole process on one of stock YADE's own asserts, with the remedy; empty if nothing of
/// the kind is known. Debian's YADE is built with asserts, and throws out of parallel loops where no functor fits a contact. Looks at
/// every body once; holds the GIL while it asks the dispatchers. Grains of IceBondMat must have functors for all that they may touch; other
/// bodies need not touch, unless dense.
std::string reasonAgainstRunning(const yade::Scene& scene, bool dense);

/// Why a scene cannot take the packed form (shapes, laws or materials that it does not know); empty if it can. Holds the GIL.
std::string reasonAgainstPacking(const yade::Scene& scene);

/// Whether ice bonds of a scene carry moments.
bool bondsCarryMoments(const yade::Scene& scene);

/// 2 for a scene of discs, that is of bodies that lie in one layer or are held there, 3 for one of spheres.
int packedDimension(const yade::Scene& scene);

/// Thickness of the slice that carries the forces of a scene of discs [m]: O.tags["thickness"], or the depth of the cell. Stress is divided by
/// it. Throws std::invalid_argument if the tag is no positive number.
double thicknessOf(const yade::Scene& scene);

/// Time step [s] with which a scene stays stable when full ice saturation stiffens its contacts: that of the scene, lowered where it is
/// too long. A scene that has it keeps it.
double timeStepForIce(const yade::Scene& scene);

/// Time step [s] that a scene bears with the ice of now, if its own bears full ice: as much longer as contacts are softer, and no longer than
/// samples are prepared with. That of the scene where a grain is not of IceBondMat. iceStiffness: factor by which the ice of the materials is
/// stiffer than it was when the time step of the scene was chosen.
double longestTimeStep(const yade::Scene& scene, double iceStiffness);
/// Stiffness of the most loaded contacts of grains of a radius under a multiple of the stress of the scene, over that of linear springs [-].
double overLinear(const yade::Scene& scene, const yade::IceBondMat& grains, double radius, double times);

/// The packed form of a periodic scene of discs (YADE spheres in one layer with z and the rotations about x and y blocked) or of spheres
/// free to move: one material, Cundall-Strack or ice-bond law. Where the scene still shows what `former` opened into, the numbers of `former` are
/// taken, so that packed -> open -> packed is the identity bit for bit. Without `former` the time step is lowered to that for ice.
/// Throws std::invalid_argument with the reason if the scene cannot be packed.
template <int Dim> PackedState<Dim> packScene(const yade::Scene& scene, const PackedState<Dim>* former = nullptr);

/// Writes a packed state into the scene that it came from (or a copy): motion, radii, cell, contacts with forces and bonds.
/// Throws std::invalid_argument if bodies are missing.
template <int Dim> void openInto(yade::Scene& scene, const PackedState<Dim>& state);

/// A copy of a scene with everything in it, through YADE's own archives.
boost::shared_ptr<yade::Scene> copyScene(const boost::shared_ptr<yade::Scene>& scene);
std::string                    sceneToBytes(const boost::shared_ptr<yade::Scene>& scene);
/// threads: how many may step the scene; YADE sizes the storage of its engines when they are made. Samples are stepped by one each.
boost::shared_ptr<yade::Scene> sceneFromBytes(const std::string& bytes, int threads = 1);
/// A scene as YADE's own files hold it, for O; throws what Boost throws.
boost::shared_ptr<yade::Scene> sceneFromFile(const std::string& content, bool xml);
/// The same as sceneFromBytes, to be shown and run in O with as many threads as yade was given.
boost::shared_ptr<yade::Scene> sceneForView(const std::string& bytes);

} // namespace talik
