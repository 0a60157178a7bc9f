// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
/// Scriptable, archivable classes: the attribute macros of YADE, written anew on Boost for classes that live outside its tree.
/// An attribute is the tuple (type, name, default, flags, "documentation").
#include <boost/preprocessor.hpp>
#include <boost/python.hpp>
#include <boost/python/raw_function.hpp>
#include <lib/factory/Factorable.hpp>
#include <lib/serialization/StockArchives.hpp>
#include <pkg/python/HeldObject.hpp>

namespace yade {
template <typename T> void preLoad(T&) {}
template <typename T> void postLoad(T&) {}
template <typename T> void preSave(T&) {}
template <typename T> void postSave(T&) {}

namespace Attr {
	enum flags { noSave = 1, readonly = 2, triggerPostLoad = 4, hidden = 8, noResize = 16 };
}

class Serializable : public Factorable {
public:
	Serializable() {}
	virtual ~Serializable();
	string getBaseClassName(unsigned int = 0) const override;
	int    getBaseClassNumber() const override;
	string getClassName() const override;

	virtual void                  pySetAttr(const std::string& key, const ::boost::python::object& value);
	virtual ::boost::python::dict pyDict() const;
	virtual ::boost::python::dict pyDictCustom() const;
	virtual void                  callPostLoad();
	virtual void                  checkPyClassRegistersItself(const std::string& thisClassName) const;
	virtual void                  pyRegisterClass(::boost::python::object scope);
	virtual void                  pyHandleCustomCtorArgs(::boost::python::tuple& args, ::boost::python::dict& keywords);

	void pyUpdateAttrs(const ::boost::python::dict&);
};
} // namespace yade
TALIK_STOCK_BASE(Serializable)

/// What every class of stock YADE declares for scripts and archives.
#define TALIK_STOCK_OVERRIDES()                                                                       \
	string                getBaseClassName(unsigned int = 0) const override;                      \
	int                   getBaseClassNumber() const override;                                    \
	string                getClassName() const override;                                          \
	void                  pySetAttr(const std::string&, const ::boost::python::object&) override; \
	::boost::python::dict pyDict() const override;                                                \
	void                  callPostLoad() override;                                                \
	void                  pyRegisterClass(::boost::python::object) override;

namespace talik {
namespace scripting {
	namespace py = boost::python;

	/// YADE hands Eigen objects out by reference, so that O.bodies[0].state.vel[2]=0 works; all else by value.
	template <class T> struct ByReference : std::false_type {};
	template <class S, int r, int c> struct ByReference<Eigen::Matrix<S, r, c>> : std::integral_constant<bool, (r > 0 && c > 0 && r < 6)> {};
	template <> struct ByReference<yade::Quaternionr> : std::true_type {};

	/// Setter of an attribute whose new value the class checks.
	template <class Class, class T> struct CheckedSetter {
		T Class::*member;
		void      operator()(Class& self, const T& value) const
		{
			const T former = self.*member;
			self.*member   = value;
			try {
				self.callPostLoad();
			} catch (...) { // a refused value must not stay
				self.*member = former;
				throw;
			}
		}
	};

	template <class Class, class T> struct Getter {
		using Policy = std::conditional_t<ByReference<T>::value, py::return_internal_reference<>, py::return_value_policy<py::return_by_value>>;
		static py::object make(T Class::*member) { return py::make_getter(member, Policy()); }
	};

	inline std::string attributeText(const char* text, int flags) { return std::string(text) + " :yattrflags:`" + std::to_string(flags) + "` "; }

	/// One function for all attributes of one class that have the same type.
	template <int flags, class PyClass, class Class, class T> void attribute(PyClass& cls, const char* name, T Class::*member, const char* doc)
	{
		if constexpr (!(flags & yade::Attr::hidden)) {
			const std::string text = attributeText(doc, flags);
			const py::object  get  = Getter<Class, T>::make(member);
			if constexpr (flags & yade::Attr::readonly) cls.add_property(name, get, text.c_str());
			else if constexpr (flags & yade::Attr::triggerPostLoad) {
				using Signature = boost::mpl::vector3<void, Class&, const T&>;
				cls.add_property(
				        name, get, py::make_function(CheckedSetter<Class, T> { member }, py::default_call_policies(), Signature()),
				        text.c_str());
			} else cls.add_property(name, get, py::make_setter(member, py::return_value_policy<py::return_by_value>()), text.c_str());
		}
	}

	template <class T> void assign(T& member, const py::object& value) { member = py::extract<T>(value)(); }

	template <int flags, class T> void put(py::dict& attributes, const char* name, const T& value)
	{
		if constexpr (!(flags & yade::Attr::hidden)) attributes[name] = py::object(value);
	}

	template <class Class> boost::shared_ptr<Class> makeFromKeywords(py::tuple positional, py::dict keywords)
	{
		boost::shared_ptr<Class> instance(new Class);
		instance->pyHandleCustomCtorArgs(positional, keywords);
		if (py::len(positional) > 0) {
			const std::string name = instance->getClassName();
			PyErr_SetString(PyExc_TypeError, (name + " takes keyword arguments only: " + name + "(attribute=value, …)").c_str());
			py::throw_error_already_set();
		}
		if (py::len(keywords) > 0) {
			instance->pyUpdateAttrs(keywords);
			instance->callPostLoad();
		}
		return instance;
	}

	/// Keyword constructor of every class: unknown names are refused by pyUpdateAttrs, positional ones above.
	template <class Class> py::object constructFromKeywords(py::tuple args, py::dict keywords)
	{
		static py::object* const constructor = new py::object(py::make_constructor(&makeFromKeywords<Class>));
		return (*constructor)(py::object(args[0]), py::tuple(args.slice(1, py::_)), keywords);
	}

	/// Eigen's fixed-size types are written component by component.
	template <class M> struct Components {
		M&                            m;
		template <class Archive> void serialize(Archive& ar, unsigned)
		{
			for (int i = 0; i < int(m.size()); i++)
				ar& boost::serialization::make_nvp("c", m.data()[i]);
		}
	};
	template <class Archive, class T> void archiveAttribute(Archive& ar, const char* name, T& value) { ar& boost::serialization::make_nvp(name, value); }
	template <class Archive, class S, int r, int c> void archiveAttribute(Archive& ar, const char* name, Eigen::Matrix<S, r, c>& value)
	{
		Components<Eigen::Matrix<S, r, c>> components { value };
		ar&                                boost::serialization::make_nvp(name, components);
	}
} // namespace scripting
} // namespace talik
namespace boost {
namespace serialization {
	template <class M> struct tracking_level<talik::scripting::Components<M>> {
		typedef mpl::integral_c_tag    tag;
		typedef mpl::int_<track_never> type;
		static const int               value = track_never;
	};
	template <class M> struct implementation_level<talik::scripting::Components<M>> {
		typedef mpl::integral_c_tag            tag;
		typedef mpl::int_<object_serializable> type;
		static const int                       value = object_serializable;
	};
} // namespace serialization
} // namespace boost

#define TALIK_ATTR_TYPE(a) BOOST_PP_TUPLE_ELEM(5, 0, a)
#define TALIK_ATTR_NAME(a) BOOST_PP_TUPLE_ELEM(5, 1, a)
#define TALIK_ATTR_INIT(a) BOOST_PP_TUPLE_ELEM(5, 2, a)
#define TALIK_ATTR_FLAGS(a) (BOOST_PP_TUPLE_ELEM(5, 3, a) + 0)
#define TALIK_ATTR_TEXT(a)           \
	BOOST_PP_TUPLE_ELEM(5, 4, a) \
	" :ydefault:`" BOOST_PP_STRINGIZE(TALIK_ATTR_INIT(a)) "` :yattrtype:`" BOOST_PP_STRINGIZE(TALIK_ATTR_TYPE(a)) "`"
#define TALIK_ATTR_KEY(a) BOOST_PP_STRINGIZE(TALIK_ATTR_NAME(a))

#define TALIK_ATTR_DECLARE(r, Class, a) TALIK_ATTR_TYPE(a) TALIK_ATTR_NAME(a) = TALIK_ATTR_TYPE(a)(TALIK_ATTR_INIT(a));
#define TALIK_ATTR_ARCHIVE(r, Class, a) \
	if constexpr (!(TALIK_ATTR_FLAGS(a) & ::yade::Attr::noSave)) ::talik::scripting::archiveAttribute(ar, TALIK_ATTR_KEY(a), self.TALIK_ATTR_NAME(a));
#define TALIK_ATTR_SET(r, Class, a) \
	if (key == TALIK_ATTR_KEY(a)) return ::talik::scripting::assign(self.TALIK_ATTR_NAME(a), value);
#define TALIK_ATTR_GET(r, Class, a) ::talik::scripting::put<TALIK_ATTR_FLAGS(a)>(attributes, TALIK_ATTR_KEY(a), self.TALIK_ATTR_NAME(a));
#define TALIK_ATTR_EXPOSE(r, Class, a) \
	::talik::scripting::attribute<TALIK_ATTR_FLAGS(a)>(classObject, TALIK_ATTR_KEY(a), &Self::TALIK_ATTR_NAME(a), TALIK_ATTR_TEXT(a));

/// What scripts and archives need of a class is declared in the class. The bodies are templates of the class, whose name there is Self, so
/// that they are compiled in one unit, by TALIK_PLUGIN_BODIES, and not in every unit that includes the class.
#define TALIK_CLASS_COMMON(Class, Base, archived, members, ctor, exposed)                                                \
	REGISTER_CLASS_AND_BASE(Class, Base)                                                                             \
	friend class boost::serialization::access;                                                                       \
                                                                                                                         \
public:                                                                                                                  \
	Class();                                                                                                         \
	void                          archiveBy(::boost::archive::binary_iarchive&);                                     \
	void                          archiveBy(::boost::archive::binary_oarchive&);                                     \
	void                          archiveBy(::boost::archive::xml_iarchive&);                                        \
	void                          archiveBy(::boost::archive::xml_oarchive&);                                        \
	template <class Archive> void serialize(Archive& ar, unsigned) { archiveBy(ar); }                                \
	void                          pySetAttr(const std::string& key, const ::boost::python::object& value) override;  \
	::boost::python::dict         pyDict() const override;                                                           \
	void                          callPostLoad() override;                                                           \
	void                          pyRegisterClass(::boost::python::object moduleScope) override;                     \
                                                                                                                         \
	template <class Self> void                constructBody(Self&) { ctor; }                                         \
	template <class Self, class Archive> void archiveBody(Self& self, Archive& ar)                                   \
	{                                                                                                                \
		::boost::serialization::void_cast_register<Self, Base>();                                                \
		if constexpr (Archive::is_loading::value) preLoad(self);                                                 \
		else preSave(self);                                                                                      \
		ar& ::boost::serialization::make_nvp(#Base, static_cast<Base&>(self));                                   \
		BOOST_PP_SEQ_FOR_EACH(TALIK_ATTR_ARCHIVE, Class, archived)                                               \
		if constexpr (Archive::is_loading::value) postLoad(self);                                                \
		else postSave(self);                                                                                     \
	}                                                                                                                \
	template <class Self> void setAttrBody(Self& self, const std::string& key, const ::boost::python::object& value) \
	{                                                                                                                \
		BOOST_PP_SEQ_FOR_EACH(TALIK_ATTR_SET, Class, members)                                                    \
		self.Base::pySetAttr(key, value);                                                                        \
	}                                                                                                                \
	template <class Self>::boost::python::dict dictBody(const Self& self) const                                      \
	{                                                                                                                \
		::boost::python::dict attributes;                                                                        \
		BOOST_PP_SEQ_FOR_EACH(TALIK_ATTR_GET, Class, members)                                                    \
		attributes.update(self.pyDictCustom());                                                                  \
		attributes.update(self.Base::pyDict());                                                                  \
		return attributes;                                                                                       \
	}                                                                                                                \
	template <class Self> void postLoadBody(Self& self)                                                              \
	{                                                                                                                \
		self.Base::callPostLoad();                                                                               \
		postLoad(self);                                                                                          \
	}                                                                                                                \
	template <class Self> void registerBody(Self& self, const ::boost::python::object& moduleScope)                  \
	{                                                                                                                \
		self.checkPyClassRegistersItself(#Class);                                                                \
		::boost::python::scope             within(moduleScope);                                                  \
		::boost::python::docstring_options plainText(true, false);                                               \
		exposed                                                                                                  \
	}

/// Begins what registerBody() does.
#define TALIK_CLASS_OBJECT(Class, Base, docString)                                                                              \
	::boost::python::class_<Self, ::boost::shared_ptr<Self>, ::boost::python::bases<Base>, boost::noncopyable> classObject( \
	        #Class, docString, ::boost::python::no_init);                                                                   \
	::talik::HeldPointer<Self>::registerOnce();                                                                             \
	classObject.def("__init__", ::boost::python::raw_function(&::talik::scripting::constructFromKeywords<Self>, 1));

/// Definitions of what TALIK_CLASS_COMMON declares.
#define TALIK_PLUGIN_BODIES(Class)                                                                                                               \
	Class::Class() { constructBody(*this); }                                                                                                 \
	void                  Class::archiveBy(::boost::archive::binary_iarchive& ar) { archiveBody(*this, ar); }                                \
	void                  Class::archiveBy(::boost::archive::binary_oarchive& ar) { archiveBody(*this, ar); }                                \
	void                  Class::archiveBy(::boost::archive::xml_iarchive& ar) { archiveBody(*this, ar); }                                   \
	void                  Class::archiveBy(::boost::archive::xml_oarchive& ar) { archiveBody(*this, ar); }                                   \
	void                  Class::pySetAttr(const std::string& key, const ::boost::python::object& value) { setAttrBody(*this, key, value); } \
	::boost::python::dict Class::pyDict() const { return dictBody(*this); }                                                                  \
	void                  Class::callPostLoad() { postLoadBody(*this); }                                                                     \
	void                  Class::pyRegisterClass(::boost::python::object moduleScope) { registerBody(*this, moduleScope); }                  \
	REGISTER_FACTORABLE(Class)

#define YADE_CLASS_BASE_DOC_ATTRS_INIT_CTOR_PY(Class, Base, docString, attrs, inits, ctor, py) \
public:                                                                                        \
	BOOST_PP_SEQ_FOR_EACH(TALIK_ATTR_DECLARE, Class, attrs)                                \
	TALIK_CLASS_COMMON(Class, Base, attrs, attrs, ctor,                                    \
	                   TALIK_CLASS_OBJECT(Class, Base, docString) BOOST_PP_SEQ_FOR_EACH(TALIK_ATTR_EXPOSE, Class, attrs)(void) classObject py;)
#define YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(Class, Base, doc, attrs, ctor, py) YADE_CLASS_BASE_DOC_ATTRS_INIT_CTOR_PY(Class, Base, doc, attrs, , ctor, py)
#define YADE_CLASS_BASE_DOC_ATTRS_CTOR(Class, Base, doc, attrs, ctor) YADE_CLASS_BASE_DOC_ATTRS_INIT_CTOR_PY(Class, Base, doc, attrs, , ctor, )
#define YADE_CLASS_BASE_DOC_ATTRS(Class, Base, doc, attrs) YADE_CLASS_BASE_DOC_ATTRS_INIT_CTOR_PY(Class, Base, doc, attrs, , , )
#define YADE_CLASS_BASE_DOC(Class, Base, doc) YADE_CLASS_BASE_DOC_ATTRS_INIT_CTOR_PY(Class, Base, doc, , , , )

#define TALIK_STATIC_DECLARE(r, Class, a) static TALIK_ATTR_TYPE(a) TALIK_ATTR_NAME(a);
#define TALIK_STATIC_INIT(r, Class, a) Class::TALIK_ATTR_NAME(a) = TALIK_ATTR_TYPE(a)(TALIK_ATTR_INIT(a));
#define TALIK_STATIC_EXPOSE(r, Class, a)                                                                                                            \
	classObject.add_static_property(                                                                                                            \
	        TALIK_ATTR_KEY(a),                                                                                                                  \
	        ::boost::python::make_getter(&Class::TALIK_ATTR_NAME(a), ::boost::python::return_value_policy<::boost::python::return_by_value>()), \
	        ::boost::python::make_setter(&Class::TALIK_ATTR_NAME(a), ::boost::python::return_value_policy<::boost::python::return_by_value>()));
#define TALIK_STATIC_TEXT(r, Class, a) "\n\n" TALIK_ATTR_KEY(a) ": " TALIK_ATTR_TEXT(a)

/// Drawing functors: YADE makes their instances, so what a user sets is static.
#define YADE_CLASS_BASE_DOC_STATICATTRS(Class, Base, docString, attrs)                                                    \
public:                                                                                                                   \
	BOOST_PP_SEQ_FOR_EACH(TALIK_STATIC_DECLARE, Class, attrs)                                                         \
	TALIK_CLASS_COMMON(                                                                                               \
	        Class, Base, attrs, , ,                                                                                   \
	        BOOST_PP_SEQ_FOR_EACH(TALIK_STATIC_INIT, Class, attrs)                                                    \
	                TALIK_CLASS_OBJECT(Class, Base, docString BOOST_PP_SEQ_FOR_EACH(TALIK_STATIC_TEXT, Class, attrs)) \
	                        BOOST_PP_SEQ_FOR_EACH(TALIK_STATIC_EXPOSE, Class, attrs))

#define REGISTER_SERIALIZABLE(Class)        \
	}                                   \
	BOOST_CLASS_EXPORT_KEY(yade::Class) \
	namespace yade {
