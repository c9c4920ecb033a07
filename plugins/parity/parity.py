"""Simulators compared: the same poses, motions and dives through each."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np

from harness.env.solid_probes import Probe
from harness.files.plain import Plain, tells
from harness.simulator import family_of

from .classes import CONTACT, FAST, SINGULAR, Told, told_by
from .contenders import Contenders, Missing
from .difference import (
    CONTACT_KEYS,
    Contact,
    Difference,
    Response,
    after_contact,
    compare_contacts,
    difference_between,
    response_of,
)
from .motions import Held
from .orders import Orders, Setting, draw_orders
from .performance import Failure, Performance, attempt, part, perform, time_in_turns
from .track import Drift, Placement, Track, drift_between, placement_of

FORMAT = 1
"""The version of the JSON."""
NO_DIVES = "no part of the arm was found to get into the ground"
LEFT_OUT = {
    FAST: "no such motion was found that is clear of the ground",
    SINGULAR: "no such motion was found that is clear of the ground",
    CONTACT: NO_DIVES,
}
"""Why there may be no motions of a class."""


@tells(
    "name",
    "family",
    "placement_error_m=placement.error_m",
    "placement_error_rad=placement.error_rad",
    "tracking_error_m=tracking.max_tip_error_m",
    "tracking_error_rad=tracking.max_joint_error_rad",
    "seconds_per_step",
    "dives_touched=touched",
    "missing_solids",
    "classes=responses",
)
@dataclass(frozen=True)
class Measured:
    """One simulator.

    Attributes:
        name: Its name, parameters included.
        family: The engine that it computes with, see `harness.simulator.family_of`.
        placement: Errors of an arm that is placed.
        tracking: How far the driven arm is from where it was told to be.
        seconds_per_step: Of one arm, median, [s].
        responses: How its joints follow, by class of motions.
        touched: In how many dives it touches the ground; None where there are none.
        missing: The solids that it lacks.
    """

    name: str
    family: str | None
    placement: Placement
    tracking: Drift
    seconds_per_step: float
    responses: Mapping[str, Response]
    touched: int | None = None
    missing: tuple[Probe, ...] = ()

    @property
    def missing_solids(self) -> list[str]:
        """The links of the solids that it lacks."""
        return [probe.link for probe in self.missing]


@tells(
    "a",
    "b",
    "*drift",
    "*contact",
    "contact_note",
    "placed_contact_disagreement=placed_disagreement",
    "classes=differences",
    "curves=drift.curves",
)
@dataclass(frozen=True)
class Pair(Plain):
    """Two simulators.

    Attributes:
        a: The first one's name.
        b: The second one's.
        drift: How far they are apart in smooth motion.
        contact: When they see the ground in dives; None if the arm does not reach it.
        placed_disagreement: Share of the random poses in which one sees contact and the other does not.
        differences: How far they are apart by class of motions; of contact from the first one on.
    """

    a: str
    b: str
    drift: Drift
    contact: Contact | None
    placed_disagreement: float
    differences: Mapping[str, Difference]

    @property
    def contact_note(self) -> str:
        """What a reader has to know about the dives; empty where every one touches the ground in both."""
        return self.contact.note if self.contact else NO_DIVES

    def to_json(self) -> dict[str, Any]:
        """Plain data; without dives the figures of contact are null."""
        return {**dict.fromkeys(CONTACT_KEYS), **super().to_json()}


@tells(
    "format",
    "reference",
    "robot=setting.robot.name",
    "steps=setting.steps",
    "episodes=setting.episodes",
    "seed=setting.seed",
    "control_period_s=setting.period",
    "classes=told",
    "left_out",
    "near_ground",
    "simulators",
    "missing",
    "pairs",
)
@dataclass(frozen=True)
class Parity(Plain):
    """How far simulators differ.

    Attributes:
        reference: What the others are compared with, in the first place; it may have failed.
        setting: What was driven.
        simulators: Those that got through, the reference first.
        pairs: Each two of them, in the same order.
        failed: The others, by name, and why.
        missing: Those that are not installed.
        told: What each class of motions asks of the joints.
        held: What of the arm keeps away from the ground, by class but contact.
    """

    reference: str
    setting: Setting
    simulators: tuple[Measured, ...]
    pairs: tuple[Pair, ...]
    failed: dict[str, Failure]
    missing: tuple[Missing, ...]
    told: Mapping[str, Told]
    held: Mapping[str, Held]

    format = FORMAT

    @property
    def left_out(self) -> dict[str, str]:
        """The classes without any motions, and why."""
        return {name: reason for name, reason in LEFT_OUT.items() if name not in self.told}

    @property
    def near_ground(self) -> dict[str, Held]:
        """The classes in which less than the whole arm keeps away from the ground, and what does."""
        return {name: held for name, held in self.held.items() if held != "whole"}

    def to_json(self) -> dict[str, Any]:
        """Plain data, finite numbers only."""
        failed = [{"name": name, "reason": failure.reason} for name, failure in self.failed.items()]
        return {**super().to_json(), "failed": failed}


def compare_simulators(contenders: Contenders, setting: Setting) -> Parity:
    """Place and drive the same arm in each simulator; one that fails costs itself alone."""
    orders = draw_orders(setting)
    simulators, failed = part(contenders.simulators)
    performed, broken = part(
        {name: attempt(partial(perform, simulator, setting, orders)) for name, simulator in simulators.items()}
    )
    going = {name: simulators[name] for name in performed}
    seconds, stopped = part(time_in_turns(going, setting.robot, orders.motion[:, 0], setting.period))
    sound = {name: performed[name] for name in seconds}
    return Parity(
        contenders.reference,
        setting,
        _measure(sound, {name: family_of(simulators[name]) for name in sound}, seconds, setting, orders),
        tuple(_compare(*first, *second, setting, orders) for first, second in combinations(sound.items(), 2)),
        failed | broken | stopped,
        contenders.missing,
        {name: told_by(setting.robot, motion, setting.period) for name, motion in orders.classes.items()},
        orders.held,
    )


def _measure(
    performed: Mapping[str, Performance],
    families: Mapping[str, str | None],
    seconds: Mapping[str, float],
    setting: Setting,
    orders: Orders,
) -> tuple[Measured, ...]:
    motion, robot = orders.motion, setting.robot
    ideal = Track(motion, robot.end_effector(motion), np.zeros(motion.shape[:2], bool))
    return tuple(
        Measured(
            name,
            families[name],
            placement_of(performance.placed, robot, orders.poses),
            drift_between(ideal, performance.driven, robot.per_radian),
            seconds[name],
            {
                kind: response_of(performance.classes[kind], told, robot, setting.period)
                for kind, told in orders.classes.items()
            },
            None if performance.dived is None else int(performance.dived.contact.any(axis=0).sum()),
            performance.missing,
        )
        for name, performance in performed.items()
    )


def _compare(a: str, first: Performance, b: str, second: Performance, setting: Setting, orders: Orders) -> Pair:
    dives = first.dived, second.dived
    contact = None
    if dives[0] is not None and dives[1] is not None:
        contact = compare_contacts(dives[0].contact, dives[1].contact, setting.period)
    disagreement = float((first.placed.contact != second.placed.contact).mean())
    drift = drift_between(first.driven, second.driven, setting.robot.per_radian)
    differences = _differences(first, second, setting, orders)
    return Pair(a, b, drift, contact, disagreement, differences)


def _differences(first: Performance, second: Performance, setting: Setting, orders: Orders) -> dict[str, Difference]:
    found = {}
    for name, told in orders.classes.items():
        one, other = first.classes[name], second.classes[name]
        counted = after_contact(one, other) if name == CONTACT else None
        difference = difference_between(one, other, told, setting.robot, setting.period, counted)
        if difference is not None:
            found[name] = difference
    return found
