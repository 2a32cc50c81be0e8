// The shared object is both: an extension module of Python and a plugin of YADE. Importing it
// registers our classes with a YADE that has already started.
#include "Yade.hpp"
#include "checks/Engines.hpp"
#include "classes/SoftGrainIntegrator.hpp"
#include "classes/WallStressController.hpp"
#include "python/PythonContactProblem.hpp"
#include "scene/Hardening.hpp"

#include <malloc.h>

namespace {

namespace py = boost::python;

/// YADE registers what stands in ClassFactory::pluginClasses. Of these, only classes it does not
/// know yet may be registered now: registering one twice replaces its Python class under the user's
/// feet.
void registerClasses()
{
	auto& factory = yade::ClassFactory::instance();
	const auto& known = yade::Omega::instance().getDynlibsDescriptor();
	const std::list<std::string> all = factory.pluginClasses;
	factory.pluginClasses.remove_if(
		[&](const std::string& name) { return known.count(name) > 0; });
	yade::Omega::instance().loadPlugins({});
	factory.pluginClasses = all;
}

/// Does this plugin see YADE's objects laid out as YADE does? Values written through YADE's own
/// Python wrapper into late members are read back with the layout compiled in here.
bool layoutMatches()
{
	const auto scene = yade::Omega::instance().getScene();
	const long slack = static_cast<long>(malloc_usable_size(scene.get())) -
			   static_cast<long>(sizeof(yade::Scene));
	py::object O = py::import("yade").attr("O");
	const long before = scene->stopAtIter;
	O.attr("stopAtIter") = 123457;
	const bool sceneAgrees = scene->stopAtIter == 123457;
	O.attr("stopAtIter") = before;

	py::object wrapper = py::import("yade.wrapper");
	py::object shape = wrapper.attr("Wall")();
	shape.attr("highlight") = true;
	shape.attr("axis") = 2;
	const yade::Wall& wall = py::extract<const yade::Wall&>(shape);
	py::object state = wrapper.attr("State")();
	state.attr("densityScaling") = 0.625;
	const yade::State& read = py::extract<const yade::State&>(state);
	return slack >= 0 && slack < 32 && sceneAgrees && wall.highlight && wall.axis == 2 &&
	       read.densityScaling == 0.625;
}

/// Where bodies were erased, a new collider knows none until it is told that they changed.
void letColliderReadBodies()
{
	yade::Omega::instance().getScene()->bodies->checkedByCollider = false;
}

double criticalTimeStep() { return yade::criticalTimeStep(*yade::Omega::instance().getScene()); }

bool hasForcesOfLastStep()
{
	return yade::hasForcesOfLastStep(*yade::Omega::instance().getScene());
}

yade::Vector3r contactForce(int id)
{
	const auto& bodies = *yade::Omega::instance().getScene()->bodies;
	if (!bodies.exists(id))
		throw std::invalid_argument("body #" + std::to_string(id) + " does not exist");
	return yade::contactForceOn(*bodies[id]);
}

} // namespace

BOOST_PYTHON_MODULE(_softgrain)
{
	py::scope().attr("version") = SOFTGRAIN_VERSION;
	py::scope().attr("yadeVersion") = SOFTGRAIN_YADE_VERSION;
	py::scope().attr("yadeBits") = YADE_REAL_BIT;
	py::def("registerClasses", registerClasses,
		"Register the classes of softgrain with the running YADE.");
	py::def("layoutMatches", layoutMatches,
		"Whether YADE's objects have the layout this plugin was compiled for.");
	py::def("criticalTimeStep", criticalTimeStep,
		"Critical time step of the undeformed soft grains of the scene [s]; 0 if there are "
		"none.");
	py::def("contactForce", contactForce,
		"Sum of the contact forces on a body in the last step, from its interactions [N].");
	py::def("hasForcesOfLastStep", hasForcesOfLastStep,
		"Whether O.forces holds the forces of the last step, or of the present one.");
	py::def("letColliderReadBodies", letColliderReadBodies,
		"Has the next run of the collider take the bodies from their list.");
	py::def("becomeClump", yade::becomeClump,
		"(id, centre, mass, inertia (axes of space), velocity, angular momentum): gives a "
		"clump what a body has that it is to stand for; its members stay where they are.");
	py::def("solveContactProblem", softgrain::solveDict,
		"Sweeps over a contact problem: (problem, tolerance, maxSweeps) to dict; see "
		"softgrain.solve_contact_problem.");
}
