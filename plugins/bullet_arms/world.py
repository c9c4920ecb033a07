"""Bullet's worlds: clients, their options, and the bodies in them."""

import ctypes
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryFile
from xml.etree import ElementTree

import numpy as np
import pybullet

from harness import Float
from harness.errors import MissingSolid, UsageError, print_visible
from harness.robot import Robot

GRAVITY = -9.81
"""Along z, [m/s^2]."""
LOAD_FLAGS = pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_IMPLICIT_CYLINDER
BASE = -1
"""Bullet's number of the root link."""
MESH_MARGIN = 1e-3
"""Bullet's margin around a mesh that a URDF names, [m]; it cannot be changed."""
LONGEST_PRINT = 20_000
"""Bytes that are told of what Bullet prints about a file."""


def load_body(client: int, robot: Robot, path: Path, flags: int) -> int:
    """Load a robot as a body with a fixed base at the origin; Bullet's number of it.

    Links do not touch one another, unless `flags` has URDF_USE_SELF_COLLISION.

    Args:
        client: Where to.
        robot: The arm.
        path: Its file, see `file_of_arm`.
        flags: Bullet's, of ``loadURDF``.

    Raises:
        UsageError: Bullet cannot load the URDF.
        MissingSolid: Bullet has left out a collision shape.
    """
    try:
        with _c_prints_visible():
            body = int(pybullet.loadURDF(str(path), useFixedBase=True, flags=flags, physicsClientId=client))
    except pybullet.error as error:
        raise UsageError(f"PyBullet cannot load the URDF of robot '{robot.name}': {error}") from error
    _check_solids(client, body, robot, path)
    return body


def _check_solids(client: int, body: int, robot: Robot, path: Path) -> None:
    """Check that each link has all its solids."""
    links = {name: number for number, name in _link_names(client, body).items()}
    for link in ElementTree.parse(path).iterfind("link"):
        name, solids = link.get("name", ""), link.findall("collision")
        count = len(pybullet.getCollisionShapeData(body, links.get(name, BASE), physicsClientId=client))
        if count != len(solids):
            raise MissingSolid(
                f"PyBullet has loaded {count} of the {len(solids)} collision shapes of link '{name}' of robot "
                f"'{robot.name}': simplify them, or take another simulator"
            )


def _link_names(client: int, body: int) -> dict[int, str]:
    """The names of all links but the root, by Bullet's numbers."""
    count = pybullet.getNumJoints(body, physicsClientId=client)
    return {link: pybullet.getJointInfo(body, link, physicsClientId=client)[12].decode() for link in range(count)}


def exact_timestep(period: float, substeps: int) -> float:
    """The duration of a physics step [s], `period / substeps` in single precision.

    Bullet computes in double precision. It divides a period by the physics step and keeps the remainder for later. A
    physics step in single precision has so few bits that the quotient is exact. So there is never a remainder, and no
    period depends on those before it.
    """
    return float(np.float32(period / substeps))


def set_options(client: int, timestep: float, substeps: int, iterations: int) -> None:
    """Set gravity, solver and physics steps of a world; `stepSimulation` does `substeps` of `timestep` [s]."""
    pybullet.setGravity(0.0, 0.0, GRAVITY, physicsClientId=client)
    pybullet.setPhysicsEngineParameter(deterministicOverlappingPairs=1, physicsClientId=client)
    set_iterations(client, iterations)
    set_steps(client, timestep, substeps)


def set_iterations(client: int, iterations: int) -> None:
    """Let the solver go through all constraints so often in a physics step."""
    pybullet.setPhysicsEngineParameter(numSolverIterations=iterations, physicsClientId=client)


def set_steps(client: int, timestep: float, steps: int) -> None:
    """Let every `stepSimulation` do `steps` physics steps of `timestep` [s]."""
    pybullet.setPhysicsEngineParameter(fixedTimeStep=timestep * steps, numSubSteps=steps, physicsClientId=client)


def numbers(client: int, body: int, robot: Robot) -> tuple[dict[str, int], list[int]]:
    """Bullet's numbers of the links by name, and of the driven joints in the robot's order."""
    count = pybullet.getNumJoints(body, physicsClientId=client)
    infos = [pybullet.getJointInfo(body, number, physicsClientId=client) for number in range(count)]
    links = {info[12].decode(): info[0] for info in infos}
    joints = {info[1].decode(): info[0] for info in infos}
    return links, [joints[name] for name in robot.joint_names]


def add_ground(client: int, body: int, joints: list[int]) -> int:
    """Add the plane z = 0; Bullet's number of it. Links that no driven joint moves may stand in the plane."""
    shape = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
    ground = pybullet.createMultiBody(0.0, shape, physicsClientId=client)
    for link in (link for link, group in _groups(client, body, joints).items() if not group):
        pybullet.setCollisionFilterPair(body, ground, link, BASE, 0, physicsClientId=client)
    return int(ground)


def part_neighbours(client: int, body: int, joints: list[int], home: Float) -> None:
    """Exclude contacts between neighbours, and between links that touch at `home`, (dof,).

    The body must have been loaded with URDF_USE_SELF_COLLISION. Two links are neighbours if the same joint moves them,
    or if one joint connects them.
    """
    groups = _groups(client, body, joints)
    set_joints(client, body, joints, home)
    for first, second in combinations(groups, 2):
        points = pybullet.getClosestPoints(body, body, 0.0, first, second, physicsClientId=client)
        if abs(groups[first] - groups[second]) <= 1 or points:
            pybullet.setCollisionFilterPair(body, body, first, second, 0, physicsClientId=client)


def _groups(client: int, body: int, joints: list[int]) -> dict[int, int]:
    """For each link, how many driven joints are between it and the world."""
    groups = {BASE: 0}
    for link in range(pybullet.getNumJoints(body, physicsClientId=client)):  # parents come first
        parent = pybullet.getJointInfo(body, link, physicsClientId=client)[16]
        groups[link] = groups[parent] + (link in joints)
    return groups


def contact_distances(links: Mapping[str, int], robot: Robot) -> dict[int, float]:
    """How near to the ground each link touches it, as Bullet tells the distance, by Bullet's number of the link, [m].

    Bullet lets a mesh, but no other shape, begin `MESH_MARGIN` before its surface.
    """
    return {
        links.get(name, BASE): -MESH_MARGIN * all(shape.kind == "mesh" for shape in shapes)
        for name, shapes in robot.link_shapes.items()
    }


def set_joints(client: int, body: int, joints: list[int], qpos: Float) -> None:
    """Put the driven joints at rest at `qpos`, (dof,)."""
    for joint, position in zip(joints, qpos, strict=True):
        pybullet.resetJointState(body, joint, position, 0.0, physicsClientId=client)


@contextmanager
def _c_prints_visible() -> Iterator[None]:
    """Tell on stderr what Bullet prints about a file: stdout is for results, and a name in it may hold anything."""
    if os.name != "posix":
        yield
        return
    sys.stdout.flush()
    flush = ctypes.CDLL(None).fflush
    flush(None)
    kept = os.dup(1)
    with TemporaryFile() as prints:
        os.dup2(prints.fileno(), 1)
        try:
            yield
        finally:
            flush(None)
            os.dup2(kept, 1)
            os.close(kept)
            prints.seek(0)
            text = prints.read(LONGEST_PRINT).decode(errors="replace").strip()
            if text:
                print_visible(text, err=True)
