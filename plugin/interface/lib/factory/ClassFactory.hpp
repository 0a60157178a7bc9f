// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/base/Math.hpp>
#include <lib/base/Singleton.hpp>
#include <list>
// the four archives must be known before export.hpp
#include <boost/archive/binary_iarchive.hpp>
#include <boost/archive/binary_oarchive.hpp>
#include <boost/archive/xml_iarchive.hpp>
#include <boost/archive/xml_oarchive.hpp>
// then what may be archived
#include <boost/serialization/export.hpp>
#include <boost/serialization/map.hpp>
#include <boost/serialization/nvp.hpp>
#include <boost/serialization/shared_ptr.hpp>
#include <boost/serialization/string.hpp>
#include <boost/serialization/vector.hpp>

namespace yade {
class Factorable;

/// Member of ClassFactory that is only measured, never called.
struct DynLibManager {
	std::map<const string, void*> handles;
	bool                          autoUnload;
	string                        lastError_;
};

/// Registry of YADE's classes by name.
class ClassFactory : public Singleton<ClassFactory> {
	using CreateFactorableFnPtr       = Factorable* (*)();
	using CreateSharedFactorableFnPtr = shared_ptr<Factorable> (*)();
	using CreatePureCustomFnPtr       = void* (*)();
	struct FactorableCreators {
		CreateFactorableFnPtr       create;
		CreateSharedFactorableFnPtr createShared;
		CreatePureCustomFnPtr       createPureCustom;
	};

	DynLibManager                        dlm;
	std::map<string, FactorableCreators> map;
	ClassFactory();
	virtual ~ClassFactory();

public:
	std::list<string> pluginClasses;

	shared_ptr<Factorable> createShared(string name);
	bool                   registerFactorable(string name, CreateFactorableFnPtr, CreateSharedFactorableFnPtr, CreatePureCustomFnPtr);
	void                   registerPluginClasses(const char* fileAndClasses[]);
	virtual string         getClassName() const;
	virtual string         getBaseClassName(int) const;
};
} // namespace yade

#define REGISTER_FACTORABLE(Name)                                                                                             \
	inline shared_ptr<Factorable> CreateShared##Name() { return shared_ptr<Name>(new Name); }                             \
	inline Factorable*            Create##Name() { return new Name; }                                                     \
	inline void*                  CreatePureCustom##Name() { return new Name; }                                           \
	const bool                    registered##Name __attribute__((unused)) = ClassFactory::instance().registerFactorable( \
	                           #Name, Create##Name, CreateShared##Name, CreatePureCustom##Name);

#define TALIK_PLUGIN_NAME(r, data, Name) BOOST_PP_STRINGIZE(Name),
#define TALIK_PLUGIN_BODY(r, data, Name) TALIK_PLUGIN_BODIES(Name)
#define TALIK_PLUGIN_EXPORT(r, data, Name) BOOST_CLASS_EXPORT_IMPLEMENT(yade::Name)

/// YADE_PLUGIN((ClassA)(ClassB)) inside namespace yade, once per source file.
#define YADE_PLUGIN(classes)                                                                                              \
	BOOST_PP_SEQ_FOR_EACH(TALIK_PLUGIN_BODY, ~, classes)                                                              \
	namespace {                                                                                                       \
		__attribute__((constructor)) void BOOST_PP_CAT(announce_, BOOST_PP_SEQ_HEAD(classes))()                   \
		{                                                                                                         \
			const char* names[] = { __FILE__, BOOST_PP_SEQ_FOR_EACH(TALIK_PLUGIN_NAME, ~, classes) nullptr }; \
			ClassFactory::instance().registerPluginClasses(names);                                            \
		}                                                                                                         \
	}                                                                                                                 \
	}                                                                                                                 \
	BOOST_PP_SEQ_FOR_EACH(TALIK_PLUGIN_EXPORT, ~, classes)                                                            \
	namespace yade {
