#include "contact/Balls.hpp"
#include "contact/search/Search.hpp"
#include "grain/Observables.hpp"

#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <limits>
#include <map>
#include <set>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// Distance of `x` to the flat facets of a body, from places a tenth of a facet apart: too large
/// rather than too small.
template <int dim> double sampledDistance(const Vec<dim>& x, const ContactBody<dim>& body)
{
	double least = std::numeric_limits<double>::infinity();
	for (const auto& facet : body.mesh->facet)
		for (int i = 0; i <= 10; ++i)
			for (int j = 0; j <= (dim == 3 ? 10 - i : 0); ++j) {
				Vec<dim> y = body.position[facet[0]];
				y += i / 10. * (body.position[facet[1]] - body.position[facet[0]]);
				y += j / 10. *
				     (body.position[facet[dim - 1]] - body.position[facet[0]]);
				least = std::min(least, (x - y).norm());
			}
	return least;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Search: no node near a stretched outline is left out", "[contact]",
		       ((int dim), dim), 2, 3)
{
	const double spacing = dim == 2 ? 0.1 : 0.25, reach = 0.5 * spacing;
	Random random(11);
	int found = 0;
	for (int trial = 0; trial < 12; ++trial) {
		auto balls = twoBalls<dim>(0, spacing, 100 + trial);
		for (int b : { 0, 1 }) {
			Mat<dim> stretch = Mat<dim>::Identity();
			stretch(0, 0) = 3;
			const Mat<dim> Q = random.rotation<dim>();
			const Mat<dim> F = Q * stretch * Q.transpose();
			for (Vec<dim>& x : balls.body[b].position)
				x = balls.centre[b] + F * (x - balls.centre[b]);
			balls.body[b].updateGeometry();
		}
		// Move the second one along the line of centres until the outlines just touch.
		const Vec<dim> way = (balls.centre[1] - balls.centre[0]).normalized();
		auto closest = [&] {
			double least = std::numeric_limits<double>::infinity();
			for (const Vec<dim>& x : balls.body[0].position)
				least = std::min(least, sampledDistance(x, balls.body[1]));
			return least;
		};
		auto shift = [&](double by) {
			for (Vec<dim>& x : balls.body[1].position)
				x += by * way;
			balls.body[1].updateGeometry();
		};
		shift(4);
		while (closest() > 0.5 * reach)
			shift(-0.5 * closest());
		auto list = pairList<dim>();
		findContacts(balls.body[0], balls.body[1], reach, list);
		std::set<std::pair<int, int>> listed;
		for (const Contact<dim>& c : list.contacts)
			listed.insert({ c.key.side, c.key.node });
		for (int side : { 0, 1 })
			for (int s = 0; s < balls.body[side].nodes(); ++s) {
				if (sampledDistance(balls.body[side].position[s],
						    balls.body[1 - side]) >= reach)
					continue;
				CAPTURE(trial, side, s);
				CHECK(listed.count({ side, s }) == 1);
				++found;
			}
	}
	CHECK(found > 20);
}

TEMPLATE_TEST_CASE_SIG("Search: all nodes within reach, in both directions, and no others",
		       "[contact]", ((int dim), dim), 2, 3)
{
	const double h = 0.1, reach = 0.05, margin = 2e-3; // of the outline's own error
	for (unsigned seed = 1; seed <= 10; ++seed)
		for (double gap : { -0.05, 0.02 }) {
			const auto balls = twoBalls<dim>(gap, h, seed);
			auto list = pairList<dim>();
			findContacts(balls.body[0], balls.body[1], reach, list);
			std::map<ContactKey, double> found;
			double deepest = 0;
			for (const Contact<dim>& c : list.contacts) {
				CHECK(c.key.other == -1);
				CHECK(c.partners == mostPartners<dim>);
				double sum = 0;
				for (double w : c.weight) {
					CHECK(w >= (dim == 2 ? -2. / 27 - 1e-12 : 0));
					sum += w;
				}
				CHECK(std::abs(sum - 1) < 1e-12);
				CHECK(std::abs(c.normal.norm() - 1) < 1e-12);
				CHECK(c.impulse.norm() == 0);
				found[c.key] = c.gap;
				deepest = std::max(deepest, -c.gap / h);
			}
			CHECK(found.size() == list.contacts.size());
			CHECK(std::is_sorted(
				list.contacts.begin(), list.contacts.end(),
				[](const auto& a, const auto& b) { return a.key < b.key; }));
			CHECK(list.deepest == deepest);
			int sides[2] = { 0, 0 };
			for (int side : { 0, 1 })
				for (int s = 0; s < balls.body[side].nodes(); ++s) {
					const double exact = balls.gap(side, s, 1 - side);
					const bool present = found.count({ side, s, -1 });
					sides[side] += present;
					if (exact < reach - margin) CHECK(present);
					if (exact > reach + margin) CHECK(!present);
				}
			CHECK(sides[0] > 0);
			CHECK(sides[1] > 0);
		}
}

TEMPLATE_TEST_CASE_SIG("Search: nothing beyond reach", "[contact]", ((int dim), dim), 2, 3)
{
	const auto balls = twoBalls<dim>(0.06, 0.1, 3);
	auto list = pairList<dim>();
	findContacts(balls.body[0], balls.body[1], 0.05, list);
	CHECK(list.contacts.empty());
	CHECK(list.deepest == 0);
}

TEMPLATE_TEST_CASE_SIG("Search: exchanging the bodies exchanges the sides", "[contact]",
		       ((int dim), dim), 2, 3)
{
	const auto balls = twoBalls<dim>(-0.03, 0.15, 5);
	auto forth = pairList<dim>(), back = pairList<dim>();
	findContacts(balls.body[0], balls.body[1], 0.05, forth);
	findContacts(balls.body[1], balls.body[0], 0.05, back);
	REQUIRE(!forth.contacts.empty());
	REQUIRE(forth.contacts.size() == back.contacts.size());
	std::map<ContactKey, Contact<dim>> byKey;
	for (Contact<dim> c : back.contacts) {
		c.key.side = 1 - c.key.side;
		byKey[c.key] = c;
	}
	for (const Contact<dim>& c : forth.contacts) {
		REQUIRE(byKey.count(c.key) == 1);
		const Contact<dim>& other = byKey[c.key];
		CHECK(c.gap == other.gap);
		CHECK(c.normal == other.normal);
		CHECK(c.weight == other.weight);
	}
	CHECK(forth.deepest == back.deepest);
}

TEMPLATE_TEST_CASE_SIG("Search: impulses follow their contacts", "[contact]", ((int dim), dim), 2,
		       3)
{
	auto balls = twoBalls<dim>(-0.03, 0.1, 6);
	auto list = pairList<dim>();
	findContacts(balls.body[0], balls.body[1], 0.03, list);
	auto mark = [](const ContactKey& k) {
		Vec<dim> r = Vec<dim>::Constant(1 + k.side);
		r[0] = 10 + k.node;
		return r;
	};
	std::map<ContactKey, Vec<dim>> before; // normals
	for (Contact<dim>& c : list.contacts) {
		c.impulse = mark(c.key);
		before[c.key] = c.normal;
	}
	Random random(1); // rolls over to other nodes
	const Vec<dim> arm = balls.centre[1] - balls.centre[0];
	Vec<dim> sideways = random.vector<dim>();
	sideways = (sideways - sideways.dot(arm) / arm.squaredNorm() * arm).normalized();
	for (Vec<dim>& x : balls.body[1].position)
		x += 0.2 * sideways;
	balls.body[1].updateGeometry();
	balls.body[1].carried += 0.2 * sideways;
	findContacts(balls.body[0], balls.body[1], 0.03, list);
	int kept = 0, fresh = 0;
	for (const Contact<dim>& c : list.contacts)
		if (before.count(c.key)) {
			++kept;
			const Vec<dim> last = mark(c.key);
			CHECK(std::abs(c.impulse.norm() / last.norm() - 1) < 1e-12);
			CHECK(std::abs(c.impulse.dot(c.normal) - last.dot(before[c.key])) <
			      1e-12 * last.norm());
		} else {
			++fresh;
			CHECK(c.impulse.norm() == 0);
		}
	CHECK(kept > 0);
	CHECK(fresh > 0);
	CHECK(kept < static_cast<int>(before.size()));
}

TEST_CASE("Search: impulses and slips of bonds turn with the bodies in contact", "[contact]")
{
	auto balls = twoBalls<2>(-0.03, 0.1, 6);
	auto list = pairList<2>();
	list.interface.emplace();
	findContacts(balls.body[0], balls.body[1], 0.03, list);
	Random random(5);
	std::map<ContactKey, Vec<2>> last;
	for (std::size_t k = 0; k < list.contacts.size(); ++k) {
		Contact<2>& c = list.contacts[k];
		last[c.key] = c.impulse = random.vector<2>();
		list.interface->history[k].slip = c.impulse;
	}
	REQUIRE(last.size() > 3);
	const Mat<2> turn = Eigen::Rotation2Dd(0.3).toRotationMatrix();
	for (ContactBody<2>& body : balls.body) {
		const Vec<2> centre = body.box.centre();
		for (Vec<2>& x : body.position)
			x = turn * x;
		body.updateGeometry();
		body.carried += body.box.centre() - centre;
		body.travelled += 1;
	}
	findContacts(balls.body[0], balls.body[1], 0.03, list);
	REQUIRE(list.contacts.size() == last.size());
	for (std::size_t k = 0; k < list.contacts.size(); ++k) {
		const Vec<2> turned = turn * last[list.contacts[k].key];
		CHECK((list.contacts[k].impulse - turned).norm() < 1e-10);
		CHECK((list.interface->history[k].slip - turned).norm() < 1e-10);
	}
}

TEMPLATE_TEST_CASE_SIG("Search: candidates are kept while they hold, and miss nothing", "[contact]",
		       ((int dim), dim), 2, 3)
{
	auto balls = twoBalls<dim>(-0.03, dim == 2 ? 0.1 : 0.25, 6);
	ContactBody<dim>&first = balls.body[0], &second = balls.body[1];
	for (Vec<dim>& x : first.position) { // dented where the other rolls
		const Vec<dim> arm = x - balls.centre[0];
		x -= 0.1 * std::pow(std::sin(4 * arm[0]), 2) * arm;
	}
	first.updateGeometry();
	auto kept = pairList<dim>();
	Random random(2);
	int testedKept = 0, testedFresh = 0, most = 0;
	Vec<dim> flight = Vec<dim>::Constant(0.1);
	flight[0] = 0.2;
	Spin<dim> rate;
	rate.setConstant(0.004);
	for (int step = 0; step < 400; ++step) {
		// Both fly; one rolls round the other, shakes, and its nodes tremble.
		for (Vec<dim>& x : first.position)
			x += flight;
		first.updateGeometry();
		first.carried += flight;
		const Vec<dim> about = first.box.centre();
		const Vec<dim> shake = random.vector<dim>(0.002);
		const auto from = second.position;
		const Vec<dim> centre = second.box.centre();
		for (Vec<dim>& x : second.position) {
			const Vec<dim> arm = x + flight - about;
			const Vec<dim> turned = arm + spinMatrix<dim>(rate) * arm;
			x = about + arm.norm() * turned.normalized() + shake +
			    random.vector<dim>(2e-4);
		}
		second.updateGeometry();
		noteWays(second, from, centre);
		auto fresh = pairList<dim>();
		const double reach = step % 5 == 0 ? 0.03 : 0.01; // as speeds change
		findContacts(first, second, reach, kept);
		findContacts(first, second, reach, fresh);
		testedKept += kept.tested;
		testedFresh += fresh.tested;
		most = std::max(most, static_cast<int>(fresh.contacts.size()));
		REQUIRE(kept.contacts.size() == fresh.contacts.size());
		for (std::size_t k = 0; k < kept.contacts.size(); ++k) {
			CHECK(kept.contacts[k].key == fresh.contacts[k].key);
			CHECK(kept.contacts[k].facet == fresh.contacts[k].facet);
			CHECK(kept.contacts[k].gap == fresh.contacts[k].gap);
		}
	}
	CAPTURE(testedKept, testedFresh, most);
	CHECK(most >= 6);
	CHECK(testedKept < 0.8 * testedFresh);
}

TEMPLATE_TEST_CASE_SIG("Search: disks about points against each other", "[contact]",
		       ((int dim), dim), 2, 3)
{
	TemplateRecipe r = recipe(dim == 2 ? 0.11 : 0.25);
	r.contact = ContactGeometry::points;
	const auto reference = makeGrainTemplate<dim>(r);
	Random random(2);
	const Vec<dim> way = random.direction<dim>();
	const auto first =
		contactBody<dim>(*reference, 1, Vec<dim>::Zero(), random.rotation<dim>());
	const auto second = contactBody<dim>(*reference, 0.8, 1.75 * way, random.rotation<dim>());
	const double touch = 0.5 * r.zeta * 1.8, reach = 0.02;
	auto list = pairList<dim>();
	findContacts(first, second, reach, list);
	std::size_t expected = 0;
	double deepest = 0;
	for (const Vec<dim>& x : first.position)
		for (const Vec<dim>& y : second.position) {
			expected += (x - y).norm() - touch < reach;
			deepest = std::max(deepest, 1 - (x - y).norm() / touch);
		}
	CHECK(expected > 1);
	CHECK(list.contacts.size() == expected);
	CHECK(std::abs(list.deepest - deepest) < 1e-12);
	for (const Contact<dim>& c : list.contacts) {
		const Vec<dim> apart = first.position[c.key.node] - second.position[c.key.other];
		CHECK(c.key.side == 0);
		CHECK(c.partners == 1);
		CHECK(c.partner[0] == c.key.other);
		CHECK(c.weight[0] == 1);
		CHECK(std::abs(c.gap - (apart.norm() - touch)) < 1e-14);
		CHECK((c.normal - apart.normalized()).norm() < 1e-14);
	}
	for (Contact<dim>& c : list.contacts)
		c.impulse = Vec<dim>::Constant(c.key.node + 0.001 * c.key.other);
	findContacts(first, second, reach, list);
	for (const Contact<dim>& c : list.contacts)
		CHECK(c.impulse == Vec<dim>::Constant(c.key.node + 0.001 * c.key.other));
}

TEMPLATE_TEST_CASE_SIG("Search: against a plane", "[contact]", ((int dim), dim), 2, 3)
{
	for (ContactGeometry geometry : { ContactGeometry::surface, ContactGeometry::points }) {
		TemplateRecipe r = recipe(0.25);
		r.contact = geometry;
		const auto reference = makeGrainTemplate<dim>(r);
		Random random(3);
		const Vec<dim> normal = random.direction<dim>(), centre = random.vector<dim>();
		const auto body = contactBody<dim>(*reference, 2, centre, random.rotation<dim>());
		ContactList<dim> list;
		list.first = 0;
		Vec<dim> aside = random.vector<dim>();
		aside -= aside.dot(normal) * normal;
		list.plane = { centre - 1.8 * normal + aside, normal, Vec<dim>::Zero() };
		const double reach = 0.1, radius = geometry == ContactGeometry::points ? 0.25 : 0;
		findContacts(body, reach, list);
		std::map<int, const Contact<dim>*> found;
		for (const Contact<dim>& c : list.contacts)
			found[c.key.node] = &c;
		CHECK(!found.empty());
		double deepest = 0;
		for (int s = 0; s < body.nodes(); ++s) {
			const double gap = (body.position[s] - centre).dot(normal) + 1.8 - radius;
			deepest = std::max(deepest, -gap / 0.5);
			REQUIRE(bool(found.count(s)) == (gap < reach));
			if (gap >= reach) continue;
			CHECK(std::abs(found[s]->gap - gap) < 1e-13);
			CHECK(found[s]->normal == normal);
			CHECK(found[s]->partners == 0);
		}
		CHECK(std::abs(list.deepest - deepest) < 1e-12);
		for (Contact<dim>& c : list.contacts)
			c.impulse = Vec<dim>::Constant(c.key.node);
		list.plane.point += 0.05 * normal;
		findContacts(body, reach, list);
		for (const Contact<dim>& c : list.contacts)
			CHECK(c.impulse == Vec<dim>(Vec<dim>::Constant(
						   found.count(c.key.node) ? c.key.node : 0)));
	}
}

TEMPLATE_TEST_CASE_SIG("Search: too deep is reported and not pushed out", "[contact]",
		       ((int dim), dim), 2, 3)
{
	Random random(4);
	Balls<dim> balls;
	balls.add(1, Vec<dim>::Zero(), random.rotation<dim>(), 0.1);
	balls.add(1, 1.6 * Vec<dim>::Unit(0), random.rotation<dim>(), 0.1);    // overlap 4 dr
	balls.add(0.5, 0.01 * Vec<dim>::Unit(1), random.rotation<dim>(), 0.1); // inside the first
	auto list = pairList<dim>();
	findContacts(balls.body[0], balls.body[1], 0.02, list);
	CHECK(list.deepest > 3.5);
	CHECK(list.deepest < 4.1);
	CHECK(!list.contacts.empty());
	for (const Contact<dim>& c : list.contacts)
		CHECK(c.gap >= -0.15);
	auto inner = pairList<dim>();
	findContacts(balls.body[0], balls.body[2], 0.02, inner);
	CHECK(std::isinf(inner.deepest));
}
