// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Dispatching.hpp>

namespace yade {
class GlIPhysFunctor
        : public Functor1D<
                  IPhys, void,
                  boost::mpl::vector<const shared_ptr<IPhys>&, const shared_ptr<Interaction>&, const shared_ptr<Body>&, const shared_ptr<Body>&, bool>> {
public:
	TALIK_STOCK_FUNCTOR(GlIPhysFunctor)
	virtual string renders() const;
	virtual void   initgl();
};
} // namespace yade
TALIK_STOCK_BASE(GlIPhysFunctor)

#define RENDERS(Class)                                     \
public:                                                    \
	string renders() const override { return #Class; } \
	FUNCTOR1D(Class)
