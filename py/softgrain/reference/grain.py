"""State of one grain: total-Lagrangian MPM with nodal unknowns that persist."""

import numpy as np

from .template import DIM, template


class Grain:
    """A soft disk.

    Attributes:
        material (Material): its material.
        radius (float): of the undeformed disk [m].
        x (ndarray): nodal positions at t_n [m], shape (nodes, 2).
        v (ndarray): nodal velocities at t_n - dt/2 [m/s], shape (nodes, 2).
        mass (ndarray): lumped nodal masses [kg per metre of thickness], shape (nodes,).
        point_spacing (float): dr [m].
        contact_radius (float): radius of the disk about a contact node [m]; 0 on a surface.
    """

    def __init__(self, recipe, material, radius, centre, velocity=(0, 0), spin=0.0):
        """Place an undeformed disk that moves as a rigid body.

        Args:
            recipe (Recipe): how it is discretised.
            material (Material): its material.
            radius (float): [m].
            centre (Vector2): [m].
            velocity (Vector2): of the centre [m/s].
            spin (float): angular velocity, counter-clockwise [1/s].
        """
        self.template = template(recipe)
        self.material = material
        self.radius = radius
        arm = radius * self.template.node_position
        self.x = np.array(centre) + arm
        self.v = np.array(velocity) + spin * np.column_stack([-arm[:, 1], arm[:, 0]])
        self.mass = material.density * radius**DIM * self.template.node_mass
        self.point_spacing = radius * recipe.zeta
        self.contact_radius = radius * self.template.contact_radius

    @property
    def has_surface(self):
        """Whether its contact nodes lie on its outline; else they are disks of their own."""
        return self.template.recipe.contact == "surface"

    @property
    def centre(self):
        """Centre of mass [m]."""
        return self.mass @ self.x / self.mass.sum()

    def deformation_gradient(self):
        """F = sum_I x_I (x) G_I(Xp), shape (points, 2, 2)."""
        return np.einsum("Ia,pIb->pab", self.x, self.template.point_gradient) / self.radius

    def internal_force(self):
        """f_I = - sum_p Vp0 P_p G_I(Xp) [N per metre of thickness], shape (nodes, 2)."""
        P = self.material.first_piola(self.deformation_gradient())
        G = self.template.point_gradient / self.radius
        volume = self.template.point_volume * self.radius**DIM
        return -np.einsum("p,pab,pIb->Ia", volume, P, G)

    def contact_positions(self):
        """x_s = sum_I N_I(Xs) x_I [m], shape (contact nodes, 2)."""
        return self.template.contact_shape @ self.x

    def contact_velocities(self):
        """v_s = sum_I N_I(Xs) v_I [m/s], shape (contact nodes, 2)."""
        return self.template.contact_shape @ self.v

    def fastest(self):
        """Largest speed of a contact node [m/s]."""
        return np.linalg.norm(self.contact_velocities(), axis=1).max()
