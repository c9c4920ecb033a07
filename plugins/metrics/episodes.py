"""What episodes of an arm say of themselves: whether and how soon they reach the target, and how they move."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from harness import Float, Ints
from harness.errors import Unmeasured
from harness.log import Log, episode_facts


def steps_to_target(trace: Log) -> Ints:
    """How many environment steps each finished episode takes to its first target, (episodes,).

    The number is 0 if the episode reaches no target. The order is that of `Log.episodes`.
    """
    reached = trace["reached"]
    first = np.array([rows[reached[rows].argmax()] for rows in trace.episodes], np.int64)
    steps: Ints = np.where(reached[first], trace["step"][first], 0)
    return steps


def paths_to_target(trace: Log) -> Float:
    """Lengths of the end effector's path to the first target and of the straight line, for each finished episode.

    The line leads from the end effector's place at the start to its place when it reaches the target.

    Returns:
        Path and line, [m], shape (episodes, 2), in the order of `Log.episodes`; NaN if the episode reaches no target.

    Raises:
        Unmeasured: The target moves. Where the line should end is not known before the target is reached.
    """
    if episode_facts(trace).target_moves:
        raise Unmeasured("the target moves: no straight line is the shortest way to it")
    position = np.stack([trace[f"end_effector_{axis}"] for axis in "xyz"], axis=1)
    lengths = np.full((len(trace.episodes), 2), np.nan)
    for episode, rows in enumerate(trace.episodes):
        reached = trace["reached"][rows]
        if reached.any():
            path = position[rows[: reached.argmax() + 1]]
            lengths[episode, 0] = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
            lengths[episode, 1] = np.linalg.norm(path[-1] - path[0])
    return lengths


@dataclass(frozen=True)
class TimeToTarget:
    """Mean time to the first target over all finished episodes, [s]. A failed episode counts as the whole horizon.

    This is the restricted mean of survival analysis. How an episode fails does not matter: if it ends on the ground,
    the target is not reached before the horizon either.
    """

    unit: ClassVar[str] = "s"
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (0.0, math.inf)
    is_time: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode, or if the trace does not record the control period.

        It is also None if an episode fails and the trace does not record the horizon.
        """
        steps, facts = steps_to_target(trace), episode_facts(trace)
        if len(steps) == 0 or facts.control_period is None or (facts.horizon is None and not steps.all()):
            return None
        return float(np.where(steps > 0, steps, facts.horizon or 0).mean() * facts.control_period)


@dataclass(frozen=True)
class StepsToTarget:
    """Mean number of steps to the first target, over the successful episodes only.

    A policy that fails more often in the far corners gets a better value. `time_to_target` counts all episodes.
    """

    unit: ClassVar[str] = "steps"
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (1.0, math.inf)
    is_time: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None if no episode reaches a target."""
        steps = steps_to_target(trace)
        return float(steps[steps > 0].mean()) if steps.any() else None


@dataclass(frozen=True)
class ObstacleHits:
    """Share of the finished episodes that end with the arm at an obstacle, in [0, 1].

    Only tasks that have obstacles have this metric.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"
    is_share: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode, or if the task has no obstacles."""
        ends = trace.last_rows
        return float(trace["obstacle"][ends].mean()) if "obstacle" in trace.columns and len(ends) else None


@dataclass(frozen=True)
class GroundHits:
    """Share of the finished episodes that end with the arm on the ground, in [0, 1]."""

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"
    is_share: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        ends = trace.last_rows
        return float(trace["ground"][ends].mean()) if len(ends) else None


@dataclass(frozen=True)
class Timeouts:
    """Share of the finished episodes whose time runs out before they reach the target, in [0, 1].

    Without obstacles, three shares add up to 1: this one, `success_rate`, and the share of episodes that end on the
    ground before they reach a target. If reaching the target ends an episode, `ground_hits` is the third share, but it
    also counts a step that reaches the target and hits the ground. If episodes go on after a target, `ground_hits` also
    counts those that hit the ground after their first target.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"
    is_share: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        reached, truncated = trace["reached"], trace["truncated"]
        over = [bool(truncated[rows[-1]]) and not reached[rows].any() for rows in trace.episodes]
        return sum(over) / len(over) if over else None


@dataclass(frozen=True)
class ClosestDistance:
    """Smallest distance from end effector to target in an episode, [m]; mean over the finished episodes.

    The distance at the start counts too. If the task measures another error, such as a pose error, the metric takes
    that error in its unit. If no episode ends at the target, or all end on the ground, this metric says more than
    `final_distance`.
    """

    unit: ClassVar[str] = "m"
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (0.0, math.inf)
    is_error: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        closest = [float(trace["distance"][rows].min()) for rows in trace.episodes]
        return sum(closest) / len(closest) if closest else None


@dataclass(frozen=True)
class FinalDistance:
    """Mean distance from end effector to target at the end of the finished episodes, [m].

    If the task measures another error, such as a pose error, the metric takes that error in its unit.
    """

    unit: ClassVar[str] = "m"
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (0.0, math.inf)
    is_error: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        ends = trace.last_rows
        return float(trace["distance"][ends].mean()) if len(ends) else None


@dataclass(frozen=True)
class SuccessRate:
    """Share of the finished episodes in which the target is reached, in [0, 1]."""

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"
    is_share: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        reached = [trace["reached"][rows].any() for rows in trace.episodes]
        return sum(reached) / len(reached) if reached else None


@dataclass(frozen=True)
class Work:
    """Mean mechanical work of a finished episode, [J]: the least that the joints must have put into the links.

    It is the sum of all gains in kinetic and potential energy from row to row, see `harness.robot.energy.least_work`.
    Energy that comes back when it falls counts as lost. Friction is not counted. An arm that stands still does no work,
    so read this metric together with the success rate.
    """

    unit: ClassVar[str] = "J"
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (0.0, math.inf)

    def __call__(self, trace: Log) -> float | None:
        """None if the trace does not record the work, or without a finished episode."""
        work = episode_facts(trace).work
        if work is None or not trace.episodes:
            return None
        works = [work[trace["env"][rows[0]]] for rows in trace.episodes]
        return float(sum(works) / len(works))


@dataclass(frozen=True)
class Optimality:
    """Steps that inverse kinematics take to the target, divided by the steps that the policy takes; mean over episodes.

    The mean is over the finished episodes whose target inverse kinematics reach. An episode in which the policy fails
    counts 0. Inverse kinematics drive the joints to one pose as fast as they can. That pose is seldom the nearest one,
    so the policy may be faster: the value is then above 1.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"
    bounds: ClassVar[tuple[float, float]] = (0.0, math.inf)

    def __call__(self, trace: Log) -> float | None:
        """None if the trace does not record the steps of inverse kinematics, or if no episode counts."""
        of_env = episode_facts(trace).ik_steps
        if of_env is None:
            return None
        ik_steps = [of_env[trace["env"][rows[0]]] for rows in trace.episodes]
        pairs = zip(ik_steps, steps_to_target(trace), strict=True)
        shares = [ik / steps if steps else 0.0 for ik, steps in pairs if ik is not None]
        return float(np.mean(shares)) if shares else None


@dataclass(frozen=True)
class Spl:
    """Success weighted by path length, mean over all finished episodes, in [0, 1] (Anderson et al. 2018, SPL).

    An episode that reaches the target counts the straight line divided by the end effector's path, both as in
    `path_ratio`. An episode that fails, or ends where it began, counts 0.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"
    is_share: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        path, straight = paths_to_target(trace).T
        counts = straight > 0.0
        return float((straight[counts] / path[counts]).sum() / len(path)) if len(path) else None


@dataclass(frozen=True)
class PathRatio:
    """Length of the end effector's path to the target, divided by the straight line between the path's ends.

    The metric is the mean over the successful episodes, >= 1. A path ends when its episode first reaches the target.
    Failed episodes do not count, because they may end anywhere; `spl` counts them. A path that ends where it began does
    not count either, because it has no straight line.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (1.0, math.inf)

    def __call__(self, trace: Log) -> float | None:
        """None if no episode counts."""
        path, straight = paths_to_target(trace).T
        counts = straight > 0.0
        return float(np.mean(path[counts] / straight[counts])) if counts.any() else None


CUT_OFF = 10.0
"""Higher frequencies are left out, [Hz]."""
THRESHOLD = 0.05
"""The spectrum ends at the last frequency whose normalised magnitude is at least this."""
PADDING = 4
"""The speeds are padded with zeros to the next power of 2, times 2 to the power of this number."""
FEWEST = 4
"""An episode with fewer speeds does not count, because it has almost no spectrum."""
BATCH = 1024
"""So many episodes are transformed together."""
STANDING = 1e-6
"""An end effector whose path is shorter than this counts as standing still, [m]."""


@dataclass(frozen=True)
class Sparc:
    """Spectral arc length of the end effector's speed, mean over the finished episodes, < 0; nearer to 0 is smoother.

    The magnitude of the speed's Fourier spectrum draws a curve up to the cut-off, which is 10 Hz or half the control
    rate, whichever is lower. Both axes are scaled to the range from 0 to 1. The spectral arc length is minus the length
    of this curve (Balasubramanian et al. 2015, SPARC). Neither duration nor amplitude of the motion matter. Episodes
    with fewer than 4 steps, or without motion, do not count.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"
    bounds: ClassVar[tuple[float, float]] = (-math.inf, 0.0)

    def __call__(self, trace: Log) -> float | None:
        """None if the trace does not record the control period, or if no episode counts."""
        period = episode_facts(trace).control_period
        if period is None or not trace.episodes:
            return None
        position = np.stack([trace[f"end_effector_{axis}"] for axis in "xyz"], axis=1)
        speed = np.linalg.norm(np.diff(position[np.concatenate(trace.episodes)], axis=0), axis=1)
        lengths = [*map(len, trace.episodes)]  # what lies between two episodes is no speed
        profiles = [speed[end - length : end - 1] for length, end in zip(lengths, np.cumsum(lengths), strict=True)]
        moved = [way for way in profiles if len(way) >= FEWEST and way.sum() >= STANDING]
        arcs = [arc for at in range(0, len(moved), BATCH) for arc in spectral_arcs(moved[at : at + BATCH], period)]
        return float(np.mean(arcs)) if arcs else None


def spectral_arcs(speeds: Sequence[Float], period: float) -> list[float]:
    """The spectral arc length, < 0, of each speed profile, (samples,), in any unit, with a sample per `period` [s]."""
    arcs = [0.0] * len(speeds)
    sizes = [2 ** ((len(speed) - 1).bit_length() + PADDING) for speed in speeds]
    for size in set(sizes):  # profiles that are padded alike are transformed together
        alike = [number for number, own in enumerate(sizes) if own == size]
        padded = np.zeros((len(alike), size >> PADDING))
        for row, number in zip(padded, alike, strict=True):
            row[: len(speeds[number])] = speeds[number]
        within = int(min(max(CUT_OFF * period * size, 1.0), size // 2)) + 1
        magnitudes = np.abs(np.fft.rfft(padded, size)[:, :within])
        magnitudes /= magnitudes[:, :1]  # the largest: speeds are not negative
        lasts = within - 1 - (magnitudes[:, ::-1] >= THRESHOLD).argmax(axis=1)
        for number, magnitude, last in zip(alike, magnitudes, lasts.tolist(), strict=True):
            arcs[number] = -float(np.hypot(1.0 / last, magnitude[1 : last + 1] - magnitude[:last]).sum())
    return arcs


@dataclass(frozen=True)
class Smoothness:
    """Root mean square of the second difference of the joint positions, per step squared; 0 at constant speed.

    It is computed for each joint over all finished episodes. The metric is the mean over the joints.
    """

    unit: ClassVar[str] = "rad/step^2"
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (0.0, math.inf)

    def __call__(self, trace: Log) -> float | None:
        """None if no finished episode has two steps."""
        seconds = [np.diff(trace["qpos"][rows], n=2, axis=0) for rows in trace.episodes if len(rows) > 2]
        if not seconds:
            return None
        return float(np.sqrt(np.mean(np.concatenate(seconds) ** 2, axis=0)).mean())
