// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <boost/mpl/at.hpp>
#include <boost/mpl/vector.hpp>
#include <lib/serialization/Serializable.hpp>

namespace yade {
/// Second base of every functor: its table has go() and goReverse() of one to seven arguments. All bodies are stock YADE's.
template <class Result, class Arguments> class FunctorWrapper {
	template <int i> using Arg = typename boost::mpl::at_c<Arguments, i>::type;

public:
	virtual ~FunctorWrapper() {}
	virtual string checkOrder() const;
	virtual Result go(Arg<0>);
	virtual Result go(Arg<0>, Arg<1>);
	virtual Result go(Arg<0>, Arg<1>, Arg<2>);
	virtual Result go(Arg<0>, Arg<1>, Arg<2>, Arg<3>);
	virtual Result go(Arg<0>, Arg<1>, Arg<2>, Arg<3>, Arg<4>);
	virtual Result go(Arg<0>, Arg<1>, Arg<2>, Arg<3>, Arg<4>, Arg<5>);
	virtual Result go(Arg<0>, Arg<1>, Arg<2>, Arg<3>, Arg<4>, Arg<5>, Arg<6>);
	virtual Result goReverse(Arg<0>);
	virtual Result goReverse(Arg<0>, Arg<1>);
	virtual Result goReverse(Arg<0>, Arg<1>, Arg<2>);
	virtual Result goReverse(Arg<0>, Arg<1>, Arg<2>, Arg<3>);
	virtual Result goReverse(Arg<0>, Arg<1>, Arg<2>, Arg<3>, Arg<4>);
	virtual Result goReverse(Arg<0>, Arg<1>, Arg<2>, Arg<3>, Arg<4>, Arg<5>);
	virtual Result goReverse(Arg<0>, Arg<1>, Arg<2>, Arg<3>, Arg<4>, Arg<5>, Arg<6>);
};
} // namespace yade
