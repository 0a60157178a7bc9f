// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/points/Bands.hpp>
#include <pkg/mpm/ThreadTeam.hpp>
#include <pkg/multiscale/checkpoints/SavedBytes.hpp>
#include <pkg/multiscale/samples/SampleSkeleton.hpp>
#include <pkg/thm/Errors.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <omp.h>
#include <stdexcept>

namespace talik {
namespace {
	const char archiveMagic[] = "talik samples 4", besideMagic[] = "talik samples 4 beside";

	constexpr double stressFloor      = 1e3; ///< sigma_ref of the relative error [Pa]
	constexpr double failingRatio     = 0.3; ///< below it a point deforms plastically: no prediction, a tighter tolerance
	constexpr double failingTightness = 0.25;
	constexpr double saturationShare  = 1.
	        / 3; ///< saturation tolerance over that of the error: the modulus grows sixfold on freezing, in part without effect on stress
	/// Steps of a point of the ground that take as long as a DEM step of a packed sample, over the bytes of that: 4e-4 with discs, less in space.
	constexpr double pointStepsPerCost = 5e-4;
	constexpr double toleranceRange    = 10.; ///< the steered tolerance stays within this factor of the given one
	constexpr double changeOverError   = 2.;  ///< change of stress that is predicted at most, over stressTolerance

	template <int Dim> using MatrixOf = typename PackedTypes<Dim>::Matrix;

	/// Independent components of a symmetric tensor, in the order of components().
	template <int Dim> constexpr int                symmetricSize = Dim*(Dim + 1) / 2;
	template <int Dim> constexpr std::array<int, 2> symmetricPair(int n)
	{
		constexpr int plane[3][2] = { { 0, 0 }, { 1, 1 }, { 0, 1 } }, space[6][2] = { { 0, 0 }, { 1, 1 }, { 2, 2 }, { 1, 2 }, { 0, 2 }, { 0, 1 } };
		return Dim == 2 ? std::array<int, 2> { plane[n % 3][0], plane[n % 3][1] } : std::array<int, 2> { space[n][0], space[n][1] };
	}
	template <int Dim> constexpr int tangentSize = symmetricSize<Dim>* symmetricSize<Dim>;
	template <int Dim> using CompactTangent      = std::array<double, tangentSize<Dim>>;

	/// Out of plane discs do not touch; the mean of the in-plane stresses stands there for display and invariants.
	template <int Dim> void storeStress(const SkeletonBatch<Dim>& batch, int place, const MatrixOf<Dim>& s)
	{
		for (int n = 0; n < symmetricSize<Dim>; ++n) {
			const auto [i, j]                           = symmetricPair<Dim>(n);
			batch.stress[stressIndex<Dim>(i, j)][place] = i == j ? s(i, i) : 0.5 * (s(i, j) + s(j, i));
		}
		if (Dim == 2) batch.stress[2][place] = 0.5 * (s(0, 0) + s(1, 1));
	}

	/// Rotation of the polar decomposition of 1 + H.
	MatrixOf<2> rotationOf(const MatrixOf<2>& h)
	{
		const double sine = h(1, 0) - h(0, 1), cosine = 2 + h(0, 0) + h(1, 1), size = std::sqrt(sine * sine + cosine * cosine);
		MatrixOf<2>  r;
		r << cosine, -sine, sine, cosine;
		return size > 0 ? MatrixOf<2>(r / size) : MatrixOf<2>::Identity();
	}

	/// Newton's iteration: converges from every matrix with an inverse.
	MatrixOf<3> rotationOf(const MatrixOf<3>& h)
	{
		MatrixOf<3> r = MatrixOf<3>::Identity() + h;
		for (int k = 0; k < 30; ++k) {
			const MatrixOf<3> next   = 0.5 * (r + r.inverse().transpose());
			const double      change = (next - r).norm();
			r                        = next;
			if (change < 1e-15) break;
		}
		return r;
	}

	/// Rows: components of stress; columns: those of the tensor strain.
	template <int Dim> CompactTangent<Dim> compact(const PackedTangent<Dim>& c)
	{
		const auto          at  = [&](int i, int j, int k, int l) { return c[((i * Dim + j) * Dim + k) * Dim + l]; };
		const auto          row = [&](int i, int j, int k, int l) { return i == j ? at(i, j, k, l) : 0.5 * (at(i, j, k, l) + at(j, i, k, l)); };
		CompactTangent<Dim> result;
		for (int n = 0; n < tangentSize<Dim>; ++n) {
			const auto [i, j] = symmetricPair<Dim>(n / symmetricSize<Dim>);
			const auto [k, l] = symmetricPair<Dim>(n % symmetricSize<Dim>);
			result[n]         = k == l ? row(i, j, k, l) : row(i, j, k, l) + row(i, j, l, k);
		}
		return result;
	}

	template <int Dim> MatrixOf<Dim> elasticChange(const CompactTangent<Dim>& c, const MatrixOf<Dim>& h)
	{
		constexpr int size = symmetricSize<Dim>;
		double        strain[size];
		for (int n = 0; n < size; ++n) {
			const auto [i, j] = symmetricPair<Dim>(n);
			strain[n]         = i == j ? h(i, i) : 0.5 * (h(i, j) + h(j, i));
		}
		MatrixOf<Dim> s;
		for (int n = 0; n < size; ++n) {
			const auto [i, j] = symmetricPair<Dim>(n);
			double sum        = c[n * size] * strain[0];
			for (int m = 1; m < size; ++m)
				sum += c[n * size + m] * strain[m];
			s(i, j) = s(j, i) = sum;
		}
		return s;
	}
} // namespace

/// The model's own fields of the points, as arrays by place.
template <int Dim> struct SampleSkeleton<Dim>::Arrays {
	using Components = std::array<double*, Dim * Dim>;

	Components                            gradient, last;
	std::array<double*, tangentSize<Dim>> tangent;
	double *                              saturation, *ratio, *tolerance;

	static Matrix matrixAt(const Components& components, int p)
	{
		Matrix m;
		for (int c = 0; c < Dim * Dim; ++c)
			m(c / Dim, c % Dim) = components[c][p];
		return m;
	}
	static void setMatrixAt(const Components& components, int p, const Matrix& m)
	{
		for (int c = 0; c < Dim * Dim; ++c)
			components[c][p] = m(c / Dim, c % Dim);
	}
	Matrix              accumulated(int p) const { return matrixAt(gradient, p); }
	void                setAccumulated(int p, const Matrix& h) const { setMatrixAt(gradient, p, h); }
	Matrix              lastStress(int p) const { return matrixAt(last, p); }
	void                setLastStress(int p, const Matrix& s) const { setMatrixAt(last, p, s); }
	CompactTangent<Dim> tangentAt(int p) const
	{
		CompactTangent<Dim> c;
		for (int i = 0; i < tangentSize<Dim>; ++i)
			c[i] = tangent[i][p];
		return c;
	}
	/// Change of stress that the tangent predicts for the accumulated motion h, beside its rotation.
	Matrix predictedChange(int p, const Matrix& h) const
	{
		return ratio[p] < failingRatio ? Matrix(Matrix::Zero()) : Matrix(ratio[p] * elasticChange<Dim>(tangentAt(p), h));
	}
	/// Stress that the last call and the tangent predict for the accumulated motion h, eq. (15.3); change: predictedChange(p, h).
	Matrix predicted(int p, const Matrix& h, const Matrix& change) const
	{
		const Matrix r = rotationOf(h);
		return r * lastStress(p) * r.transpose() + change;
	}
};

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

template <int Dim>
SampleSkeleton<Dim>::SampleSkeleton(std::shared_ptr<SampleStoreOf<Dim>> samples, std::vector<int> of, const SampleScheduling& s)
        : PointSamples(samples, std::move(of), s)
        , store(std::move(samples))
        , banded(std::dynamic_pointer_cast<BandStore<Dim>>(store))
{}

template <int Dim> void SampleSkeleton<Dim>::declareFields(PointFields& f, const std::string& prefix)
{
	fields          = &f;
	gradientField   = f.declare(prefix + "accumulatedGradient", name(), "-", Dim * Dim);
	stressField     = f.declare(prefix + "sampleStress", name(), "Pa", Dim * Dim);
	saturationField = f.declare(prefix + "sampleIceSaturation", name(), "-", 1);
	toleranceField  = f.declare(prefix + "strainTolerance", name(), "-", 1);
	ratioField      = f.declare(prefix + "tangentRatio", name(), "-", 1);
	tangentField    = f.declare(prefix + "tangent", name(), "Pa", tangentSize<Dim>);
	if (schedule.followsTime()) timeField = f.declare(prefix + "timeSinceUpdate", name(), "s", 1);
	if (accuracy) accuracy->declareFields(f, prefix, name());
}

template <int Dim> typename SampleSkeleton<Dim>::Arrays SampleSkeleton<Dim>::arrays() const
{
	Arrays a;
	for (int c = 0; c < Dim * Dim; ++c) {
		a.gradient[c] = fields->component(gradientField, c);
		a.last[c]     = fields->component(stressField, c);
	}
	for (int c = 0; c < tangentSize<Dim>; ++c)
		a.tangent[c] = fields->component(tangentField, c);
	a.saturation = fields->component(saturationField);
	a.ratio      = fields->component(ratioField);
	a.tolerance  = fields->component(toleranceField);
	return a;
}

template <int Dim> void SampleSkeleton<Dim>::initialise(const SkeletonBatch<Dim>& batch)
{
	const Arrays a = arrays();
	store->clear();
	// by id: the numbering of samples must not depend on how points are sorted in memory
	std::map<int, int> placeOf;
	for (int k = 0; k < batch.count; ++k)
		placeOf[batch.id[batch.place[k]]] = batch.place[k];
	for (const auto& [id, place] : placeOf) {
		if (id >= int(prototypeOf.size()) || prototypeOf[id] < 0)
			throw std::invalid_argument(
			        "RveSkeleton.sampleOf has no number for point " + std::to_string(id) + ": give one number per point, or none at all.");
		const double iceSaturation    = batch.iceSaturation ? batch.iceSaturation[place] : store->prototypeIce(prototypeOf[id]);
		sampleOf[id]                  = int(store->size());
		const SampleStart<Dim>& start = store->add(prototypeOf[id], iceSaturation, schedule.update);
		if (bands && !bands->has(place)) continue;
		const auto tangent = compact<Dim>(start.tangent);
		for (int c = 0; c < tangentSize<Dim>; ++c)
			a.tangent[c][place] = tangent[c];
		a.setAccumulated(place, Matrix::Zero());
		a.saturation[place] = iceSaturation;
		a.ratio[place]      = 1;
		a.tolerance[place]  = schedule.strainTolerance;
		a.setLastStress(place, start.stress);
		if (schedule.followsTime()) fields->component(timeField)[place] = 0;
		storeStress<Dim>(batch, place, start.stress);
		if (accuracy) accuracy->begin(place);
	}
	count.points = placeOf.size();
	if (bands) banded->own(owners(store->size()));
}

template <int Dim> bool SampleSkeleton<Dim>::isDue(const Arrays& a, int place, const Matrix& h, const Matrix& change, double iceSaturation) const
{
	const double most = h.cwiseAbs().maxCoeff();
	if (schedule.strainTolerance <= 0 ? most > 0 : most > a.tolerance[place]) return true;
	if (schedule.steersTolerance() && !accuracy && change.norm() > changeOverError * schedule.stressTolerance * (a.lastStress(place).norm() + stressFloor))
		return true;
	const double ofIce = std::fabs(iceSaturation - a.saturation[place]);
	if (ofIce == 0) return false;
	// ice that vanishes or appears altogether makes or breaks bonds: never wait for it
	return ofIce > schedule.saturationTolerance || iceSaturation == 0 || a.saturation[place] == 0;
}

template <int Dim> void SampleSkeleton<Dim>::updateStress(const SkeletonBatch<Dim>& batch)
{
	const Arrays a = arrays();
	if (bands) banded->beginStep();
	if (accuracy) accuracy->countStep();
	if (schedule.followsTime()) passTime(batch);
	flagScratch.assign(batch.count, 0);
	constexpr int piece = 128, fewestForThreads = 500;
	const auto    follow = [&](int k) {
                const int place = batch.place[k];
                if (!isolated.empty() && isolated.count(batch.id[place])) return;
                Matrix step;
                for (int c = 0; c < Dim * Dim; ++c)
                        step(c / Dim, c % Dim) = batch.gradient[c][place];
                const Matrix before = a.accumulated(place), h = before + step * (Matrix::Identity() + before); // eq. (15.1)
                a.setAccumulated(place, h);
                const Matrix change        = schedule.prediction ? a.predictedChange(place, h) : Matrix(Matrix::Zero());
                const double iceSaturation = batch.iceSaturation ? batch.iceSaturation[place] : a.saturation[place];
                if (isDue(a, place, h, change, iceSaturation) || (schedule.iceCreep && hasCrept(batch, place))) flagScratch[k] = 1;
                else if (schedule.prediction) storeStress<Dim>(batch, place, a.predicted(place, h, change));
	};
	ThreadTeam::run((batch.count + piece - 1) / piece, batch.count >= fewestForThreads ? ThreadTeam::threads() : 1, [&](int i, int) {
		for (int k = i * piece; k < std::min(batch.count, (i + 1) * piece); ++k)
			follow(k);
	});
	if (!changed.empty()) flagChanged(batch);
	dueScratch.clear();
	for (int k = 0; k < batch.count; ++k)
		if (flagScratch[k]) dueScratch.push_back(batch.place[k]);
	if (bands) askInBands(batch, dueScratch, a);
	else if (!dueScratch.empty()) book(ask(batch, dueScratch, a));
}

/// Calendar time since the samples were updated.
template <int Dim> void SampleSkeleton<Dim>::passTime(const SkeletonBatch<Dim>& batch) const
{
	double* time = fields->component(timeField);
	for (int k = 0; k < batch.count; ++k)
		time[batch.place[k]] += batch.time.calendar;
}

/// Whether the bonds of a point's sample have had time to creep.
template <int Dim> bool SampleSkeleton<Dim>::hasCrept(const SkeletonBatch<Dim>& batch, int place) const
{
	const double time = fields->component(timeField)[place];
	return time > 0 && time >= schedule.creepInterval && !(batch.iceSaturation && batch.iceSaturation[place] == 0);
}

/// At the temperature of a point, over the time since its sample was asked.
template <int Dim> BondCreep SampleSkeleton<Dim>::creep(const SkeletonBatch<Dim>& batch, int place) const
{
	const IceCreepLaw& law = *schedule.iceCreep;
	return law.over(batch.temperature ? batch.temperature[place] : law.referenceTemperature, fields->component(timeField)[place]);
}

/// At the temperature of a point and the largest principal strain rate since its sample was last updated, eq. (15.7).
template <int Dim> BondStrengthFactors SampleSkeleton<Dim>::strengthFactors(const SkeletonBatch<Dim>& batch, int place, const Matrix& gradient) const
{
	const IceStrengthLaw& law    = *schedule.iceStrength;
	const Matrix          strain = 0.5 * (gradient + gradient.transpose());
	const double          size   = Eigen::SelfAdjointEigenSolver<Matrix>(strain, Eigen::EigenvaluesOnly).eigenvalues().cwiseAbs().maxCoeff();
	const double          time   = fields->component(timeField)[place];
	return law.factors(batch.temperature ? batch.temperature[place] : law.referenceTemperature, time > 0 ? size / time : 0.);
}

template <int Dim> void SampleSkeleton<Dim>::flagChanged(const SkeletonBatch<Dim>& batch)
{
	for (int k = 0; k < batch.count; ++k)
		if (changed.count(batch.id[batch.place[k]])) flagScratch[k] = 1;
	changed.clear();
}

template <int Dim>
std::vector<PackedRequest<Dim>> SampleSkeleton<Dim>::requests(const SkeletonBatch<Dim>& batch, const std::vector<int>& due, const Arrays& a) const
{
	std::vector<PackedRequest<Dim>> list;
	for (const int place : due) {
		list.push_back({ std::size_t(sampleOf[batch.id[place]]), a.accumulated(place),
		                 batch.iceSaturation ? batch.iceSaturation[place] : a.saturation[place] });
		if (schedule.iceStrength) {
			list.back().strength = strengthFactors(batch, place, list.back().displacementGradient);
			if (batch.temperature) list.back().iceStiffness = schedule.iceStrength->stiffness(batch.temperature[place]);
		}
		if (schedule.iceCreep) list.back().creep = creep(batch, place);
		if (!accuracy) continue;
		list.back().inertialNumber = accuracy->inertialNumber(place);
		list.back().compareRates   = accuracy->comparesRates(place);
	}
	return list;
}

template <int Dim> typename SampleSkeleton<Dim>::Asked SampleSkeleton<Dim>::ask(const SkeletonBatch<Dim>& batch, const std::vector<int>& due, const Arrays& a)
{
	const auto          start = std::chrono::steady_clock::now();
	Asked               came;
	const auto          asked   = requests(batch, due, a);
	PackedUpdateOptions options = schedule.update;
	options.tangent             = schedule.prediction;
	const auto results          = store->update(asked, options, schedule.threads);
	for (std::size_t r = 0; r < due.size(); ++r) {
		const int place = due[r];
		came.steps += std::uint64_t(results[r].steps);
		if (results[r].blewUp) came.blownUp.push_back({ batch.id[place], results[r].reason });
		const Matrix h = a.accumulated(place), predicted = a.predicted(place, h, a.predictedChange(place, h));
		const Matrix before = a.lastStress(place), after = results[r].stress;
		if (schedule.prediction && !results[r].blewUp) {
			const Matrix turn    = rotationOf(h);
			const double elastic = elasticChange<Dim>(a.tangentAt(place), h).norm(), actual = (after - turn * before * turn.transpose()).norm();
			a.ratio[place] = elastic > 0 ? std::min(1., actual / elastic) : 1.;
			const auto c   = compact<Dim>(results[r].tangent);
			for (int i = 0; i < tangentSize<Dim>; ++i)
				a.tangent[i][place] = c[i];
			const double error = (after - predicted).norm();
			if (accuracy) came.errors.push_back(steer(batch, place, error, results[r], a));
			else if (schedule.steersTolerance()) {
				const double tight = a.ratio[place] < failingRatio ? failingTightness : 1., given = schedule.strainTolerance;
				a.tolerance[place] = steeredStrainTolerance(
				        a.tolerance[place], h.cwiseAbs().maxCoeff(), schedule.stressTolerance * (after.norm() + stressFloor), error,
				        given / toleranceRange, toleranceRange * given * tight);
			}
		}
		a.setLastStress(place, after);
		a.setAccumulated(place, Matrix::Zero());
		a.saturation[place] = asked[r].iceSaturation;
		if (schedule.followsTime()) fields->component(timeField)[place] = 0;
		storeStress<Dim>(batch, place, after);
	}
	came.calls = due.size();
	count.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
	return came;
}

template <int Dim>
SampleAccuracy::Term SampleSkeleton<Dim>::steer(
        const SkeletonBatch<Dim>& batch, int place, double predictionError, const PackedUpdateResult<Dim>& result, const Arrays& a)
{
	SampleAccuracy::Answer answer;
	answer.place           = place;
	answer.volume          = batch.volume[place];
	answer.stress          = result.stress.norm();
	answer.predictionError = predictionError;
	answer.rateError       = result.rateError;
	answer.strain          = a.accumulated(place).cwiseAbs().maxCoeff();
	return accuracy->learn(answer, a.tolerance[place]);
}

void PointSamples::book(const Asked& asked)
{
	count.calls += asked.calls;
	count.steps += asked.steps;
	for (const auto& term : asked.errors)
		accuracy->book(term);
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

// ---- where ranks have bands of the ground ---------------------------------------------------------------------------------

/// Answers stay where their points are. What has to be known by all ranks is how many there were, what they add to the estimated error, and
/// which samples blew up.
template <int Dim> void SampleSkeleton<Dim>::askInBands(const SkeletonBatch<Dim>& batch, const std::vector<int>& due, const Arrays& a)
{
	Asked       own;
	std::string failure;
	try {
		if (!due.empty()) own = ask(batch, due, a);
	} catch (const std::exception& problem) {
		failure = problem.what();
	}
	book(ofAllRanks(own, failure));
}

template <int Dim> typename SampleSkeleton<Dim>::Asked SampleSkeleton<Dim>::ofAllRanks(const Asked& own, const std::string& failure)
{
	struct Told {
		std::uint64_t calls, steps, errors, hasWords;
		double        cost;
	};
	const auto byRank = bands->byRank(Told { own.calls, own.steps, own.errors.size(), !failure.empty() || !own.blownUp.empty(), banded->takeCost() });
	Asked      all;
	bool       anyWords = false;
	std::vector<std::size_t> lengths;
	std::vector<double>      costs;
	std::size_t              errors = 0;
	for (const Told& told : byRank) {
		all.calls += told.calls;
		all.steps += told.steps;
		errors += told.errors;
		anyWords = anyWords || told.hasWords;
		lengths.push_back(told.errors * sizeof(SampleAccuracy::Term));
		costs.push_back(told.cost);
	}
	banded->bookCosts(costs);
	all.errors.resize(errors);
	if (errors > 0) bands->ranks().allGather(own.errors.data(), lengths, all.errors.data());
	if (!anyWords) return all;
	ByteWriter words;
	words.block(failure);
	words.number(own.blownUp.size());
	for (const auto& [id, reason] : own.blownUp) {
		words.number(std::uint64_t(id));
		words.block(reason);
		words.block(banded->stateToShow(sampleNumber(id))); // the first rank keeps it
	}
	const auto said = bands->say(words.bytes());
	for (int rank = 0; rank < bands->count(); ++rank) {
		ByteReader reader(said[std::size_t(rank)]);
		const auto problem = reader.block();
		if (!problem.empty()) throw std::runtime_error(problem);
		for (std::uint64_t left = reader.number(); left > 0; --left) {
			const int id = int(reader.number());
			all.blownUp.push_back({ id, reader.block() });
			banded->show(sampleNumber(id), reader.block());
		}
	}
	return all;
}

template <int Dim> void SampleSkeleton<Dim>::addCost(const SkeletonPoints& points, double* costByPlace)
{
	for (int k = 0; banded && k < points.count; ++k)
		costByPlace[points.place[k]] += pointStepsPerCost * banded->takeCost(sampleNumber(points.id[points.place[k]]));
}

/// The rank of the point of each sample, -1 for one that no point has.
template <int Dim> std::vector<int> SampleSkeleton<Dim>::owners(std::size_t samples) const
{
	std::vector<int> ownerOf(samples, -1);
	for (int rank = 0; rank < bands->count(); ++rank) {
		const auto [first, end] = bands->pointsOf(rank);
		for (int place = first; place < end; ++place)
			if (has(idAt[place])) ownerOf[std::size_t(sampleOf[idAt[place]])] = rank;
	}
	return ownerOf;
}

template <int Dim> void SampleSkeleton<Dim>::followBands(Bands& of, const int* ids, bool moved)
{
	if (!banded) throw std::logic_error("SampleSkeleton: a ground in bands needs a BandStore");
	bands = &of;
	idAt  = ids;
	if (moved) banded->deal(owners(store->size()));
	else banded->own(owners(store->size()));
}

template <int Dim> void SampleSkeleton<Dim>::beginWithOwners()
{
	const int last = sampleOf.empty() ? -1 : *std::max_element(sampleOf.begin(), sampleOf.end());
	if (bands) banded->own(owners(std::size_t(last + 1)));
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

template <int Dim> ErrorSquares SampleSkeleton<Dim>::errorSquares(const SkeletonPoints& batch) const
{
	if (!accuracy) return {};
	const Arrays a   = arrays();
	ErrorSquares sum = accuracy->squares();
	for (int k = 0; k < batch.count; ++k) {
		const auto term = accuracy->pending(batch.place[k], batch.volume[batch.place[k]], a.lastStress(batch.place[k]).norm());
		sum.add(term.weight, term.error, term.stress);
	}
	return sum;
}

template <int Dim> void SampleSkeleton<Dim>::tangentModulus(const SkeletonBatch<Dim>& batch, double* modulus) const
{
	for (int k = 0; k < batch.count; ++k) {
		const int place = batch.place[k], prototype = prototypeOf[batch.id[place]];
		modulus[place] = store->oedometricModulus(prototype, batch.iceSaturation ? batch.iceSaturation[place] : store->prototypeIce(prototype));
	}
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

std::string PointSamples::save() const
{
	ByteWriter writer;
	writer.block(archiveMagic);
	anyStore->save(writer);
	saveBooks(writer);
	return writer.bytes();
}

std::string PointSamples::saveBeside(const SampleStore::Layout& layout) const
{
	ByteWriter writer;
	writer.block(besideMagic);
	layout.save(writer);
	saveBooks(writer);
	return writer.bytes();
}

void PointSamples::saveBooks(ByteWriter& writer) const
{
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
}

namespace {
	void requireMagic(ByteReader& reader, const char* magic)
	{
		if (reader.block() != magic)
			throw std::runtime_error(
			        "RveSkeleton: the saved samples are not those of this version of Talik: continue them with the version that saved them.");
	}
} // namespace

void PointSamples::restore(const std::string& bytes)
{
	ByteReader reader(bytes);
	requireMagic(reader, archiveMagic);
	ByteReader states = reader; // which are restored when it is known who has which
	SampleStore::skip(reader);
	restoreNumbers(reader);
	anyStore->restore(states);
	restoreBooks(reader);
}

void PointSamples::restoreBeside(const std::string& bytes, const PartedFile& file, std::uint64_t at)
{
	ByteReader reader(bytes);
	requireMagic(reader, besideMagic);
	const auto layout = SampleStore::Layout::from(reader);
	restoreNumbers(reader);
	anyStore->restore(layout, file, at);
	restoreBooks(reader);
}

void PointSamples::restoreNumbers(ByteReader& reader)
{
	sampleOf.assign(reader.number(), -1);
	for (int& s : sampleOf)
		s = int(reader.number()) - 1;
	beginWithOwners();
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
	if (accuracy) accuracy->restore(reader);
}

template class SampleSkeleton<2>;
template class SampleSkeleton<3>;

} // namespace talik
