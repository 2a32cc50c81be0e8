"""State of one grain, total-Lagrangian and updated-Lagrangian MPM.

Both show the step the same: nodal masses and velocities, internal force, contact nodes.
"""

import numpy as np

from .grid import DIM, Grid
from .template import template


class Grain:
    """A soft disk, total Lagrangian: shape functions and nodal masses never change.

    Attributes:
        material (Material): its material.
        radius (float): of the undeformed disk [m].
        x (ndarray): nodal positions at t_n [m], shape (nodes, 2).
        v (ndarray): nodal velocities at t_n - dt/2 [m/s], shape (nodes, 2).
        v_next (ndarray): the same at t_n + dt/2, while they are being found.
        mass (ndarray): lumped nodal masses [kg per metre of thickness], shape (nodes,).
        contact_shape (ndarray): N_I(Xs), shape (contact nodes, nodes).
        point_velocity (ndarray): v_p [m/s], shape (points, 2); None where velocities stay at nodes.
        rate (int): steps from one computation of the forces to the next.
        force, viscous_force (ndarray): those that act now [N per metre], shape (nodes, 2).
        point_spacing (float): dr [m].
        contact_radius (float): radius of the disk about a contact node [m]; 0 on a surface.
    """

    def __init__(
        self, recipe, material, radius, centre, velocity=(0, 0), spin=0.0, flip=False, pic_share=0.0
    ):
        """Place an undeformed disk that moves as a rigid body.

        Args:
            recipe (Recipe): how it is discretised.
            material (Material): its material.
            radius (float): [m].
            centre (Vector2): [m].
            velocity (Vector2): of the centre [m/s].
            spin (float): angular velocity, counter-clockwise [1/s].
            flip (bool): whether velocities live at the material points.
            pic_share (float): share of PIC in their update.
        """
        self.template = template(recipe)
        self.material = material
        self.radius = radius
        self.pic_share = pic_share
        self.rate = 1
        arm = radius * self.template.node_position
        self.x = np.array(centre) + arm
        self.v = _rigid_velocity(arm, velocity, spin)
        self.v_next = self.v
        self.mass = material.density * radius**DIM * self.template.node_mass
        self.contact_shape = self.template.contact_shape
        self.point_spacing = radius * recipe.zeta
        self.contact_radius = radius * self.template.contact_radius
        self.point_velocity = None
        if flip:
            self.point_velocity = self.template.point_shape @ self.v
            self._map_to_nodes()

    @property
    def has_surface(self):
        """Whether its contact nodes lie on its outline; else they are disks of their own."""
        return self.template.recipe.contact == "surface"

    @property
    def centre(self):
        """Centre of mass [m]."""
        return self.mass @ self.x / self.mass.sum()

    @property
    def state(self):
        """Positions and velocities as the plugin shows them: of the nodes."""
        return self.x, self.v

    def lay_grid(self):
        """Nothing: the grid stays in the reference configuration."""

    def find_forces(self, step, dt):
        """Forces that act in this step, at every `rate`-th step anew: of the positions expected in
        the middle of the kicks until then. In the first two steps anew as well, since the first
        cannot know dt."""
        if step > 1 and step % self.rate:
            return
        kicks = self.rate - step % self.rate
        present = self.x
        if step > 0:
            self.x = present + 0.5 * (kicks - 1) * dt * self.v
        self.force = self.internal_force()
        self.viscous_force = self._viscous_force()
        self.x = present

    def deformation_gradient(self):
        """F = sum_I x_I (x) G_I(Xp), shape (points, 2, 2)."""
        return np.einsum("Ia,pIb->pab", self.x, self.template.point_gradient) / self.radius

    def internal_force(self):
        """f_I = - sum_p Vp0 P_p G_I(Xp) [N per metre of thickness], shape (nodes, 2)."""
        P = self.material.first_piola(self.deformation_gradient(), self.template.volume_projection)
        return self._force_of(P) - self.material.mu * self.template.hourglass @ self.x

    def _force_of(self, P):
        G = self.template.point_gradient / self.radius
        volume = self.template.point_volume * self.radius**DIM
        return -np.einsum("p,pab,pIb->Ia", volume, P, G)

    def _viscous_force(self):
        """Of the damping that is proportional to stiffness."""
        F_rate = np.einsum("Ia,pIb->pab", self.v, self.template.point_gradient) / self.radius
        P = self.material.viscous_piola(
            self.deformation_gradient(), F_rate, self.template.volume_projection
        )
        return self._force_of(P)

    def damping_impulse(self, dt):
        """Of both terms of Rayleigh damping in a step dt [N s per metre], shape (nodes, 2)."""
        arm = self.x - self.centre
        mean = self.mass @ self.v / self.mass.sum()
        inertia = self.mass @ (arm**2).sum(axis=1)
        spin = self.mass @ (arm[:, 0] * self.v[:, 1] - arm[:, 1] * self.v[:, 0]) / inertia
        relative = self.v - _rigid_velocity(arm, mean, spin)
        share = 1 - np.exp(-self.material.mass_damping * dt)
        return dt * self.viscous_force - share * self.mass[:, None] * relative

    def move(self, dt):
        """x_I += dt v_I; the new velocities become the present ones, by way of the points if they
        live there."""
        self.x = self.x + dt * self.v_next
        if self.point_velocity is None:
            self.v = self.v_next
            return
        self.point_velocity = points_velocity(
            self.point_velocity, self.template.point_shape, self.v, self.v_next, self.pic_share
        )
        self._map_to_nodes()

    def _map_to_nodes(self):
        """v_I = sum_p m_p N_I(Xp) v_p / m_I."""
        momentum = (self.template.point_volume * self.template.point_shape.T) @ self.point_velocity
        self.v = momentum / self.template.node_mass[:, None]

    def contact_positions(self):
        """x_s = sum_I N_I(Xs) x_I [m], shape (contact nodes, 2)."""
        return self.contact_shape @ self.x

    def contact_velocities(self):
        """v_s = sum_I N_I(Xs) v_I [m/s], shape (contact nodes, 2)."""
        return self.contact_shape @ self.v

    def velocity_range(self):
        """Middle of the box of the velocities of contact nodes, and how far they differ from it at
        most [m/s]."""
        velocities = self.contact_velocities()
        middle = 0.5 * (velocities.min(axis=0) + velocities.max(axis=0))
        return middle, np.linalg.norm(velocities - middle, axis=1).max()


class UpdatedGrain:
    """A soft disk, updated Lagrangian: a grid fixed in space about the centre it was placed at, and
    shape functions of the present positions. The state is that of points and contact nodes.

    Attributes that :class:`Grain` has too mean the same; `v`, `v_next`, `mass` and `contact_shape`
    are those of the grid of this step. Arrays over points: `x_p`, `v_p`, `F`; over contact nodes:
    `x_s`, `v_s`.
    """

    def __init__(self, recipe, material, radius, centre, velocity=(0, 0), spin=0.0, pic_share=0.0):
        """Place an undeformed disk that moves as a rigid body; arguments as for :class:`Grain`."""
        self.template = template(recipe)
        self.material = material
        self.radius = radius
        self.pic_share = pic_share
        self.origin = np.array(centre)
        arm = radius * self.template.point_position
        self.x_p = self.origin + arm
        self.v_p = _rigid_velocity(arm, velocity, spin)
        self.F = np.broadcast_to(np.eye(DIM), (len(arm), DIM, DIM))
        arm = radius * self.template.contact_position
        self.x_s = self.origin + arm
        self.v_s = _rigid_velocity(arm, velocity, spin)
        self.volume = self.template.point_volume * radius**DIM
        self.point_spacing = radius * recipe.zeta
        self.contact_radius = radius * self.template.contact_radius
        self.lay_grid()

    has_surface = Grain.has_surface

    def find_forces(self, step, dt):
        """Forces that act in this step."""
        self.force = self.internal_force()

    def damping_impulse(self, dt):
        """None: this formulation has no damping of its own."""
        return np.zeros_like(self.v)

    velocity_range = Grain.velocity_range

    @property
    def centre(self):
        """Centre of mass [m]."""
        return self.volume @ self.x_p / self.volume.sum()

    @property
    def state(self):
        """Positions and velocities as the plugin shows them: of the material points."""
        return self.x_p, self.v_p

    def lay_grid(self):
        """Shape functions, nodal masses and velocities of the present positions."""
        points = (self.x_p - self.origin) / self.radius
        contacts = (self.x_s - self.origin) / self.radius
        grid = Grid(self.template.recipe, points, self.volume, also=contacts)
        self._shape, gradient = grid.shapes(points)
        self._gradient = gradient / self.radius
        self.contact_shape, _ = grid.shapes(contacts)
        point_mass = self.material.density * self.volume
        self.mass = point_mass @ self._shape
        self.v = (point_mass * self._shape.T) @ self.v_p / self.mass[:, None]
        self.v_next = self.v

    def internal_force(self):
        """f_I = - sum_p Vp0 tau_p grad N_I(x_p), tau = P F^T, shape (nodes, 2)."""
        tau = self.material.first_piola(self.F) @ self.F.transpose(0, 2, 1)
        return -np.einsum("p,pab,pIb->Ia", self.volume, tau, self._gradient)

    def move(self, dt):
        """Points and contact nodes go with the grid; F <- (1 + dt grad v) F."""
        velocity_gradient = np.einsum("Ia,pIb->pab", self.v_next, self._gradient)
        self.F = self.F + dt * velocity_gradient @ self.F
        self.x_p = self.x_p + dt * self._shape @ self.v_next
        self.v_p = points_velocity(self.v_p, self._shape, self.v, self.v_next, self.pic_share)
        self.v_s = self.contact_shape @ self.v_next
        self.x_s = self.x_s + dt * self.v_s

    def contact_positions(self):
        """x_s [m], shape (contact nodes, 2)."""
        return self.x_s

    def contact_velocities(self):
        """v_s in the last step [m/s], shape (contact nodes, 2)."""
        return self.v_s


def points_velocity(v_p, shape, v, v_next, pic_share):
    """Velocities of the points after a step: FLIP, v_p + N (v_next - v), blended with PIC.

    Args:
        v_p (ndarray): before [m/s], shape (points, 2).
        shape (ndarray): N_I at the points, shape (points, nodes).
        v, v_next (ndarray): nodal velocities before and after the step [m/s], shape (nodes, 2).
        pic_share (float): in [0, 1].

    Returns:
        ndarray: [m/s], shape (points, 2).
    """
    flip = v_p + shape @ (v_next - v)
    return (1 - pic_share) * flip + pic_share * shape @ v_next


def _rigid_velocity(arm, velocity, spin):
    return np.array(velocity) + spin * np.column_stack([-arm[:, 1], arm[:, 0]])
