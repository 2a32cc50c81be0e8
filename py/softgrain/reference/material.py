"""The compressible neo-Hookean law in plane strain and plane stress."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Material:
    """Constants of a grain's material."""

    young: float = 1e6  #: Pa
    poisson: float = 0.45
    density: float = 1000.0  #: kg/m^3
    friction_angle: float = 0.0  #: rad; the smaller one of two bodies counts
    condition: str = "planeStrain"  #: or 'planeStress'
    mass_damping: float = 0.0  #: alpha, 1/s
    stiffness_damping: float = 0.0  #: beta, s

    @property
    def lam(self):
        """First Lame constant lambda [Pa]."""
        return self.young * self.poisson / ((1 + self.poisson) * (1 - 2 * self.poisson))

    @property
    def mu(self):
        """Shear modulus [Pa]."""
        return 0.5 * self.young / (1 + self.poisson)

    @property
    def plane_lam(self):
        """First Lame constant lambda' that acts in the plane at small strain [Pa]."""
        lam, mu = self.lam, self.mu
        return 2 * lam * mu / (lam + 2 * mu) if self.condition == "planeStress" else lam

    @property
    def wave_speed(self):
        """Speed of pressure waves in the plane of the undeformed grain [m/s]."""
        return np.sqrt((self.plane_lam + 2 * self.mu) / self.density)

    def viscous_piola(self, F, F_rate, volume_projection=None):
        """Stress of stiffness damping, F S with S = beta (lambda' tr(E') 1 + 2 mu E').

        Args:
            F, F_rate (ndarray): deformation gradient and its rate [1/s], shape (points, 2, 2).
            volume_projection (ndarray | None): as for `first_piola`, applied to tr(E').

        Returns:
            ndarray: [Pa], shape (points, 2, 2).
        """
        E_rate = F.transpose(0, 2, 1) @ F_rate
        E_rate = 0.5 * (E_rate + E_rate.transpose(0, 2, 1))
        trace = np.trace(E_rate, axis1=1, axis2=2)
        if volume_projection is not None:
            trace = volume_projection @ trace
        S = 2 * self.mu * E_rate + self.plane_lam * trace[:, None, None] * np.eye(2)
        return self.stiffness_damping * F @ S

    def first_piola(self, F, volume_projection=None):
        """First Piola-Kirchhoff stress P = mu (F - F^-T) + lambda ln J F^-T, J = det(F) F33.

        Args:
            F (ndarray): deformation gradient in the plane, shape (points, 2, 2).
            volume_projection (ndarray | None): takes ln J at all points to what stands in its place
                in P, shape (points, points); plane strain only.

        Returns:
            ndarray: P in the plane [Pa], shape (points, 2, 2).
        """
        ln_J = np.log(np.linalg.det(F))
        if self.condition == "planeStress":
            ln_J = ln_J + self.thickness_strain(ln_J)
        if volume_projection is not None:
            ln_J = volume_projection @ ln_J
        inverse_transposed = np.linalg.inv(F).transpose(0, 2, 1)
        return self.mu * F + (self.lam * ln_J - self.mu)[:, None, None] * inverse_transposed

    def thickness_strain(self, ln_area):
        """Thickness strain y = ln F33 in plane stress, by Newton's method.

        P33 = 0 reads mu (exp(2 y) - 1) + lambda (ln_area + y) = 0.

        Args:
            ln_area (ndarray): ln of the determinant of F in the plane.

        Returns:
            ndarray: y, shape of ln_area.
        """
        y = np.zeros_like(ln_area)
        for _ in range(30):
            square = np.exp(2 * y)
            stress = self.mu * (square - 1) + self.lam * (ln_area + y)
            y = y - stress / (2 * self.mu * square + self.lam)
        return y
