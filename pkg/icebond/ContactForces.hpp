// SPDX-License-Identifier: GPL-2.0-or-later
// Forces of one step within the limits of friction and bond, for numbers of any kind: double, or a vector with one contact in every
// lane. As a header of Highway's it is read once for every kind of processor that the including file is compiled for.
#if defined(TALIK_ICEBOND_CONTACTFORCES) == defined(HWY_TARGET_TOGGLE)
#ifdef TALIK_ICEBOND_CONTACTFORCES
#undef TALIK_ICEBOND_CONTACTFORCES
#else
#define TALIK_ICEBOND_CONTACTFORCES
#endif

#include <hwy/highway.h>
#include <pkg/icebond/IceBond.hpp>

HWY_BEFORE_NAMESPACE();
namespace talik {
namespace HWY_NAMESPACE {

	// What Highway offers for vectors, for one number.
	HWY_INLINE double Add(double a, double b) { return a + b; }
	HWY_INLINE double Sub(double a, double b) { return a - b; }
	HWY_INLINE double Mul(double a, double b) { return a * b; }
	HWY_INLINE double Div(double a, double b) { return a / b; }
	HWY_INLINE double Neg(double a) { return -a; }
	HWY_INLINE double Sqrt(double a) { return __builtin_sqrt(a); }
	HWY_INLINE double CopySignToAbs(double size, double sign) { return __builtin_copysign(size, sign); }
	HWY_INLINE double Min(double a, double b) { return a < b ? a : b; }
	HWY_INLINE double Max(double a, double b) { return a < b ? b : a; }
	HWY_INLINE double MulAdd(double a, double b, double c) { return a * b + c; }
	HWY_INLINE double MulSub(double a, double b, double c) { return a * b - c; }
	HWY_INLINE double NegMulAdd(double a, double b, double c) { return c - a * b; }
	HWY_INLINE bool   Lt(double a, double b) { return a < b; }
	HWY_INLINE bool   Ne(double a, double b) { return a != b; }
	HWY_INLINE bool   And(bool a, bool b) { return a && b; }
	HWY_INLINE bool   AndNot(bool a, bool b) { return !a && b; }
	HWY_INLINE bool   Or(bool a, bool b) { return a || b; }
	HWY_INLINE double IfThenElse(bool condition, double yes, double no) { return condition ? yes : no; }

	/// Zero and any value of the kind of a number, and whether a condition on such numbers holds in some lane.
	HWY_INLINE double                         zeroLike(double) { return 0; }
	HWY_INLINE bool                           holdsSomewhere(double, bool condition) { return condition; }
	template <class Vector> HWY_INLINE Vector zeroLike(Vector) { return hwy::HWY_NAMESPACE::Zero(hwy::HWY_NAMESPACE::DFromV<Vector>()); }
	HWY_INLINE double                         alike(double, double value) { return value; }
	template <class Vector> HWY_INLINE Vector alike(Vector, double value) { return hwy::HWY_NAMESPACE::Set(hwy::HWY_NAMESPACE::DFromV<Vector>(), value); }
	template <class Vector, class Mask> HWY_INLINE bool holdsSomewhere(Vector, Mask condition)
	{
		return !hwy::HWY_NAMESPACE::AllFalse(hwy::HWY_NAMESPACE::DFromV<Vector>(), condition);
	}

	template <class Number> HWY_INLINE Number lengthOf(const Number& shear) { return Max(shear, Neg(shear)); }
	template <class Number> HWY_INLINE Number limitedShear(Number trial, Number limit) { return Min(Max(trial, Neg(limit)), limit); }
	/// The ice's part of a shear force that slides from `trial` to `shear`.
	template <class Number> HWY_INLINE Number slidIce(Number iceShear, Number shear, Number trial) { return Mul(iceShear, Div(shear, trial)); }

	/// A shear force in space, its components numbers of any kind.
	template <class Number> struct InSpace {
		Number x, y, z;
	};
	template <class Number> HWY_INLINE Number dot(const InSpace<Number>& a, const InSpace<Number>& b)
	{
		return MulAdd(a.x, b.x, MulAdd(a.y, b.y, Mul(a.z, b.z)));
	}
	template <class Number> HWY_INLINE Number lengthOf(const InSpace<Number>& a) { return Sqrt(dot(a, a)); }
	template <class Number> HWY_INLINE InSpace<Number> scaled(const InSpace<Number>& a, Number factor)
	{
		return { Mul(a.x, factor), Mul(a.y, factor), Mul(a.z, factor) };
	}
	template <class Number> HWY_INLINE InSpace<Number> Sub(const InSpace<Number>& a, const InSpace<Number>& b)
	{
		return { Sub(a.x, b.x), Sub(a.y, b.y), Sub(a.z, b.z) };
	}
	template <class Number> HWY_INLINE InSpace<Number> Add(const InSpace<Number>& a, const InSpace<Number>& b)
	{
		return { Add(a.x, b.x), Add(a.y, b.y), Add(a.z, b.z) };
	}
	template <class Number> HWY_INLINE InSpace<Number> MulAdd(Number a, const InSpace<Number>& b, const InSpace<Number>& c)
	{
		return { MulAdd(a, b.x, c.x), MulAdd(a, b.y, c.y), MulAdd(a, b.z, c.z) };
	}
	template <class Number> HWY_INLINE InSpace<Number> cross(const InSpace<Number>& a, const InSpace<Number>& b)
	{
		return { MulSub(a.y, b.z, Mul(a.z, b.y)), MulSub(a.z, b.x, Mul(a.x, b.z)), MulSub(a.x, b.y, Mul(a.y, b.x)) };
	}
	/// a x b + c
	template <class Number> HWY_INLINE InSpace<Number> crossAdd(const InSpace<Number>& a, const InSpace<Number>& b, const InSpace<Number>& c)
	{
		return { NegMulAdd(a.z, b.y, MulAdd(a.y, b.z, c.x)), NegMulAdd(a.x, b.z, MulAdd(a.z, b.x, c.y)), NegMulAdd(a.y, b.x, MulAdd(a.x, b.y, c.z)) };
	}
	template <class Number> HWY_INLINE InSpace<Number> NegMulAdd(Number a, const InSpace<Number>& b, const InSpace<Number>& c)
	{
		return { NegMulAdd(a, b.x, c.x), NegMulAdd(a, b.y, c.y), NegMulAdd(a, b.z, c.z) };
	}
	template <class Number> HWY_INLINE auto Ne(const InSpace<Number>& a, const InSpace<Number>& b)
	{
		return Or(Or(Ne(a.x, b.x), Ne(a.y, b.y)), Ne(a.z, b.z));
	}
	template <class Condition, class Number>
	HWY_INLINE InSpace<Number> IfThenElse(Condition condition, const InSpace<Number>& yes, const InSpace<Number>& no)
	{
		return { IfThenElse(condition, yes.x, no.x), IfThenElse(condition, yes.y, no.y), IfThenElse(condition, yes.z, no.z) };
	}
	template <class Number> HWY_INLINE InSpace<Number> limitedShear(const InSpace<Number>& trial, Number limit)
	{
		const Number square = dot(trial, trial);
		const auto   beyond = Lt(Mul(limit, limit), square);
		if (!holdsSomewhere(square, beyond)) return trial;
		return scaled(trial, IfThenElse(beyond, Div(limit, Sqrt(square)), alike(square, 1.)));
	}
	template <class Number> HWY_INLINE InSpace<Number> slidIce(const InSpace<Number>& iceShear, const InSpace<Number>& shear, const InSpace<Number>& trial)
	{
		return scaled(iceShear, Sqrt(Div(dot(shear, shear), dot(trial, trial))));
	}

#if HWY_TARGET == HWY_STATIC_TARGET
	// The same for a shear force of YADE's.
	using Spatial = Eigen::Matrix<double, 3, 1>;
	HWY_INLINE Spatial Sub(const Spatial& a, const Spatial& b) { return a - b; }
	HWY_INLINE Spatial NegMulAdd(double a, const Spatial& b, const Spatial& c) { return c - a * b; }
	HWY_INLINE bool    Ne(const Spatial& a, const Spatial& b) { return a != b; }
	HWY_INLINE Spatial IfThenElse(bool condition, const Spatial& yes, const Spatial& no) { return condition ? yes : no; }
	HWY_INLINE double  lengthOf(const Spatial& a) { return shearNorm(a); }
	HWY_INLINE Spatial limitedShear(const Spatial& trial, double limit)
	{
		const double norm = shearNorm(trial);
		return norm <= limit ? trial : Spatial(trial * (limit / norm));
	}
	HWY_INLINE Spatial slidIce(const Spatial& iceShear, const Spatial& shear, const Spatial& trial)
	{
		return iceShear * (shearNorm(shear) / shearNorm(trial));
	}
#endif

	/// Acceleration times 1 - damping sign(acceleration (velocity + dt/2 acceleration)).
	template <class Number> HWY_INLINE Number damped(Number acceleration, Number velocity, Number damping, Number halfStep)
	{
		const Number power = Mul(acceleration, MulAdd(halfStep, acceleration, velocity));
		return NegMulAdd(CopySignToAbs(damping, power), acceleration, acceleration);
	}
	template <class Number> HWY_INLINE InSpace<Number> damped(const InSpace<Number>& a, const InSpace<Number>& v, Number damping, Number halfStep)
	{
		return { damped(a.x, v.x, damping, halfStep), damped(a.y, v.y, damping, halfStep), damped(a.z, v.z, damping, halfStep) };
	}

	/// Springs of grains at an overlap: linear ones are the same at any. `stiffness` is H of Hertz's grains, eq. (14.15).
	template <bool Hertz, class Number> HWY_INLINE Number grainSecant(const Number& stiffness, const Number& overlap)
	{
		if constexpr (Hertz) return Mul(stiffness, Sqrt(Max(overlap, zeroLike(overlap))));
		else return stiffness;
	}
	template <bool Hertz, class Number> HWY_INLINE Number grainTangent(const Number& stiffness, const Number& overlap)
	{
		if constexpr (Hertz) return Mul(alike(overlap, 1.5), grainSecant<true>(stiffness, overlap));
		else return stiffness;
	}
	/// A response at an overlap.
	template <bool Hertz, class Number> HWY_INLINE ContactResponse<Number> responseAt(const ContactResponse<Number>& c, const Number& overlap)
	{
		if constexpr (!Hertz) return c;
		const Number tangent = Add(grainTangent<Hertz>(c.stiffness, overlap), c.iceShare), least = alike(overlap, 1e-300);
		return { Add(grainSecant<Hertz>(c.stiffness, overlap), c.iceShare), c.offset, c.floor, c.cohesion, Div(c.iceShare, Max(tangent, least)) };
	}

	/// Moment by which grains resist rolling on each other, eq. (14.6): elastic, at most lever times the normal force that presses them together.
	/// The moment is reduced by the increment in this step.
	template <class Number, class Moment>
	HWY_INLINE Moment rollingMoment(const Number& lever, const Number& normal, const Moment& moment, const Moment& increment)
	{
		return limitedShear(Sub(moment, increment), Mul(lever, Max(normal, zeroLike(normal))));
	}

	/// Contacts that have no bond; no force across a gap.
	template <class Number, class Shear>
	HWY_INLINE ContactForces<Number, Shear> frictionalForces(
	        const Number& stiffness, const Number& friction, const Number& overlap, const Shear& shear, const Shear& increment)
	{
		ContactForces<Number, Shear> f;
		f.overlap    = overlap;
		f.increment  = increment;
		f.trialShear = Sub(shear, increment);
		f.normal     = Max(Mul(stiffness, overlap), zeroLike(overlap));
		f.shear      = limitedShear(f.trialShear, Mul(friction, f.normal));
		return f;
	}

	/// Normal force at the edge of a bond's section that bending stretches most.
	template <class Number> HWY_INLINE Number atEdge(const Number& normal, NoMoments) { return normal; }
	template <class Number> HWY_INLINE Number atEdge(const Number& normal, const EdgeForces<Number>& edge) { return Sub(normal, edge.tension); }

	/// Contacts whose shear has reached its limit, at the edge of the section where a bond is twisted.
	template <class Number, class Shear, class Condition> HWY_INLINE Condition atLimit(const Shear&, const Number&, Condition limited, Condition, NoMoments)
	{
		return limited;
	}
	template <class Number, class Shear, class Condition>
	HWY_INLINE Condition atLimit(const Shear& trial, const Number& limit, Condition limited, Condition intact, const EdgeForces<Number>& edge)
	{
		return Or(limited, And(intact, Lt(limit, Add(lengthOf(trial), edge.shear))));
	}

	/// Contacts that may be bonded. edge: what moments add at the edge of the section, zero where no bond is intact, or NoMoments.
	/// If some of them reached the limit of a bond or fell below the floor of a broken one, settle(condition, forces) is called.
	/// It must replace their forces by the result of IceBond::settle.
	template <class Number, class Shear, class Edge, class Settle>
	HWY_INLINE ContactForces<Number, Shear> bondedForces(
	        const ContactResponse<Number>& contact, const Number& friction, const Number& overlap, const Shear& shear, const Shear& iceShear,
	        const Shear& increment, const Edge& edge, Settle&& settle)
	{
		const Number                 zero   = zeroLike(overlap);
		const auto                   intact = Lt(contact.floor, zero);
		ContactForces<Number, Shear> f;
		f.overlap          = overlap;
		f.trialNormal      = Sub(Mul(contact.stiffness, overlap), contact.offset);
		f.normal           = Max(f.trialNormal, contact.floor);
		const Number limit = MulAdd(friction, Max(f.trialNormal, zero), contact.cohesion);
		f.trialShear       = Sub(shear, increment);
		f.shear            = limitedShear(f.trialShear, limit);
		f.iceShear         = NegMulAdd(contact.iceShare, increment, iceShear);
		f.trialNormal      = atEdge(f.trialNormal, edge);
		const auto limited = atLimit(f.trialShear, limit, Ne(f.trialShear, f.shear), intact, edge);
		const auto opened  = And(Lt(f.trialNormal, contact.floor), Ne(contact.floor, zero));
		const auto shared  = And(limited, Or(intact, Ne(contact.iceShare, zero)));
		if (HWY_UNLIKELY(holdsSomewhere(overlap, Or(opened, shared)))) {
			const auto slides = AndNot(Or(opened, intact), shared); // a broken bond whose ice still carries
			f.iceShear        = IfThenElse(slides, slidIce(f.iceShear, f.shear, f.trialShear), f.iceShear);
			const auto failed = Or(opened, AndNot(slides, shared));
			if (!holdsSomewhere(overlap, failed)) return f;
			f.increment = increment; // asked for by what settles a bond only
			settle(failed, f);
		}
		return f;
	}

} // namespace HWY_NAMESPACE
} // namespace talik
HWY_AFTER_NAMESPACE();

#endif
