// What a grain is to be made of, and the sets of the kernel made of such descriptions.
#pragma once

#include "assembly/SpaceVectors.hpp"
#include "grain/GrainSet.hpp"

#include <map>
#include <memory>
#include <vector>

namespace softgrain {

/// One grain to be assembled. Throughout, 2D grains lie in the xy-plane.
struct GrainDescription {
	int id = -1; ///< of the YADE body
	int dim = 2;
	TemplateRecipe recipe;
	Scheme scheme;
	Law law = Law::neoHookean;
	Condition condition = Condition::planeStrain;
	ElasticConstants constants;
	Damping damping;
	double radius = 0;                   ///< m
	Vec3 position = Vec3::Zero();        ///< of the centre, m
	Vec3 velocity = Vec3::Zero();        ///< m/s
	Vec3 angularVelocity = Vec3::Zero(); ///< 1/s
	Rotation orientation = Rotation::Identity();
	Vec3 origin = Vec3::Zero(); ///< of the positions in `state`, m
	GrainState state;           ///< to go on from; empty: undeformed
};

/// Throws std::invalid_argument for a grain so far from the origin that gaps lose their digits.
void requireDigits(int id, const Vec3& position, double radius);

/// Throws std::invalid_argument, naming the grain and what is admissible, unless there are grains
/// that can be in one system.
void requireOneSystem(const std::vector<GrainDescription>& grains);

template <int dim>
using Templates = std::map<TemplateRecipe, std::shared_ptr<const GrainTemplate<dim>>>;

template <int dim> struct DescribedSet {
	std::unique_ptr<GrainSet<dim>> set;
	std::vector<const GrainDescription*> members; ///< in the order of the set
};

/// Grains with equal recipe, scheme, law and condition form a set; sets keep the order of ids
/// within. `templates` gets those of the grains, taken over from `known` where they are there.
/// Throws std::invalid_argument for a state that does not fit its grain.
template <int dim>
std::vector<DescribedSet<dim>> makeSets(const std::vector<GrainDescription>& grains,
					const Templates<dim>& known, Templates<dim>& templates);

} // namespace softgrain
