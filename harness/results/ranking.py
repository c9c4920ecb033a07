"""The order of an experiment's rewards in all its places, and whether the choice would differ. Reads results only.

A place is a simulator, or an environment, with an algorithm. Places are compared within a task of an arm, environments
with one another; two of them where they differ in one alone.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from harness.eta.headline import SUCCESS
from harness.eta.index import Estimate
from harness.eta.ranking import (
    FEWEST_RANKED,
    Answer,
    Order,
    Transplant,
    agreement_of,
    kendall,
    mean_agreement,
    order_rewards,
    transplant,
)
from harness.files.plain import Plain, tells
from harness.record.cell import Cell
from harness.results.comparison import Group, deciding_manner, still_to_come
from harness.results.results import Results

Kind: TypeAlias = Literal["simulator", "algorithm"]
KINDS: tuple[Kind, ...] = ("simulator", "algorithm")
NO_ENGINE = "no engine"
ROUNDING = 1e-9
"""Numbers that differ by less have the same rank."""


@tells("values", "tau_with_success=tau")
class EtaOrder(NamedTuple):
    """The order that an eta, or a part of it, gives the rewards.

    Attributes:
        values: The value of each reward, the best first; the baseline's is 1. Rewards without a value are left out.
        tau: Kendall's tau-b with the order by success, of the rewards that have both; None where it is not defined.
    """

    values: Mapping[str, float]
    tau: float | None


@tells("simulator", "algorithm", "engine", "seeds=success.seeds", "etas")
@dataclass(frozen=True, eq=False)
class Place(Plain):
    """The order of the rewards with one simulator and one algorithm.

    Attributes:
        simulator: The label of the simulator.
        algorithm: The label of the algorithm.
        engine: The simulator's engine; None if it is not recorded.
        success: The order of the rewards that are in every place, by their success rate.
        etas: By ``eta_P``, ``eta_P behaviour``, ``eta_N``, ``eta_N behaviour``.
    """

    simulator: str
    algorithm: str
    engine: str | None
    success: Order
    etas: Mapping[str, EtaOrder]

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        order = self.success
        means = dict(zip(order.rewards, order.means.tolist(), strict=True))
        return {
            **super().to_json(),
            "success": dict(sorted(means.items(), key=lambda item: -item[1])),
            "may_be_best": [order.rewards[it] for it in order.candidates],
        }


@tells(
    "differ_in=kind", "shared", "tau=agreement", "chosen_in_one_used_in_other=forth", "chosen_in_other_used_in_one=back"
)
@dataclass(frozen=True, eq=False)
class PlacePair(Plain):
    """Two places that differ in their simulator or in their algorithm."""

    kind: Kind
    """What the two places differ in."""
    one: Place
    other: Place
    agreement: Estimate
    forth: Transplant
    """The best reward of `one`, used in `other`."""
    back: Transplant

    @property
    def names(self) -> tuple[str, str]:
        """The names of both places: what tells them apart."""
        return getattr(self.one, self.kind), getattr(self.other, self.kind)

    @property
    def shared(self) -> str:
        """What both places have in common."""
        return self.one.algorithm if self.kind == "simulator" else self.one.simulator

    @property
    def votes(self) -> tuple[str, str]:
        """A name for each place. Places with one name have one vote: simulators of one engine, if it is recorded."""
        one, other = self.names
        return (self.one.engine or one, self.other.engine or other) if self.kind == "simulator" else (one, other)

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        one, other = self.names
        return {**super().to_json(), "one": one, "other": other, "same_vote": len({*self.votes}) == 1}


@dataclass(frozen=True, eq=False)
class TaskRanking(Plain):
    """The rewards of one task.

    Attributes:
        robot: The name of the robot; empty if the places are environments.
        task: The label of the task; empty if the places are several environments.
        steps: Environment steps of each training.
        rewards: The rewards that are in every place.
        left_out: The rewards that are not in every place.
        places: All places.
        pairs: All pairs of places that differ in one thing alone.
        between: The mean agreement for each kind of difference, with one vote for the simulators of one engine.
    """

    robot: str
    task: str
    steps: int
    rewards: tuple[str, ...]
    left_out: tuple[str, ...]
    places: tuple[Place, ...]
    pairs: tuple[PlacePair, ...]
    between: Mapping[Kind, Estimate]

    @property
    def has_engines(self) -> bool:
        """Whether the engine of every place is known. If it is not, each simulator has a vote of its own."""
        return all(place.engine is not None for place in self.places)

    @property
    def transplants(self) -> list[Transplant]:
        """All transplants, in both directions."""
        return [it for pair in self.pairs for it in (pair.forth, pair.back)]

    def count(self, answer: Answer) -> int:
        """How many choices have this answer."""
        return sum(it.answer == answer for it in self.transplants)

    def votes(self, kind: Kind) -> tuple[str, ...]:
        """The independent votes among the places that are compared."""
        return tuple(dict.fromkeys(vote for pair in self.pairs if pair.kind == kind for vote in pair.votes))

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        told = super().to_json()
        between = told.pop("between")
        return {**told, **{f"between_{kind}s": it for kind, it in between.items()}}


@dataclass(frozen=True)
class Ranking(Plain):
    """The rankings of all tasks.

    Attributes:
        tasks: The tasks in which several rewards are in several places.
        note: Why there is no ranking; empty if there is one.
    """

    tasks: tuple[TaskRanking, ...]
    note: str = ""


def ranking_of(results: Results) -> Ranking:
    """The order of the rewards in every place, by success and by eta, and how the best one does elsewhere.

    There is none before the plan is trained to its end: whoever looks again and again gives luck more chances.
    """
    if missing := still_to_come(results.combinations):
        return Ranking((), f"{missing}, and an order may change with them")
    tasks: dict[tuple[Any, ...], list[_Found]] = {}
    for group, cells in results.groups.items():
        found = _find(results, group, [cell for cell in cells if not results.is_control(cell)])
        if found.runs:
            differ = {*KINDS, *([] if "simulator" in group.labels else ["task"])}
            same = tuple(getattr(group, name) for name in group._fields if name not in differ)
            tasks.setdefault(same, []).append(found)
    ranked = [task for places in tasks.values() if (task := _rank(results, places)) is not None]
    return Ranking(tuple(ranked), "" if ranked else _why_none(tasks.values()))


class _Found(NamedTuple):
    """The values of the cells of one place."""

    group: Group
    runs: dict[str, dict[int, float]]
    """Success rate by reward and seed."""
    episodes: int
    engine: str | None
    """The engine; None if it is not recorded."""


def _find(results: Results, group: Group, cells: Sequence[Cell]) -> _Found:
    measured = {cell: results.measured(cell) for cell in cells}
    manners = set.intersection(*(set(it.manners) & set(it.episodes) for it in measured.values())) if measured else set()
    episodes = {manner: min(it.episodes[manner] for it in measured.values()) for manner in manners}
    compared = next((it for it in results.combinations if it.group == group and it.seeds), None)
    manner = compared.manner if compared else deciding_manner(group.deterministic, episodes)
    decisive = compared.decisive if compared else None
    success = decisive.measure.name if decisive and decisive.measure.episodes is not None else SUCCESS
    runs: dict[str, dict[int, float]] = {}
    for cell, it in measured.items():
        value = it.manners.get(manner, {}).get(success)
        if value is not None:
            runs.setdefault(cell.reward.label, {})[cell.seed] = value
    return _Found(group, runs, episodes.get(manner, 0), _engine(results, cells))


def _engine(results: Results, cells: Sequence[Cell]) -> str | None:
    """The engine of a place's cells, which all have one simulator. Cells of an older version do not record it."""
    if cells and "simulator" not in Group.of(cells[0]).labels:
        return cells[0].place.label  # every environment has a vote of its own
    environment = results.manifest(cells[0]).environment if cells else {}
    return (environment["engine"] or NO_ENGINE) if "engine" in environment else None


def _rank(results: Results, found: Sequence[_Found]) -> TaskRanking | None:
    """The ranking of a task; None if there is nothing to compare."""
    every = tuple(dict.fromkeys(reward for it in found for reward in it.runs))
    rewards = [reward for reward in every if all(reward in it.runs for it in found)]
    if min(len(rewards), len(found)) < FEWEST_RANKED:
        return None
    shared = [sorted(set.intersection(*({*it.runs[reward]} for reward in rewards))) for it in found]
    if not all(shared):
        return None
    runs = [
        {reward: [it.runs[reward][seed] for seed in seeds] for reward in rewards}
        for it, seeds in zip(found, shared, strict=True)
    ]
    orders = order_rewards(runs, [it.episodes for it in found])
    places = [_place(results, it, order) for it, order in zip(found, orders, strict=True)]
    group, left_out = found[0].group, tuple(reward for reward in every if reward not in rewards)
    task = group.task.label if len({it.group.task for it in found}) == 1 else ""
    return compare_places(places, group.labels.get("robot", ""), task, group.steps, left_out)


def compare_places(
    places: Sequence[Place], robot: str, task: str, steps: int, left_out: tuple[str, ...] = ()
) -> TaskRanking:
    """Compare each two places that differ in one thing alone, and all of them together.

    Args:
        places: At least one place. Their orders have the same rewards, and intervals that hold together.
        robot: The robot of all places.
        task: The task of all places.
        steps: The steps of all trainings.
        left_out: Rewards that are not in every place.
    """
    pairs = tuple(pair for one, other in combinations(places, 2) if (pair := _compare(one, other)) is not None)
    kinds = {kind: [pair for pair in pairs if pair.kind == kind] for kind in KINDS}
    between = {
        kind: mean_agreement([(*pair.votes, pair.agreement) for pair in them]) for kind, them in kinds.items() if them
    }
    return TaskRanking(robot, task, steps, places[0].success.rewards, left_out, tuple(places), pairs, between)


def _place(results: Results, found: _Found, success: Order) -> Place:
    group, etas = found.group, {}
    compared = [
        it for it in results.combinations if it.group == group and it.baseline == results.baseline and not it.is_control
    ]
    for name, lower in LOWER.items():
        for part in ("eta", "behaviour"):
            ratios = {it.proposed: getattr(it.number.splits[name], part) for it in compared}
            values = {reward: it.value for reward, it in ratios.items() if it.is_telling and it.value is not None}
            told = name if part == "eta" else f"{name} {part}"
            etas[told] = _eta_order({results.baseline: 1.0, **values}, lower, success)
    return Place(group.place, group.algorithm.label, found.engine, success, etas)


LOWER = {"eta_P": False, "eta_N": True}
"""Whether a lower eta is better."""


def _eta_order(values: Mapping[str, float], lower: bool, success: Order) -> EtaOrder:
    """The order by an eta. Rewards that are not in every place are left out."""
    known = {reward: values[reward] for reward in success.rewards if reward in values}
    means = dict(zip(success.rewards, success.means, strict=True))
    one = np.array([-value if lower else value for value in known.values()])
    other = np.array([means[reward] for reward in known])
    pairs = np.triu_indices(len(known), 1)
    differences = [it[pairs[0]] - it[pairs[1]] for it in (one, other)]
    tau = kendall(*(np.sign(np.where(np.abs(it) < ROUNDING, 0, it)).astype(np.int64) for it in differences))
    return EtaOrder(dict(sorted(known.items(), key=lambda item: item[1] if lower else -item[1])), tau)


def _compare(one: Place, other: Place) -> PlacePair | None:
    """Compare two places; None if they differ in both simulator and algorithm."""
    differ: list[Kind] = [kind for kind in KINDS if getattr(one, kind) != getattr(other, kind)]
    if len(differ) != 1:
        return None
    both = one.success, other.success
    return PlacePair(differ[0], one, other, agreement_of(*both), transplant(*both), transplant(*both[::-1]))


def _why_none(tasks: Iterable[Sequence[_Found]]) -> str:
    """Why there is no ranking, by the task with the most places."""
    most = max(tasks, key=len, default=())
    rewards = set.intersection(*(set(it.runs) for it in most)) if most else set()
    if min(len(rewards), len(most)) >= FEWEST_RANKED:
        return "in a place no seed is done under every reward"
    here = f"{len(rewards)} reward{'s' * (len(rewards) != 1)} in {len(most)} place{'s' * (len(most) != 1)}"
    return f"at least {FEWEST_RANKED} rewards in {FEWEST_RANKED} places are needed, and this experiment has {here}"
