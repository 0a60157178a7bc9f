// SPDX-License-Identifier: GPL-2.0-or-later
// Where a packed sample lies on a card between calls, and what the block of threads that advances it holds.
#pragma once
#include <pkg/rve/device/CardTarget.hpp>
#include <pkg/rve/device/SampleCall.hpp>

namespace talik {
namespace N_ONE {

	// ---------------------------------------------------------------------------------------------- cell, in plain numbers as on the host

	template <int Dim> HWY_INLINE void multiply(const double* a, const double* b, double* c)
	{
		TALIK_UNROLL for (int i = 0; i < Dim; ++i) TALIK_UNROLL for (int j = 0; j < Dim; ++j)
		{
			double sum = 0;
			TALIK_UNROLL for (int k = 0; k < Dim; ++k) sum += a[i * Dim + k] * b[k * Dim + j];
			c[i * Dim + j] = sum;
		}
	}

	template <int Dim> HWY_INLINE double volumeOf(const double* h, double thickness)
	{
		double volume;
		if constexpr (Dim == 2) volume = h[0] * h[3] - h[1] * h[2];
		else volume = h[0] * (h[4] * h[8] - h[5] * h[7]) - h[1] * (h[3] * h[8] - h[5] * h[6]) + h[2] * (h[3] * h[7] - h[4] * h[6]);
		volume = __builtin_fabs(volume);
		return Dim == 2 ? volume * thickness : volume;
	}

	/// Velocity gradient in force in a step, and the one that comes into force at its end.
	template <int Dim> struct Gradients {
		double     now[Dim * Dim], next[Dim * Dim];
		HWY_INLINE Gradients(const SampleCall& call, int step)
		{
			TALIK_UNROLL for (int k = 0; k < Dim * Dim; ++k)
			{
				now[k]  = step > 0 && step <= call.moving ? call.velGrad[k] : 0.;
				next[k] = step < call.moving ? call.velGrad[k] : 0.;
			}
		}
	};

	template <int Dim> struct Image {
		double place[Dim], speed[Dim];
	};

	/// The cell, moved by a step of the velocity gradient, and an image of it. The one that `keeps` the cell writes it.
	template <int Dim>
	HWY_INLINE void moveCell(const double* before, double* after, bool keeps, const double* velGrad, double dt, const std::int8_t* cells, Image<Dim>& image)
	{
		double h[Dim * Dim], rate[Dim * Dim], moved[Dim * Dim];
		TALIK_UNROLL for (int k = 0; k < Dim * Dim; ++k) h[k] = before[k];
		multiply<Dim>(velGrad, h, rate);
		TALIK_UNROLL for (int k = 0; k < Dim * Dim; ++k) moved[k] = h[k] + dt * rate[k];
		TALIK_UNROLL for (int d = 0; d < Dim; ++d)
		{
			double x = 0, v = 0;
			TALIK_UNROLL for (int e = 0; e < Dim; ++e)
			{
				x += moved[d * Dim + e] * cells[e];
				v += rate[d * Dim + e] * cells[e];
			}
			image.place[d] = x;
			image.speed[d] = v;
		}
		if (!keeps) return;
		TALIK_UNROLL for (int k = 0; k < Dim * Dim; ++k)
		{
			after[k] = moved[k];
			h[k]     = before[Dim * Dim + k];
		}
		multiply<Dim>(velGrad, h, rate);
		TALIK_UNROLL for (int k = 0; k < Dim * Dim; ++k) after[Dim * Dim + k] = h[k] + dt * rate[k];
	}

	// ---------------------------------------------------------------------------------------------- memory

	/// The place of a sample on the card.
	template <int Dim, bool Bonded> struct Place {
		static constexpr int motionRows = Dim == 2 ? 6 : 9, shearRows = Dim == 2 ? 1 : 3;
		/// Rows of grains after those of their motion, see PlaceLayout.
		enum Constant { minusInverseMass, inverseInertia, radius, inverseSlackSquare, ownRadius, constants };
		/// Rows of pairs.
		enum Row {
			shear          = 0,
			sumRadius      = shearRows,
			stiffness      = sumRadius + 1,
			halfDifference = stiffness + 1, // of spheres
			iceShear       = sumRadius + Dim,
			offset         = iceShear + shearRows,
			floorForce,
			cohesion,
			iceShare,
			grainStiffness,
			area,
			uGrain,
			uIce
		};
		unsigned char* const base;
		const int            grains, pairs;
		const PlaceLayout&   layout;
		HWY_INLINE           Place(std::uint64_t address, const PlaceLayout& l)
		        : base(reinterpret_cast<unsigned char*>(address))
		        , grains(l.grains)
		        , pairs(l.pairs)
		        , layout(l)
		{}
		HWY_INLINE double& motion(int row, int g) const { return reinterpret_cast<double*>(base)[row * grains + g]; }
		HWY_INLINE double  constant(int row, int g) const { return motion(motionRows + row, g); }
		HWY_INLINE double& pair(int row, int p) const { return reinterpret_cast<double*>(base)[(motionRows + constants) * grains + row * pairs + p]; }
		HWY_INLINE std::uint32_t index(int p) const { return reinterpret_cast<const std::uint32_t*>(base + layout.index)[p]; }
		HWY_INLINE std::uint16_t incidence(int e) const { return reinterpret_cast<const std::uint16_t*>(base + layout.incidence)[e]; }
		HWY_INLINE std::uint16_t start(int g) const { return reinterpret_cast<const std::uint16_t*>(base + layout.start)[g]; }
		HWY_INLINE std::uint8_t& bond(int p) const { return base[layout.bond + p]; }
		HWY_INLINE std::int8_t image(int k) const { return reinterpret_cast<const std::int8_t*>(base + layout.images)[k]; }
		HWY_INLINE void        setRadius(int g, double r) const { motion(motionRows + radius, g) = r; }
		HWY_INLINE void        setSlack(int g, int slack) const { motion(motionRows + inverseSlackSquare, g) = 1. / double(1u << 2 * slack); }
		HWY_INLINE void        setIndex(int p, std::uint32_t code) const { reinterpret_cast<std::uint32_t*>(base + layout.index)[p] = code; }
		HWY_INLINE void        setIncidence(int e, std::uint16_t code) const { reinterpret_cast<std::uint16_t*>(base + layout.incidence)[e] = code; }
		HWY_INLINE void        setStart(int g, std::uint16_t at) const { reinterpret_cast<std::uint16_t*>(base + layout.start)[g] = at; }
		HWY_INLINE void        setImage(int k, std::int8_t cell) const { reinterpret_cast<std::int8_t*>(base + layout.images)[k] = cell; }

		// A bond in a byte: its state, and whether the ice spring is cut.
		HWY_INLINE IceBond iceBond(int p) const { return { BondState(bond(p) & 3), (bond(p) & 4) != 0, pair(uGrain, p), pair(uIce, p) }; }
		HWY_INLINE void    setBond(int p, const IceBond& b) const
		{
			bond(p)         = std::uint8_t(int(b.state) | (b.iceCut ? 4 : 0));
			pair(uGrain, p) = b.uGrain;
			pair(uIce, p)   = b.uIce;
		}
		HWY_INLINE ContactStiffness contactStiffness(const SampleCall& call, int p) const
		{
			return { pair(grainStiffness, p), call.stiffnessRatio, call.iceRatio, call.elasticity.acts() ? pair(stiffness, p) : 0 };
		}
		HWY_INLINE BondStrength strength(const SampleCall& call, int p) const
		{
			return { call.tensileStrength * pair(area, p), call.shearStrength * pair(area, p) };
		}
		HWY_INLINE void setResponse(int p, const ContactResponse<double>& r) const
		{
			pair(stiffness, p)  = r.stiffness;
			pair(offset, p)     = r.offset;
			pair(floorForce, p) = r.floor;
			pair(cohesion, p)   = r.cohesion;
			pair(iceShare, p)   = r.iceShare;
		}
	};

	/// What a block holds whatever the size of its sample.
	template <int Dim> struct Fixed {
		SampleCall    call; ///< of which new lists change what is theirs
		double        cell[2][2 * Dim * Dim];
		double        virial[4 * Dim * Dim], imageForce[mostImages][Dim];
		Image<Dim>    image[mostImages];
		std::uint64_t most[3]; ///< largest departure from the affine motion of a step, squared, as bits
		std::uint32_t brokenInTension, brokenInShear, bonds, unsound;
		// of changes of ice; someBond: a pair is or was bonded
		double        formerIceRatio;
		std::uint32_t bondsFormed, bondsMelted, formed, someBond, carries;
		// of new lists: pairs found inside the cell and across it, distant bonds that are kept, images, whether the host must, how often
		double        skin;
		std::uint32_t found[2], kept[2], images, noLists, lists;
		std::int8_t   cells[mostImages * Dim];
	};

	/// The memory of a block: rows of grains and of pairs in twos.
	template <int Dim> struct Shared {
		static constexpr int grainTwos = Dim == 2 ? 2 : 6, pairTwos = Dim == 2 ? 2 : 4;
		Fixed<Dim>&          fixed;
		Two *const grain, *const pair;
		One* const           rim; ///< discs
		std::uint16_t *const start, *const incidence;
		const int             grains, pairs;
		static constexpr long fixedBytes = (sizeof(Fixed<Dim>) + 15) / 16 * 16;
		static long           bytes(int grains, int pairs)
		{
			return fixedBytes + long(sizeof(Two)) * (grainTwos * grains + pairTwos * pairs) + (Dim == 2 ? 8 * grains : 0)
			        + 2 * (grains + 1 + 2 * pairs);
		}
		HWY_INLINE Shared(unsigned char* memory, const PlaceLayout& l)
		        : fixed(*reinterpret_cast<Fixed<Dim>*>(memory))
		        , grain(reinterpret_cast<Two*>(memory + fixedBytes))
		        , pair(grain + grainTwos * l.grains)
		        , rim(reinterpret_cast<One*>(pair + pairTwos * l.pairs))
		        , start(reinterpret_cast<std::uint16_t*>(rim + (Dim == 2 ? l.grains : 0)))
		        , incidence(start + l.grains + 1)
		        , grains(l.grains)
		        , pairs(l.pairs)
		{}
		HWY_INLINE Two& ofGrain(int row, int g) const { return grain[row * grains + g]; }
		HWY_INLINE Two& ofPair(int row, int p) const { return pair[row * pairs + p]; }
	};

} // namespace N_ONE
} // namespace talik
