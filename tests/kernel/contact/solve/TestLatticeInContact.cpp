// Grains as they are in a packing: with real tables, in contact on all sides.
#include "Helpers.hpp"
#include "contact/search/Search.hpp"
#include "contact/solve/ContactSolver.hpp"
#include "contact/solve/CoulombCone.hpp"
#include "contact/solve/Sharing.hpp"
#include "reference/GrainTemplate.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <optional>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// Real grains in a square (cubic) lattice, which overlap their neighbours and a plane a little;
/// one more, aside, overlaps its own image.
template <int dim> class Lattice {
public:
	static constexpr int across = dim == 2 ? 8 : 4;

	std::vector<ContactBody<dim>> body;

	explicit Lattice(const std::optional<InterfaceLaw>& law = {})
		: template_(makeGrainTemplate<dim>(recipe()))
		, law_(law)
	{
		const int count = static_cast<int>(std::lround(std::pow(across, dim)));
		for (int k = 0; k < count; ++k) {
			Vec<dim> place;
			for (int a = 0, rest = k; a < dim; ++a, rest /= across)
				place[a] = spacing * (rest % across);
			addGrain(place);
		}
		addGrain(Vec<dim>::Constant(-5));
		Random random(1);
		for (ContactBody<dim>& b : body)
			for (Vec<dim>& v : b.velocity)
				v = random.vector<dim>();
		for (const ContactBody<dim>& b : body)
			start_.push_back(b.velocity);
		findLists();
	}
	Lattice(const Lattice&) = delete;

	void findAllContacts()
	{
		const double reach = 0.02;
		for (ContactList<dim>& list : lists_)
			if (list.second < 0)
				findContacts(body[list.first], reach, list);
			else if (list.second != list.first)
				findContacts(body[list.first], body[list.second], reach, list);
			else {
				ContactOutline<dim> image;
				image.becomeImage(body[list.first], list.image.shift);
				findContacts(body[list.first], image, reach, list);
			}
	}
	/// All velocities as at the start; grains at other places along the first axis have other
	/// contacts.
	void solve(ContactSolver<dim>& solver, double shear, int threads)
	{
		for (std::size_t g = 0; g < body.size(); ++g) {
			ContactBody<dim>& b = body[g];
			b.velocity = start_[g];
			const Vec<dim> way = shear * b.box.centre()[1] * Vec<dim>::Unit(0);
			for (Vec<dim>& x : b.position)
				x += way;
			b.carried += way;
			b.updateGeometry();
			b.prepareSolve();
		}
		findAllContacts();
		std::vector<ContactList<dim>*> lists;
		for (ContactList<dim>& list : lists_)
			lists.push_back(&list);
		constexpr double dt = 1e-3;
		for (ContactList<dim>& list : lists_)
			if (list.interface) list.interface->begin(dt, dt);
		REQUIRE(threadsThatShare<dim>(lists_, body, {}, {}, threads) == threads);
		solver.plan(lists, static_cast<int>(body.size()));
		solver.prepare(body, dt, {}, threads);
		const SolverReport report = solver.solve();
		CHECK(report.active > 100);
		CHECK(report.converged);
	}
	/// How far velocities of nodes in contact are from those that the impulses make, over the
	/// largest change of a velocity.
	double error() const
	{
		double largest = 0, change = 0;
		for (const ContactList<dim>& list : lists_)
			for (const Contact<dim>& c : list.contacts) {
				const int own = c.key.side == 0 ? list.first : list.second;
				check(own, c.key.node, largest, change);
				for (int i = 0; i < c.partners; ++i)
					check(own == list.first ? list.second : list.first,
					      c.partner[i], largest, change);
			}
		return largest / change;
	}

	/// What the contacts of all interfaces remember.
	std::vector<double> histories() const
	{
		std::vector<double> all;
		for (const ContactList<dim>& list : lists_) {
			const std::vector<double> own = list.interface->numbers();
			all.insert(all.end(), own.begin(), own.end());
		}
		return all;
	}
	int bonds() const
	{
		int count = 0;
		for (const ContactList<dim>& list : lists_)
			for (const ContactHistory<dim>& history : list.interface->history)
				count += history.bond == Bond::whole;
		return count;
	}

	/// The problem of each list on its own, after the four sweeps of every step; with W as it
	/// is laid out for sweeps, or as a sparse table.
	std::vector<ContactProblem<dim>> sweptAlone(bool laidOut)
	{
		std::vector<ContactProblem<dim>> problems;
		SolverSettings settings;
		settings.tolerance = 1e9;
		Random random(2);
		for (ContactList<dim>& list : lists_) {
			for (std::size_t g = 0; g < body.size(); ++g) {
				body[g].velocity = start_[g];
				body[g].surfaceMobility =
					laidOut ? &template_->surfaceMobility : nullptr;
				body[g].prepareSolve();
			}
			for (Contact<dim>& c : list.contacts)
				c.impulse = 0.1 * c.normal + 0.1 * random.vector<dim>();
			ContactSolver<dim> solver;
			solver.plan({ &list }, static_cast<int>(body.size()));
			solver.prepare(body, 1e-3, settings);
			CHECK(solver.solve().sweeps == 4);
			problems.push_back(solver.problem());
		}
		return problems;
	}

private:
	static constexpr double spacing = 1.99;

	static TemplateRecipe recipe()
	{
		TemplateRecipe recipe;
		recipe.zeta = dim == 2 ? 0.2 : 0.3;
		recipe.order = 2;
		return recipe;
	}
	void addGrain(const Vec<dim>& place)
	{
		body.push_back(contactBody<dim>(*template_, 1, place));
		body.back().surfaceMobility = &template_->surfaceMobility;
	}
	void findLists()
	{
		const int last = static_cast<int>(body.size()) - 1;
		auto add = [&](int first, int second) -> ContactList<dim>& {
			lists_.emplace_back();
			lists_.back().first = first;
			lists_.back().second = second;
			lists_.back().friction = 0.3;
			if (law_) {
				lists_.back().interface.emplace();
				lists_.back().interface->law = *law_;
			}
			return lists_.back();
		};
		for (int g = 0; g < last; ++g) {
			const Vec<dim> place = body[g].box.centre();
			if (place[1] < 0.5)
				add(g, -1).plane = { Vec<dim>(-0.99 * Vec<dim>::Unit(1)),
						     Vec<dim>::Unit(1), Vec<dim>::Zero() };
			for (int h = g + 1; h < last; ++h)
				if ((body[h].box.centre() - place).norm() < 1.1 * spacing)
					add(g, h);
		}
		add(last, last).image.shift = spacing * Vec<dim>::Unit(0);
	}
	void check(int g, int node, double& largest, double& change) const
	{
		const ContactBody<dim>& b = body[g];
		Vec<dim> made = Vec<dim>::Zero();
		for (int k = b.delassus->begin(node); k < b.delassus->end(node); ++k)
			made += b.delassusScale * b.delassus->value[k] *
				b.impulse[b.delassus->column[k]];
		largest = std::max(largest, (b.velocity[node] - start_[g][node] - made).norm());
		change = std::max(change, made.norm());
	}

	std::shared_ptr<const GrainTemplate<dim>> template_;
	std::optional<InterfaceLaw> law_; ///< in all pairs
	std::vector<ContactList<dim>> lists_;
	std::vector<std::vector<Vec<dim>>> start_;
};

/// Impulses after two sweeps backwards and two forwards, each contact with the velocity that all
/// impulses make.
template <int dim> std::vector<Vec<dim>> sweptByHand(ContactProblem<dim> problem)
{
	problem.impulse = problem.start;
	const int count = problem.contacts();
	for (int visit = 0; visit < 4 * count; ++visit) {
		const int place = visit % count;
		const int k = visit < 2 * count ? count - 1 - place : place;
		problem.impulse[k] = solvedContact<dim>(
			problem.impulse[k], problem.velocity()[k], problem.normal[k],
			problem.bias[k], 1 / problem.mobility(k), problem.friction[k]);
	}
	return problem.impulse;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Solver: each contact is solved with what those before it did", "[contact]",
		       ((int dim), dim), 2, 3)
{
	const bool laidOut = GENERATE(true, false);
	Lattice<dim> lattice;
	lattice.findAllContacts();
	int contacts = 0;
	for (const ContactProblem<dim>& problem : lattice.sweptAlone(laidOut)) {
		const std::vector<Vec<dim>> byHand = sweptByHand(problem);
		for (int k = 0; k < problem.contacts(); ++k)
			CHECK((problem.impulse[k] - byHand[k]).norm() < 1e-11);
		contacts += problem.contacts();
	}
	CHECK(contacts > 100);
}

TEMPLATE_TEST_CASE_SIG("Solver: grains in contact on all sides move as their impulses say",
		       "[contact]", ((int dim), dim), 2, 3)
{
	Lattice<dim> one, three;
	ContactSolver<dim> ofOne, ofThree;
	for (double shear : { 0., 0.02, 0.02, -0.05 }) { // with other nodes in contact
		CAPTURE(shear);
		one.solve(ofOne, shear, 1);
		three.solve(ofThree, shear, 3);
		CHECK(one.error() < 1e-10);
		for (std::size_t g = 0; g < one.body.size(); ++g) {
			CHECK(one.body[g].velocity == three.body[g].velocity);
			CHECK(one.body[g].impulse == three.body[g].impulse);
		}
	}
}

TEMPLATE_TEST_CASE_SIG("Solver: interfaces give the same bits with any number of threads",
		       "[contact]", ((int dim), dim), 2, 3)
{
	InterfaceLaw law;
	law.dynamicFriction = 0.1;
	law.cohesion = 1e4;
	law.cohesionRange = 0.03;
	law.bondStrength = 3e4;
	law.bondEnergy = 1e3;
	Lattice<dim> one(law), three(law);
	ContactSolver<dim> ofOne, ofThree;
	for (double shear : { 0., 0.002, 0.02 }) {
		CAPTURE(shear);
		one.solve(ofOne, shear, 1);
		three.solve(ofThree, shear, 3);
		CHECK(one.bonds() > 100);
		CHECK(one.histories() == three.histories());
		for (std::size_t g = 0; g < one.body.size(); ++g) {
			CHECK(one.body[g].velocity == three.body[g].velocity);
			CHECK(one.body[g].impulse == three.body[g].impulse);
		}
	}
}
