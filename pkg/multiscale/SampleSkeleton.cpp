// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/Errors.hpp>
#include <pkg/mpm/ThreadTeam.hpp>
#include <pkg/multiscale/ByteArchive.hpp>
#include <pkg/multiscale/SampleSkeleton.hpp>

#include <chrono>
#include <cmath>
#include <omp.h>
#include <stdexcept>

namespace talik {
namespace {
	using Matrix = PackedTypes<2>::Matrix;

	const char archiveMagic[] = "talik samples 3";

	constexpr double stressFloor      = 1e3; ///< sigma_ref of the relative error [Pa]
	constexpr double failingRatio     = 0.3; ///< below it a point deforms plastically: no prediction, a tighter tolerance
	constexpr double failingTightness = 0.25;
	constexpr double saturationShare  = 1.
	        / 3; ///< saturation tolerance over that of the error: the modulus grows sixfold on freezing, in part without effect on stress
	constexpr double toleranceRange = 10.; ///< the steered tolerance stays within this factor of the given one

	/// Out of plane the discs do not touch; the mean of the in-plane stresses stands there for display and invariants.
	void storeStress(const SkeletonBatch<2>& batch, int place, const Matrix& s)
	{
		batch.stress[0][place] = s(0, 0);
		batch.stress[1][place] = s(1, 1);
		batch.stress[2][place] = 0.5 * (s(0, 0) + s(1, 1));
		batch.stress[3][place] = 0.5 * (s(0, 1) + s(1, 0));
	}

	/// Rotation of the polar decomposition of 1 + H.
	Matrix rotationOf(const Matrix& h)
	{
		const double angle = std::atan2(h(1, 0) - h(0, 1), 2 + h(0, 0) + h(1, 1));
		Matrix       r;
		r << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
		return r;
	}

	/// Rows xx, yy, xy; columns e_xx, e_yy, e_xy (tensor strain).
	std::array<double, 9> compact(const PackedTangent<2>& c)
	{
		const auto at  = [&](int i, int j, int k, int l) { return c[((i * 2 + j) * 2 + k) * 2 + l]; };
		const auto sym = [&](int k, int l) { return 0.5 * (at(0, 1, k, l) + at(1, 0, k, l)); };
		return { at(0, 0, 0, 0), at(0, 0, 1, 1), at(0, 0, 0, 1) + at(0, 0, 1, 0),
			 at(1, 1, 0, 0), at(1, 1, 1, 1), at(1, 1, 0, 1) + at(1, 1, 1, 0),
			 sym(0, 0),      sym(1, 1),      sym(0, 1) + sym(1, 0) };
	}

	Matrix elasticChange(const std::array<double, 9>& c, const Matrix& h)
	{
		const double exx = h(0, 0), eyy = h(1, 1), exy = 0.5 * (h(0, 1) + h(1, 0));
		const double xx = c[0] * exx + c[1] * eyy + c[2] * exy, yy = c[3] * exx + c[4] * eyy + c[5] * exy, xy = c[6] * exx + c[7] * eyy + c[8] * exy;
		Matrix       s;
		s << xx, xy, xy, yy;
		return s;
	}
} // namespace

/// The model's own fields of the points, as arrays by place.
struct SampleSkeleton::Arrays {
	std::array<double*, 4> gradient, last;
	std::array<double*, 9> tangent;
	double *               saturation, *ratio, *tolerance;

	Matrix accumulated(int p) const
	{
		Matrix h;
		h << gradient[0][p], gradient[1][p], gradient[2][p], gradient[3][p];
		return h;
	}
	void setAccumulated(int p, const Matrix& h) const
	{
		for (int c = 0; c < 4; c++)
			gradient[c][p] = h(c / 2, c % 2);
	}
	Matrix lastStress(int p) const
	{
		Matrix s;
		s << last[0][p], last[1][p], last[2][p], last[3][p];
		return s;
	}
	void setLastStress(int p, const Matrix& s) const
	{
		for (int c = 0; c < 4; c++)
			last[c][p] = s(c / 2, c % 2);
	}
	std::array<double, 9> tangentAt(int p) const
	{
		std::array<double, 9> c;
		for (int i = 0; i < 9; i++)
			c[i] = tangent[i][p];
		return c;
	}
	/// Stress that the last call and the tangent predict for the accumulated motion, eq. (15.3).
	Matrix predicted(int p) const
	{
		const Matrix h = accumulated(p), r = rotationOf(h);
		const Matrix turned = r * lastStress(p) * r.transpose();
		return ratio[p] < failingRatio ? turned : Matrix(turned + ratio[p] * elasticChange(tangentAt(p), h));
	}
};

SampleSkeleton::SampleSkeleton(std::shared_ptr<SampleStore> samples, std::vector<int> of, const SampleScheduling& s)
        : store(std::move(samples))
        , prototypeOf(std::move(of))
        , schedule(s)
{
	if (store->prototypeCount() == 0)
		throw std::invalid_argument("RveSkeleton.samples is empty: give at least one sample, e.g. talik.rve.pack(talik.rve.prepare()).");
	for (std::size_t id = 0; id < prototypeOf.size(); id++)
		if (prototypeOf[id] >= store->prototypeCount())
			throw std::invalid_argument(
			        "RveSkeleton.sampleOf[" + std::to_string(id) + "] is " + std::to_string(prototypeOf[id]) + ": there are "
			        + std::to_string(store->prototypeCount()) + " samples, counted from 0.");
	sampleOf.assign(prototypeOf.size(), -1);
}

void SampleSkeleton::declareFields(PointFields& f, const std::string& prefix)
{
	fields          = &f;
	gradientField   = f.declare(prefix + "accumulatedGradient", name(), "-", 4);
	stressField     = f.declare(prefix + "sampleStress", name(), "Pa", 4);
	saturationField = f.declare(prefix + "sampleIceSaturation", name(), "-", 1);
	toleranceField  = f.declare(prefix + "strainTolerance", name(), "-", 1);
	ratioField      = f.declare(prefix + "tangentRatio", name(), "-", 1);
	tangentField    = f.declare(prefix + "tangent", name(), "Pa", 9);
	if (accuracy) accuracy->declareFields(f, prefix, name());
}

SampleSkeleton::Arrays SampleSkeleton::arrays() const
{
	Arrays a;
	for (int c = 0; c < 4; c++) {
		a.gradient[c] = fields->component(gradientField, c);
		a.last[c]     = fields->component(stressField, c);
	}
	for (int c = 0; c < 9; c++)
		a.tangent[c] = fields->component(tangentField, c);
	a.saturation = fields->component(saturationField);
	a.ratio      = fields->component(ratioField);
	a.tolerance  = fields->component(toleranceField);
	return a;
}

void SampleSkeleton::initialise(const SkeletonBatch<2>& batch)
{
	const Arrays a = arrays();
	store->clear();
	// by id: the numbering of samples must not depend on how points are sorted in memory
	std::map<int, int> placeOf;
	for (int k = 0; k < batch.count; k++)
		placeOf[batch.id[batch.place[k]]] = batch.place[k];
	for (const auto& [id, place] : placeOf) {
		if (id >= int(prototypeOf.size()) || prototypeOf[id] < 0)
			throw std::invalid_argument(
			        "RveSkeleton.sampleOf has no number for point " + std::to_string(id) + ": give one number per point, or none at all.");
		const double iceSaturation = batch.iceSaturation ? batch.iceSaturation[place] : store->prototypeIce(prototypeOf[id]);
		sampleOf[id]               = int(store->size());
		const SampleStart& start   = store->add(prototypeOf[id], iceSaturation, schedule.update);
		const auto         tangent = compact(start.tangent);
		for (int c = 0; c < 9; c++)
			a.tangent[c][place] = tangent[c];
		a.setAccumulated(place, Matrix::Zero());
		a.saturation[place] = iceSaturation;
		a.ratio[place]      = 1;
		a.tolerance[place]  = schedule.strainTolerance;
		a.setLastStress(place, start.stress);
		storeStress(batch, place, start.stress);
		if (accuracy) accuracy->begin(place);
	}
	count.points = placeOf.size();
}

bool SampleSkeleton::isDue(const Arrays& a, int place, double iceSaturation) const
{
	const Matrix h    = a.accumulated(place);
	const double most = h.cwiseAbs().maxCoeff();
	if (schedule.strainTolerance <= 0 ? most > 0 : most > a.tolerance[place]) return true;
	const double change = std::fabs(iceSaturation - a.saturation[place]);
	if (change == 0) return false;
	// ice that vanishes or appears altogether makes or breaks bonds: never wait for it
	return change > schedule.saturationTolerance || iceSaturation == 0 || a.saturation[place] == 0;
}

void SampleSkeleton::predict(const SkeletonBatch<2>& batch, int place, const Arrays& a) const
{
	if (schedule.prediction) storeStress(batch, place, a.predicted(place));
}

void SampleSkeleton::updateStress(const SkeletonBatch<2>& batch)
{
	const Arrays a = arrays();
	if (accuracy) accuracy->countStep();
	flagScratch.assign(batch.count, 0);
	constexpr int piece  = 256;
	const auto    follow = [&](int k) {
                const int place = batch.place[k];
                if (!isolated.empty() && isolated.count(batch.id[place])) return;
                Matrix step;
                step << batch.gradient[0][place], batch.gradient[1][place], batch.gradient[2][place], batch.gradient[3][place];
                const Matrix h = a.accumulated(place);
                a.setAccumulated(place, h + step * (Matrix::Identity() + h));
                const double iceSaturation = batch.iceSaturation ? batch.iceSaturation[place] : a.saturation[place];
                if (isDue(a, place, iceSaturation)) flagScratch[k] = 1;
                else predict(batch, place, a);
	};
	ThreadTeam::run((batch.count + piece - 1) / piece, batch.count >= 4000 ? ThreadTeam::threads() : 1, [&](int i, int) {
		for (int k = i * piece; k < std::min(batch.count, (i + 1) * piece); k++)
			follow(k);
	});
	if (!changed.empty()) flagChanged(batch);
	dueScratch.clear();
	for (int k = 0; k < batch.count; k++)
		if (flagScratch[k]) dueScratch.push_back(batch.place[k]);
	if (!dueScratch.empty()) ask(batch, dueScratch, a);
}

void SampleSkeleton::flagChanged(const SkeletonBatch<2>& batch)
{
	for (int k = 0; k < batch.count; k++)
		if (changed.count(batch.id[batch.place[k]])) flagScratch[k] = 1;
	changed.clear();
}

std::vector<PackedRequest<2>> SampleSkeleton::requests(const SkeletonBatch<2>& batch, const std::vector<int>& due, const Arrays& a) const
{
	std::vector<PackedRequest<2>> list;
	for (const int place : due) {
		list.push_back({ std::size_t(sampleOf[batch.id[place]]), a.accumulated(place),
		                 batch.iceSaturation ? batch.iceSaturation[place] : a.saturation[place] });
		if (!accuracy) continue;
		list.back().inertialNumber = accuracy->inertialNumber(place);
		list.back().compareRates   = accuracy->comparesRates(place);
	}
	return list;
}

void SampleSkeleton::ask(const SkeletonBatch<2>& batch, const std::vector<int>& due, const Arrays& a)
{
	const auto          start     = std::chrono::steady_clock::now();
	int                 stoppedBy = -1;
	const auto          asked     = requests(batch, due, a);
	PackedUpdateOptions options   = schedule.update;
	options.tangent               = schedule.prediction;
	const auto results            = store->update(asked, options, schedule.threads);
	for (std::size_t r = 0; r < due.size(); r++) {
		const int place = due[r], id = batch.id[place];
		count.steps += std::uint64_t(results[r].steps);
		if (results[r].blewUp) {
			failures[id] = results[r].reason;
			if (onBlowUp ? onBlowUp(id) : schedule.stopOnBlowUp) stoppedBy = stoppedBy < 0 ? id : stoppedBy;
			else isolated.insert(id);
		}
		const Matrix predicted = a.predicted(place), before = a.lastStress(place), after = results[r].stress;
		if (schedule.prediction && !results[r].blewUp) {
			const Matrix h = a.accumulated(place), turn = rotationOf(h);
			const double elastic = elasticChange(a.tangentAt(place), h).norm(), actual = (after - turn * before * turn.transpose()).norm();
			a.ratio[place] = elastic > 0 ? std::min(1., actual / elastic) : 1.;
			const auto c   = compact(results[r].tangent);
			for (int i = 0; i < 9; i++)
				a.tangent[i][place] = c[i];
			const double error = (after - predicted).norm();
			if (accuracy) steer(batch, place, error, results[r], a);
			else if (schedule.stressTolerance > 0 && schedule.strainTolerance > 0) {
				const double relative = error / (after.norm() + stressFloor);
				const double factor   = relative > 0 ? std::sqrt(schedule.stressTolerance / relative) : 2.;
				const double tight    = a.ratio[place] < failingRatio ? failingTightness : 1.;
				a.tolerance[place]    = std::min(
				           toleranceRange * schedule.strainTolerance * tight,
				           std::max(schedule.strainTolerance / toleranceRange, a.tolerance[place] * std::min(2., std::max(0.3, factor))));
			}
		}
		a.setLastStress(place, after);
		a.setAccumulated(place, Matrix::Zero());
		a.saturation[place] = asked[r].iceSaturation;
		storeStress(batch, place, after);
	}
	count.calls += due.size();
	count.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
	if (stoppedBy >= 0)
		throw StopAfterStep(
		        "The sample of point " + std::to_string(stoppedBy) + " blew up: " + failures[stoppedBy]
		        + ". The step was completed with its last stress; look at the sample (RveSkeleton.scene), use finer maxInertialNumber or "
		          "maxStrainPerStep, or go on with onBlowUp='isolate'.");
}

void SampleSkeleton::steer(const SkeletonBatch<2>& batch, int place, double predictionError, const PackedUpdateResult<2>& result, const Arrays& a)
{
	SampleAccuracy::Answer answer;
	answer.place           = place;
	answer.volume          = batch.volume[place];
	answer.stress          = result.stress.norm();
	answer.predictionError = predictionError;
	answer.rateError       = result.rateError;
	answer.strain          = a.accumulated(place).cwiseAbs().maxCoeff();
	a.tolerance[place]     = accuracy->learn(answer, a.tolerance[place]);
}

void SampleSkeleton::setTolerance(double tolerance)
{
	if (!store->comparesRates())
		throw std::invalid_argument(
		        "MpmEngine.tolerance needs packed samples, whose rates can be compared: set tolerance=0, or give samples that can be packed.");
	if (!schedule.prediction || schedule.strainTolerance <= 0)
		throw std::invalid_argument("MpmEngine.tolerance steers RveSkeleton.strainTolerance of every point by the error of the prediction: leave "
		                            "strainTolerance above 0 and prediction=True.");
	if (!accuracy) accuracy = std::make_unique<SampleAccuracy>();
	accuracy->setTolerance(tolerance);
	schedule.saturationTolerance = saturationShare * tolerance;
}

ErrorSquares SampleSkeleton::errorSquares(const SkeletonBatch<2>& batch) const
{
	if (!accuracy) return {};
	const Arrays a   = arrays();
	ErrorSquares sum = accuracy->squares();
	for (int k = 0; k < batch.count; k++)
		accuracy->addPending(batch.place[k], batch.volume[batch.place[k]], a.lastStress(batch.place[k]).norm(), sum);
	return sum;
}

void SampleSkeleton::tangentModulus(const SkeletonBatch<2>& batch, double* modulus) const
{
	for (int k = 0; k < batch.count; k++) {
		const int place = batch.place[k], prototype = prototypeOf[batch.id[place]];
		modulus[place] = store->oedometricModulus(prototype, batch.iceSaturation ? batch.iceSaturation[place] : store->prototypeIce(prototype));
	}
}

std::size_t SampleSkeleton::sampleNumber(int id) const
{
	if (!has(id)) throw std::invalid_argument("point " + std::to_string(id) + " has no sample");
	return std::size_t(sampleOf[id]);
}

void SampleSkeleton::keepOnly(const SkeletonBatch<2>& batch)
{
	std::vector<char> stays(sampleOf.size(), 0);
	for (int k = 0; k < batch.count; k++)
		stays.at(batch.id[batch.place[k]]) = 1;
	for (std::size_t id = 0; id < sampleOf.size(); id++) {
		if (stays[id] || sampleOf[id] < 0) continue;
		store->release(std::size_t(sampleOf[id]));
		sampleOf[id] = -1;
		failures.erase(int(id));
		isolated.erase(int(id));
		changed.erase(int(id));
	}
	count.points = std::uint64_t(batch.count);
}

std::string SampleSkeleton::save() const
{
	ByteWriter writer;
	writer.block(archiveMagic);
	store->save(writer);
	writer.number(sampleOf.size());
	for (const int s : sampleOf)
		writer.number(std::uint64_t(s + 1));
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
	if (accuracy) accuracy->save(writer);
	return writer.bytes();
}

void SampleSkeleton::restore(const std::string& bytes)
{
	ByteReader reader(bytes);
	if (reader.block() != archiveMagic)
		throw std::runtime_error(
		        "RveSkeleton: the saved samples are not those of this version of Talik: continue them with the version that saved them.");
	store->restore(reader);
	sampleOf.assign(reader.number(), -1);
	for (int& s : sampleOf)
		s = int(reader.number()) - 1;
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
	if (accuracy) accuracy->restore(reader);
}

} // namespace talik
