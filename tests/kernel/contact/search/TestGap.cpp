// How good gaps and normals between round bodies are.
#include "contact/Balls.hpp"
#include "contact/search/Search.hpp"

#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <map>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

struct Errors {
	double gap = 0, normal = 0;
	int contacts = 0;
};

/// Largest errors of gaps and normals over many placements, for gaps below `reach`.
template <int dim> Errors searchErrors(double gap, double reach, double spacing)
{
	Errors errors;
	for (unsigned seed = 1; seed <= 10; ++seed) {
		const auto balls = twoBalls<dim>(gap, spacing, seed);
		auto list = pairList<dim>();
		findContacts(balls.body[0], balls.body[1], reach, list);
		errors.contacts += static_cast<int>(list.contacts.size());
		for (const Contact<dim>& c : list.contacts) {
			const int from = c.key.side, to = 1 - c.key.side;
			const Vec<dim> exact =
				(balls.body[from].position[c.key.node] - balls.centre[to])
					.normalized();
			errors.gap = std::max(errors.gap,
					      std::abs(c.gap - balls.gap(from, c.key.node, to)));
			errors.normal = std::max(errors.normal, (c.normal - exact).norm());
		}
	}
	return errors;
}

} // namespace

TEST_CASE("Search: gap and normal of two disks", "[contact]")
{
	// On a circle the curve through the nodes leaves h^4; chords would leave h^2/8.
	double last = 0;
	for (double h : { 0.2, 0.1, 0.05 }) {
		const Errors e = searchErrors<2>(-0.003, 0.01, h);
		CAPTURE(h, e.gap, e.normal, e.contacts);
		CHECK(e.contacts >= 20);
		const double R = 0.7; // of the sharper disk
		CHECK(e.gap < std::pow(h, 4) / 30 / std::pow(R, 3));
		CHECK(e.normal < std::pow(h / R, 3) / 10);
		if (last > 0) CHECK(last / e.gap > 12);
		last = e.gap;
	}
	CHECK(last < 1e-5);
}

TEST_CASE("Search: a node between an outline and its facet is deep", "[contact]")
{
	const double depth = 0.022; // a facet of 0.44 bulges by 0.024
	TemplateRecipe coarse = recipe(0.11);
	coarse.surfaceSpacing = 4;
	const auto reference = makeGrainTemplate<2>(coarse),
		   other = makeGrainTemplate<2>(recipe(0.11));
	const ContactBody<2> first = contactBody<2>(*reference, 1, Vec<2>::Zero());
	const auto& facet = reference->contactMesh.facet[0];
	const Vec<2> way = (first.position[facet[0]] + first.position[facet[1]]).normalized();
	const ContactBody<2> second = contactBody<2>(*other, 1, (2 - depth) * way);
	ContactList<2> list;
	findContacts(first, second, 0.01, list);
	double deepest = 0;
	for (const Contact<2>& c : list.contacts)
		if (c.key.side == 1) deepest = std::max(deepest, -c.gap);
	CHECK(deepest > 0.8 * depth);
	CHECK(deepest < 1.01 * depth);
}

TEST_CASE("Search: the gap of two disks opens at the relative velocity of the contact", "[contact]")
{
	Random random(7);
	const double h = 0.1, dt = 1e-5;
	auto balls = twoBalls<2>(-0.01, h, 7);
	const Mat<2> F = random.deformation<2>(0.3);
	for (auto& body : balls.body)
		for (Vec<2>& x : body.position)
			x = balls.centre[0] + F * (x - balls.centre[0]) +
			    random.vector<2>(0.02 * h);
	std::vector<Vec<2>> velocity[2];
	for (int b : { 0, 1 })
		for (int s = 0; s < balls.body[b].nodes(); ++s)
			velocity[b].push_back(random.vector<2>());
	std::map<ContactKey, double> gap[2];
	auto list = pairList<2>();
	std::map<ContactKey, Contact<2>> middle;
	auto search = [&](double shift) {
		for (int b : { 0, 1 }) {
			auto& body = balls.body[b];
			for (int s = 0; s < body.nodes(); ++s)
				body.position[s] += shift * velocity[b][s];
			body.updateGeometry();
		}
		findContacts(balls.body[0], balls.body[1], 0.3 * h, list);
	};
	search(0);
	for (const Contact<2>& c : list.contacts)
		middle[c.key] = c;
	search(-dt);
	for (const Contact<2>& c : list.contacts)
		gap[0][c.key] = c.gap;
	search(2 * dt);
	for (const Contact<2>& c : list.contacts)
		gap[1][c.key] = c.gap;
	int compared = 0;
	for (const auto& [key, c] : middle) {
		if (gap[0].count(key) + gap[1].count(key) < 2) continue;
		Vec<2> u = velocity[key.side][key.node];
		for (int k = 0; k < c.partners; ++k)
			u -= c.weight[k] * velocity[1 - key.side][c.partner[k]];
		CAPTURE(key.side, key.node);
		CHECK(std::abs((gap[1][key] - gap[0][key]) / (2 * dt) - u.dot(c.normal)) < 1e-3);
		++compared;
	}
	CHECK(compared > 5);
}

TEST_CASE("Search: gap and normal of two balls", "[contact]")
{
	Errors last;
	for (double h : { 0.2, 0.1, 0.05 }) {
		const Errors e = searchErrors<3>(-0.003, 0.01, h);
		CAPTURE(h, e.gap, e.normal, e.contacts);
		CHECK(e.contacts > 5);
		CHECK(e.gap < 0.02 * h * h); // flat triangles: h^2/6
		CHECK(e.normal < 0.2 * h);
		last = e;
	}
	CHECK(last.gap < 5e-5);
}
