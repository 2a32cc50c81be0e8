#include "classes/SoftGrain.hpp"
#include "Require.hpp"
#include "checks/Engines.hpp"
#include "checks/HostChecks.hpp"
#include "classes/SoftMat.hpp"
#include "python/PythonArrays.hpp"
#include "scene/PeriodicCell.hpp"
#include "scene/SceneAssembly.hpp"
#include "scene/SoftBodies.hpp"

namespace yade {

using softgrain::Vec3;

YADE_PLUGIN((SoftGrain)(Bo1_SoftGrain_Aabb));

CREATE_LOGGER(Bo1_SoftGrain_Aabb);

namespace {

template <class Choice>
Choice choose(const char* parameter, const string& value,
	      const std::vector<std::pair<string, Choice>>& choices)
{
	string known;
	for (const auto& [name, choice] : choices) {
		if (value == name) return choice;
		known += (known.empty() ? "'" : ", '") + name + "'";
	}
	throw std::invalid_argument(string(parameter) + " = '" + value +
				    "' is unknown; known: " + known);
}

} // namespace

softgrain::TemplateRecipe SoftGrain::recipe() const
{
	using softgrain::ContactGeometry;
	using softgrain::QuadratureRule;
	softgrain::TemplateRecipe r;
	r.zeta = zeta;
	r.order = order;
	r.nodeSpacing = nodeSpacing;
	r.surfaceSpacing = surfaceSpacing;
	r.quadrature = choose<QuadratureRule>(
		"quadrature", quadrature,
		{ { "cutCell", QuadratureRule::cutCell }, { "lattice", QuadratureRule::lattice } });
	r.contact = choose<ContactGeometry>("contact", contact,
					    { { "surface", ContactGeometry::surface },
					      { "points", ContactGeometry::points },
					      { "nodes", ContactGeometry::nodes } });
	r.form.form = choose<softgrain::Form>("form", form,
					      { { "ball", softgrain::Form::ball },
						{ "block", softgrain::Form::block },
						{ "superdisk", softgrain::Form::superdisk },
						{ "polygon", softgrain::Form::polygon } });
	for (int a = 0; a < 3; ++a)
		r.form.aspect[a] = aspect[a];
	r.form.exponent = exponent;
	if (!vertices.empty()) {
		softgrain::Ring ring;
		for (const Vector2r& X : vertices)
			ring.vertex.emplace_back(X[0], X[1]);
		ring.corner.assign(corners.begin(), corners.end());
		r.form.ring = std::make_shared<const softgrain::Ring>(std::move(ring));
	}
	r.volumetric = choose<softgrain::VolumetricStrain>(
		"volumetric", volumetric,
		{ { "pointwise", softgrain::VolumetricStrain::pointwise },
		  { "projected", softgrain::VolumetricStrain::projected } });
	r.basis = choose<softgrain::Basis>("basis", basis,
					   { { "splines", softgrain::Basis::splines },
					     { "triangles", softgrain::Basis::triangles } });
	r.lumping = scheme().lumping();
	return r;
}

softgrain::Scheme SoftGrain::scheme() const
{
	using softgrain::Formulation;
	using softgrain::VelocityUpdate;
	softgrain::Scheme s;
	s.formulation = choose<Formulation>(
		"formulation", formulation,
		{ { "total", Formulation::total }, { "updated", Formulation::updated } });
	s.velocityUpdate = choose<VelocityUpdate>(
		"velocityUpdate", velocityUpdate,
		{ { "nodal", VelocityUpdate::nodal }, { "flip", VelocityUpdate::flip } });
	s.picShare = picShare;
	return s;
}

softgrain::GrainDescription SoftGrain::describe(const Body& body) const
{
	const SoftMat& material = static_cast<const SoftMat&>(*body.material);
	softgrain::GrainDescription d;
	d.id = body.getId();
	d.dim = dim;
	d.recipe = recipe();
	d.scheme = scheme();
	d.law = material.constitutiveLaw();
	d.condition = material.conditionIn(dim);
	d.constants = material.constants();
	d.damping = material.damping();
	d.radius = radius;
	d.position = body.state->pos;
	d.velocity = body.state->vel;
	d.angularVelocity = body.state->angVel;
	d.orientation = body.state->ori;
	d.origin = stateOrigin;
	d.state = { savedPositions, savedVelocities, savedGradients, savedRigidMotion,
		    savedForces,    savedStiffening, savedRest,      savedSleep };
	return d;
}

shared_ptr<SoftGrain> SoftGrain::undeformed() const
{
	const auto grain = shared_ptr<SoftGrain>(new SoftGrain(*this));
	grain->assembly.reset();
	grain->assembledMaterial.reset();
	grain->index = -1;
	grain->drawn.reset();
	for (auto* saved : { &grain->savedPositions, &grain->savedVelocities,
			     &grain->savedGradients, &grain->savedRigidMotion, &grain->savedForces,
			     &grain->savedStiffening, &grain->savedRest, &grain->savedSleep })
		saved->clear();
	return grain;
}

void SoftGrain::fetchState()
{
	if (!assembly) return;
	softgrain::GrainState state = assembly->state(index, stateOrigin);
	savedPositions = std::move(state.x);
	savedVelocities = std::move(state.v);
	savedGradients = std::move(state.F);
	savedRigidMotion = std::move(state.rigid);
	savedForces = std::move(state.held);
	savedStiffening = std::move(state.stiffening);
	savedRest = std::move(state.rest);
	savedSleep = std::move(state.sleep);
}

void SoftGrain::postLoad(SoftGrain&)
{
	recipe().validate();
	scheme().validate(recipe());
	softgrain::require(radius > 0 && math::isfinite(radius), "radius", radius, "(0, inf) m");
	softgrain::require(dim == 2 || dim == 3, "dim", dim, "2, 3");
	softgrain::require(dim == 2 || basis == "splines", "basis", basis, "'splines' for dim = 3");
	softgrain::require(dim == 3 || std::min(aspect[0], aspect[1]) == 1,
			   "aspect (smaller component)", std::min(aspect[0], aspect[1]),
			   "1: the radius is half the shortest side");
	const bool sides = form == "block" || form == "superdisk";
	softgrain::require((form == "block" && dim == 3) || aspect[2] == 1, "aspect[2]", aspect[2],
			   "1 for a ball, and in 2D");
	softgrain::require(sides || (aspect[0] == 1 && aspect[1] == 1), "aspect",
			   std::max(aspect[0], aspect[1]), "1 for a ball or polygon");
	softgrain::require(dim == 2 || form == "ball" || form == "block", "dim", dim,
			   "2 for superdisks and polygons");
	softgrain::require(form == "superdisk" || exponent == 2, "exponent", exponent,
			   "2 for other forms than 'superdisk'");
	softgrain::require(form == "polygon" || vertices.empty(), "vertices (number)",
			   vertices.size(), "0 for other forms than 'polygon'");
}

softgrain::GrainAssembly& SoftGrain::assembled()
{
	if (!assembly) assembleScene(*Omega::instance().getScene());
	if (!assembly)
		throw std::runtime_error("this SoftGrain belongs to no body of the scene; add it "
					 "with O.bodies.append first");
	return *assembly;
}

StateChange SoftGrain::shownChange()
{
	const softgrain::GrainAssembly& grains = assembled();
	const Scene& scene = *Omega::instance().getScene();
	const int id = grains.idOf(index);
	if (!scene.bodies->exists(id) || (*scene.bodies)[id]->shape.get() != this) return {};
	return shownChangeOf(*(*scene.bodies)[id], grains.continuation().lastStep);
}

py::object SoftGrain::outlineArray()
{
	return softgrain::numpyArray(shownChange().positionsOf(assembled().outline(index)));
}

py::object SoftGrain::facetsArray()
{
	return softgrain::numpyArray(assembled().facets(index), py::make_tuple(-1, dim));
}

Matrix3r SoftGrain::presentInertia() { return shownChange().tensorOf(assembled().inertia(index)); }

py::object SoftGrain::nodesArray()
{
	return softgrain::numpyArray(shownChange().positionsOf(assembled().nodePositions(index)),
				     dim);
}

py::object SoftGrain::nodalVelocitiesArray()
{
	std::vector<Vec3> velocities = assembled().nodeVelocities(index);
	const std::vector<Vec3> nodes = assembled().nodePositions(index);
	const StateChange change = shownChange();
	for (std::size_t I = 0; I < nodes.size(); ++I)
		velocities[I] = change.velocityOf(nodes[I], velocities[I]);
	return softgrain::numpyArray(velocities, dim);
}

py::dict SoftGrain::pointArrays()
{
	auto fields = assembled().points(index);
	const StateChange change = shownChange();
	const softgrain::Mat3 turn = change.turn.toRotationMatrix();
	for (softgrain::Mat3& F : fields.F)
		F = turn * F;
	for (softgrain::Mat3& stress : fields.cauchy)
		stress = change.tensorOf(stress);
	py::dict arrays;
	arrays["position"] = softgrain::numpyArray(change.positionsOf(fields.position));
	arrays["F"] = softgrain::numpyArray(fields.F);
	arrays["cauchy"] = softgrain::numpyArray(fields.cauchy);
	arrays["volume"] = softgrain::numpyArray(fields.volume, py::make_tuple(-1));
	return arrays;
}

bool SoftGrain::movesRigidly() { return assembled().isRigid(index); }

bool SoftGrain::sleeps() { return assembled().isAsleep(index); }

py::dict SoftGrain::energyDict()
{
	const auto energy = assembled().energy(index);
	py::dict d;
	d["kinetic"] = energy.kinetic + shownChange().energyOf(written, assembled().inertia(index));
	d["elastic"] = energy.elastic;
	return d;
}

Real SoftGrain::undeformedVolume() { return assembled().undeformedVolume(index); }

Real SoftGrain::presentVolume() { return assembled().presentVolume(index); }

void Bo1_SoftGrain_Aabb::postLoad(Bo1_SoftGrain_Aabb&)
{
	softgrain::require(hasMargin(), "margin", margin, "(0, inf)");
}

/// Once for each list of engines.
void Bo1_SoftGrain_Aabb::reportMissingIntegrator()
{
	if (reported_.load(std::memory_order_relaxed) || reported_.exchange(true)) return;
	if (!softGrainIntegratorOf(*scene))
		LOG_ERROR("there is no SoftGrainIntegrator in O.engines, which computes soft "
			  "grains: they neither deform nor touch anything. See sg.engines()");
}

void Bo1_SoftGrain_Aabb::go(const shared_ptr<Shape>& shape, shared_ptr<Bound>& bound,
			    const Se3r& se3, const Body*)
{
	SoftGrain& grain = static_cast<SoftGrain&>(*shape);
	reportMissingIntegrator();
	if (!bound) bound = shared_ptr<Bound>(new Aabb);
	Real extent = grain.aspect.norm();
	for (const Vector2r& X : grain.vertices)
		extent = std::max(extent, X.norm());
	Matrix3r map = Matrix3r::Identity();
	if (scene->isPeriodic) {
		grain.boundCell = scene->cell->getSize();
		map = toBoxes(*scene, grain.boundCell);
	}
	const Vector3r centre = map * se3.position;
	const auto [assembly, index] = assembledGrain(grain, *scene);
	// YADE keeps a value that was refused; the step refuses it, here it would end the process
	const Real beyond = hasMargin() ? margin * grain.radius : 0;
	const auto box =
		assembly ? assembly->box(index, map).grown(roomInBox(*assembly, index, beyond))
			 : softgrain::Box<3> { centre, centre }.grown(grain.radius * extent);
	bound->min = box.low;
	bound->max = box.high;
}

} // namespace yade
