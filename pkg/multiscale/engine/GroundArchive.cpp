// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/multiscale/checkpoints/SavedBytes.hpp>
#include <pkg/multiscale/engine/MpmEngine.hpp>

// The state of a running ground in an archive of its engine.

namespace yade {

namespace {
	const char archiveMagic[] = "talik ground 6";
} // namespace

void MpmEngine::preSave(MpmEngine&)
{
	if (!ground || !hasBegun()) return; // until it has begun it comes from its inputs
	talik::ByteWriter writer;
	writer.block(archiveMagic);
	writer.block(&stableStep, sizeof stableStep);
	writer.block(&stepsUntilLimit, sizeof stepsUntilLimit);
	writer.number(points.digest());
	for (const auto& array : ground->state()) {
		writer.block(array.name);
		writer.block(array.data, array.bytes);
	}
	const auto& events = ground->endedEvents();
	writer.block(string(reinterpret_cast<const char*>(events.data()), events.size() * sizeof(talik::MotionEvent)));
	for (const auto& law : activeSkeletons())
		writer.block(law->savedState());
	saved = talik::toBase64(writer.bytes());
}

/// A running ground needs its archived state no more; that of one loaded and not yet begun is its only one.
void MpmEngine::postSave(MpmEngine&)
{
	if (ground) string().swap(saved);
}

void MpmEngine::restoreSavedState()
{
	if (saved.empty()) return;
	begun                   = true;
	const string      bytes = talik::fromBase64(saved);
	talik::ByteReader reader(bytes);
	if (reader.block() != archiveMagic)
		throw std::runtime_error("MpmEngine: the saved state is not one of this version of Talik: continue it with the version that saved it.");
	// the run goes on with the same time steps as if it had not been saved
	reader.block(&stableStep, sizeof stableStep);
	reader.block(&stepsUntilLimit, sizeof stepsUntilLimit);
	if (reader.number() != points.digest())
		throw std::runtime_error("MpmEngine: the points in the file are not those of its saved state, it is damaged: load an earlier file.");
	for (const auto& array : ground->state()) {
		const string name = reader.block();
		if (name != array.name)
			throw std::runtime_error(
			        "MpmEngine: the saved state has the field '" + name + "' where this Talik has '" + array.name
			        + "': continue it with the version that saved it.");
		reader.block(array.data, array.bytes);
	}
	const string events = reader.block();
	if (events.size() % sizeof(talik::MotionEvent) != 0)
		throw std::runtime_error("MpmEngine: the saved events are damaged; go on from another checkpoint.");
	vector<talik::MotionEvent> ended(events.size() / sizeof(talik::MotionEvent));
	std::copy_n(events.data(), events.size(), reinterpret_cast<char*>(ended.data()));
	ground->setEndedEvents(ended);
	ground->stateRestored();
	for (const auto& law : activeSkeletons())
		law->restoreState(reader.block());
	saved.clear();
}

} // namespace yade
