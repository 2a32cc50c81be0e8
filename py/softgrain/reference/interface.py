"""What surfaces do to each other besides unilateral contact with one coefficient of friction."""

from dataclasses import dataclass

import numpy as np

#: A sliding contact is on its cone up to rounding.
CONE_ROUNDING = 1e-9


@dataclass
class Interface:
    """Constant cohesion over a range (Dugdale), and a coefficient of friction while sliding."""

    cohesion: float = 0.0  #: attracting traction sigma_c, Pa
    cohesion_range: float = 0.0  #: gap up to which it acts, m
    dynamic_friction: float | None = None  #: mu_d; None: that of a contact that sticks

    def pull(self, contact, area, kick):
        """Impulse p of the traction on the node of a contact [N s per metre].

        The node stands for a piece of the outline across whose width the gap rises evenly by
        `spread`; the traction acts in the share of it where the gap is within the range.

        Args:
            contact (Contact): with normal and gap.
            area (ndarray): of that piece along its outward normal [m], shape (2,).
            kick (float): time over which impulses act [s].
        """
        along = -contact.normal @ area
        if along <= 0 or self.cohesion == 0:
            return np.zeros(2)
        size = np.linalg.norm(area)
        spread = size * np.sqrt(max(0.0, 1 - (along / size) ** 2))
        room = self.cohesion_range - contact.gap
        share = np.clip(room / spread + 0.5, 0, 1) if spread > 0 else float(room > 0)
        return -kick * along * self.cohesion * share * contact.normal

    def friction(self, contact, static):
        """Coefficient of a contact, mu_d if it slid."""
        return (
            static if self.dynamic_friction is None or not contact.slid else self.dynamic_friction
        )


def has_slid(contact, friction):
    """Whether a contact is on its cone; without a reaction it is what it was."""
    pressed = contact.impulse @ contact.normal
    if pressed <= 0:
        return contact.slid
    tangential = np.linalg.norm(contact.impulse - pressed * contact.normal)
    return tangential >= (1 - CONE_ROUNDING) * friction * pressed


def node_areas(outline):
    """Outward area vectors of the nodes of a counter-clockwise polygon [m]: half of both edges."""
    edge = np.roll(outline, -1, axis=0) - outline
    normal = np.column_stack([edge[:, 1], -edge[:, 0]])
    return 0.5 * (normal + np.roll(normal, 1, axis=0))
