// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Timing.hpp>
#include <lib/multimethods/FunctorWrapper.hpp>

namespace yade {
class Scene;

class Functor : public Serializable {
public:
	shared_ptr<TimingDeltas> timingDeltas;
	Scene*                   scene = nullptr;
	string                   label;

	Functor() {}
	virtual ~Functor();
	TALIK_STOCK_OVERRIDES()
	virtual vector<string> getFunctorTypes() const;
};

template <class D1, class Result, class Arguments> class Functor1D : public Functor, public FunctorWrapper<Result, Arguments> {
public:
	using DispatchType1 = D1;
	virtual ~Functor1D() {}
	virtual string get1DFunctorType1() const { throw runtime_error("FUNCTOR1D is missing"); }
	vector<string> getFunctorTypes() const override { return { get1DFunctorType1() }; }
};

template <class D1, class D2, class Result, class Arguments> class Functor2D : public Functor, public FunctorWrapper<Result, Arguments> {
public:
	using DispatchType1 = D1;
	using DispatchType2 = D2;
	virtual ~Functor2D() {}
	virtual string get2DFunctorType1() const { throw runtime_error("FUNCTOR2D is missing"); }
	virtual string get2DFunctorType2() const { throw runtime_error("FUNCTOR2D is missing"); }
	vector<string> getFunctorTypes() const override { return { get2DFunctorType1(), get2DFunctorType2() }; }
};
} // namespace yade

#define FUNCTOR1D(type1) \
public:                  \
	std::string get1DFunctorType1() const override { return #type1; }
#define FUNCTOR2D(type1, type2)                                           \
public:                                                                   \
	std::string get2DFunctorType1() const override { return #type1; } \
	std::string get2DFunctorType2() const override { return #type2; }
