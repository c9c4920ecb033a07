"""Where a search plays: an arm's task or anybody's environment, begun by a seed, moved by actions, paid by one reward.

A `World` opens batches of episodes and plays them, whatever moves there. A search knows nothing else of it.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple, Protocol, TypeAlias

import gymnasium
import numpy as np
from numpy.typing import NDArray

from harness import Float, Ints, Mask
from harness.errors import SimulationDiverged
from harness.log.log import UNCOUNTABLE, is_countable, sums_from

Actions: TypeAlias = NDArray[Any]
"""Those of one episode: (steps, action_size) inside the box, or (steps,) of choices."""
Space: TypeAlias = gymnasium.spaces.Box | gymnasium.spaces.Discrete
"""The space of one action."""
Rng: TypeAlias = np.random.Generator
Data: TypeAlias = Mapping[str, Any]
"""Plain data, as JSON has it: a policy, by its kind; a part of a certificate."""
Act: TypeAlias = Callable[[Any], Any]
"""A policy: from an observation, as the world gives it, to one action."""
REWARD = "reward"
TRIED = 3
"""Episodes of random actions that show whether a world repeats itself."""


@dataclass(frozen=True, eq=False)
class Outcomes:
    """What n episodes came to.

    Attributes:
        steps: Their lengths, (n,).
        paid: Sums of what they were paid, a task's events included, (n,).
        discounted: The same times gamma^t, t from 0, (n,).
        success: Whether they ended in success, (n,); False everywhere if nothing measures it.
        time: The step from which on an episode was a success until its end, counted from 1, (n,); the world's horizon
            for a failure. Where success ends an episode, that is its length.
        share: The share of an episode's steps that were a success, (n,), in [0, 1].
        near: How near they came to success, (n,): larger is nearer; NaN if nothing tells.
        measures: By name, the last value of each measure of behaviour, (n,); NaN where it is untold.
        trails: The observations of each episode, flat, (steps + 1, size); none if `near` tells enough.
    """

    steps: Ints
    paid: Float
    discounted: Float
    success: Mask
    time: Ints
    share: Float
    near: Float
    measures: Mapping[str, Float] = field(default_factory=dict)
    trails: Sequence[Float] = ()


@dataclass(frozen=True, eq=False)
class Shown:
    """One episode with everything that a page or a certificate shows.

    Attributes:
        start: The seed of its reset.
        actions: Those that were taken, as long as the episode.
        paid: What each step paid, (steps,).
        terms: By name, what each term of it paid, (steps,); a task's events are the term ``events``.
        success: Whether each step was a success, (steps,).
        measures: By name, the value at each step, (steps,).
        ended: ``"terminated"``, ``"truncated"``, or ``"cut"`` at the world's horizon.
        observed: What a policy was given before each step, and what it would be given after the last one, as the
            world gives it, (steps + 1).
        drawn: What an arm is drawn from, at the start and after each step: ``time``, [s], ``qpos``,
            ``target``, world frame, [m], and ``distance``, (steps + 1, size); empty of an environment.
    """

    start: int
    actions: Actions
    paid: Float
    terms: Mapping[str, Float]
    success: Mask
    measures: Mapping[str, Float]
    ended: str
    observed: Sequence[Any] = ()
    drawn: Mapping[str, Float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Beginning:
    """A behaviour to begin from: actions or a policy.

    Attributes:
        made_by: What it comes from, in words: ``script creep``.
        actions: Of an episode for each start, or of one for all, of any length; none for a policy.
        act: A policy; None for actions.
    """

    made_by: str
    actions: Sequence[Actions] = ()
    act: Act | None = None


def key_of(observed: Any) -> str:
    """What is observed, as a key: equal if every part is."""
    if isinstance(observed, Mapping):
        return ",".join(f"{name}={key_of(observed[name])}" for name in sorted(observed))
    if isinstance(observed, tuple | list):
        return ",".join(map(key_of, observed))
    values = np.asarray(observed)
    return str(values.item()) if values.ndim == 0 else values.tobytes().hex()


def since(flags: Mask) -> int:
    """The step, from 1, from which on all are True; one more than there are if the last one is not."""
    return int(len(flags) - np.append(flags[::-1], False).argmin() + 1)


class Step(NamedTuple):
    """One step of n episodes side by side; of those that have ended it says nothing."""

    taken: Any
    """The actions as they were taken, (n, ...)."""
    observed: Any
    """What a policy is given next, (n)."""
    kept: Any
    """Copies of that, (n)."""
    paid: Any
    """What was paid, and by term, (n, 1 + terms)."""
    told: Any
    """What was measured, (n, measures or more)."""
    ended: Mapping[int, str]
    """The episodes that end with it: ``"terminated"`` or ``"truncated"``."""


class Batch(Protocol):
    """Episodes side by side."""

    def reset(self, starts: list[int]) -> tuple[Any, Any]:
        """Begin one with each seed; returns the fields `observed` and `kept` of a `Step`."""

    def step(self, actions: Any) -> Step:
        """Take an action in each; what ended rests."""

    def close(self) -> None:
        """Close what moves there."""


Choose: TypeAlias = Callable[[int, Any, Mapping[int, Any]], Any]
"""From the number of a step, from 0, what is observed before it, and the episodes that have ended, to actions."""


class World(ABC):
    """One reward in one task or environment. Everything that it does is repeated by the same calls."""

    name: str
    """What it is called: ``gymnasium:id=Pendulum-v1``."""
    reward: str
    """The label of the reward."""
    gamma: float
    """The learner's discount per step, in (0, 1]."""
    horizon: int
    """The most steps of an episode."""
    space: Space
    """The space of one action."""
    observes: gymnasium.Space[Any]
    """The space of what policies are given."""
    success: str
    """What tells success, as a user types it: ``success``, ``height>0.9``; empty if nothing does."""
    directions: Mapping[str, int]
    """By name, of the measures of which that is known: 1 where more is better, -1 where less is."""
    measures: Sequence[str]
    """The names of what is measured."""
    terms: Sequence[str]
    """The names of the terms of the reward; none if it has none."""
    notes: Sequence[str] = ()
    """Sentences that a reader of the answer has to know: what was taken for success, where episodes are cut."""
    together = 1
    """How many episodes are played side by side in hardly more time than one."""
    period = 1
    """How many steps a decision counts."""
    taken = 0
    """Steps taken so far; a search's budget is counted in these."""

    def written(self, action: Any) -> Any:
        """What somebody's policy does as an action of `space`."""
        return action

    @abstractmethod
    def open(self, count: int) -> Batch:
        """A batch of so many episodes, at most `together`; the one that was opened before if it is open."""

    @abstractmethod
    def close(self) -> None:
        """Close all that was opened."""

    @abstractmethod
    def successes(self, told: Float) -> Mask:
        """Whether each step of an episode was a success, (steps,), by what was measured, (steps, ...)."""

    @abstractmethod
    def nearest(self, shown: Shown) -> tuple[float, Sequence[Float]]:
        """How near an episode came to success; and its observations, flat, unless that tells enough."""

    def distinct(self, starts: Sequence[int]) -> tuple[int, ...]:
        """Those starts that differ."""
        return tuple(starts)

    def scripts(self, starts: Sequence[int]) -> Sequence[Beginning]:
        """What a search begins from here, whoever asks: movements that somebody planned from each start."""
        return ()

    @cached_property
    def is_repeated(self) -> bool:
        """Whether the same start and actions bring the same steps and the same pay, bit for bit.

        It is tried: in another order, and in what is opened anew.
        """
        taken, first, again = self.taken, self.at_random(), self.at_random(reversed(range(TRIED)))[::-1]
        self.close()
        pairs = [*zip(first, again, strict=True), *zip(first, self.at_random(), strict=True)]
        self.taken = taken
        return all(key_of(vars(one)) == key_of(vars(other)) for one, other in pairs)

    def play(self, starts: Ints, actions: Actions) -> Outcomes:
        """Play n episodes of given actions.

        Args:
            starts: The seed of each one's reset, (n,).
            actions: (n, horizon, action_size), or (n, horizon) of choices.
        """
        return self._outcomes(self.played(starts, actions))

    def act(self, starts: Ints, policy: Act) -> tuple[Outcomes, list[Actions]]:
        """Play n episodes of a policy; also returns the actions that it took, of each episode."""
        choose = self._following(policy)
        shown = [it for some in self._parts(starts) for it in self.episodes(starts[some], choose)]
        return self._outcomes(shown), [it.actions for it in shown]

    def show(self, start: int, actions: Actions) -> Shown:
        """Play one episode and keep everything."""
        (shown,) = self.episodes(np.array([start]), lambda step, *_: actions[step : step + 1], len(actions))
        return replace(shown, drawn=self.drawn())

    def drawn(self) -> Mapping[str, Float]:
        """What an arm that was played alone last is drawn from; see `Shown`."""
        return {}

    def watch(self, start: int, policy: Act) -> Shown:
        """Play one episode of a policy; tables are learnt of this."""
        return self.episodes(np.array([start]), self._following(policy))[0]

    def at_random(self, starts: Iterable[int] = range(TRIED)) -> list[Shown]:
        """An episode of random actions from each start, drawn by its seed."""
        seeds, drawn = list(starts), list[list[Any]]()
        for start in seeds:
            self.space.seed(start)
            drawn.append([self.space.sample() for _ in range(self.horizon)])
        return self.played(np.array(seeds), np.array(drawn))

    def episodes(self, starts: Ints, choose: Choose, most: int | None = None) -> list[Shown]:
        """Play episodes side by side, of at most so many steps."""
        batch, ended, steps = self.open(len(starts)), dict[int, tuple[int, str]](), list[Step]()
        observed, begun = batch.reset(starts.tolist())
        for step in range(min(self.horizon, most or self.horizon)):
            now = batch.step(choose(step, observed, ended))
            steps.append(now)
            observed = now.observed
            if now.ended:
                ended = {**{k: (step + 1, how) for k, how in now.ended.items()}, **ended}
                if len(ended) == len(starts):
                    break
        taken = np.array([it.taken for it in steps])
        paid, told = (np.array([getattr(it, name) for it in steps], np.float64) for name in ("paid", "told"))
        shown = []
        for k, (start, seen) in enumerate(zip(starts.tolist(), zip(begun, *(it.kept for it in steps)))):  # noqa: B905
            length, how = ended.get(k, (len(steps), "cut"))
            self.taken += length * self.period
            of, saw = paid[:length, k], told[:length, k]
            if not is_countable(of).all():
                raise SimulationDiverged(f"the reward pays {UNCOUNTABLE}, in the episode of start {start}")
            terms = {name: of[:, 1 + at] for at, name in enumerate(self.terms)} or {REWARD: of[:, 0]}
            measures = {name: saw[:, at] for at, name in enumerate(self.measures)}
            shown.append(
                Shown(start, taken[:length, k], of[:, 0], terms, self.successes(saw), measures, how, seen[: length + 1])
            )
        return shown

    def _following(self, policy: Act) -> Choose:
        still = np.zeros(self.space.shape or (), self.space.dtype)
        return lambda _, seen, ended: [still if k in ended else policy(it) for k, it in enumerate(seen)]

    def played(self, starts: Ints, actions: Actions) -> list[Shown]:
        """Play n episodes of given actions, and keep everything but what an arm is drawn from; see `play`."""
        return [
            it
            for some in self._parts(starts)
            for it in self.episodes(starts[some], lambda step, *_, some=some: actions[some, step])
        ]

    def _parts(self, starts: Sequence[int] | Ints) -> list[slice]:
        return [slice(at, min(at + self.together, len(starts))) for at in range(0, len(starts), self.together)]

    def _outcomes(self, shown: Sequence[Shown]) -> Outcomes:
        near, steps = [self.nearest(it) for it in shown], np.array([len(it.paid) for it in shown])
        begins, paid = np.cumsum(steps) - steps, np.concatenate([it.paid for it in shown])
        return Outcomes(
            steps,
            sums_from(begins, paid),
            sums_from(begins, paid, self.gamma),
            np.array([it.success[-1] for it in shown]),
            np.array([since(it.success) if it.success[-1] else self.horizon for it in shown]),
            np.array([it.success.mean() for it in shown]),
            np.array([nearest for nearest, _ in near]),
            {name: np.array([it.measures[name][-1] for it in shown]) for name in self.measures},
            [trail for _, trails in near for trail in trails],
        )
