#include "Helpers.hpp"
#include "contact/search/Search.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <numbers>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// Spikes of two lengths, their tips sharp and the notches between them smooth, or all sharp.
TemplateRecipe star(bool allSharp)
{
	Ring ring;
	for (int k = 0; k < 10; ++k) {
		const double r = k % 2 ? 1 : k % 4 ? 1.5 : 2, t = std::numbers::pi * k / 5;
		ring.vertex.emplace_back(r * std::cos(t), r * std::sin(t));
		if (allSharp || k % 2 == 0) ring.corner.push_back(k);
	}
	return polygonRecipe(0.25, ring);
}

TemplateRecipe block(double zeta)
{
	TemplateRecipe r = recipe(zeta);
	r.form.form = Form::block;
	r.form.aspect = { 1.5, 1, 1 };
	return r;
}

template <int dim> bool isIn(const ContactBody<dim>& body, const ContactBody<dim>& other)
{
	return std::any_of(body.position.begin(), body.position.end(),
			   [&](const Vec<dim>& x) { return other.encloses(x); });
}

/// Two grains of a form; one goes round the other, turns and trembles, and is pressed on it and let
/// off again and again.
template <int dim> class Wanderers {
public:
	explicit Wanderers(const TemplateRecipe& form)
		: Wanderers(form, form, 1, Mat<dim>::Identity())
	{
	}
	/// `size`: of the second one, whose form is another, and which leans.
	Wanderers(const TemplateRecipe& form, const TemplateRecipe& other, double size,
		  const Mat<dim>& lean)
		: reference_(makeGrainTemplate<dim>(form))
		, other_(makeGrainTemplate<dim>(other))
		, first(contactBody<dim>(*reference_, 1, Vec<dim>::Zero()))
		, second(contactBody<dim>(*other_, size, 4 * Vec<dim>::Unit(0)))
	{
		for (Vec<dim>& x : second.position)
			x = 4 * Vec<dim>::Unit(0) + lean * (x - 4 * Vec<dim>::Unit(0));
		second.updateGeometry();
		while (!isIn(second, first))
			move(-0.05, Mat<dim>::Identity(), 0);
	}
	void step()
	{
		Mat<dim> turn = Mat<dim>::Identity();
		turn.template topLeftCorner<2, 2>() = Eigen::Rotation2Dd(0.01).toRotationMatrix();
		move(isIn(second, first) || isIn(first, second) ? 0.03 : -0.01, turn, 1e-4);
	}

private:
	/// Turns the second one and its way about the first, moves it off by `away`.
	void move(double away, const Mat<dim>& turn, double tremor)
	{
		const auto from = second.position;
		const Vec<dim> centre = second.box.centre();
		for (Vec<dim>& x : second.position)
			x = turn * x + away * (turn * centre).normalized() +
			    random_.vector<dim>(tremor);
		second.updateGeometry();
		noteWays(second, from, centre);
	}

	std::shared_ptr<const GrainTemplate<dim>> reference_, other_;
	Random random_ { 3 };

public:
	ContactBody<dim> first, second;
};

/// Of some hundred steps; returns nodes that were measured, over those of a search from anew.
template <int dim>
double requireSameAsFresh(Wanderers<dim> grains, int steps, int leastContactsOfEdges = 0,
			  double farReach = 0.06)
{
	ContactList<dim> kept;
	double testedKept = 0, testedFresh = 0;
	int contacts = 0, deep = 0, edges = 0;
	for (int step = 0; step < steps; ++step) {
		grains.step();
		ContactList<dim> fresh;
		const double reach = step % 5 == 0 ? farReach : 0.02; // as speeds change
		findContacts(grains.first, grains.second, reach, kept);
		findContacts(grains.first, grains.second, reach, fresh);
		testedKept += kept.tested;
		testedFresh += fresh.tested;
		REQUIRE(kept.contacts.size() == fresh.contacts.size());
		CHECK(kept.deepest == fresh.deepest);
		for (std::size_t k = 0; k < kept.contacts.size(); ++k) {
			CHECK(kept.contacts[k].key == fresh.contacts[k].key);
			CHECK(kept.contacts[k].facet == fresh.contacts[k].facet);
			CHECK(kept.contacts[k].gap == fresh.contacts[k].gap);
			++contacts;
			deep += fresh.contacts[k].gap < 0;
			edges += fresh.contacts[k].key.isOfEdges();
		}
	}
	CAPTURE(contacts, deep);
	CHECK(contacts > steps / 2);
	CHECK(deep > steps / 8);
	CHECK(edges >= leastContactsOfEdges);
	return testedKept / testedFresh;
}

} // namespace

TEST_CASE("Corner search: a grain that goes on inside of another", "[contact]")
{
	const auto inner = makeGrainTemplate<2>(block(0.25)), outer = inner;
	const ContactBody<2> around = contactBody<2>(*outer, 4, Vec<2>::Zero());
	ContactBody<2> within = contactBody<2>(*inner, 1, Vec<2>::Zero());
	const double side = around.box.high[0] - within.box.high[0];
	for (Vec<2>& x : within.position)
		x[0] += side;
	within.updateGeometry();
	ContactList<2> kept;
	for (double depth = 0; depth < 4; depth += 0.01) {
		const auto from = within.position;
		const Vec<2> centre = within.box.centre();
		for (Vec<2>& x : within.position)
			x[0] -= 0.01;
		within.updateGeometry();
		noteWays(within, from, centre);
		ContactList<2> fresh;
		findContacts(around, within, 0.02, kept);
		findContacts(around, within, 0.02, fresh);
		CAPTURE(depth);
		CHECK(kept.contacts.size() == fresh.contacts.size());
		CHECK(kept.deepest == fresh.deepest);
		for (const auto& node : kept.candidates.nodes)
			CHECK(!std::isnan(node.clearance));
	}
}

TEST_CASE("Corner search: what is found does not depend on when nodes were looked for", "[contact]")
{
	CHECK(requireSameAsFresh(Wanderers<2>(block(0.25)), 700) < 0.6);
	CHECK(requireSameAsFresh(Wanderers<2>(star(true)), 700) < 0.6);
	CHECK(requireSameAsFresh(Wanderers<2>(star(false)), 700) < 0.6);
	CHECK(requireSameAsFresh(Wanderers<3>(block(0.4)), 300) < 0.8);
}

namespace {

template <int dim> Mat<dim> leaning(int k);
template <> Mat<2> leaning<2>(int k) { return Eigen::Rotation2Dd(0.37 * k).toRotationMatrix(); }
template <> Mat<3> leaning<3>(int k)
{
	const Vec<3> axis = Vec<3>(1, 0.3 * k, 0.7 - 0.2 * k).normalized();
	return Eigen::AngleAxisd(0.37 * k, axis).toRotationMatrix();
}

/// A fine block goes round a coarse ball.
template <int dim> Wanderers<dim> blockAboutBall(int k)
{
	return { recipe(0.34), block(0.34), 0.24, leaning<dim>(k) };
}

} // namespace

TEST_CASE("Corner search: edges that cross do not depend on when they were looked for", "[contact]")
{
	for (int k = 1; k < 5; ++k) {
		const Wanderers<3> grains(block(0.5), block(0.4), 0.8, leaning<3>(k));
		requireSameAsFresh(grains, 200, 5);
	}
}

TEST_CASE("Corner search: nodes above facets that bulge are not lost where the reach falls",
	  "[contact]")
{
	TemplateRecipe ball = recipe(0.34);
	ball.surfaceSpacing = 2;
	for (int k = 0; k < 6; ++k)
		requireSameAsFresh(Wanderers<2>(ball, block(0.34), 0.24, leaning<2>(k)), 300, 0,
				   0.12);
}

TEMPLATE_TEST_CASE_SIG("Corner search: a fine block beside a coarse ball", "[contact]",
		       ((int dim), dim), 2, 3)
{
	for (int k = 0; k < 6; ++k) {
		Wanderers<dim> grains = blockAboutBall<dim>(k);
		for (int step = 0; step < 100; ++step) {
			grains.step();
			ContactList<dim> list;
			findContacts(grains.first, grains.second, 0.005, list);
			for (const Contact<dim>& c : list.contacts) {
				const bool ofFirst = c.key.side == 0;
				const auto& body = ofFirst ? grains.first : grains.second;
				const auto& other = ofFirst ? grains.second : grains.first;
				CAPTURE(k, step, c.key.side, c.key.node, c.gap);
				const bool isInside = other.encloses(body.position[c.key.node]);
				CHECK((isInside || c.gap > -0.1 * other.pointSpacing));
			}
		}
		CHECK(requireSameAsFresh(blockAboutBall<dim>(k), 100) < 1);
	}
}
