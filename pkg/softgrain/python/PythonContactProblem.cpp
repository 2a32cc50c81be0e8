#include "python/PythonContactProblem.hpp"
#include "python/PythonArrays.hpp"

#include <cstring>

namespace softgrain {

namespace py = boost::python;

namespace {

template <class Number>
std::vector<Number> numbersOf(const py::dict& dict, const char* key, const char* type)
{
	const py::object array = dict[key], numpy = py::import("numpy"),
			 bytes = numpy.attr("ascontiguousarray")(array, type).attr("tobytes")();
	std::vector<Number> numbers(static_cast<std::size_t>(PyBytes_Size(bytes.ptr())) /
				    sizeof(Number));
	if (!numbers.empty())
		std::memcpy(numbers.data(), PyBytes_AsString(bytes.ptr()),
			    numbers.size() * sizeof(Number));
	return numbers;
}

std::vector<double> doublesOf(const py::dict& dict, const char* key)
{
	return numbersOf<double>(dict, key, "f8");
}

std::vector<int> integersOf(const py::dict& dict, const char* key)
{
	return numbersOf<int>(dict, key, "i4");
}

ContactProblemArrays fromDict(const py::dict& dict)
{
	const py::object normal = dict["normal"], shape = py::import("numpy").attr("shape")(normal);
	if (py::len(shape) != 2)
		throw std::invalid_argument("normal is not an array (contacts, dim)");
	ContactProblemArrays p;
	p.dim = py::extract<int>(shape[1]);
	p.delassus.offset = integersOf(dict, "delassus_offset");
	if (p.delassus.offset.empty()) throw std::invalid_argument("delassus_offset is empty");
	p.delassus.column = integersOf(dict, "delassus_column");
	p.delassus.value = doublesOf(dict, "delassus_value");
	p.normal = doublesOf(dict, "normal");
	p.freeVelocity = doublesOf(dict, "free_velocity");
	p.bias = doublesOf(dict, "bias");
	p.friction = doublesOf(dict, "friction");
	p.start = doublesOf(dict, "start");
	return p;
}

py::object vectorArray(const std::vector<double>& numbers, int dim)
{
	return numpyArray(numbers, py::make_tuple(-1, dim));
}

} // namespace

py::dict toDict(const ContactProblemArrays& p)
{
	const py::tuple list = py::make_tuple(-1);
	py::dict dict;
	dict["normal"] = vectorArray(p.normal, p.dim);
	dict["free_velocity"] = vectorArray(p.freeVelocity, p.dim);
	dict["bias"] = numpyArray(p.bias, list);
	dict["friction"] = numpyArray(p.friction, list);
	dict["delassus_offset"] = numpyArray(p.delassus.offset, list);
	dict["delassus_column"] = numpyArray(p.delassus.column, list);
	dict["delassus_value"] = numpyArray(p.delassus.value, list);
	dict["start"] = vectorArray(p.start, p.dim);
	dict["impulse"] = vectorArray(p.impulse, p.dim);
	return dict;
}

py::dict solveDict(const py::dict& problem, double tolerance, int maxSweeps)
{
	ContactProblemArrays arrays = fromDict(problem);
	const SolverReport report = solve(arrays, tolerance, maxSweeps);
	py::dict result;
	result["impulse"] = vectorArray(arrays.impulse, arrays.dim);
	result["residual"] = report.residual;
	result["sweeps"] = report.sweeps;
	result["converged"] = report.converged;
	return result;
}

} // namespace softgrain
