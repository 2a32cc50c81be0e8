#include "Helpers.hpp"
#include "contact/Interface.hpp"
#include "contact/solve/ContactSolver.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <limits>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

InterfaceLaw bondLaw()
{
	InterfaceLaw law;
	law.bondStrength = 2e4;
	law.bondEnergy = 5;
	law.bondStiffness = 4e8;
	return law;
}

/// Work that a bond takes when it is opened along `way` (s and g at 0 <= t <= 1), J/m^2.
template <int dim> double workOfOpening(const InterfaceLaw& law, Vec<dim> slip, double gap)
{
	PairInterface<dim> interface;
	interface.law = law;
	interface.resize(1);
	interface.bondNow(0, 0);
	const int steps = 20000;
	interface.begin(1, 1. / steps);
	const Vec<dim> n = Vec<dim>::Unit(dim - 1);
	double work = 0;
	for (int i = 0; i < steps; ++i) {
		const double t = (i + 0.5) / steps;
		interface.history[0].slip = t * slip;
		const Vec<dim> p = interface.pullOn(0, { n, t * gap, { 1, 0 } });
		work -= p.dot(slip + gap * n) / steps;
	}
	CHECK(interface.history[0].bond == Bond::broken);
	return work;
}

} // namespace

TEST_CASE("a bad interface law is refused with its name", "[interface]")
{
	const double infinity = std::numeric_limits<double>::infinity();
	auto complaint = [](auto change, double friction = 0.5) {
		InterfaceLaw law = bondLaw();
		law.cohesion = 1e3;
		law.cohesionRange = 1e-4;
		change(law);
		return complaintOf([&] { law.validate(friction); });
	};
	CHECK(complaint([](InterfaceLaw&) {}).empty());
	CHECK(complaint([](InterfaceLaw&) {}, -0.1).starts_with("friction = -0.1"));
	CHECK(complaint([](InterfaceLaw&) {}, infinity).starts_with("friction = inf"));
	using Law = InterfaceLaw;
	CHECK(complaint([](Law& l) { l.dynamicFriction = 0.6; })
		      .starts_with("dynamicFrictAngle = 0.54042 is outside the admissible range "
				   "[0, 0.463648] rad"));
	CHECK(complaint([](Law& l) { l.cohesion = -1; }).starts_with("cohesion = -1"));
	CHECK(complaint([](Law& l) { l.cohesionRange = 0; }).starts_with("cohesionRange = 0"));
	CHECK(complaint([&](Law& l) { l.bondStrength = infinity; }).starts_with("bondStrength"));
	CHECK(complaint([](Law& l) { l.bondEnergy = 0; }).starts_with("bondEnergy"));
	CHECK(complaint([](Law& l) { l.bondStiffness = 1e7; }).starts_with("bondStiffness"));
	CHECK(complaint([](Law& l) { l.restitution = 1.01; }).starts_with("restitution = 1.01"));
}

TEMPLATE_TEST_CASE_SIG("a bond takes its energy however it is opened", "[interface]",
		       ((int dim), dim), 2, 3)
{
	const InterfaceLaw law = bondLaw();
	const Vec<dim> along = Vec<dim>::Unit(0);
	const double end = 1.2 * law.finalOpening();
	for (double angle : { 0., 0.4, 1.2, 0.5 * M_PI }) {
		const double work = workOfOpening<dim>(law, end * std::sin(angle) * along,
						       end * std::cos(angle));
		CHECK(std::abs(work - law.bondEnergy) < 1e-4 * law.bondEnergy);
	}
}

TEST_CASE("a damaged bond unloads along its secant and does not form again", "[interface]")
{
	PairInterface<2> interface;
	interface.law = bondLaw();
	interface.resize(1);
	interface.begin(1, 1);
	const ContactOutcome<2> pressed { { 0, 1 }, { 0, 1 }, { 0, 0 }, 0, 0, 1 };
	interface.remember(0, pressed, 0);
	CHECK(interface.history[0].bond == Bond::whole);
	auto traction = [&](double gap) {
		return -interface.pullOn(0, { { 0, 1 }, gap, { 1, 0 } })[1];
	};
	const double half = 0.5 * interface.law.finalOpening();
	const double loaded = traction(half);
	CHECK(loaded < interface.law.bondStrength);
	CHECK(loaded > 0.4 * interface.law.bondStrength);
	CHECK(std::abs(traction(0.5 * half) - 0.5 * loaded) < 1e-12 * loaded);
	CHECK(traction(-half) == 0); // compression is the contact's
	CHECK(std::abs(traction(half) - loaded) < 1e-12 * loaded);
	CHECK(traction(2.1 * half) == 0);
	interface.remember(0, pressed, 0);
	CHECK(interface.history[0].bond == Bond::broken);
	CHECK(traction(0.1 * half) == 0);

	PairInterface<2> restored;
	restored.restore(interface.numbers());
	CHECK(restored.numbers() == interface.numbers());
}

TEST_CASE("a sheared bond turns with the body that it holds", "[interface]")
{
	PairInterface<3> interface;
	interface.law = bondLaw();
	interface.resize(1);
	const double dt = 1e-3, spin = 2;
	interface.begin(1, dt);
	interface.bondNow(0, 0);
	const Vec<3> up(0, 0, 1);
	const double slip = 0.2 * interface.law.finalOpening();
	interface.remember(0, { up, Vec<3>::Zero(), { slip / dt, 0, 0 }, 0, 0, 1 }, 0);
	const double turns = M_PI / 2 / (spin * dt); // a quarter of one
	for (int step = 0; step < std::lround(turns); ++step)
		interface.remember(0, { up, Vec<3>::Zero(), Vec<3>::Zero(), spin, 0, 1 }, 0);
	CHECK((interface.history[0].slip - Vec<3>(0, slip, 0)).norm() < 1e-3 * slip);
}

TEST_CASE("cohesion ends within the part of the outline that a node stands for", "[interface]")
{
	PairInterface<2> interface;
	interface.law.cohesion = 10;
	interface.law.cohesionRange = 1;
	interface.resize(1);
	interface.begin(0.1, 0.1);
	auto share = [&](double gap, double spread) {
		return -interface.pullOn(0, { { 0, 1 }, gap, { 2, spread } })[1] / 2;
	};
	CHECK(share(0.99, 0) == 1);
	CHECK(share(1.01, 0) == 0);
	CHECK(std::abs(share(1.1, 0.4) - 0.25) < 1e-12);
	CHECK(std::abs(share(1, 0.4) - 0.5) < 1e-12);
	CHECK(share(0.7, 0.4) == 1);
}

TEST_CASE("friction is dynamic after a contact slid, and static again once it sticks",
	  "[interface]")
{
	PairInterface<2> interface;
	interface.law.dynamicFriction = 0.3;
	interface.resize(1);
	interface.begin(1, 1);
	const double friction = 0.5;
	auto after = [&](double tangential, double normal) {
		interface.remember(0, { { 0, 1 }, { tangential, normal }, { 0, 0 }, 0, 0, 1 },
				   friction);
		return interface.frictionOf(0, friction);
	};
	CHECK(after(0.49, 1) == 0.5); // more than mu_d, but it stuck
	CHECK(after(-0.5, 1) == 0.3);
	CHECK(after(0.3, 1) == 0.3); // at the bound: still sliding
	CHECK(after(0, 0) == 0.3);   // no force, no news
	CHECK(after(0.29, 1) == 0.5);
}

TEST_CASE("a bond is carried with its contact, and counted where that is lost", "[interface]")
{
	PairInterface<2> interface;
	interface.law = bondLaw();
	interface.resize(3);
	interface.bondNow(0, 0);
	interface.bondNow(2, 1e-6);
	interface.beginSearch();
	interface.resize(2);
	interface.carry(2, 1);
	CHECK(interface.history[0].bond == Bond::none);
	CHECK(interface.history[1].bond == Bond::whole);
	CHECK(interface.history[1].start == 1e-6);
	CHECK(interface.takeLostBonds() == 1);
	CHECK(interface.takeLostBonds() == 0);
}

TEMPLATE_TEST_CASE_SIG("two bodies rebound with Newton's coefficient", "[interface]",
		       ((int dim), dim), 2, 3)
{
	for (double restitution : { 0., 0.4, 1. }) {
		SparseRows<double> table;
		table.append(0, 1);
		table.closeRow();
		OutlineMesh<dim> mesh;
		std::vector<ContactBody<dim>> body(1);
		body[0].mesh = &mesh;
		body[0].delassus = &table;
		body[0].delassusScale = 1 / 2.; // of a mass of 2 kg
		body[0].position = { 0.5 * Vec<dim>::Unit(0) };
		const Vec<dim> v = -3 * Vec<dim>::Unit(0);
		body[0].velocity = body[0].velocityBefore = { v };
		body[0].impulse = { Vec<dim>::Zero() };
		std::vector<RigidPartner<dim>> partner(1);
		partner[0].inverseMass.setConstant(1 / 5.);
		partner[0].velocity = partner[0].velocityBefore = Vec<dim>::Unit(0);
		ContactList<dim> list;
		list.first = 0;
		list.second = -1;
		list.rigid.emplace();
		list.rigid->partner = 0;
		list.rigid->moves = true;
		list.interface.emplace();
		list.interface->law.restitution = restitution;
		Contact<dim> contact;
		contact.key = { 0, 0, -1 };
		contact.normal = Vec<dim>::Unit(0);
		contact.gap = 0.01;
		list.contacts = { contact };
		list.interface->resize(1);
		list.interface->begin(0.1, 0.1);
		SolverSettings settings;
		settings.tolerance = 1e-12;
		ContactSolver<dim> solver;
		solver.plan({ &list }, static_cast<int>(body.size()), &partner);
		solver.prepare(body, 0.1, settings);
		solver.solve();
		// not even a perfectly plastic impact leaves the gap at hand unused
		const double relative = restitution > 0 ? 4 * restitution : -0.01 / 0.1;
		const double mean = (2 * -3. + 5 * 1.) / 7;
		CHECK(std::abs(body[0].velocity[0][0] - (mean + relative * 5 / 7)) < 1e-12);
		CHECK(std::abs(partner[0].velocity[0] - (mean - relative * 2 / 7)) < 1e-12);
	}
}
