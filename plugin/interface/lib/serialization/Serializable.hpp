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

	void        pyUpdateAttrs(const ::boost::python::dict&);
	std::string pyStr();
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

	template <class Class, class T, T Class::*member> void assignAndCheck(Class& self, const T& value)
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

	template <class Class, class T, T Class::*member> struct Getter {
		using Policy = std::conditional_t<ByReference<T>::value, py::return_internal_reference<>, py::return_value_policy<py::return_by_value>>;
		static py::object make() { return py::make_getter(member, Policy()); }
	};

	template <class Class, class T, T Class::*member, class PyClass> void attribute(PyClass& cls, const char* name, int flags, const std::string& doc)
	{
		if (flags & yade::Attr::hidden) return;
		const std::string text = doc + " :yattrflags:`" + std::to_string(flags) + "` ";
		const py::object  get  = Getter<Class, T, member>::make();
		if (flags & yade::Attr::readonly) cls.add_property(name, get, text.c_str());
		else if (flags & yade::Attr::triggerPostLoad) cls.add_property(name, get, py::make_function(&assignAndCheck<Class, T, member>), text.c_str());
		else cls.add_property(name, get, py::make_setter(member, py::return_value_policy<py::return_by_value>()), text.c_str());
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
	if (!(TALIK_ATTR_FLAGS(a) & ::yade::Attr::noSave)) ::talik::scripting::archiveAttribute(ar, TALIK_ATTR_KEY(a), TALIK_ATTR_NAME(a));
#define TALIK_ATTR_SET(r, Class, a)                                                         \
	if (key == TALIK_ATTR_KEY(a)) {                                                     \
		TALIK_ATTR_NAME(a) = ::boost::python::extract<TALIK_ATTR_TYPE(a)>(value)(); \
		return;                                                                     \
	}
#define TALIK_ATTR_GET(r, Class, a) \
	if (!(TALIK_ATTR_FLAGS(a) & ::yade::Attr::hidden)) result[TALIK_ATTR_KEY(a)] = ::boost::python::object(TALIK_ATTR_NAME(a));
#define TALIK_ATTR_EXPOSE(r, Class, a)                                                        \
	::talik::scripting::attribute<Class, TALIK_ATTR_TYPE(a), &Class::TALIK_ATTR_NAME(a)>( \
	        classObject, TALIK_ATTR_KEY(a), TALIK_ATTR_FLAGS(a), TALIK_ATTR_TEXT(a));

#define TALIK_CLASS_COMMON(Class, Base, docString, attrs, py)                                                                                        \
	REGISTER_CLASS_AND_BASE(Class, Base)                                                                                                         \
	friend class boost::serialization::access;                                                                                                   \
                                                                                                                                                     \
public:                                                                                                                                              \
	template <class Archive> void serialize(Archive& ar, unsigned)                                                                               \
	{                                                                                                                                            \
		::boost::serialization::void_cast_register<Class, Base>();                                                                           \
		if (Archive::is_loading::value) preLoad(*this);                                                                                      \
		else preSave(*this);                                                                                                                 \
		ar& ::boost::serialization::make_nvp(#Base, static_cast<Base&>(*this));                                                              \
		BOOST_PP_SEQ_FOR_EACH(TALIK_ATTR_ARCHIVE, Class, attrs)                                                                              \
		if (Archive::is_loading::value) postLoad(*this);                                                                                     \
		else postSave(*this);                                                                                                                \
	}                                                                                                                                            \
	void pySetAttr(const std::string& key, const ::boost::python::object& value) override                                                        \
	{                                                                                                                                            \
		BOOST_PP_SEQ_FOR_EACH(TALIK_ATTR_SET, Class, attrs)                                                                                  \
		Base::pySetAttr(key, value);                                                                                                         \
	}                                                                                                                                            \
	::boost::python::dict pyDict() const override                                                                                                \
	{                                                                                                                                            \
		::boost::python::dict result;                                                                                                        \
		BOOST_PP_SEQ_FOR_EACH(TALIK_ATTR_GET, Class, attrs)                                                                                  \
		result.update(this->pyDictCustom());                                                                                                 \
		result.update(Base::pyDict());                                                                                                       \
		return result;                                                                                                                       \
	}                                                                                                                                            \
	void callPostLoad() override                                                                                                                 \
	{                                                                                                                                            \
		Base::callPostLoad();                                                                                                                \
		postLoad(*this);                                                                                                                     \
	}                                                                                                                                            \
	void pyRegisterClass(::boost::python::object moduleScope) override                                                                           \
	{                                                                                                                                            \
		this->checkPyClassRegistersItself(#Class);                                                                                           \
		::boost::python::scope                                                                                       within(moduleScope);    \
		::boost::python::docstring_options                                                                           plainText(true, false); \
		::boost::python::class_<Class, ::boost::shared_ptr<Class>, ::boost::python::bases<Base>, boost::noncopyable> classObject(            \
		        #Class, docString, ::boost::python::no_init);                                                                                \
		::talik::HeldPointer<Class>::registerOnce();                                                                                         \
		classObject.def("__init__", ::boost::python::raw_function(&::talik::scripting::constructFromKeywords<Class>, 1));                    \
		BOOST_PP_SEQ_FOR_EACH(TALIK_ATTR_EXPOSE, Class, attrs)                                                                               \
		(void)classObject py;                                                                                                                \
	}

#define YADE_CLASS_BASE_DOC_ATTRS_INIT_CTOR_PY(Class, Base, docString, attrs, inits, ctor, py) \
public:                                                                                        \
	BOOST_PP_SEQ_FOR_EACH(TALIK_ATTR_DECLARE, Class, attrs)                                \
	Class() { ctor; }                                                                      \
	TALIK_CLASS_COMMON(Class, Base, docString, attrs, py)
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
#define YADE_CLASS_BASE_DOC_STATICATTRS(Class, Base, docString, attrs)                                                                               \
public:                                                                                                                                              \
	BOOST_PP_SEQ_FOR_EACH(TALIK_STATIC_DECLARE, Class, attrs)                                                                                    \
	REGISTER_CLASS_AND_BASE(Class, Base)                                                                                                         \
	template <class Archive> void serialize(Archive& ar, unsigned)                                                                               \
	{                                                                                                                                            \
		::boost::serialization::void_cast_register<Class, Base>();                                                                           \
		ar& ::boost::serialization::make_nvp(#Base, static_cast<Base&>(*this));                                                              \
		BOOST_PP_SEQ_FOR_EACH(TALIK_ATTR_ARCHIVE, Class, attrs)                                                                              \
	}                                                                                                                                            \
	void pyRegisterClass(::boost::python::object moduleScope) override                                                                           \
	{                                                                                                                                            \
		this->checkPyClassRegistersItself(#Class);                                                                                           \
		BOOST_PP_SEQ_FOR_EACH(TALIK_STATIC_INIT, Class, attrs)                                                                               \
		::boost::python::scope                                                                                       within(moduleScope);    \
		::boost::python::docstring_options                                                                           plainText(true, false); \
		::boost::python::class_<Class, ::boost::shared_ptr<Class>, ::boost::python::bases<Base>, boost::noncopyable> classObject(            \
		        #Class, docString BOOST_PP_SEQ_FOR_EACH(TALIK_STATIC_TEXT, Class, attrs), ::boost::python::no_init);                         \
		::talik::HeldPointer<Class>::registerOnce();                                                                                         \
		classObject.def("__init__", ::boost::python::raw_function(&::talik::scripting::constructFromKeywords<Class>, 1));                    \
		BOOST_PP_SEQ_FOR_EACH(TALIK_STATIC_EXPOSE, Class, attrs)                                                                             \
	}

#define REGISTER_SERIALIZABLE(Class)        \
	REGISTER_FACTORABLE(Class)          \
	}                                   \
	BOOST_CLASS_EXPORT_KEY(yade::Class) \
	namespace yade {
