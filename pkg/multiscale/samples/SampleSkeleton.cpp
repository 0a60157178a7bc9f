// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/Errors.hpp>
#include <pkg/base/SavedBytes.hpp>
#include <pkg/base/ThreadPool.hpp>
#include <pkg/mpm/points/SlabDecomposition.hpp>
#include <pkg/multiscale/samples/SampleSkeleton.hpp>
#include <pkg/multiscale/samples/StressPrediction.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

namespace talik {
namespace {
	/// Steps of a point of the ground that take as long as a DEM step of a packed sample, over the bytes of that: 4e-4 with discs, less in space.
	constexpr double pointStepsPerCost = 5e-4;

	template <int Dim> using MatrixOf = typename PackedTypes<Dim>::Matrix;

	/// Out of plane discs do not touch; the mean of the in-plane stresses stands there for display and invariants.
	template <int Dim> void storeStress(const SkeletonBatch<Dim>& batch, int place, const MatrixOf<Dim>& s)
	{
		for (int n = 0; n < symmetricSize<Dim>; ++n) {
			const auto [i, j]                           = symmetricPair<Dim>(n);
			batch.stress[stressIndex<Dim>(i, j)][place] = i == j ? s(i, i) : 0.5 * (s(i, j) + s(j, i));
		}
		if (Dim == 2) batch.stress[2][place] = 0.5 * (s(0, 0) + s(1, 1));
	}
} // namespace

template <int Dim>
SampleSkeleton<Dim>::SampleSkeleton(std::shared_ptr<SampleStoreOf<Dim>> samples, std::vector<int> of, const SampleScheduling& s)
        : PointSamples(samples, std::move(of), s)
        , store(std::move(samples))
        , ofSlabs(std::dynamic_pointer_cast<SlabStore<Dim>>(store))
{}

template <int Dim> void SampleSkeleton<Dim>::declareFields(PointFields& f, const std::string& prefix)
{
	record.declare(f, prefix, name(), schedule.followsTime());
	if (accuracy) accuracy->declareFields(f, prefix, name());
}

template <int Dim> void SampleSkeleton<Dim>::initialise(const SkeletonBatch<Dim>& batch)
{
	const Record& a = record;
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
		if (slabs && !slabs->has(place)) continue;
		a.setTangent(place, start.tangent);
		a.setAccumulated(place, Matrix::Zero());
		a.saturation[place] = iceSaturation;
		a.ratio[place]      = 1;
		a.tolerance[place]  = schedule.strainTolerance;
		a.setLastStress(place, start.stress);
		if (a.time) a.time[place] = 0;
		storeStress<Dim>(batch, place, start.stress);
		if (accuracy) accuracy->begin(place);
	}
	count.points = placeOf.size();
	if (slabs) ofSlabs->own(owners(store->size()));
}

template <int Dim> void SampleSkeleton<Dim>::divide(const std::vector<int>& parents)
{
	for (const int id : parents) {
		prototypeOf.push_back(prototypeOf[id]);
		sampleOf.push_back(sampleOf[id] < 0 ? -1 : int(store->size()));
		if (sampleOf[id] < 0) continue;
		store->copy(std::size_t(sampleOf[id]));
		++count.points;
		if (isolated.count(id)) isolated.insert(int(sampleOf.size()) - 1);
		if (changed.count(id)) changed.insert(int(sampleOf.size()) - 1);
	}
}

template <int Dim> void SampleSkeleton<Dim>::updateStress(const SkeletonBatch<Dim>& batch)
{
	const Record&               a = record;
	const StressPrediction<Dim> predictor { a };
	const auto                  when = scheduler();
	if (slabs) ofSlabs->beginStep();
	if (a.time) when.passTime(a, batch);
	flagScratch.assign(batch.count, 0);
	constexpr int piece = 128, fewestForThreads = 500;
	const auto    follow = [&](int k) {
                const int place = batch.place[k];
                if (accuracy) accuracy->passStep(place);
                if (!isolated.empty() && isolated.count(batch.id[place])) return;
                Matrix step;
                for (int c = 0; c < Dim * Dim; ++c)
                        step(c / Dim, c % Dim) = batch.gradient[c][place];
                const Matrix before = a.accumulated(place), h = before + step * (Matrix::Identity() + before); // eq. (15.1)
                a.setAccumulated(place, h);
                const Matrix change        = schedule.prediction ? predictor.change(place, h) : Matrix(Matrix::Zero());
                const double iceSaturation = batch.iceSaturation ? batch.iceSaturation[place] : a.saturation[place];
                if (when.isDue(a, place, h, change, iceSaturation) || (schedule.iceCreep && when.hasCrept(a, batch, place))) flagScratch[k] = 1;
                else if (schedule.prediction) storeStress<Dim>(batch, place, predictor.stress(place, h, change));
	};
	ThreadPool::run((batch.count + piece - 1) / piece, batch.count >= fewestForThreads ? ThreadPool::threads() : 1, [&](int i, int) {
		for (int k = i * piece; k < std::min(batch.count, (i + 1) * piece); ++k)
			follow(k);
	});
	if (!changed.empty()) flagChanged(batch);
	dueScratch.clear();
	for (int k = 0; k < batch.count; ++k)
		if (flagScratch[k]) dueScratch.push_back(batch.place[k]);
	if (slabs) askInSlabs(batch, dueScratch, a);
	else if (!dueScratch.empty()) book(ask(batch, dueScratch, a));
}

template <int Dim> void SampleSkeleton<Dim>::flagChanged(const SkeletonBatch<Dim>& batch)
{
	for (int k = 0; k < batch.count; ++k)
		if (changed.count(batch.id[batch.place[k]])) flagScratch[k] = 1;
	changed.clear();
}

template <int Dim>
std::vector<PackedRequest<Dim>> SampleSkeleton<Dim>::requests(const SkeletonBatch<Dim>& batch, const std::vector<int>& due, const Record& a) const
{
	std::vector<PackedRequest<Dim>> list;
	for (const int place : due) {
		list.push_back(scheduler().request(a, batch, place, std::size_t(sampleOf[batch.id[place]])));
		if (!accuracy) continue;
		list.back().inertialNumber = accuracy->inertialNumber(place);
		list.back().compareRates   = accuracy->comparesRates(place);
	}
	return list;
}

template <int Dim> typename SampleSkeleton<Dim>::Asked SampleSkeleton<Dim>::ask(const SkeletonBatch<Dim>& batch, const std::vector<int>& due, const Record& a)
{
	const auto          start = std::chrono::steady_clock::now();
	Asked               came;
	const auto          asked           = requests(batch, due, a);
	PackedUpdateOptions options         = schedule.update;
	options.tangent                     = schedule.prediction;
	const auto                  results = store->update(asked, options, schedule.threads);
	const StressPrediction<Dim> predictor { a };
	for (std::size_t r = 0; r < due.size(); ++r) {
		const int place = due[r];
		came.steps += std::uint64_t(results[r].steps);
		if (results[r].blewUp) came.blownUp.push_back({ batch.id[place], results[r].reason });
		const Matrix h = a.accumulated(place), after = results[r].stress;
		if (schedule.prediction && !results[r].blewUp) {
			const double error = (after - predictor.stress(place, h, predictor.change(place, h))).norm();
			predictor.learn(place, h, after, results[r].tangent);
			if (accuracy) steer(place, error, results[r], a);
			else scheduler().steer(a, place, h, after, error, predictor.failing(place));
		}
		a.setLastStress(place, after);
		a.setAccumulated(place, Matrix::Zero());
		a.saturation[place] = asked[r].iceSaturation;
		if (a.time) a.time[place] = 0;
		storeStress<Dim>(batch, place, after);
	}
	came.calls = due.size();
	count.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
	return came;
}

template <int Dim> void SampleSkeleton<Dim>::steer(int place, double predictionError, const PackedUpdateResult<Dim>& result, const Record& a)
{
	SampleAccuracy::Answer answer;
	answer.place           = place;
	answer.stress          = result.stress.norm();
	answer.predictionError = predictionError;
	answer.rateError       = result.rateError;
	answer.strain          = a.accumulated(place).cwiseAbs().maxCoeff();
	accuracy->learn(answer, a.tolerance[place]);
}

// ---- where ranks have slabs of the ground ---------------------------------------------------------------------------------

/// Answers stay where their points are. What has to be known by all ranks is how many there were, and which samples blew up.
template <int Dim> void SampleSkeleton<Dim>::askInSlabs(const SkeletonBatch<Dim>& batch, const std::vector<int>& due, const Record& a)
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
		std::uint64_t calls, steps, hasWords;
		double        cost;
	};
	const auto          byRank = slabs->byRank(Told { own.calls, own.steps, !failure.empty() || !own.blownUp.empty(), ofSlabs->takeCost() });
	Asked               all;
	bool                anyWords = false;
	std::vector<double> costs;
	for (const Told& told : byRank) {
		all.calls += told.calls;
		all.steps += told.steps;
		anyWords = anyWords || told.hasWords;
		costs.push_back(told.cost);
	}
	ofSlabs->bookCosts(costs);
	if (!anyWords) return all;
	ByteWriter words;
	words.block(failure);
	words.number(own.blownUp.size());
	for (const auto& [id, reason] : own.blownUp) {
		words.number(std::uint64_t(id));
		words.block(reason);
		words.block(ofSlabs->stateToShow(sampleNumber(id))); // the first rank keeps it
	}
	const auto said = slabs->say(words.bytes());
	for (int rank = 0; rank < slabs->count(); ++rank) {
		ByteReader reader(said[std::size_t(rank)]);
		const auto problem = reader.block();
		if (!problem.empty()) throw std::runtime_error(problem);
		for (std::uint64_t left = reader.number(); left > 0; --left) {
			const int id = int(reader.number());
			all.blownUp.push_back({ id, reader.block() });
			ofSlabs->show(sampleNumber(id), reader.block());
		}
	}
	return all;
}

template <int Dim> void SampleSkeleton<Dim>::addCost(const SkeletonPoints& points, double* costByPlace)
{
	for (int k = 0; ofSlabs && k < points.count; ++k)
		costByPlace[points.place[k]] += pointStepsPerCost * ofSlabs->takeCost(sampleNumber(points.id[points.place[k]]));
}

/// The rank of the point of each sample, -1 for one that no point has.
template <int Dim> std::vector<int> SampleSkeleton<Dim>::owners(std::size_t samples) const
{
	std::vector<int> ownerOf(samples, -1);
	for (int rank = 0; rank < slabs->count(); ++rank) {
		const auto [first, end] = slabs->pointsOf(rank);
		for (int place = first; place < end; ++place)
			if (has(idAt[place])) ownerOf[std::size_t(sampleOf[idAt[place]])] = rank;
	}
	return ownerOf;
}

template <int Dim> void SampleSkeleton<Dim>::followSlabs(SlabDecomposition& of, const int* ids, bool moved)
{
	if (!ofSlabs) throw std::logic_error("SampleSkeleton: a ground in slabs needs a SlabStore");
	slabs = &of;
	idAt  = ids;
	if (moved) ofSlabs->deal(owners(store->size()));
	else ofSlabs->own(owners(store->size()));
}

template <int Dim> void SampleSkeleton<Dim>::beginWithOwners()
{
	const int last = sampleOf.empty() ? -1 : *std::max_element(sampleOf.begin(), sampleOf.end());
	if (slabs) ofSlabs->own(owners(std::size_t(last + 1)));
}

template <int Dim> ErrorSquares SampleSkeleton<Dim>::errorSquares(const SkeletonPoints& batch) const
{
	ErrorSquares sum;
	for (int k = 0; accuracy && k < batch.count; ++k) {
		const auto its = accuracy->squares(batch.place[k], record.lastStress(batch.place[k]).norm());
		sum.add(batch.volume[batch.place[k]], its.error, its.stress);
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

TALIK_IN_PLANE_AND_SPACE(SampleSkeleton);

} // namespace talik
