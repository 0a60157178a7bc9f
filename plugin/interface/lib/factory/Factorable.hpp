// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <boost/enable_shared_from_this.hpp>
#include <lib/factory/ClassFactory.hpp>

namespace yade {
class Factorable : public boost::enable_shared_from_this<Factorable> {
public:
	Factorable() {}
	virtual ~Factorable();
	virtual string getBaseClassName(unsigned int = 0) const;
	virtual int    getBaseClassNumber() const;
	virtual string getClassName() const;
};
} // namespace yade

#define REGISTER_CLASS_NAME(Class) \
public:                            \
	string getClassName() const override { return #Class; }
/// One base name: what YADE's class database and dispatchers walk up.
#define REGISTER_BASE_CLASS_NAME(Base)                                                             \
public:                                                                                            \
	string getBaseClassName(unsigned int i = 0) const override { return i == 0 ? #Base : ""; } \
	int    getBaseClassNumber() const override { return 1; }
#define REGISTER_CLASS_AND_BASE(Class, Base) REGISTER_CLASS_NAME(Class) REGISTER_BASE_CLASS_NAME(Base)
