// SPDX-License-Identifier: GPL-2.0-or-later
// Measures of a sample, from the geometry and the forces of its contacts.
#include <algorithm>
#include <cmath>
#include <pkg/rve/packed/PackedWorkspace.hpp>
#include <pkg/rve/SampleUpdate.hpp>

namespace talik {

template <int Dim> typename PackedWorkspace<Dim>::Geometry PackedWorkspace<Dim>::geometry(const Lanes& lanes, std::size_t lane) const
{
	Geometry pair;
	pair.rows      = pairRows(view, &lanes == &periodicLanes ? view.periodic : view.inner, lane);
	pair.distance  = std::sqrt(pairBranch(view, pair.rows, pair.n));
	pair.sumRadius = lanes.block[lane / packedWidth].sumRadius[lane % packedWidth];
	pair.overlap   = pair.sumRadius - pair.distance;
	for (double& component : pair.n)
		component /= pair.distance;
	return pair;
}

/// Geometry of all pairs of a block; square: of their distances [m2].
template <int Dim>
void PackedWorkspace<Dim>::blockGeometry(const PackedPairs<Dim>& pairs, std::size_t b, Geometry (&result)[packedWidth], double (&square)[packedWidth]) const
{
	double                  branch[Dim][packedWidth], distance[packedWidth];
	const PackedBlock<Dim>& block = pairs.block[b];
	for (std::size_t l = 0; l < packedWidth; ++l) {
		double n[Dim];
		result[l].rows = pairRows(view, pairs, b * packedWidth + l);
		square[l]      = pairBranch(view, result[l].rows, n);
		for (int d = 0; d < Dim; ++d)
			branch[d][l] = n[d];
	}
	for (std::size_t l = 0; l < packedWidth; ++l) {
		distance[l] = std::sqrt(square[l]);
		for (int d = 0; d < Dim; ++d)
			branch[d][l] /= distance[l];
	}
	for (std::size_t l = 0; l < packedWidth; ++l) {
		result[l].distance  = distance[l];
		result[l].sumRadius = block.sumRadius[l];
		result[l].overlap   = block.sumRadius[l] - distance[l];
		for (int d = 0; d < Dim; ++d)
			result[l].n[d] = branch[d][l];
	}
}

/// Calls visitor(geometry, normal stiffness, normal force, shear, bond) for every contact that bears or could bear a force.
template <int Dim> template <class Visitor> void PackedWorkspace<Dim>::forContacts(Visitor&& visit) const
{
	for (const Lanes* lanes : { &innerLanes, &periodicLanes })
		for (std::size_t b = 0; b < lanes->block.size(); ++b) {
			const PackedBlock<Dim>& block = lanes->block[b];
			Geometry                pairs[packedWidth];
			double                  square[packedWidth];
			blockGeometry(lanes == &periodicLanes ? view.periodic : view.inner, b, pairs, square);
			for (std::size_t l = 0; l < std::min(packedWidth, lanes->pairs - b * packedWidth); ++l) {
				const Geometry& now = pairs[l];
				if (!carriesBonds) {
					if (square[l] > now.sumRadius * now.sumRadius || now.overlap < 0) continue;
					visit(now, block.stiffness[l], block.stiffness[l] * now.overlap, laneShear<Dim>(block.shear, l), IceBond());
					continue;
				}
				const std::size_t lane = b * packedWidth + l;
				const IceBond     bond = lanes->bond[lane].relaxed(now.overlap);
				if (now.overlap < 0 && !bond.intact()) continue;
				const ContactResponse<double> contact = bond.response(stiffness(*lanes, lane, iceRatio), strength(*lanes, lane));
				visit(now, contact.stiffness, contact.stiffness * now.overlap - contact.offset, laneShear<Dim>(block.shear, l), bond);
			}
		}
}

template <int Dim> PackedStatistics<Dim> PackedWorkspace<Dim>::statistics() const
{
	PackedStatistics<Dim> result;
	std::vector<Vector>   net(grainCount, Vector::Zero());
	double                forces = 0, overlaps = 0;
	forContacts([&](const Geometry& now, double, double normalForce, const Shear& shear, const IceBond& bond) {
		double       force[Dim];
		const double norm = shearNorm(shear);
		pairForce<Dim>(now.n, normalForce, shear, force);
		for (int d = 0; d < Dim; ++d) {
			net[now.rows.first][d] -= force[d];
			net[now.rows.second][d] += force[d];
			for (int e = 0; e < Dim; ++e)
				result.fabric(d, e) += now.n[d] * now.n[e];
		}
		forces += std::sqrt(normalForce * normalForce + norm * norm);
		++result.contacts;
		result.bondsIntact += bond.intact();
		result.bondsBroken += bond.state == BondState::BROKEN;
		if (now.overlap <= 0) return;
		overlaps += now.overlap / now.sumRadius;
		result.maxOverlapRatio = std::max(result.maxOverlapRatio, now.overlap / std::min(view.radius[now.rows.first], view.radius[now.rows.second]));
	});
	double solid = 0, imbalance = 0;
	for (std::size_t g = 0; g < grainCount; ++g) {
		const double* x      = view.position(g);
		const double  r      = view.radius[g];
		double        square = 0, spinSquare = 0;
		for (int d = 0; d < Dim; ++d) {
			double v = view.velocity(g)[d];
			for (int e = 0; e < Dim; ++e)
				v -= view.prevVelGrad[d * Dim + e] * x[e];
			square += v * v;
		}
		for (int d = 0; d < PackedLayout<Dim>::angular; ++d) {
			const double w = view.spin(g, d);
			spinSquare += w * w;
		}
		result.kineticEnergy += 0.5 * (grains->mass[g] * square + grains->inertia[g] * spinSquare);
		solid += Dim == 2 ? M_PI * r * r * base.thickness : 4. / 3. * M_PI * r * r * r;
		imbalance += net[g].norm();
	}
	result.porosity           = 1 - solid / parameters().volume();
	result.coordinationNumber = 2. * double(result.contacts) / double(grainCount);
	result.cellThickness      = cellThickness();
	if (result.contacts > 0) {
		result.fabric /= double(result.contacts);
		result.meanOverlapRatio = overlaps / double(result.contacts);
	}
	if (forces > 0) result.unbalancedForce = (imbalance / double(grainCount)) / (forces / double(result.contacts));
	return result;
}

template <int Dim> double PackedWorkspace<Dim>::cellThickness() const { return shortestImage<Dim>(hSize()) / (2 * averageRadius); }

template <int Dim> PackedTangent<Dim> tangentFromSums(const double* second, const double* fourth, double stiffnessRatio)
{
	constexpr int products = Dim * (Dim + 1) / 2;
	const auto    product  = [](int j, int l) {
                const auto [smaller, larger] = std::minmax({ j, l });
                return smaller * (2 * Dim - smaller - 1) / 2 + larger;
	};
	PackedTangent<Dim> result {};
	for (int i = 0; i < Dim; ++i)
		for (int j = 0; j < Dim; ++j)
			for (int k = 0; k < Dim; ++k)
				for (int l = 0; l < Dim; ++l) {
					const auto [first, last]                    = std::minmax({ product(i, j), product(k, l) });
					result[((i * Dim + j) * Dim + k) * Dim + l] = (1 - stiffnessRatio) * fourth[first * products + last]
					        + (i == k ? stiffnessRatio * second[product(j, l)] : 0.);
				}
	return result;
}

template <int Dim> PackedTangent<Dim> PackedWorkspace<Dim>::tangent() const
{
	// C = (1 - ratio) sum f n n n n + ratio sum f delta_ik n_j n_l with f = d^2 k_n/V
	constexpr int products = Dim * (Dim + 1) / 2; // n_j n_l with j <= l, row by row
	double        fourth[products][products] {}, second[products] {};
	const double  volume = parameters().volume();
	forContacts([&](const Geometry& now, double stiffness, double, const Shear&, const IceBond&) {
		const double factor = now.distance * now.distance * stiffness / volume;
		double       pairs[products];
		for (int j = 0, k = 0; j < Dim; ++j)
			for (int l = j; l < Dim; ++l)
				pairs[k++] = now.n[j] * now.n[l];
		for (int k = 0; k < products; ++k) {
			const double weighted = factor * pairs[k];
			second[k] += weighted;
			for (int l = k; l < products; ++l)
				fourth[k][l] += weighted * pairs[l];
		}
	});
	return tangentFromSums<Dim>(second, &fourth[0][0], base.stiffnessRatio);
}

template PackedWorkspace<2>::Geometry PackedWorkspace<2>::geometry(const Lanes&, std::size_t) const;
template PackedStatistics<2>          PackedWorkspace<2>::statistics() const;
template double                       PackedWorkspace<2>::cellThickness() const;
template PackedTangent<2>             PackedWorkspace<2>::tangent() const;
template PackedTangent<2>             tangentFromSums<2>(const double*, const double*, double);
template PackedTangent<3>             tangentFromSums<3>(const double*, const double*, double);
template PackedWorkspace<3>::Geometry PackedWorkspace<3>::geometry(const Lanes&, std::size_t) const;
template PackedStatistics<3>          PackedWorkspace<3>::statistics() const;
template double                       PackedWorkspace<3>::cellThickness() const;
template PackedTangent<3>             PackedWorkspace<3>::tangent() const;

} // namespace talik
