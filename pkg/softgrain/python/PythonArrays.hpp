// C++ vectors to numpy arrays (read-only copies).
#pragma once

#include "Yade.hpp"

#include <vector>

namespace softgrain {

/// Array of `numbers` (row-major) with the given shape, e.g. "(-1, 3)".
template <class Number>
inline boost::python::object numpyArray(const std::vector<Number>& numbers,
					boost::python::tuple shape)
{
	namespace py = boost::python;
	static_assert(sizeof(Number) == 8 || sizeof(Number) == 4);
	const py::object bytes(py::handle<>(PyBytes_FromStringAndSize(
		reinterpret_cast<const char*>(numbers.data()),
		static_cast<Py_ssize_t>(numbers.size() * sizeof(Number)))));
	const char* type = std::is_floating_point<Number>::value ? "f8"
			   : sizeof(Number) == 8                 ? "i8"
								 : "i4";
	return py::import("numpy").attr("frombuffer")(bytes, type).attr("reshape")(shape);
}

/// Array (n, dim) of the first `dim` components of vectors in space.
template <class Vector>
inline boost::python::object numpyArray(const std::vector<Vector>& vectors, int dim)
{
	std::vector<double> numbers;
	for (const Vector& v : vectors)
		numbers.insert(numbers.end(), v.data(), v.data() + dim);
	return numpyArray(numbers, boost::python::make_tuple(-1, dim));
}

/// Array (n, 3) of vectors, (n, 3, 3) of matrices.
template <class Tensor> inline boost::python::object numpyArray(const std::vector<Tensor>& tensors)
{
	namespace py = boost::python;
	std::vector<double> numbers;
	for (const Tensor& t : tensors)
		for (int a = 0; a < t.rows(); ++a)
			for (int b = 0; b < t.cols(); ++b)
				numbers.push_back(t(a, b));
	return numpyArray(numbers, Tensor::ColsAtCompileTime == 1 ? py::make_tuple(-1, 3)
								  : py::make_tuple(-1, 3, 3));
}

} // namespace softgrain
