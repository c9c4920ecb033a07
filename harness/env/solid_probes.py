"""Whether an engine has all solids of an arm: where one of them alone is in the ground, the arm has to touch it.

This asks nothing of a simulator but what it tells anyway. So it finds a solid that an engine has dropped, or made
smaller, whatever the engine.
"""

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace

import numpy as np

from harness.arrays import Float
from harness.errors import MissingSolid
from harness.registry.choice import Registry
from harness.robot import Robot
from harness.robot.ground_clearance import Solids, build_solids
from harness.robot.kinematics import link_frames, read_only
from harness.robot.robot import load_robot
from harness.robot.shapes import Shape, attach_shapes
from harness.robot.urdf import parse_urdf
from harness.simulator import Simulation, Simulator

WAYS = 512
"""Straight ways in joint space from above the ground into it, at whose first contacts the arm is looked at."""
HALVINGS = 14
"""How often a way is halved to find where the lowest solid is `DEPTH` below the ground."""
DEPTH, GAP = 5e-3, 2e-3
"""How deep one solid is in the ground, and how high all others are above it at least, [m]: more than engines round."""
KNOWN = "fd100"
"""The arm that tells whether a simulator tells of ground contact at all."""
PERIOD = 0.1
"""[s]; nothing is driven."""
DIRECTIONS = 256
"""A mesh is probed by its farthest points in so many directions: none of them is outside of its solid."""


@dataclass(frozen=True, eq=False)
class Probe:
    """A pose in which one solid alone is in the ground.

    Attributes:
        link: The link of the solid.
        kind: Of the solid, as ``mesh``.
        qpos: The pose, (dof,), [rad] or [m].
    """

    link: str
    kind: str
    qpos: Float


def probes_of(robot: Robot) -> tuple[Probe, ...]:
    """A probe for each solid that can be the first to touch the ground; the same for the same robot.

    As far as the ground is concerned, a simulation tells next to the same with and without any other solid.
    """
    solids = list(_solids_alone(robot))
    poses = _first_contacts(robot, [alone for _, _, alone in solids]) if solids else np.empty((0, robot.dof))
    if not len(poses):
        return ()
    heights = _heights(robot, [alone for _, _, alone in solids], poses)
    lowest, second = _two_lowest(heights)
    probes = []
    for (link, kind, _), own in zip(solids, heights, strict=True):
        gaps = np.where((own == lowest) & (own <= -0.8 * DEPTH), second, -np.inf)
        best = int(gaps.argmax())
        if gaps[best] >= GAP:
            probes.append(Probe(link, kind, poses[best]))
    return tuple(probes)


def find_missing(simulation: Simulation, probes: Sequence[Probe], num_envs: int = 1) -> tuple[Probe, ...]:
    """The probes at which a simulation of `num_envs` arms touches nothing: it lacks their solids."""
    everyone = np.ones(num_envs, bool)
    return tuple(
        probe
        for probe in probes
        if not simulation.reset(np.tile(probe.qpos, (num_envs, 1)), everyone).ground_contact.any()
    )


def require_solids(name: str, simulator: Simulator, robot: Robot, registry: Registry | None = None) -> None:
    """Check that a simulator has the solids of an arm.

    Nothing is said of a simulator that tells no ground contact of any arm; ``harness check`` of it does.

    Args:
        name: Of the simulator, for the message.
        simulator: To be opened with one arm.
        robot: The arm.
        registry: The plugins; loaded if None.

    Raises:
        MissingSolid: It lacks one; names its link.
    """
    missing, probes = _missing_of(simulator, robot)
    if missing and (len(missing) < len(probes) or _tells_contact(simulator, robot, registry)):
        raise MissingSolid(
            f"Simulator '{name}' has {missing_in_words(missing)} of robot '{robot.name}': the arm touches nothing "
            "where that solid alone is in the ground. Give the link another <collision>, or take another simulator."
        )


def _tells_contact(simulator: Simulator, silent: Robot, registry: Registry | None) -> bool:
    """Whether a simulator that tells no contact of one arm does of another."""
    if silent.name == KNOWN:
        return False
    missing, probes = _missing_of(simulator, load_robot(KNOWN, registry))
    return len(missing) < len(probes)


def _missing_of(simulator: Simulator, robot: Robot) -> tuple[tuple[Probe, ...], tuple[Probe, ...]]:
    """The probes that a simulator fails, and all probes."""
    probes = probes_of(robot)
    if not probes:
        return (), ()
    with closing(simulator.open(robot, 1, PERIOD)) as simulation:
        return find_missing(simulation, probes), probes


def missing_in_words(missing: Sequence[Probe]) -> str:
    """``no solid for link 'tool' (mesh)``, with all links that lack one."""
    links = dict.fromkeys(f"'{probe.link}' ({probe.kind})" for probe in missing)
    return f"no solid for link{'s' * (len(links) > 1)} {', '.join(links)}"


def few_points(shapes: Sequence[Sequence[Shape]]) -> list[list[Shape]]:
    """The same shapes, with no more than `DIRECTIONS` points for a mesh: quick to compute with, a little too small."""
    return [[_with_few_points(shape) for shape in group] for group in shapes]


def _first_contacts(robot: Robot, solids: Sequence[Solids]) -> Float:
    """Poses, (n, dof), where the lowest solid is `DEPTH` below the ground, on ways there from above it."""
    drawn = np.random.default_rng(0).uniform(robot.lower, robot.upper, (4 * WAYS, robot.dof))
    below = _heights(robot, solids, drawn).min(axis=0) < -DEPTH
    count = min(WAYS, int(below.sum()), int((~below).sum()))
    above, inside = drawn[~below][:count], drawn[below][:count]
    for _ in range(HALVINGS if count else 0):
        middle = (above + inside) / 2.0
        deep = (_heights(robot, solids, middle).min(axis=0) < -DEPTH)[:, None]
        above, inside = np.where(deep, above, middle), np.where(deep, middle, inside)
    return np.asarray(inside)


def _heights(robot: Robot, solids: Sequence[Solids], poses: Float) -> Float:
    """The height of the lowest point of each solid at each pose, (solids, poses), [m]."""
    frames = link_frames(robot.chain, poses)
    heights: Float = np.stack([alone.lowest(frames) for alone in solids])
    return heights


def _solids_alone(robot: Robot) -> Iterator[tuple[str, str, Solids]]:
    """Each solid that a joint of the chain moves, with its link and kind."""
    urdf = parse_urdf(robot.urdf)
    for link, shapes in robot.link_shapes.items():
        for shape in shapes:
            attached = attach_shapes(urdf, {link: [_with_few_points(shape)]}, robot.joint_names)
            if any(attached):
                yield link, shape.kind, build_solids(attached)


def _with_few_points(shape: Shape) -> Shape:
    if len(shape.points) <= DIRECTIONS:
        return shape
    directions = np.random.default_rng(0).standard_normal((3, DIRECTIONS))
    farthest = np.unique((shape.points @ directions).argmax(axis=0))
    return replace(shape, points=read_only(shape.points[farthest]))


def _two_lowest(heights: Float) -> tuple[Float, Float]:
    """The lowest and the second lowest height at each pose, (poses,) both; inf where there is no second."""
    padded = np.concatenate([heights, np.full((1, heights.shape[1]), np.inf)])
    lowest, second = np.partition(padded, 1, axis=0)[:2]
    return lowest, second
