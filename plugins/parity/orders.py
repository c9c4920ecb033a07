"""What every simulator is told."""

from dataclasses import dataclass
from typing import NamedTuple

from harness.arrays import Float
from harness.env.solid_probes import Probe, probes_of
from harness.robot import Robot

from .classes import CONTACT, SMOOTH, class_motions, in_order
from .dives import dive_motions
from .motions import smooth_motions
from .placement import random_poses


@dataclass(frozen=True)
class Setting:
    """What orders are drawn from.

    Attributes:
        robot: The arm.
        steps: Control periods of each smooth motion, >= 1.
        episodes: How many smooth motions, and how many dives, >= 1.
        seed: Of all that is drawn, >= 0.
        period: Control period, [s].
    """

    robot: Robot
    steps: int = 200
    episodes: int = 8
    seed: int = 0
    period: float = 0.1


class Orders(NamedTuple):
    """Joint positions to be placed at and driven to, [rad]."""

    poses: Float
    """(rounds, episodes, dof)"""
    motion: Float
    """(steps + 1, episodes, dof)"""
    dives: Float | None
    """(rows, episodes, dof); None if the arm does not reach the ground."""
    others: dict[str, Float]
    """Motions of the other classes, by class, (steps + 1, episodes, dof)."""
    probes: tuple[Probe, ...]
    """Poses that tell which solids a simulator lacks."""

    @property
    def classes(self) -> dict[str, Float]:
        """Every class of motions, in the order in which they are shown."""
        dives = {} if self.dives is None else {CONTACT: self.dives}
        return in_order({SMOOTH: self.motion, **dives, **self.others})


def draw_orders(setting: Setting) -> Orders:
    """The same for the same setting.

    Raises:
        UsageError: Next to every motion of the robot meets the ground.
    """
    robot, seed, episodes = setting.robot, setting.seed, setting.episodes
    return Orders(
        random_poses(robot, seed, episodes),
        smooth_motions(robot, seed, episodes, setting.steps, setting.period),
        dive_motions(robot, seed, episodes, setting.period),
        class_motions(robot, seed, episodes, setting.steps, setting.period),
        probes_of(robot),
    )
