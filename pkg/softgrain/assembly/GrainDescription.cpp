#include "assembly/GrainDescription.hpp"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <tuple>

namespace softgrain {

namespace {

/// Over the radius. Gaps are differences of positions in space: so far from the origin they are
/// good to 1e-7 dr.
constexpr double farthest = 1e8;

std::string nameOf(const GrainDescription& d) { return "grain #" + std::to_string(d.id); }

void requireAlike(const GrainDescription& d, const GrainDescription& first)
{
	const std::string both =
		"grains #" + std::to_string(first.id) + " and #" + std::to_string(d.id);
	if (d.dim != first.dim)
		throw std::invalid_argument(both +
					    " have different dim; a scene is either 2D or 3D");
	if (d.recipe.contact != first.recipe.contact)
		throw std::invalid_argument(both + " have different contact geometries; a scene "
						   "uses 'surface', 'points' or 'nodes' for all");
}

void requirePlane(const GrainDescription& d, const GrainDescription& first)
{
	if (d.dim == 2 && std::abs(d.position[2] - first.position[2]) > planeTolerance * d.radius)
		throw std::invalid_argument(nameOf(d) +
					    ": 2D soft grains must lie in one plane z = const");
}

/// Calls; what is wrong is said of the grain.
template <class Call> auto naming(const GrainDescription& d, Call&& call)
{
	try {
		return call();
	} catch (const std::invalid_argument& e) {
		throw std::invalid_argument(nameOf(d) + ": " + e.what());
	}
}

template <int dim> void setState(GrainSet<dim>& set, int k, const GrainDescription& d)
{
	if (d.state.x.empty()) {
		set.place(k, rotationToKernel<dim>(d.orientation), toKernel<dim>(d.velocity),
			  spinMatrix<dim>(angularToKernel<dim>(d.angularVelocity)));
		return;
	}
	naming(d, [&] { set.setState(k, d.state); });
}

template <int dim> GrainParameters<dim> parametersOf(const GrainDescription& d)
{
	const Vec3& origin = d.state.x.empty() ? d.position : d.origin;
	return { d.radius, d.constants, toKernel<dim>(origin), d.damping };
}

/// The template of `templates`, taken over from `known` or made if need be.
template <int dim>
std::shared_ptr<const GrainTemplate<dim>>
templateOf(const TemplateRecipe& recipe, const Templates<dim>& known, Templates<dim>& templates)
{
	auto& found = templates[recipe];
	if (found) return found;
	const auto old = known.find(recipe);
	found = old != known.end() ? old->second : makeGrainTemplate<dim>(recipe);
	return found;
}

/// Of grains that are alike but for radius, constants, place and damping.
template <int dim>
std::unique_ptr<GrainSet<dim>> makeSet(const std::vector<const GrainDescription*>& members,
				       const Templates<dim>& known, Templates<dim>& templates)
{
	std::vector<GrainParameters<dim>> parameters;
	for (const GrainDescription* d : members)
		parameters.push_back(parametersOf<dim>(*d));
	const GrainDescription& first = *members.front();
	return naming(first, [&] {
		return makeGrainSet<dim>(templateOf(first.recipe, known, templates), first.law,
					 first.condition, parameters, first.scheme);
	});
}

} // namespace

void requireDigits(int id, const Vec3& position, double radius)
{
	const double distance = position.stableNorm() / radius;
	if (distance <= farthest) return;
	std::ostringstream message;
	message << "grain #" << id << " lies " << distance
		<< " radii from the origin, more than the admissible 1e8, where gaps lose their "
		   "digits; move the scene nearer";
	throw std::invalid_argument(message.str());
}

void requireOneSystem(const std::vector<GrainDescription>& grains)
{
	if (grains.empty()) throw std::invalid_argument("there is no soft grain to assemble");
	for (const GrainDescription& d : grains)
		requireAlike(d, grains.front());
	for (const GrainDescription& d : grains) {
		requirePlane(d, grains.front());
		requireDigits(d.id, d.position, d.radius);
	}
}

template <int dim>
std::vector<DescribedSet<dim>> makeSets(const std::vector<GrainDescription>& grains,
					const Templates<dim>& known, Templates<dim>& templates)
{
	using Kind = std::tuple<TemplateRecipe, Scheme, Law, Condition>;
	std::map<Kind, std::vector<const GrainDescription*>> kinds;
	for (const GrainDescription& d : grains)
		kinds[{ d.recipe, d.scheme, d.law, d.condition }].push_back(&d);
	std::vector<DescribedSet<dim>> sets;
	for (const auto& [kind, members] : kinds) {
		auto set = makeSet<dim>(members, known, templates);
		for (int k = 0; k < set->grains(); ++k)
			setState(*set, k, *members[k]);
		sets.push_back({ std::move(set), members });
	}
	return sets;
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template std::vector<DescribedSet<dim>> makeSets<dim>(                                     \
		const std::vector<GrainDescription>&, const Templates<dim>&, Templates<dim>&);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain
