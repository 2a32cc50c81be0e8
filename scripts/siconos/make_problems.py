"""Write contact problems to files, solved by softgrain, for ``compare.py`` and the tests.

    scripts/yade -n -x scripts/siconos/make_problems.py --out DIR

Random contacts, towers of blocks, strong friction and redundant contacts, made here of bodies that
only translate; and the problem of one step of a compaction of soft disks.
"""

import math

import numpy as np
from yade import FrictMat, O

import softgrain as sg
from softgrain import command_line

TOLERANCE = 1e-13
MAX_SWEEPS = 1_000_000


def problem(W, normal, free_velocity, bias, friction):
    """Arrays as ``SoftGrainIntegrator.contactProblem`` gives them, from a dense W [1/kg]."""
    rows, columns = np.nonzero(W)
    return {
        "normal": normal,
        "free_velocity": free_velocity,
        "bias": bias,
        "friction": friction,
        "delassus_offset": np.searchsorted(rows, np.arange(len(W) + 1)).astype("i4"),
        "delassus_column": columns.astype("i4"),
        "delassus_value": W[rows, columns],
        "start": np.zeros_like(normal),
    }


def random_contacts(dim, contacts, friction, seed):
    """Contacts in all directions with a regular W."""
    random = np.random.default_rng(seed)
    L = random.uniform(-1, 1, (contacts, contacts))
    W = L @ L.T / contacts + 0.3 * np.eye(contacts)
    normal = random.normal(size=(contacts, dim))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    velocity = random.uniform(-1, 1, (contacts, dim))
    bias = random.uniform(-0.2, 0.4, contacts)
    return problem(W, normal, velocity, bias, friction * random.uniform(0.5, 1, contacts))


def tower(dim, blocks, redundancy, friction):
    """Blocks on each other and the ground in a step of gravity, the upper half pushed sideways.

    Each face has `redundancy` contacts; with more than one, W is singular.
    """
    H = np.repeat(np.eye(blocks) - np.eye(blocks, k=-1), redundancy, axis=0)
    velocity = np.zeros((blocks, dim))
    velocity[:, -1] = -0.1
    velocity[blocks // 2 :, 0] = np.linspace(0.05, 0.3, blocks - blocks // 2)
    normal = np.zeros((len(H), dim))
    normal[:, -1] = 1
    mass = np.linspace(1, 3, blocks)
    return problem(
        H / mass @ H.T, normal, H @ velocity, np.zeros(len(H)), np.full(len(H), friction)
    )


def wedged_bodies(dim, bodies, friction, seed):
    """Neighbours in a row that are pressed together between two fixed ends, by tilted faces.

    Two contacts with different normals a face: hyperstatic.
    """
    random = np.random.default_rng(seed)
    H = np.zeros((bodies + 1, bodies))
    H[:-1] += np.eye(bodies)
    H[1:] -= np.eye(bodies)
    H = np.repeat(H, 2, axis=0)
    normal = random.normal(scale=0.3, size=(len(H), dim))
    normal[:, 0] = 1
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    velocity = random.uniform(-1, 1, (bodies, dim))
    mass = random.uniform(0.5, 2, bodies)
    free = H @ velocity
    return problem(H / mass @ H.T, normal, free, np.zeros(len(H)), np.full(len(H), friction))


def compaction(friction):
    """Contacts of a step in which three soft disks in a box are squeezed."""
    O.reset()
    soft = sg.SoftMat(young=1e6, poisson=0.45, density=1000, frictionAngle=math.atan(friction))
    O.materials.append(FrictMat(frictionAngle=math.atan(0.5 * friction), label="wall"))
    for x, y in ((0.01, 0.01), (0.03, 0.0105), (0.0195, 0.0277)):
        O.bodies.append(sg.soft_disk((x, y, 0), 0.01, soft, zeta=0.25))
    *_, top = O.bodies.append(sg.walls_around((0, 0), (0.0403, 0.0378), "wall"))
    O.bodies[top].state.vel = (0.1, -1, 0)
    O.engines = sg.engines(gravity=(0, -9.81, 0))
    sg.set_time_step()
    while O.bodies[top].state.pos[1] > 0.0305:
        O.step()
    return sg.integrator().contactProblem()


def problems():
    """All problems by name."""
    return {
        "random_2d": random_contacts(2, 20, 0.5, seed=1),
        "random_3d": random_contacts(3, 20, 0.5, seed=2),
        "frictionless_3d": random_contacts(3, 20, 0.0, seed=3),
        "tower_2d": tower(2, 15, 1, 0.3),
        "tower_3d": tower(3, 15, 1, 0.3),
        "high_friction_2d": random_contacts(2, 20, 10.0, seed=4),
        "high_friction_3d": random_contacts(3, 20, 4.0, seed=5),
        "high_friction_tower_3d": tower(3, 10, 1, 2.0),
        "redundant_tower_2d": tower(2, 6, 4, 0.3),
        "redundant_tower_3d": tower(3, 6, 4, 0.3),
        "wedged_2d": wedged_bodies(2, 8, 0.5, seed=6),
        "wedged_3d": wedged_bodies(3, 8, 2.0, seed=7),
        "compaction": compaction(0.3),
        "compaction_high_friction": compaction(2.0),
    }


def main():
    options = command_line.case_parser(__doc__, out="contact_problems").parse_args()
    for name, arrays in problems().items():
        answer = sg.solve_contact_problem(arrays, TOLERANCE, MAX_SWEEPS)
        print(
            f"{name}: {len(arrays['bias'])} contacts, {answer['sweeps']:.0f} sweeps, "
            f"residual {answer['residual']:.1e}"
        )
        file = options.out / f"{name}.npz"
        np.savez_compressed(file, **{**arrays, "impulse": answer["impulse"]})


if __name__ == "__main__":
    main()
