#include "scene/Hardening.hpp"

#include <Eigen/Eigenvalues>

namespace yade {

void becomeClump(int id, const Vector3r& centre, Real mass, const Matrix3r& inertia,
		 const Vector3r& velocity, const Vector3r& angularMomentum)
{
	Scene& scene = *Omega::instance().getScene();
	if (!scene.bodies->exists(id) || !(*scene.bodies)[id]->isClump())
		throw std::invalid_argument("body #" + std::to_string(id) + " is no clump");
	const shared_ptr<Body>& body = (*scene.bodies)[id];
	State& state = *body->state;
	const Eigen::SelfAdjointEigenSolver<Matrix3r> principal(inertia);
	Matrix3r axes = principal.eigenvectors();
	if (axes.determinant() < 0) axes.col(2) *= -1;
	state.pos = state.refPos = centre;
	state.ori = state.refOri = Quaternionr(axes).normalized();
	state.mass = mass;
	state.inertia = principal.eigenvalues();
	state.vel = velocity;
	state.angMom = angularMomentum;
	state.angVel = inertia.ldlt().solve(angularMomentum);
	body->setAspherical(state.inertia[0] != state.inertia[2]);

	for (auto& [member, place] : static_cast<Clump&>(*body->shape).members) {
		const State& own = *(*scene.bodies)[member]->state;
		place.position = state.ori.conjugate() * (own.pos - centre);
		place.orientation = state.ori.conjugate() * own.ori;
	}
	Clump::moveMembers<NewtonIntegrator>(body, &scene);
}

} // namespace yade
