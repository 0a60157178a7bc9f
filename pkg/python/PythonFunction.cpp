// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/python/PythonFunction.hpp>

#include <algorithm>
#include <iostream>
#include <sstream>
#include <stdexcept>

namespace py = boost::python;

namespace talik {
namespace {
	std::string textOf(const py::object& value)
	{
		const py::handle<> text(py::allow_null(PyObject_Str(value.ptr())));
		const char* const  letters = text ? PyUnicode_AsUTF8(text.get()) : nullptr;
		if (letters) return letters;
		PyErr_Clear();
		return "?";
	}

	std::string attributeOf(const py::object& of, const char* name)
	{
		const py::handle<> value(py::allow_null(PyObject_GetAttrString(of.ptr(), name)));
		if (value) return textOf(py::object(value));
		PyErr_Clear();
		return "";
	}

	/// Of a function or class its own name, of another object that of its class.
	std::string importName(const py::object& function)
	{
		const bool        named = PyObject_HasAttrString(function.ptr(), "__qualname__");
		const py::object  owner = named ? function : function.attr("__class__");
		const std::string path  = attributeOf(owner, "__qualname__");
		return attributeOf(owner, "__module__") + ":" + (named ? path : path + "()");
	}

	/// Throws what Python raises.
	py::object import(const std::string& name)
	{
		const auto         colon = name.find(':');
		py::object         found = py::import("importlib").attr("import_module")(name.substr(0, colon));
		std::istringstream path(name.substr(colon + 1));
		for (std::string part; std::getline(path, part, '.');)
			found = found.attr(part.c_str());
		return found;
	}

	struct Converter {
		static PyObject* convert(const PythonFunction& function) { return py::incref(function.forScript().ptr()); }

		static void* convertible(PyObject* object) { return object; }

		static void construct(PyObject* object, py::converter::rvalue_from_python_stage1_data* data)
		{
			void* memory = reinterpret_cast<py::converter::rvalue_from_python_storage<PythonFunction>*>(data)->storage.bytes;
			new (memory) PythonFunction(py::object(py::handle<>(py::borrowed(object))));
			data->convertible = memory;
		}
	};
} // namespace

PythonFunction::PythonFunction(const py::object& given)
{
	if (given.is_none()) return;
	if (PyUnicode_Check(given.ptr())) {
		name_ = textOf(given);
		return;
	}
	object_ = endingUnderLock(new py::object(given));
	name_   = PyCallable_Check(given.ptr()) ? importName(given) : textOf(given);
}

py::object PythonFunction::forScript() const
{
	if (object_) return *object_;
	return name_.empty() ? py::object() : py::object(name());
}

std::string PythonFunction::name() const { return !name_.empty() && name_.front() == notImportable ? name_.substr(1) : name_; }

py::object PythonFunction::find(const std::string& attribute) const
{
	if (!isGiven()) throw std::invalid_argument(attribute + " is None: give a function, or its name as 'module:name'.");
	py::object found;
	if (object_) found = *object_;
	else if (name_.front() == notImportable)
		throw std::invalid_argument(
		        attribute + " was " + name() + " when the file was written, and no import gives that back: set " + attribute
		        + " again before going on, or use a function of a module.");
	else if (name_.find(':') == std::string::npos)
		throw std::invalid_argument(attribute + " is '" + name_ + "': give a function, or its name as 'module:name'.");
	else try {
			found = import(name_);
		} catch (const py::error_already_set&) {
			throw std::invalid_argument(
			        attribute + " is '" + name_ + "', which cannot be imported (" + takePythonError()
			        + "): put the folder of its module into PYTHONPATH, in a script define it first, or set " + attribute + " to the function.");
		}
	if (!PyCallable_Check(found.ptr()))
		throw std::invalid_argument(attribute + " is " + name_ + ", which cannot be called: give a function, or its name as 'module:name'.");
	return found;
}

std::shared_ptr<py::object> PythonFunction::forRun(const std::string& attribute) const
{
	const PythonLock held;
	const auto       found = endingUnderLock(new py::object(find(attribute)));
	if (!warned_ && archivedName().front() == notImportable) {
		warned_ = true;
		std::cerr << "Talik warns: " << attribute << " " << name() << " cannot be imported again: a checkpoint of this run goes on only after "
		          << attribute << " is set anew. A function of a module is found by its name." << std::endl;
	}
	return found;
}

std::string PythonFunction::archivedName() const
{
	if (!object_) return name_;
	const PythonLock held;
	// in a script of YADE __name__ is not that of the module whose names it defines
	for (const std::string& name : { name_, "__main__" + name_.substr(std::min(name_.find(':'), name_.size())) })
		try {
			if (import(name).ptr() == object_->ptr()) return name;
		} catch (const py::error_already_set&) {
			PyErr_Clear();
		}
	return notImportable + name_;
}

void PythonFunction::registerOnce()
{
	const auto* known = py::converter::registry::query(py::type_id<PythonFunction>());
	if (known && known->m_to_python) return;
	py::to_python_converter<PythonFunction, Converter>();
	py::converter::registry::push_back(&Converter::convertible, &Converter::construct, py::type_id<PythonFunction>());
}

std::string takePythonError()
{
	PyObject *type = nullptr, *value = nullptr, *trace = nullptr;
	PyErr_Fetch(&type, &value, &trace);
	PyErr_NormalizeException(&type, &value, &trace);
	const py::handle<> heldType(py::allow_null(type)), heldValue(py::allow_null(value)), heldTrace(py::allow_null(trace));
	if (!heldType || !heldValue) return "an error without a name";
	std::string words = attributeOf(py::object(heldType), "__name__");
	try {
		if (heldTrace) {
			const py::object frames = py::import("traceback").attr("extract_tb")(py::object(heldTrace));
			if (py::len(frames) > 0) {
				const py::object last = frames[-1];
				words += " in " + textOf(last.attr("filename")) + ", line " + textOf(last.attr("lineno"));
			}
		}
	} catch (const py::error_already_set&) {
		PyErr_Clear();
	}
	std::string message = textOf(py::object(heldValue));
	std::replace(message.begin(), message.end(), '\n', ' ');
	return message.empty() ? words : words + ": " + message;
}

} // namespace talik
