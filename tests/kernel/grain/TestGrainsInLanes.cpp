// Loops over grains side by side, for each kind of parts of lanes: a machine takes one of them
// only.
#include "Helpers.hpp"
#include "grain/BulkPass.hpp"

#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>

using namespace softgrain;
using namespace softgrain::testing;

namespace {

/// Numbers side by side, `laneWidth` for each of `count`.
struct Numbers {
	std::vector<LaneSlot> slot;

	explicit Numbers(int count)
		: slot(count)
	{
	}
	double* data() { return reinterpret_cast<double*>(slot.data()); }
	double get(int k, int lane) const { return slot[k].value[lane]; }
};

void fill(double* first, int count, Random& random)
{
	for (int k = 0; k < count; ++k)
		first[k] = random.uniform(-1, 1);
}

/// In every lane a nodal field, and tensors at the points in the order of the lines; and what these
/// give by the shape functions of each point.
template <int dim> struct NodesAndPoints {
	std::shared_ptr<const GrainTemplate<dim>> reference;
	const PointLines<dim>& lines;
	BlockField<dim> field; ///< zero at tied nodes
	Numbers tensor;

	explicit NodesAndPoints(const TemplateRecipe& r)
		: reference(makeGrainTemplate<dim>(r))
		, lines(reference->pointLines)
		, field(lines.places)
		, tensor(reference->points() * dim * dim)
	{
		Random random(1);
		for (int place : lines.nodePlace)
			fill(field.data() + place * dim * laneWidth, dim * laneWidth, random);
		fill(tensor.data(), static_cast<int>(tensor.slot.size()) * laneWidth, random);
	}
	LineRange allLines() const { return { 0, static_cast<int>(lines.line.size()) }; }
	static Vec<dim> nodeOf(const BlockField<dim>& of, int place, int lane)
	{
		Vec<dim> value;
		for (int a = 0; a < dim; ++a)
			value[a] = of.at(place, a)[lane];
		return value;
	}
	static Mat<dim> tensorOf(const Numbers& of, int point, int lane)
	{
		Mat<dim> value;
		for (int a = 0; a < dim; ++a)
			for (int b = 0; b < dim; ++b)
				value(a, b) = of.get((point * dim + a) * dim + b, lane);
		return value;
	}
	/// Calls `visit(place of the node, G)` for the i-th point of the lines.
	template <class Visit> void forShapes(int i, Visit&& visit) const
	{
		const auto& shapes = reference->pointShapes;
		const int p = lines.point[i].number;
		for (int k = shapes.begin(p); k < shapes.end(p); ++k)
			visit(lines.nodePlace[shapes.column[k]], shapes.value[k].G);
	}
	void checkGradients(const Numbers& found) const
	{
		double error = 0, size = 0;
		for (int l = 0; l < laneWidth; ++l)
			for (int i = 0; i < reference->points(); ++i) {
				Mat<dim> F = Mat<dim>::Zero();
				forShapes(i, [&](int place, const Vec<dim>& G) {
					F += nodeOf(field, place, l) * G.transpose();
				});
				error = std::max(error, (tensorOf(found, i, l) - F).norm());
				size = std::max(size, F.norm());
			}
		CHECK(size > 1);
		CHECK(error < 1e-13 * size);
	}
	void checkForces(const BlockField<dim>& found) const
	{
		double error = 0, size = 0;
		for (int l = 0; l < laneWidth; ++l) {
			std::vector<Vec<dim>> f(lines.places, Vec<dim>::Zero());
			for (int i = 0; i < reference->points(); ++i)
				forShapes(i, [&](int place, const Vec<dim>& G) {
					f[place] -= tensorOf(tensor, i, l) * G;
				});
			for (int place : lines.nodePlace) {
				error = std::max(error,
						 (nodeOf(found, place, l) - f[place]).norm());
				size = std::max(size, f[place].norm());
			}
		}
		CHECK(size > 1);
		CHECK(error < 1e-13 * size);
	}
	/// Against what was found of it: sum_p P_p : F_p = - sum_I f_I . x_I.
	void checkAdjoint(const Numbers& F, const BlockField<dim>& f) const
	{
		for (int l = 0; l < laneWidth; ++l) {
			double atPoints = 0, atNodes = 0, size = 0;
			for (int i = 0; i < reference->points(); ++i) {
				const double part = tensorOf(tensor, i, l)
							    .cwiseProduct(tensorOf(F, i, l))
							    .sum();
				atPoints += part;
				size += std::abs(part);
			}
			for (int place : lines.nodePlace)
				atNodes += nodeOf(f, place, l).dot(nodeOf(field, place, l));
			CHECK(std::abs(atPoints + atNodes) < 1e-13 * size);
		}
	}
};

/// Calls `use(first lane)` for all parts, `atOnce` of them at a time.
template <class Part, class Use> void forParts(int atOnce, Use&& use)
{
	for (int begin = 0; begin < laneWidth; begin += atOnce * Part::width)
		use(begin);
}

template <int dim, int order, class Part> void checkLines(NodesAndPoints<dim>& given)
{
	constexpr int atOnce = detail::partsAtOnce<Part, dim>;
	BlockField<dim> x = given.field, forces(given.lines.places);
	Numbers F(given.reference->points() * dim * dim);
	forParts<Part>(1, [&](int begin) {
		detail::followTies<dim, Part>(given.lines, x.data() + begin);
	});
	forParts<Part>(atOnce, [&](int begin) {
		detail::gatherGrains<dim, order, Part>(given.lines, given.allLines(),
						       x.data() + begin, F.data() + begin);
		detail::scatterGrains<dim, order, Part>(given.lines, given.allLines(),
							given.tensor.data() + begin,
							forces.data() + begin);
	});
	forParts<Part>(1, [&](int begin) {
		detail::handToFollowed<dim, Part>(given.lines, forces.data() + begin);
	});
	given.checkGradients(F);
	given.checkForces(forces);
	given.checkAdjoint(F, forces);
}

template <class Part> void checkTable(NodesAndPoints<2>& given)
{
	const auto& shapes = given.reference->pointShapes;
	const int points = given.reference->points();
	BlockField<2> forces(given.lines.places);
	Numbers F(points * 4);
	forParts<Part>(1, [&](int begin) {
		detail::gatherTable<2, Part>(shapes, given.field.data() + begin, 0, points,
					     F.data() + begin);
		detail::scatterTable<2, Part>(shapes, given.tensor.data() + begin, 0, points,
					      forces.data() + begin);
	});
	given.checkGradients(F);
	given.checkForces(forces);
	given.checkAdjoint(F, forces);
}

} // namespace

TEMPLATE_TEST_CASE_SIG("Grains side by side: sums along lines are those of the shape functions",
		       "[grain]", ((int dim, int order), dim, order), (2, 1), (2, 2), (2, 3),
		       (3, 1), (3, 2), (3, 3))
{
	for (double spacing : { 1.25, 2. }) {
		CAPTURE(spacing);
		NodesAndPoints<dim> given(recipe(dim == 2 ? 0.11 : 0.3, order, spacing));
		REQUIRE(!given.lines.isTable());
		if (order > 1) CHECK(given.lines.ties.rows() > 0);
		checkLines<dim, order, WholeLanes>(given);
		checkLines<dim, order, HalfLanes>(given);
	}
}

TEST_CASE("Grains side by side: sums over a table are those of the shape functions", "[grain]")
{
	TemplateRecipe triangles = recipe(0.2);
	triangles.basis = Basis::triangles;
	NodesAndPoints<2> given(triangles);
	REQUIRE(given.lines.isTable());
	checkTable<WholeLanes>(given);
	checkTable<HalfLanes>(given);
}

TEMPLATE_TEST_CASE("Grains side by side: a field to its lanes and back", "[grain]", WholeLanes,
		   HalfLanes)
{
	constexpr int dim = 3, width = TestType::width, nodes = 7; // vectors end within a part
	const std::vector<int> place { 4, 0, 6, 1, 5, 3, 8 };
	Random random(2);
	std::vector<double> from[width], to[width];
	const double* source[width];
	double* target[width];
	typename TestType::Numbers scale;
	for (int l = 0; l < width; ++l) {
		from[l].resize(dim * nodes);
		to[l].assign(dim * nodes + 1, 0);
		fill(from[l].data(), dim * nodes, random);
		source[l] = from[l].data();
		target[l] = to[l].data();
		scale[l] = 1 << l; // exact, and its inverse
	}
	BlockField<dim> block(9);
	double* first = block.data() + laneWidth - width;
	detail::takeSideBySide<dim, TestType>(source, place.data(), nodes, scale, first);
	for (int l = 0; l < width; ++l)
		for (int I = 0; I < nodes; ++I)
			for (int a = 0; a < dim; ++a)
				CHECK(block.at(place[I], a)[laneWidth - width + l] ==
				      scale[l] * from[l][I * dim + a]);
	CHECK(block.at(2, 0)[laneWidth - 1] == 0);
	const int grains = width - 1;
	detail::putAsunder<dim, TestType>(first, place.data(), nodes, 1 / scale, grains, target);
	for (int l = 0; l < grains; ++l) {
		CHECK(to[l].back() == 0);
		to[l].pop_back();
		CHECK(to[l] == from[l]);
	}
	CHECK(to[grains] == std::vector<double>(dim * nodes + 1, 0));
}

TEST_CASE("Grains side by side: parts of a number at every point", "[grain]")
{
	const int count = laneWidth;
	Batch<2> batch(makeGrainTemplate<2>(recipe(0.3)), Law::neoHookean, Condition::planeStrain,
		       std::vector(count, paperGrain<2>()));
	const GrainsInLanes<2> side(batch, 0, batch.x);
	ProjectedField field;
	field.resize<GrainsInLanes<2>>(*batch.reference);
	Strip<2> strip;
	auto value = [&](int group, int lane) { return 100. * side.place(strip, group, 0) + lane; };
	auto check = [&]<class Part>(Part) {
		for (int group = 0; group < strip.groups; ++group)
			for (int begin = 0; begin < laneWidth; begin += Part::width) {
				const auto part = field.part<Part>(side, strip, group, begin);
				for (int l = 0; l < Part::width; ++l)
					CHECK(part[l] == value(group, begin + l));
			}
	};
	forEachStrip(side, batch.reference->pointLines, strip, [&] {
		for (int group = 0; group < strip.groups; ++group) {
			Lanes values;
			for (int l = 0; l < laneWidth; ++l)
				values[l] = value(group, l);
			field.set(side, strip, group, values);
		}
		check(WholeLanes {});
		check(HalfLanes {});
	});
}
