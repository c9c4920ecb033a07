"""Where a search plays: an arm's task or anybody's environment, begun by a seed, moved by actions, paid by one reward.

A search knows nothing else of either. It needs ``reset(seed)`` and ``step`` alone.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeAlias

import gymnasium
import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Ints, Mask

Actions: TypeAlias = NDArray[Any]
"""Those of one episode: (steps, action_size) inside the box, or (steps,) of choices."""
Space: TypeAlias = gymnasium.spaces.Box | gymnasium.spaces.Discrete
"""The space of one action."""
Rng: TypeAlias = np.random.Generator
Data: TypeAlias = Mapping[str, Any]
"""Plain data, as JSON has it: a policy, by its kind; a part of a certificate."""
Act: TypeAlias = Callable[[Any], Any]
"""A policy: from an observation, as the world gives it, to one action."""


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
            world gives it, (steps + 1); none where a world keeps none.
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


def since(flags: Mask) -> int:
    """The step, from 1, from which on all are True; one more than there are if the last one is not."""
    return int(len(flags) - np.append(flags[::-1], False).argmin() + 1)


class World(Protocol):
    """One reward in one task or environment. Everything that it does is repeated by the same calls."""

    name: str
    """What it is called: ``gymnasium:id=Pendulum-v1``."""
    reward: str
    """The label of the reward."""
    gamma: float
    """The learner's discount per step, in (0, 1]."""
    horizon: int
    """The most steps of an episode."""
    notes: Sequence[str]
    """Sentences that a reader of the answer has to know: what was taken for success, where episodes are cut."""
    together: int
    """How many episodes are played side by side in hardly more time than one."""
    taken: int
    """Steps taken so far; a search's budget is counted in these."""

    @property
    def space(self) -> Space:
        """The space of one action."""

    @property
    def observes(self) -> gymnasium.Space[Any]:
        """The space of what policies are given."""

    @property
    def success(self) -> str:
        """What tells success, as a user types it: ``success``, ``height>0.9``; empty if nothing does."""

    @property
    def directions(self) -> Mapping[str, int]:
        """By name, of the measures of which that is known: 1 where more is better, -1 where less is."""

    @property
    def is_repeated(self) -> bool:
        """Whether the same start and actions bring the same steps and the same pay, bit for bit; it was tried."""

    def play(self, starts: Ints, actions: Actions) -> Outcomes:
        """Play n episodes of given actions.

        Args:
            starts: The seed of each one's reset, (n,).
            actions: (n, horizon, action_size), or (n, horizon) of choices.
        """

    def act(self, starts: Ints, policy: Act) -> tuple[Outcomes, list[Actions]]:
        """Play n episodes of a policy; also returns the actions that it took, of each episode."""

    def show(self, start: int, actions: Actions) -> Shown:
        """Play one episode and keep everything."""

    def watch(self, start: int, policy: Act) -> Shown:
        """Play one episode of a policy and keep everything, what it observed too; tables are learnt of this."""

    def close(self) -> None:
        """Close what it plays in."""
