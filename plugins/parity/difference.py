"""How far two simulators are apart in motions of one class and in ground contact, and what explains it."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness import Float, Mask
from harness.files.plain import tells
from harness.robot import Robot

from .classes import shares_told
from .track import Track, drift_between

GRACE = 5
"""Control periods after the first contact that still count: later ones tell how the arms bounce."""

CONTACT_KEYS = ("contact_disagreement", "dives", "mean_contact_delay_s", "max_contact_delay_s")
"""Keys of `Contact` as JSON."""
SHORT = 0.1
"""A joint that is slower than told by more than this share of its largest speed falls short."""


@tells(
    "contact_disagreement=disagreement", "dives", "mean_contact_delay_s=mean_delay_s", "max_contact_delay_s=max_delay_s"
)
@dataclass(frozen=True)
class Contact:
    """Two simulators' ground contacts in the same dives.

    Attributes:
        disagreement: Share of the samples in which one sees contact and the other does not. Samples of an episode:
            from its start to `GRACE` control periods after the first contact that either sees, or to its end.
        both: Dives in which both see contact.
        only_a: Those in which the first one alone does.
        only_b: Those in which the second one alone does.
        neither: Those that touch nothing.
        mean_delay_s: By what the second sees the first contact later than the first does, mean over `both`, [s];
            None without any.
        max_delay_s: The largest difference of the two, either way, [s]; None likewise.
    """

    disagreement: float
    both: int
    only_a: int
    only_b: int
    neither: int
    mean_delay_s: float | None
    max_delay_s: float | None

    @property
    def dives(self) -> dict[str, int]:
        """Their counts by who sees contact."""
        return {"both": self.both, "only_a": self.only_a, "only_b": self.only_b, "neither": self.neither}

    @property
    def note(self) -> str:
        """What a reader has to know; empty where every dive touches the ground in both."""
        found = [(self.only_a, "the first alone"), (self.only_b, "the second alone"), (self.neither, "neither")]
        told = [f"{count} in {who}" for count, who in found if count]
        return f"of {sum(self.dives.values())} dives, {', '.join(told)} touch the ground" if told else ""


def compare_contacts(a: Mask, b: Mask, period: float) -> Contact:
    """Ground contact of two simulators in the same dives.

    Args:
        a: Whether the first sees contact, (rows, episodes); row 0 is the start.
        b: The same of the second.
        period: From one row to the next, [s].
    """
    first_a, first_b = first_contacts(a), first_contacts(b)
    counted = np.arange(len(a))[:, None] <= np.minimum(first_a, first_b) + GRACE
    touched_a, touched_b = a.any(axis=0), b.any(axis=0)
    both = touched_a & touched_b
    delays = (first_b - first_a)[both] * period
    return Contact(
        float((a != b)[counted].mean()),
        int(both.sum()),
        int((touched_a & ~touched_b).sum()),
        int((touched_b & ~touched_a).sum()),
        int((~touched_a & ~touched_b).sum()),
        float(delays.mean()) if both.any() else None,
        float(np.abs(delays).max()) if both.any() else None,
    )


def first_contacts(contact: Mask) -> NDArray[np.intp]:
    """The first row of `contact`, (rows, episodes), that sees any, (episodes,); the number of rows without any."""
    return np.where(contact.any(axis=0), contact.argmax(axis=0), len(contact))


@dataclass(frozen=True)
class Response:
    """How the joints of one simulator follow what they are told, in one class.

    Attributes:
        tracking_error_m: Largest distance of the tip from where it was told to be, [m].
        speed_told: Largest speed that a joint was told, as a share of its largest one.
        speed_reached: Largest mean speed of a joint over a control period, likewise.
        falls_short: Share of all control periods of all joints in which one is slower than told by more than `SHORT`.
        lag_s: By how much later joints are where they are told to be, the delay that fits best, [s].
    """

    tracking_error_m: float
    speed_told: float
    speed_reached: float
    falls_short: float
    lag_s: float


class Worst(NamedTuple):
    """Where two simulators are farthest apart."""

    time_s: float
    """Since the motion began; for contact since the first one that either sees, [s]."""
    episode: int
    joint: str
    """The one that differs most then."""
    speed_told: float
    """What that joint is told, as a share of its largest speed."""
    acceleration_told: float
    """The same of its largest acceleration."""


@dataclass(frozen=True)
class Difference:
    """Two simulators in motions of one class.

    Attributes:
        max_tip_error_m: Largest distance of the tips, [m].
        mean_tip_error_m: Mean over all motions and control periods, [m].
        max_joint_error_rad: Largest difference of a joint, [rad]; of a slide as in `Drift`.
        worst: Where the tips are farthest apart.
        lag_s: By how much later the second one's joints are where the first one's are, the delay that fits best, [s].
        explained_by_lag: Share of the joints' squared difference that this delay explains, 0 to 1.
        turning: Mean distance of the tips where a joint changes its speed by at least half of the most that it does in
            these motions, as a multiple of the mean elsewhere; None where that is not defined.
    """

    max_tip_error_m: float
    mean_tip_error_m: float
    max_joint_error_rad: float
    worst: Worst
    lag_s: float
    explained_by_lag: float
    turning: float | None


def response_of(track: Track, told: Float, robot: Robot, period: float) -> Response:
    """How a simulator follows a motion.

    Args:
        track: What it did.
        told: Joint targets, (rows, episodes, dof), [rad].
        robot: The arm.
        period: Control period, [s].
    """
    speed, reached = (np.diff(qpos, axis=0) / period / robot.max_speed for qpos in (told, track.qpos))
    short = np.abs(speed) - np.sign(speed) * reached > SHORT
    unit = robot.per_radian  # else metres of a slide would count as radians
    tip = np.linalg.norm(track.tip - robot.end_effector(told), axis=-1)
    lag, _ = _lag_of((track.qpos - told) / unit, told / unit, period, np.ones(told.shape[:2], bool))
    return Response(
        float(tip.max()), float(np.abs(speed).max()), float(np.abs(reached).max()), float(short.mean()), lag
    )


def difference_between(
    one: Track, other: Track, told: Float, robot: Robot, period: float, counted: Mask | None = None
) -> Difference | None:
    """How far two simulators are apart that were told the same; None where nothing is counted.

    Args:
        one: What the first one did.
        other: What the second one did.
        told: Joint targets, (rows, episodes, dof), [rad].
        robot: The arm.
        period: Control period, [s].
        counted: Which rows, (rows, episodes); all but the first if None.
    """
    counted = np.arange(len(told))[:, None] > np.zeros(told.shape[1]) if counted is None else counted
    if not counted.any():
        return None
    unit = robot.per_radian
    drift = drift_between(one, other, unit)
    row, episode = np.unravel_index(np.where(counted, drift.tip, -1.0).argmax(), drift.tip.shape)
    joints = np.abs(other.qpos - one.qpos) / unit
    joint = int(joints[row, episode].argmax())
    speed, acceleration = shares_told(robot, told, period)
    begin = int(counted[:, episode].argmax()) if not counted[1, episode] else 0
    shares = speed[row, episode, joint], acceleration[row, episode, joint]
    worst = Worst(float(row - begin) * period, int(episode), robot.joint_names[joint], *map(float, shares))
    lag, explained = _lag_of((other.qpos - one.qpos) / unit, told / unit, period, counted)
    return Difference(
        float(drift.tip[row, episode]),
        float(drift.tip[counted].mean()),
        float(drift.joint[counted].max()),
        worst,
        lag,
        explained,
        _turning(drift.tip, acceleration.max(axis=-1), counted),
    )


def after_contact(one: Track, other: Track) -> Mask:
    """Control periods from the first contact on that either of two simulators sees, (rows, episodes)."""
    first = np.minimum(first_contacts(one.contact), first_contacts(other.contact))
    return np.asarray(np.arange(len(one.contact))[:, None] >= first)


def _turning(tip: Float, acceleration: Float, counted: Mask) -> float | None:
    """All (rows, episodes)."""
    turns = acceleration >= 0.5 * acceleration[counted].max()
    there, elsewhere = tip[counted & turns], tip[counted & ~turns]
    return float(there.mean() / elsewhere.mean()) if len(there) and len(elsewhere) and elsewhere.any() else None


def _lag_of(differences: Float, told: Float, period: float, counted: Mask) -> tuple[float, float]:
    """The delay whose differences are nearest to these, [s], and the share of their squares that it explains.

    Joints that are late by a time t are behind by t times their speed: least squares.
    """
    speed = np.diff(told, axis=0, prepend=told[:1])[counted] / period
    differences = differences[counted]
    squares, moved = float((differences**2).sum()), float((speed**2).sum())
    if squares == 0.0 or moved == 0.0:
        return 0.0, 0.0
    along = float((differences * speed).sum())
    return -along / moved, min(1.0, along**2 / (squares * moved))
