// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/multiscale/settings/GroundVector.hpp>

#include <sstream>

namespace py = boost::python;

namespace talik {
namespace {
	bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

	struct Converter {
		static PyObject* convert(const GroundVector& v)
		{
			if (v.components() == 2) return py::incref(py::object(yade::Vector2r(v[0], v[1])).ptr());
			return py::incref(py::object(yade::Vector3r(v[0], v[1], v[2])).ptr());
		}

		static void* convertible(PyObject* object)
		{
			if (!PySequence_Check(object)) return nullptr;
			const Py_ssize_t size = PySequence_Size(object);
			if (size < 0) PyErr_Clear();
			if (size != 2 && size != 3) return nullptr;
			for (Py_ssize_t i = 0; i < size; ++i) {
				const py::handle<> item(py::allow_null(PySequence_GetItem(object, i)));
				if (!item) PyErr_Clear();
				if (!item || !py::extract<double>(item.get()).check()) return nullptr;
			}
			return object;
		}

		static void construct(PyObject* object, py::converter::rvalue_from_python_stage1_data* data)
		{
			void*            memory = reinterpret_cast<py::converter::rvalue_from_python_storage<GroundVector>*>(data)->storage.bytes;
			const py::object items { py::handle<>(py::borrowed(object)) };
			const auto       number = [&](int i) { return double(py::extract<double>(items[i])); };
			if (py::len(items) == 2) new (memory) GroundVector(yade::Vector2r(number(0), number(1)));
			else new (memory) GroundVector(yade::Vector3r(number(0), number(1), number(2)));
			data->convertible = memory;
		}
	};
} // namespace

GroundVector::GroundVector(double everywhere)
        : plane_(yade::Vector2r::Constant(everywhere))
        , space_(yade::Vector3r::Constant(everywhere))
{}

GroundVector::GroundVector(const yade::Vector2r& plane)
        : given_(true)
        , plane_(plane)
        , space_(yade::Vector3r::Zero())
{}

GroundVector::GroundVector(const yade::Vector3r& space)
        : inSpace_(true)
        , given_(true)
        , plane_(yade::Vector2r::Zero())
        , space_(space)
{}

/// A component may have been assigned to the vector inside. What is NaN or infinite in each direction says nothing.
bool GroundVector::isGiven() const
{
	const double first   = (*this)[0];
	bool         uniform = true;
	for (int a = 1; a < components(); ++a)
		uniform = uniform && same((*this)[a], first);
	if (uniform && !std::isfinite(first)) return false;
	return given_ || !uniform || !same(first, space_[0]);
}

std::string GroundVector::text() const
{
	std::ostringstream out;
	for (int a = 0; a < components(); ++a)
		out << (a ? ", " : "(") << (*this)[a];
	out << ")";
	return out.str();
}

template <int D> Vec<D> GroundVector::in(const std::string& attribute) const
{
	if (isGiven() && components() != D)
		throw std::invalid_argument(
		        attribute + " is " + text()
		        + (D == 3 ? ", of two components, but the ground is in space: give three, x, y and z with z upwards."
		                  : ", of three components, but the ground lies in the plane: give two, x and y with y upwards."));
	Vec<D> v;
	for (int a = 0; a < D; ++a)
		v[a] = (*this)[isGiven() ? a : 0];
	return v;
}

template Vec<2> GroundVector::in<2>(const std::string&) const;
template Vec<3> GroundVector::in<3>(const std::string&) const;

py::object GroundVector::inside(const py::object& owner)
{
	py::object vector = inSpace_ ? py::object(py::ptr(&space_)) : py::object(py::ptr(&plane_));
	if (!py::objects::make_nurse_and_patient(vector.ptr(), owner.ptr())) py::throw_error_already_set();
	return vector;
}

void GroundVector::registerOnce()
{
	const auto* known = py::converter::registry::query(py::type_id<GroundVector>());
	if (known && known->m_to_python) return;
	py::to_python_converter<GroundVector, Converter>();
	py::converter::registry::push_back(&Converter::convertible, &Converter::construct, py::type_id<GroundVector>());
}

} // namespace talik
