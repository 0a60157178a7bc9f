// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/Errors.hpp>
#include <pkg/base/SavedBytes.hpp>
#include <pkg/multiscale/samples/PointSamples.hpp>

#include <stdexcept>

namespace talik {
namespace {
	const char archiveMagic[] = "talik samples 7";

	/// Saturation tolerance over that of the error: the modulus grows sixfold on freezing, in part without effect on stress.
	constexpr double saturationShare = 1. / 3;
} // namespace

PointSamples::PointSamples(std::shared_ptr<SampleStore> samples, std::vector<int> of, const SampleScheduling& s)
        : prototypeOf(std::move(of))
        , schedule(s)
        , anyStore(std::move(samples))
{
	if (anyStore->prototypeCount() == 0)
		throw std::invalid_argument("RveSkeleton.samples is empty: give at least one sample, e.g. talik.rve.pack(talik.rve.prepare()).");
	for (std::size_t id = 0; id < prototypeOf.size(); ++id)
		if (prototypeOf[id] >= anyStore->prototypeCount())
			throw std::invalid_argument(
			        "RveSkeleton.sampleOf[" + std::to_string(id) + "] is " + std::to_string(prototypeOf[id]) + ": there are "
			        + std::to_string(anyStore->prototypeCount()) + " samples, counted from 0.");
	sampleOf.assign(prototypeOf.size(), -1);
}

void PointSamples::book(const Asked& asked)
{
	count.calls += asked.calls;
	count.steps += asked.steps;
	int stoppedBy = -1;
	for (const auto& [id, reason] : asked.blownUp) {
		failures[id] = reason;
		if (!(onBlowUp ? onBlowUp(id) : schedule.stopOnBlowUp)) isolated.insert(id);
		else if (stoppedBy < 0) stoppedBy = id;
	}
	if (stoppedBy >= 0)
		throw StopAfterStep(
		        "The sample of point " + std::to_string(stoppedBy) + " blew up: " + failures[stoppedBy]
		        + ". The step was completed with its last stress; look at the sample (RveSkeleton.scene), use finer maxInertialNumber or "
		          "maxStrainPerStep, or go on with onBlowUp='isolate'.");
}

void PointSamples::setTolerance(double tolerance)
{
	if (!anyStore->comparesRates())
		throw std::invalid_argument(
		        "MpmEngine.tolerance needs packed samples, whose rates can be compared: set tolerance=0, or give samples that can be packed.");
	if (!schedule.prediction || schedule.strainTolerance <= 0)
		throw std::invalid_argument("MpmEngine.tolerance steers RveSkeleton.strainTolerance of every point by the error of the prediction: leave "
		                            "strainTolerance above 0 and prediction=True.");
	if (!accuracy) accuracy = std::make_unique<SampleAccuracy>();
	accuracy->setTolerance(tolerance);
	schedule.saturationTolerance = saturationShare * tolerance;
}

/// Ground in which nothing thaws beside frozen ground never asks.
std::optional<ShearStrength> PointSamples::slip() const
{
	if (schedule.slipStrength) return schedule.slipStrength;
	if (!measuredSlip && measureSlip) measuredSlip = measureSlip();
	return measuredSlip;
}

std::size_t PointSamples::sampleNumber(int id) const
{
	if (!has(id)) throw std::invalid_argument("point " + std::to_string(id) + " has no sample");
	return std::size_t(sampleOf[id]);
}

void PointSamples::keepOnly(const SkeletonPoints& batch)
{
	std::vector<char> stays(sampleOf.size(), 0);
	for (int k = 0; k < batch.count; ++k)
		stays.at(batch.id[batch.place[k]]) = 1;
	for (std::size_t id = 0; id < sampleOf.size(); ++id) {
		if (stays[id] || sampleOf[id] < 0) continue;
		anyStore->release(std::size_t(sampleOf[id]));
		sampleOf[id] = -1;
		failures.erase(int(id));
		isolated.erase(int(id));
		changed.erase(int(id));
	}
	count.points = std::uint64_t(batch.count);
}

std::string PointSamples::save(const SampleStore::Layout& layout) const
{
	ByteWriter writer;
	writer.block(archiveMagic);
	layout.save(writer);
	writer.array(sampleOf);
	writer.number(count.calls);
	writer.number(count.steps);
	writer.number(failures.size());
	for (const auto& [id, reason] : failures) {
		writer.number(std::uint64_t(id));
		writer.block(reason);
		writer.number(isolated.count(id));
	}
	writer.number(changed.size());
	for (const int id : changed)
		writer.number(std::uint64_t(id));
	return writer.bytes();
}

void PointSamples::restore(const std::string& bytes, const std::function<std::string(std::uint64_t, std::uint64_t)>& states)
{
	ByteReader reader(bytes);
	if (reader.block() != archiveMagic)
		throw std::runtime_error(
		        "RveSkeleton: the saved samples are not those of this version of Talik: continue them with the version that saved them.");
	const auto layout = SampleStore::Layout::from(reader);
	reader.array(sampleOf);
	beginWithOwners(); // states are restored when it is known who has which
	anyStore->restore(layout, states);
	restoreBooks(reader);
}

void PointSamples::restoreBooks(ByteReader& reader)
{
	count.calls = reader.number();
	count.steps = reader.number();
	failures.clear();
	isolated.clear();
	for (std::uint64_t left = reader.number(); left > 0; left--) {
		const int id = int(reader.number());
		failures[id] = reader.block();
		if (reader.number()) isolated.insert(id);
	}
	changed.clear();
	for (std::uint64_t left = reader.number(); left > 0; left--)
		changed.insert(int(reader.number()));
}

} // namespace talik
