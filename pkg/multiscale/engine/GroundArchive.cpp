// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/base/SavedBytes.hpp>
#include <pkg/multiscale/checkpoints/CheckpointParts.hpp>
#include <pkg/multiscale/engine/MpmEngine.hpp>
#include <pkg/ranks/Communicator.hpp>

// The state of a running ground in an archive of its engine: all of it as text, which any archive takes; or, in a checkpoint, its numbers of
// points and states of samples behind the archive, where each rank writes what it has, and the rest there, too.

namespace yade {

namespace {
	const char archiveMagic[] = "talik ground 7", besideMagic[] = "talik ground 7 beside", besideMark[] = "beside ";

	string namesOf(const vector<talik::StateArray>& arrays)
	{
		string names;
		for (const auto& array : arrays)
			names += array.name + " ";
		return names;
	}

	std::uint64_t bytesOf(const vector<talik::StateArray>& arrays)
	{
		std::uint64_t sum = 0;
		for (const auto& array : arrays)
			sum += array.bytes;
		return sum;
	}

	void refuseVersion()
	{
		throw std::runtime_error("MpmEngine: the saved state is not one of this version of Talik: continue it with the version that saved it.");
	}
} // namespace

void MpmEngine::preSave(MpmEngine&)
{
	if (!ground && parts.file) {
		if (talik::jobCommunicator())
			throw std::runtime_error(
			        "MpmEngine: this ground was read from a checkpoint and has not begun: call mpm.initialise() on all ranks before it is saved.");
		initialise();
	}
	if (!ground || !hasBegun()) return; // until it has begun it comes from its inputs
	talik::ByteWriter writer;
	auto* const       beside = talik::CheckpointParts::writing();
	writer.block(beside ? besideMagic : archiveMagic);
	writer.block(&stableStep, sizeof stableStep);
	writer.block(&stepsUntilLimit, sizeof stepsUntilLimit);
	writer.number(points.digest());
	if (beside) {
		const auto ofPoints = ground->pointState();
		writer.block(namesOf(ofPoints));
		writer.number(beside->add(bytesOf(ofPoints), [this](const talik::FilePlace& place) { return ground->writePoints(place); }));
	}
	for (const auto& array : beside ? ground->commonState() : ground->state()) {
		writer.block(array.name);
		writer.block(array.data, array.bytes);
	}
	writer.array(ground->endedEvents());
	for (const auto& law : activeSkeletons())
		writer.block(law->saved(beside));
	saved = beside ? besideMark + std::to_string(beside->add(writer.bytes())) + " " + std::to_string(writer.bytes().size())
	               : talik::toBase64(writer.bytes());
}

/// A running ground needs its archived state no more; that of one loaded and not yet begun is its only one.
void MpmEngine::postSave(MpmEngine&)
{
	if (ground) string().swap(saved);
}

void MpmEngine::preLoad(MpmEngine&)
{
	if (const auto* const source = talik::CheckpointParts::reading()) parts = *source;
}

void MpmEngine::restoreSavedState()
{
	if (saved.empty()) return;
	begun             = true;
	const bool beside = parts.file && saved.rfind(besideMark, 0) == 0;
	string     bytes;
	if (beside) {
		const auto   blank = saved.find(' ', sizeof besideMark);
		const string at    = saved.substr(sizeof besideMark - 1);
		bytes.resize(std::stoull(saved.substr(blank)));
		parts.file->read(&bytes[0], bytes.size(), parts.at + std::stoull(at));
	} else bytes = talik::fromBase64(saved);
	talik::ByteReader reader(bytes);
	if (reader.block() != (beside ? besideMagic : archiveMagic)) refuseVersion();
	// the run goes on with the same time steps as if it had not been saved
	reader.block(&stableStep, sizeof stableStep);
	reader.block(&stepsUntilLimit, sizeof stepsUntilLimit);
	if (reader.number() != points.digest())
		throw std::runtime_error("MpmEngine: the points in the file are not those of its saved state, it is damaged: load an earlier file.");
	std::uint64_t placeOfPoints = 0;
	if (beside) {
		if (reader.block() != namesOf(ground->pointState())) refuseVersion();
		placeOfPoints = parts.at + reader.number();
	}
	restoreArrays(reader, beside ? ground->commonState() : ground->state());
	vector<talik::MotionEvent> ended;
	reader.array(ended);
	ground->setEndedEvents(ended);
	if (beside) ground->readPoints(*parts.file, placeOfPoints);
	else ground->stateRestored();
	for (const auto& law : activeSkeletons())
		law->restore(reader.block(), beside ? &parts : nullptr);
	saved.clear();
	parts = {};
}

void MpmEngine::restoreArrays(talik::ByteReader& reader, const vector<talik::StateArray>& arrays) const
{
	for (const auto& array : arrays) {
		const string name = reader.block();
		if (name != array.name)
			throw std::runtime_error(
			        "MpmEngine: the saved state has the field '" + name + "' where this Talik has '" + array.name
			        + "': continue it with the version that saved it.");
		reader.block(array.data, array.bytes);
	}
}

} // namespace yade
