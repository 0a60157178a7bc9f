// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cstdint>
#include <memory>
#include <mutex>
#include <pkg/icebond/IceBond.hpp>
#include <vector>

namespace talik {

/// The parameters of one material as they are now, and a number that they share with no others in the process: a change takes a new one.
struct NumberedBonds {
	IceBondModel  model;
	std::uint64_t number;
};

/// The bonds between grains of two materials.
struct BondMixture {
	IceBondModel  model;
	std::uint64_t first, second; ///< numbers of their parameters
	double        secondYoung;   ///< the moduli without ice, which stock YADE lets change unseen, are compared themselves [Pa]

	bool isOf(std::uint64_t a, double youngOfA, std::uint64_t b, double youngOfB) const
	{
		return first == a && second == b && model.young == youngOfA && secondYoung == youngOfB;
	}
};

/// Mixtures of a material with others, each held by the contacts that have it.
class BondMixtures {
public:
	std::shared_ptr<const BondMixture> with(const NumberedBonds& own, const NumberedBonds& other);

private:
	std::mutex                                    guard; ///< contacts are computed by several threads
	std::vector<std::weak_ptr<const BondMixture>> known;
};

/// For parameters that are new or have changed.
std::uint64_t nextBondNumber();

} // namespace talik
