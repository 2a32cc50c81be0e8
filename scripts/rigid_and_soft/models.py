"""Models of a grain that ``compare_rigid.py`` compares. All are told the same: disks of Young's
modulus YOUNG and a Poisson's ratio in plane strain, in a box of frictionless walls.

Models made of spheres stand for a layer as thick as a grain's diameter: their grains weigh what
disks of that thickness do, and their forces are divided by it.
"""

import math

import numpy as np
from yade import (
    Bo1_Sphere_Aabb,
    Bo1_Wall_Aabb,
    CohFrictMat,
    ForceResetter,
    FrictMat,
    Ig2_Sphere_Sphere_ScGeom,
    Ig2_Sphere_Sphere_ScGeom6D,
    Ig2_Wall_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_CohFrictMat_CohFrictMat_CohFrictPhys,
    Ip2_FrictMat_FrictMat_FrictPhys,
    Ip2_FrictMat_FrictMat_MindlinPhys,
    Law2_ScGeom6D_CohFrictPhys_CohesionMoment,
    Law2_ScGeom_FrictPhys_CundallStrack,
    Law2_ScGeom_MindlinPhys_Mindlin,
    NewtonIntegrator,
    O,
    utils,
)

import softgrain as sg

YOUNG, DENSITY = 1e6, 1000.0  # Pa, kg/m3
WALL_YOUNG = 1e15  # Pa: of walls of rigid models, hard next to the grains
ZETA = 0.1  # of soft grains and triangles
DAMPING = 0.2  # NewtonIntegrator.damping of the models of YADE: local, takes their vibrations out


class Model:
    """Grains of one kind.

    ``thickness``: of the layer that the forces of a scene are of [m]; ``poisson``: Poisson's ratio;
    ``mu``: friction between grains [-].
    """

    label = ""
    deforms = True
    thickness = 1.0
    parts = 1  # particles or material points a grain

    def __init__(self, mu, poisson):
        self.mu, self.poisson = mu, poisson
        self.grain_of = {}  # grain that a body is, or is a part of

    def wall_material(self):
        return FrictMat(young=WALL_YOUNG, poisson=0.3, frictionAngle=0, density=DENSITY)

    def add(self, centres, radii):
        """Add grains, disks with these centres (n, 2) and radii [m]."""
        raise NotImplementedError

    def start(self):
        """Set engines and time step; walls are there."""
        raise NotImplementedError

    def has_force(self, interaction):
        return interaction.isReal and interaction.phys.normalForce.norm() > 0

    def coordination(self):
        """Mean number of grains and walls that a grain exchanges force with."""
        touching = set()
        for i in O.interactions:
            ends = [self.grain_of.get(k, -1 - k) for k in (i.id1, i.id2)]
            if ends[0] != ends[1] and self.has_force(i):
                touching.add(tuple(sorted(ends)))
        grains = len(set(self.grain_of.values()))
        return sum((a >= 0) + (b >= 0) for a, b in touching) / grains


class Spheres(Model):
    """One rigid sphere a grain."""

    def _material(self):
        return FrictMat(
            young=YOUNG, poisson=self.poisson, density=DENSITY, frictionAngle=math.atan(self.mu)
        )

    def add(self, centres, radii):
        self.thickness = 2 * float(np.mean(radii))
        material = self._material()
        O.materials.append(material)
        for g, ((x, y), radius) in enumerate(zip(centres, radii)):
            body = utils.sphere((x, y, 0), radius, material=material)
            body.state.blockedDOFs = "zXY"
            self.grain_of[O.bodies.append(body)] = g

    def start(self):
        for k in sg.as_disks():  # per metre
            state = O.bodies[k].state
            state.mass *= self.thickness
            state.inertia *= self.thickness

    def _engines(self, geometry, physics, laws):
        radius = min(b.shape.radius for b in O.bodies if hasattr(b.shape, "radius"))
        return [
            ForceResetter(),
            InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * radius),
            InteractionLoop([geometry, Ig2_Wall_Sphere_ScGeom()], physics, laws),
            NewtonIntegrator(damping=DAMPING),
        ]


class Linear(Spheres):
    """YADE's linear law of Cundall and Strack, kn = E D/2 between equal spheres."""

    label = "rigid DEM, linear"
    physics, law = Ip2_FrictMat_FrictMat_FrictPhys, Law2_ScGeom_FrictPhys_CundallStrack

    def start(self):
        super().start()
        O.engines = self._engines(Ig2_Sphere_Sphere_ScGeom(), [self.physics()], [self.law()])
        O.dt = 0.3 * utils.PWaveTimeStep()


class Hertz(Linear):
    """Hertz and Mindlin with the material's constants."""

    label = "rigid DEM, Hertz"
    physics, law = Ip2_FrictMat_FrictMat_MindlinPhys, Law2_ScGeom_MindlinPhys_Mindlin


class Nonsmooth(Spheres):
    """Rigid disks in contact dynamics: they have no stiffness, and a jammed packing no answer."""

    label = "rigid contact dynamics"
    deforms = False
    step = 1e-4  # s: the walls move by a fraction of a percent of a radius in it

    def start(self):
        super().start()
        O.engines = sg.engines(rigid="nonsmooth")
        O.dt = self.step


class Bonded(Spheres):
    """Grains of small spheres on a triangular lattice, bonded for ever by YADE's cohesive law.

    With kn and ks of a bond the lattice has, in its plane and by unit of thickness t,
    C11 = sqrt(3)/4 (3 kn + ks)/t and C12 = sqrt(3)/4 (kn - ks)/t, so a Poisson's ratio of
    (kn - ks)/(3 kn + ks), at most 1/3. Plane strain asks for nu/(1 - nu), which is in reach up to
    nu = 0.237 with ``least_shear``; beyond that the ratio falls short. kn is that of the right
    Young's modulus in the plane, E/(1 - nu^2).
    """

    label = "bonded particles"
    across = 15  # particles on a diameter
    least_shear = 0.05  # ks/kn of a bond: a little, for friction between grains

    def _shear(self):
        """ks/kn of a bond."""
        ratio = self.poisson / (1 - self.poisson)
        return max(self.least_shear, (1 - 3 * ratio) / (1 + ratio))

    def _bond_stiffness(self):
        shear = self._shear()
        ratio = (1 - shear) / (3 + shear)
        young = YOUNG / (1 - self.poisson**2)
        return young * self.thickness / ((1 - ratio**2) * math.sqrt(3) / 4 * (3 + shear))

    def add(self, centres, radii):
        self.thickness = 2 * float(np.mean(radii))
        kn = self._bond_stiffness()
        for g, (centre, radius) in enumerate(zip(centres, radii)):
            small = radius / self.across
            places = self._lattice(radius, small)
            mass = DENSITY * math.pi * radius**2 * self.thickness / len(places)
            material = CohFrictMat(
                young=kn / small,  # two equal spheres: kn = young radius
                poisson=self._shear(),  # YADE's name for ks/kn
                density=mass / (4 / 3 * math.pi * small**3),
                frictionAngle=math.atan(self.mu),
                isCohesive=True,
                normalCohesion=1e30,
                shearCohesion=1e30,
                momentRotationLaw=False,
                label=f"grain{g}",
            )
            O.materials.append(material)
            for place in places:
                body = utils.sphere(
                    (centre[0] + place[0], centre[1] + place[1], 0), small, material=material
                )
                body.state.blockedDOFs = "zXY"
                self.grain_of[O.bodies.append(body)] = g
        self.parts = len(self.grain_of) / len(radii)

    def _lattice(self, radius, small):
        """Places of the spheres of radius ``small`` in a grain about the origin."""
        step = 2 * small * (1 - 1e-6)  # they touch
        n = self.across
        cells = np.array([(i, j) for i in range(-n, n + 1) for j in range(-n, n + 1)])
        places = step * (cells @ np.array([[1, 0], [0.5, math.sqrt(3) / 2]]))
        return places[np.linalg.norm(places, axis=1) <= (radius - small) * (1 + 1e-9)]

    def start(self):
        bonds = Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(
            setCohesionNow=True, setCohesionOnNewContacts=False
        )
        O.engines = self._engines(
            Ig2_Sphere_Sphere_ScGeom6D(),
            [bonds, Ip2_FrictMat_FrictMat_FrictPhys()],
            [Law2_ScGeom6D_CohFrictPhys_CohesionMoment(), Law2_ScGeom_FrictPhys_CundallStrack()],
        )
        mass = min(b.state.mass for b in O.bodies if hasattr(b.shape, "radius"))
        O.dt = 0.3 * math.sqrt(mass / self._bond_stiffness())


class Soft(Model):
    """Soft grains: TLMPM, contact dynamics."""

    label = "soft grains"
    basis = "splines"

    def wall_material(self):
        return FrictMat(frictionAngle=0)

    def add(self, centres, radii):
        material = sg.SoftMat(
            young=YOUNG, poisson=self.poisson, density=DENSITY, frictionAngle=math.atan(self.mu)
        )
        O.materials.append(material)
        for g, ((x, y), radius) in enumerate(zip(centres, radii)):
            body = sg.soft_disk((x, y, 0), radius, material, zeta=ZETA, basis=self.basis)
            self.grain_of[O.bodies.append(body)] = g
        self.parts = len(body.shape.points()["volume"])

    def start(self):
        O.engines = sg.engines()
        sg.set_time_step()


class Triangles(Soft):
    """The same with linear triangles in place of splines."""

    label = "finite elements (linear triangles)"
    basis = "triangles"


MODELS = {
    "linear": Linear,
    "hertz": Hertz,
    "nonsmooth": Nonsmooth,
    "bonded": Bonded,
    "triangles": Triangles,
    "soft": Soft,
}
