// SPDX-License-Identifier: GPL-2.0-or-later
#include "InterfaceCheck.hpp"

#include <core/Cell.hpp>
#include <core/Dispatching.hpp>
#include <core/GlobalEngine.hpp>
#include <core/Omega.hpp>
#include <core/Scene.hpp>
#include <core/TimeStepper.hpp>
#include <pkg/common/Box.hpp>
#include <pkg/common/Collider.hpp>
#include <pkg/common/ElastMat.hpp>
#include <pkg/common/Facet.hpp>
#include <pkg/common/GLDrawFunctors.hpp>
#include <pkg/common/NormShearPhys.hpp>
#include <pkg/common/OpenGLRenderer.hpp>
#include <pkg/common/Sphere.hpp>
#include <pkg/common/Wall.hpp>
#include <pkg/dem/FrictPhys.hpp>
#include <pkg/dem/ScGeom.hpp>

#include <cstdlib>
#include <cstring>
#include <cxxabi.h>
#include <dlfcn.h>
#include <functional>
#include <malloc.h>
#include <sstream>

namespace py = boost::python;

namespace talik {
namespace {

	/// One fact that the compiled code relies on; returns what is wrong with it, or nothing.
	struct Expectation {
		std::string                  subject; ///< "Class.member", as the sentence names it
		std::function<std::string()> violation;
	};

	long overriddenOffset(const std::string& subject, long expected)
	{
		const char* text = std::getenv("TALIK_EXPECT_OFFSET");
		if (!text) return expected;
		const std::string setting(text);
		const auto        equals = setting.find('=');
		return setting.substr(0, equals) == subject ? std::atol(setting.c_str() + equals + 1) : expected;
	}

	/// The C++ callable inside a Boost.Python function: PyObject header, then the owning pointer of the implementation.
	const py::objects::py_function_impl_base* implementation(const py::object& function)
	{
		return *reinterpret_cast<py::objects::py_function_impl_base* const*>(reinterpret_cast<const char*>(function.ptr()) + sizeof(PyObject));
	}

	/// Written-out name of a type: mangled names abbreviate repeated parts and cannot be searched.
	std::string typeName(const std::type_info& type)
	{
		int         status = 0;
		char*       text   = abi::__cxa_demangle(type.name(), nullptr, nullptr, &status);
		std::string name   = text ? text : type.name();
		std::free(text);
		return name;
	}

	template <class Class, class T> std::string getterViolation(const char* className, const char* attribute, T Class::*member)
	{
		py::object  cls    = py::import("yade.wrapper").attr(className);
		py::object  getter = py::object(cls.attr("__dict__"))[attribute].attr("fget");
		const auto* impl   = implementation(getter);
		if (typeName(typeid(*impl)).find(typeName(typeid(py::detail::member<T, Class>))) == std::string::npos)
			return "is not of type " + typeName(typeid(T));
		long actual, expected;
		std::memcpy(&actual, reinterpret_cast<const char*>(impl) + sizeof(void*), sizeof actual);
		std::memcpy(&expected, &member, sizeof expected);
		expected = overriddenOffset(std::string(className) + "." + attribute, expected);
		if (actual == expected) return "";
		return "lies at byte " + std::to_string(actual) + " instead of " + std::to_string(expected);
	}

	std::string sizeViolation(const char* className, std::size_t expected)
	{
		expected                 = overriddenOffset(std::string(className) + ".size", expected);
		const std::string name   = "CreatePureCustom" + std::string(className);
		const auto        create = reinterpret_cast<void* (*)()>(dlsym(RTLD_DEFAULT, ("_ZN4yade" + std::to_string(name.size()) + name + "Ev").c_str()));
		if (!create) return "cannot be found";
		// what glibc hands out for it; sometimes 16 bytes more, when the rest of a free block could not be used otherwise
		const std::size_t due = ((expected + sizeof(std::size_t) + 15) & ~std::size_t(15)) - sizeof(std::size_t);
		// the objects are given up: their type is what is being questioned, so they must not be destroyed
		std::size_t usable = malloc_usable_size(create());
		for (int again = 0; again < 100 && usable > due; ++again)
			usable = std::min(usable, malloc_usable_size(create()));
		if (usable == due) return "";
		return "occupies about " + std::to_string(usable) + " bytes instead of " + std::to_string(expected);
	}

	/// Position of a virtual function, counted from the address point of its table (Itanium C++ ABI).
	template <class Method> long slotOf(Method method)
	{
		long word;
		std::memcpy(&word, &method, sizeof word);
		return (word - 1) / long(sizeof(void*));
	}

	std::string slotViolation(const std::string& tableSymbol, const std::string& functionSymbol, long slot)
	{
		void* const* table    = static_cast<void* const*>(dlsym(RTLD_DEFAULT, tableSymbol.c_str()));
		void*        function = dlsym(RTLD_DEFAULT, functionSymbol.c_str());
		if (!table || !function) return "is not exported";
		if (table[2 + slot] == function) return "";
		return "is not entry " + std::to_string(slot) + " of the virtual table";
	}

#define SIZE(r, all, Class) all.push_back({ TEXT(Class) ".size", [] { return sizeViolation(TEXT(Class), sizeof(yade::Class)); } });
#define MEMBER(r, Class, member) \
	all.push_back({ TEXT(Class) "." TEXT(member), [] { return getterViolation(TEXT(Class), TEXT(member), &yade::Class::member); } });
#define TEXT(name) BOOST_PP_STRINGIZE(name)
#define SIZES(classes) BOOST_PP_SEQ_FOR_EACH(SIZE, all, classes)
#define MEMBERS(Class, attributes) BOOST_PP_SEQ_FOR_EACH(MEMBER, Class, attributes)
#define VIRTUAL(Class, lengthAndName, method, signature) \
	all.push_back({ #Class "." #method "()", [] { return slotViolation("_ZTVN4yade" lengthAndName "E", "_ZN" signature, slotOf(&yade::Class::method)); } })

	/// What the compiled code touches. ("K" in a signature: const member function.)
	std::vector<Expectation> expectations()
	{
		using namespace yade;
		std::vector<Expectation> all;
		SIZES((Engine)(GlobalEngine)(Functor)(IPhysFunctor)(LawFunctor)(GlIPhysFunctor)(State)(Body)(Material)(FrictMat)(Shape)(Sphere));
		SIZES((Interaction)(NormPhys)(FrictPhys)(ScGeom)(Cell)(Scene)(BodyContainer)(InteractionContainer)(Wall)(Box)(Facet)(TimeStepper));
		SIZES((Collider)(GlExtraDrawer));
		MEMBERS(Engine, (dead)(ompThreads)(label));
		MEMBERS(Functor, (label));
		MEMBERS(Material, (density)(label));
		MEMBERS(ElastMat, (young)(poisson));
		MEMBERS(FrictMat, (frictionAngle));
		MEMBERS(State, (vel)(mass)(angVel)(inertia)(refPos)(isDamped)(densityScaling));
		MEMBERS(Body, (id)(material)(state)(shape)(bound)(clumpId)(groupMask));
		MEMBERS(Wall, (sense)(axis));
		MEMBERS(Box, (extents));
		MEMBERS(Facet, (vertices));
		MEMBERS(TimeStepper, (active));
		MEMBERS(Collider, (avoidSelfInteractionMask));
		MEMBERS(GlExtraDrawer, (dead));
		MEMBERS(Sphere, (radius));
		MEMBERS(Shape, (color));
		MEMBERS(Interaction, (id1)(id2)(geom)(phys)(cellDist)(iterMadeReal));
		MEMBERS(GenericSpheresContact, (normal)(contactPoint));
		MEMBERS(ScGeom, (penetrationDepth)(shearInc));
		MEMBERS(NormPhys, (kn)(normalForce));
		MEMBERS(NormShearPhys, (ks)(shearForce));
		MEMBERS(FrictPhys, (tangensOfFrictionAngle));
#ifdef TALIK_YADE_2026
		MEMBERS(FrictPhys, (frictDissip));
#endif
		MEMBERS(Cell, (refHSize)(prevHSize)(nextVelGrad)(prevVelGrad)(homoDeform));
		MEMBERS(Scene, (dt)(iter)(time)(isPeriodic)(stopAtIter)(trackEnergy)(selectedBody)(tags));
		VIRTUAL(Engine, "6Engine", isActivated, "4yade6Engine11isActivatedEv");
		VIRTUAL(Engine, "6Engine", action, "4yade6Engine6actionEv");
		VIRTUAL(Serializable, "12Serializable", pyRegisterClass, "4yade12Serializable15pyRegisterClassEN5boost6python3api6objectE");
		VIRTUAL(Serializable, "12Serializable", callPostLoad, "4yade12Serializable12callPostLoadEv");
		VIRTUAL(Material, "8Material", newAssocState, "K4yade8Material13newAssocStateEv");
		VIRTUAL(FrictMat, "8FrictMat", getClassIndex, "K4yade8FrictMat13getClassIndexEv");
		VIRTUAL(FrictMat, "8FrictMat", getBaseClassIndex, "K4yade8FrictMat17getBaseClassIndexEi");
		VIRTUAL(FrictPhys, "9FrictPhys", getClassIndex, "K4yade9FrictPhys13getClassIndexEv");
		VIRTUAL(FrictPhys, "9FrictPhys", getBaseClassIndex, "K4yade9FrictPhys17getBaseClassIndexEi");
		VIRTUAL(Collider, "8Collider", invalidatePersistentData, "4yade8Collider24invalidatePersistentDataEv");
		VIRTUAL(GlExtraDrawer, "13GlExtraDrawer", render, "4yade13GlExtraDrawer6renderEv");
		VIRTUAL(GlIPhysFunctor, "14GlIPhysFunctor", renders, "K4yade14GlIPhysFunctor7rendersB5cxx11Ev");
		VIRTUAL(GlIPhysFunctor, "14GlIPhysFunctor", initgl, "4yade14GlIPhysFunctor6initglEv");
		return all;
	}

	std::string yadeVersion() { return py::extract<std::string>(py::str(py::import("yade.config").attr("version"))); }

} // namespace

std::string interfaceMismatch()
{
	for (const auto& expectation : expectations()) {
		const std::string violation = expectation.violation();
		if (violation.empty()) continue;
		return "This YADE (" + yadeVersion() + ") differs from " TALIK_YADE_VERSION ", for which Talik was built: " + expectation.subject + " "
		        + violation + ". Install Debian's package yade " TALIK_YADE_VERSION ", or rebuild Talik for this YADE.";
	}
	return "";
}

} // namespace talik
