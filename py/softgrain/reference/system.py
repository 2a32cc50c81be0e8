"""The step of the whole system."""

from dataclasses import dataclass, field

import numpy as np

from .cell import Cell
from .interface import Interface, has_slid, node_areas
from .search import contacts_of_grains, contacts_with_plane, turned_with
from .solver import (
    RESTING_OVERLAP,
    OverlapAccount,
    SolverSettings,
    closing_bias,
    excess_overlap,
    project_on_cone,
    solve,
)

#: Bodies in a cluster at most.
BODIES_PER_CLUSTER = 16


@dataclass
class Wall:
    """A rigid plane wall across an axis, with prescribed motion."""

    axis: int  #: 0: x = const, 1: y = const
    position: np.ndarray  #: of a point of it, m
    velocity: np.ndarray  #: m/s
    friction_angle: float = 0.0  #: rad

    def normal_towards(self, x):
        """Unit normal on the side of x."""
        normal = np.zeros(2)
        normal[self.axis] = 1 if x[self.axis] > self.position[self.axis] else -1
        return normal


@dataclass
class System:
    """Grains and walls in contact.

    Pairs are (g, g') with g < g', or (g, -1 - w) for wall w.
    """

    grains: list
    walls: list = field(default_factory=list)
    settings: SolverSettings = field(default_factory=SolverSettings)
    gravity: np.ndarray = field(default_factory=lambda: np.zeros(2))  #: m/s^2
    cell: Cell | None = None  #: periodic; without walls
    interface: Interface = field(default_factory=Interface)  #: of all pairs
    contacts: list = field(default_factory=list)  #: of the last step, as (pair, Contact), in order
    account: dict = field(default_factory=dict)  #: OverlapAccount by pair
    steps: int = 0  #: so far

    def step(self, dt):
        """Advance all bodies by dt [s].

        Forces and contacts are those of t_n; velocities go from t_n - dt/2 to t_n + dt/2.

        Returns:
            SolverReport: what the contact sweeps came to.
        """
        for grain in self.grains:
            grain.lay_grid()
            grain.find_forces(self.steps, dt)
        self.find_contacts(dt)
        self.predict_velocities(dt)
        report = self.solve_contacts(dt)
        self.move(dt)
        self.steps += 1
        return report

    def find_contacts(self, dt):
        """Find the contacts of t_n; those that were there before keep memory and impulse, which
        turns with the normal."""
        last = {(pair, contact.key): contact for pair, contact in self.contacts}
        self.contacts = []
        for g, grain in enumerate(self.grains):
            for w, wall in enumerate(self.walls):
                middle, spread = grain.velocity_range()
                speed = np.linalg.norm(middle - wall.velocity) + spread
                reach = self._reach(speed, dt, grain.point_spacing, grain.point_spacing)
                normal = wall.normal_towards(grain.centre)
                contacts = contacts_with_plane(grain, wall.position, normal, reach)
                for contact in contacts:
                    contact.drift = np.asarray(wall.velocity)
                self._list((g, -1 - w), contacts)
            for h, other in enumerate(self.grains[g + 1 :], g + 1):
                shift, drift = np.zeros(2), np.zeros(2)
                if self.cell:
                    shift, drift = self.cell.image(grain.centre, other.centre)
                spacings = sorted((grain.point_spacing, other.point_spacing))
                middle, spread = grain.velocity_range()
                other_middle, other_spread = other.velocity_range()
                apart = np.linalg.norm(middle - other_middle - drift)
                speed = apart + spread + other_spread
                reach = self._reach(speed, dt, *spacings)
                self._list((g, h), contacts_of_grains(grain, other, reach, shift, drift))
        self.contacts = in_sweep_order(self.contacts)
        for pair, contact in self.contacts:
            before = last.get((pair, contact.key), contact)
            contact.impulse = turned_with(before.normal, contact.normal, before.impulse)
            contact.slid = before.slid
        present = {pair: OverlapAccount() for pair, _ in self.contacts}
        self.account = {pair: self.account.get(pair, new) for pair, new in present.items()}

    def _list(self, pair, contacts):
        self.contacts += [(pair, contact) for contact in contacts]

    def _reach(self, speed, dt, finer, coarser):
        """Gaps [m] that can close in two steps, and never less than a twentieth of the finer dr;
        beyond the range of a cohesion, whose nodes stand for places within it, half the coarser."""
        touch = max(2 * dt * speed, 0.05 * finer)
        within = self.interface.cohesion_range
        return within + max(touch, 0.5 * coarser) if within > 0 else touch

    def predict_velocities(self, dt):
        """v_I += dt (f_I / m_I + gravity) + damping + what the cell takes along: the velocities
        without contact."""
        for grain in self.grains:
            acceleration = grain.force / grain.mass[:, None] + self.gravity
            damping = grain.damping_impulse(dt) / grain.mass[:, None]
            grain.v_next = grain.v + dt * acceleration + damping
            if self.cell:
                mean = grain.mass @ grain.v / grain.mass.sum()
                velocity, spin = self.cell.take_along(grain.centre, mean, dt)
                arm = grain.x - grain.centre
                grain.v_next += velocity + spin * np.column_stack([-arm[:, 1], arm[:, 0]])

    def pull(self, dt):
        """Impulses of known tractions; the nodes of two grains stand for half of their area."""
        areas = [node_areas(grain.contact_positions()) for grain in self.grains]
        for (g, h), contact in self.contacts:
            share = 0.5 if h >= 0 else 1.0
            area = areas[(g, h)[contact.side]][contact.node]
            contact.pull = share * self.interface.pull(contact, area, dt)

    def solve_contacts(self, dt):
        """Find all impulses r together and put them on the nodes, v += M^-1 H^T r."""
        H = self.contact_matrix()
        mass = np.concatenate([grain.mass for grain in self.grains])
        v = np.concatenate([grain.v_next for grain in self.grains])
        contacts = [contact for _, contact in self.contacts]
        self.pull(dt)
        v = (
            v
            + H.T @ np.array([contact.pull for contact in contacts]).reshape(-1, 2) / mass[:, None]
        )
        start = [
            project_on_cone(contact.impulse, contact.normal, self.friction(pair))
            for pair, contact in self.contacts
        ]
        impulse = np.array(start).reshape(-1, 2)
        drift = np.array([contact.drift for contact in contacts]).reshape(-1, 2)
        friction = [self.interface.friction(c, self.friction(pair)) for pair, c in self.contacts]
        report = solve(
            delassus=H / mass @ H.T,
            free_velocity=H @ v - drift,
            normal=np.array([contact.normal for contact in contacts]),
            bias=np.array(self.biases(dt)),
            friction=np.array(friction),
            impulse=impulse,
            pair=[pair for pair, _ in self.contacts],
            settings=self.settings,
        )
        for contact, r, mu in zip(contacts, impulse, friction):
            contact.impulse = r
            contact.slid = has_slid(contact, mu)
        v = v + H.T @ impulse / mass[:, None]
        self.keep_accounts(H @ v - drift)
        ends = np.cumsum([len(grain.mass) for grain in self.grains])
        for grain, part in zip(self.grains, np.split(v, ends[:-1])):
            grain.v_next = part
        return report

    def contact_matrix(self):
        """H, which takes the velocities of all nodes to relative velocities at the contacts.

        Row of a contact: N_I(Xs) for the nodes I of the grain of its node s, minus the same of its
        partners, each times its share.

        Returns:
            ndarray: shape (contacts, nodes of all grains).
        """
        begins = np.cumsum([0] + [len(grain.mass) for grain in self.grains])
        H = np.zeros((len(self.contacts), begins[-1]))
        for row, (pair, contact) in zip(H, self.contacts):
            g, h = pair if contact.side == 0 else pair[::-1]
            row[begins[g] : begins[g + 1]] += self.grains[g].contact_shape[contact.node]
            for node, share in contact.partners.items():
                row[begins[h] : begins[h + 1]] -= share * self.grains[h].contact_shape[node]
        return H

    def deepest_overlap(self):
        """Largest overlap of the contacts, over the mean dr of both grains (the dr at a wall)."""
        overlaps = [0.0]
        for (g, h), contact in self.contacts:
            spacings = [self.grains[k].point_spacing for k in (g, h) if k >= 0]
            overlaps.append(-contact.gap / np.mean(spacings))
        return max(overlaps)

    def spacing(self, pair, contact):
        """dr of the grain of the node [m]."""
        return self.grains[pair[contact.side]].point_spacing

    def biases(self, dt):
        """b of all contacts [m/s]. A pair may owe the forces of the last step over what may
        rest."""
        credit = dict.fromkeys(self.account, 0.0)
        for pair, contact in self.contacts:
            force = contact.impulse @ contact.normal / dt
            credit[pair] += force * RESTING_OVERLAP * self.spacing(pair, contact)
        good = {pair: account.is_good(credit[pair]) for pair, account in self.account.items()}
        return [
            closing_bias(contact.gap, self.spacing(pair, contact), dt, self.settings, good[pair])
            for pair, contact in self.contacts
        ]

    def keep_accounts(self, velocity):
        """Enter what overlaps give in this step.

        Args:
            velocity (ndarray): u of all contacts with their impulses [m/s], shape (contacts, 2).
        """
        given = {pair: [] for pair in self.account}
        for (pair, contact), u in zip(self.contacts, velocity):
            if excess_overlap(contact.gap, self.spacing(pair, contact)) > 0:
                given[pair].append((contact.impulse @ contact.normal) * (u @ contact.normal))
        for pair, account in self.account.items():
            account.enter(given[pair])

    def friction(self, pair):
        """Coefficient of a pair, mu = tan of the smaller one of both angles."""
        g, other = pair
        partner = self.walls[-1 - other] if other < 0 else self.grains[other].material
        return np.tan(min(self.grains[g].material.friction_angle, partner.friction_angle))

    def move(self, dt):
        """Grains with their new velocities, walls and cell with their own."""
        for grain in self.grains:
            grain.move(dt)
        for wall in self.walls:
            wall.position = wall.position + dt * np.asarray(wall.velocity)
        if self.cell:
            self.cell.move(dt)


def in_sweep_order(contacts):
    """Sort contacts as ``contact/solve/SweepPlan.hpp`` says: tasks (the pairs within a cluster of
    bodies, then those between two) by colours, each task having the first that none of its clusters
    has.

    Args:
        contacts (list): of (pair, contact), the contacts of a pair side by side; a pair is (grain,
            grain), or (grain, negative) with a wall.

    Returns:
        list: the same; within a task in the given order.
    """
    cluster = clusters(list(dict.fromkeys(pair for pair, _ in contacts)))
    tasks = {}
    for pair, contact in contacts:
        touched = sorted({cluster[g] for g in pair if g >= 0})
        tasks.setdefault((len(touched) > 1, *touched), []).append((pair, contact))
    colour, taken = {}, {}
    for task in sorted(tasks):
        used = set().union(*(taken.setdefault(c, set()) for c in task[1:]))
        colour[task] = next(k for k in range(len(used) + 1) if k not in used)
        for c in task[1:]:
            taken[c].add(colour[task])
    return [item for task in sorted(colour, key=colour.get) for item in tasks[task]]


def clusters(pairs):
    """Number of the cluster of each body: neighbours of neighbours, breadth first."""
    neighbours = {}
    for pair in pairs:
        bodies = [g for g in pair if g >= 0]
        for g in bodies:
            neighbours.setdefault(g, []).extend(h for h in bodies if h != g)
    cluster = {}
    for first in sorted(neighbours):
        if first in cluster:
            continue
        number, members = len(set(cluster.values())), [first]
        cluster[first] = number
        for member in members:
            for g in neighbours[member]:
                if g not in cluster and len(members) < BODIES_PER_CLUSTER:
                    cluster[g] = number
                    members.append(g)
    return cluster
