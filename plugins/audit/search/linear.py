"""Linear feedback policies, found by small evolutions: for worlds in which a bare sequence of actions falls over.

An action is W times the features of what is observed, scaled by what was met: a choice of the largest, or a point of
the box. The same policy is played from all starts at once.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeAlias

import numpy as np
from gymnasium.spaces import Box, Discrete
from numpy.typing import NDArray

from harness import Float, Ints
from harness.experiment.environments.spaces import rows_of

from .moves import Choices, moves_in
from .table import Keep
from .world import Act, Actions, Data, Outcomes, Rng, World

LINEAR = "linear policy"
"""The kind of such a policy, and what its episodes are said to be made by."""
LARGEST = 64
"""Numbers of an observation; where there are more, nothing is tried that is linear in them."""
SQUARED = 8
"""Numbers of an observation up to which every second evolution also gives a policy their products."""
POPULATION, PARENTS, GENERATIONS, PATIENCE = 16, 4, 15, 5
"""Policies of a generation; those that the next one is drawn from; generations of an evolution; how many of them
may bring nothing better."""
TRIED_FROM = 3
"""Starts that a generation is played from, drawn anew for each; its best policy is played from all."""
AT_ONCE, FROM_NOTHING = 0.25, 2
"""The share of what is left of a budget that an evolution may take; how many times each goal is begun from nothing."""
PAY = "pay"
"""The goal of all rewards."""
SPREAD, SPREAD_AGAIN, SPREAD_LEAST = 1.0, 0.3, 0.05
"""Standard deviation of weights at first, where an evolution begins from a known policy, and at least."""
FAR = 5.0
"""Scaled numbers are cut here."""

Goal: TypeAlias = Callable[[Outcomes], tuple[NDArray[Any], ...]]
"""What an evolution is after: of each episode, numbers of which more is better, the first one that differs decides."""


def act_linear(policy: Data, world: World) -> Act:
    """What a linear policy does in a world."""
    weights, mean, scale = (np.asarray(policy[name]) for name in ("weights", "mean", "scale"))
    of, moves, space, size = rows_of(world.observes).of, moves_in(world.space), world.space, len(mean)
    inverse, (rows, columns) = 1.0 / scale, np.triu_indices(size)
    bias, direct, squared = np.split(weights, [1, 1 + size], axis=1)
    bias = bias[:, 0]

    def act(observed: Any) -> Any:
        scaled = np.minimum(np.maximum((of(observed) - mean) * inverse, -FAR), FAR)
        told = bias + direct @ scaled
        if squared.size:
            told += squared @ (scaled[rows] * scaled[columns])
        chosen = moves.chosen(told)
        if isinstance(moves, Choices):
            return moves.first + int(chosen)
        return (moves.middle + moves.half * chosen).reshape(space.shape).astype(space.dtype)

    return act


GOALS = {
    PAY: "paid discounted",
    "success": "success share near paid",  # by whatever tells it
    "paid success": "success paid",
    "longer": "steps paid",
    "paid failure": "-success paid",
    "soon": "success -time paid",
    "discounted pay": "discounted paid",
    "shorter": "-steps paid",
    "less pay": "-paid",
}
"""What evolutions are after anywhere: numbers of `Outcomes`, with a minus those of which less is better."""


def _numbers(names: str, outcomes: Outcomes) -> tuple[NDArray[Any], ...]:
    return tuple(
        np.nan_to_num(getattr(outcomes, name.removeprefix("-"))) * (-1 if name.startswith("-") else 1)
        for name in names.split()
    )


def goals_of(world: World, outcomes: Outcomes) -> dict[str, Goal]:
    """By name, what evolutions are after in a world.

    Args:
        world: Where.
        outcomes: Some that were met there: their measures are goals too, in the direction that the world knows or else
            in both.
    """
    goals: dict[str, Goal] = {name: partial(_numbers, names) for name, names in GOALS.items()}
    for name in outcomes.measures:
        for sign in (world.directions[name],) if name in world.directions else (1, -1):
            goals[f"{name} {sign:+d}"] = lambda it, name=name, sign=sign: (  # type: ignore[misc]
                np.nan_to_num(sign * it.measures[name], nan=-np.inf, posinf=np.inf, neginf=-np.inf), it.paid
            )  # fmt: skip
    return goals


@dataclass(eq=False)
class Evolutions:
    """Evolutions of linear policies in a world, one after the other, each after one goal.

    Attributes:
        world: Where.
        starts: The seeds of the resets.
        keep: Takes in every episode.
        rng: Draws weights.
        best: By the name of a goal, the policy that came nearest to it from all starts, and what it came to there.
        differs: By the name of a goal, whether anything but pay ever told two policies apart.
    """

    world: World
    starts: Ints
    keep: Keep
    rng: Rng

    def __post_init__(self) -> None:
        """Play random actions, for the scale of what is observed and the names of measures."""
        world, starts = self.world, self.starts
        self.rows = rows_of(world.observes)
        self.size = self.rows.size
        self._count, self._sum, self._squared = 0, np.zeros(self.size), np.zeros(self.size)  # of all that was observed
        world.space.seed(int(self.rng.integers(2**31)))
        outcomes, actions = self._watch(starts, lambda observed: world.space.sample())
        self.keep(np.arange(len(starts)), actions, outcomes, "random", ())
        self.goals = goals_of(world, outcomes)
        self.best: dict[str, tuple[Data, Outcomes]] = {}
        self.differs = dict.fromkeys(self.goals, False)
        self._first = {name: _reached(goal, outcomes)[:-1] for name, goal in self.goals.items()}

    def _watch(self, starts: Ints, policy: Act) -> tuple[Outcomes, list[Actions]]:
        """Play episodes of a policy, and take in what is observed before each step."""
        seen = list[Float]()

        def act(observed: Any) -> Any:
            seen.append(np.asarray(self.rows.of(observed), np.float64))
            return policy(observed)

        played = self.world.act(starts, act)
        rows = np.clip(np.stack(seen), -1e6, 1e6)
        self._count += len(rows)
        self._sum += rows.sum(axis=0)
        self._squared += (rows**2).sum(axis=0)
        return played

    def evolve(self, name: str, until: int, *, squares: bool, again: bool) -> None:
        """One evolution after a goal, until it brings nothing more or the world has taken so many steps.

        Args:
            name: The goal's.
            until: Steps of the world.
            squares: Whether policies are given products of what is observed.
            again: Whether it begins from the best policy that is known for this goal, rather than from nothing.
        """
        goal, space = self.goals[name], self.world.space
        width = 1 + self.size + (self.size * (self.size + 1) // 2 if squares else 0)
        rows = int(np.prod(space.shape)) if isinstance(space, Box) else 1 if space.n == 2 else int(space.n)
        mean = self._sum / self._count
        scale = np.sqrt(np.maximum(self._squared / self._count - mean**2, 0.0))
        scale = np.where(scale > 1e-8, scale, 1.0)  # 1 of what never changed
        begins: dict[str, Any] = {"kind": LINEAR, "weights": [], "mean": mean.tolist(), "scale": scale.tolist()}
        middle = np.zeros((rows, width))
        if again and name in self.best:  # the products that it lacks have weights 0
            begins = dict(self.best[name][0])
            middle = np.asarray(begins["weights"])
            middle = np.pad(middle, ((0, 0), (0, max(0, width - middle.shape[1]))))
        spread = np.full(middle.shape, SPREAD_AGAIN if middle.any() else SPREAD)
        best: tuple[float, ...] = (-np.inf,)
        idle = 0
        for _ in range(GENERATIONS):
            some = np.sort(self.rng.permutation(len(self.starts))[:TRIED_FROM])
            tried = list[tuple[tuple[float, ...], Data]]()
            for _ in range(POPULATION):
                if self.world.taken >= until:
                    return
                weights = middle + spread * self.rng.standard_normal(middle.shape)
                policy = {**begins, "weights": weights.tolist()}
                tried.append((_reached(goal, self._play(policy, some)), policy))
            tried.sort(key=lambda it: it[0], reverse=True)
            parents = np.stack([policy["weights"] for _, policy in tried[:PARENTS]])
            middle, spread = parents.mean(axis=0), np.maximum(parents.std(axis=0), SPREAD_LEAST)
            first = tried[0][1]
            found = self._play(first, np.arange(len(self.starts)))
            for other, of_other in self.goals.items():
                known = self.best.get(other)
                if known is None or _reached(of_other, found) > _reached(of_other, known[1]):
                    self.best[other] = first, found
            reached = _reached(goal, found)
            best, idle = (reached, 0) if reached > best else (best, idle + 1)
            if idle >= PATIENCE:
                return

    def _play(self, policy: Data, some: Ints) -> Outcomes:
        outcomes, actions = self._watch(self.starts[some], act_linear(policy, self.world))
        self.keep(some, actions, outcomes, LINEAR, [policy] * len(some))
        for name, goal in self.goals.items():
            self.differs[name] |= _reached(goal, outcomes)[:-1] != self._first[name]
        return outcomes


def _reached(goal: Goal, outcomes: Outcomes) -> tuple[float, ...]:
    """How near some episodes came to a goal, on average."""
    return tuple(float(np.mean(it)) for it in goal(outcomes))


def search_linear(world: World, starts: Ints, keep: Keep, budget: int, rng: Rng) -> list[Data]:
    """Look for linear policies that are paid most, fail, succeed, last: every episode is given to `keep`.

    Args:
        world: Where.
        starts: The seeds of the resets; all are played at once, so that a policy is none for one start only.
        keep: Takes in every episode.
        budget: About so many steps are taken.
        rng: Draws weights and random actions.

    Returns:
        The best policies, each for a goal of its own; none where observations are not numbers, or too many.
    """
    if isinstance(world.observes, Discrete) or not 0 < rows_of(world.observes).size <= LARGEST:
        return []
    stop, evolutions = world.taken + budget, Evolutions(world, starts, keep, rng)
    for number, name in ((number, name) for number in itertools.count() for name in evolutions.goals):
        if world.taken >= stop or (number and not any(evolutions.differs.values())):
            break
        if evolutions.differs[name] or (number, name) == (0, PAY):
            until = world.taken + max(1, int(AT_ONCE * (stop - world.taken)))
            squares = number % 2 == 1 and evolutions.size <= SQUARED
            evolutions.evolve(name, until, squares=squares, again=number >= FROM_NOTHING)
    return list({id(it): it for it, _ in evolutions.best.values()}.values())
