"""Whether what a search found is a knife's edge: behaviours again, while their actions are disturbed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import gymnasium
import numpy as np

from .behaviour import Behaviour, Role
from .finding import FRAGILE, ROBUST, Disturbed
from .judge import Case
from .world import Act, Actions, Outcomes, Rng, Space, World

NOISES = (0.01, 0.05)
"""Standard deviations as shares of half the range of actions; of choices, chances that another one is taken."""
EPISODES = 32
"""So many disturbed episodes of a behaviour tell its mean pay well enough beside a margin."""


class Acting(NamedTuple):
    """A policy and the starts that it acts from."""

    act: Act
    starts: Sequence[int]


def disturb(world: World, behaviour: Behaviour, noise: float, rng: Rng, acting: Acting | None = None) -> Outcomes:
    """What `EPISODES` disturbed episodes of a behaviour come to.

    Where an episode ended before the horizon and a disturbed one does not, it rests, see `rested`.

    Args:
        world: Where.
        behaviour: Its actions are taken, whatever is observed, unless there is a policy.
        noise: See `NOISES`.
        rng: Draws the noise.
        acting: The policy of the behaviour, and where it acts; None of a bare sequence, which is played on its start.
    """
    if acting is not None:
        act, starts = acting.act, np.resize(np.array(acting.starts), EPISODES)
        return world.act(starts, lambda observation: disturbed_actions(world.space, act(observation), noise, rng))[0]
    starts = np.full(EPISODES, behaviour.start, np.int64)
    whole = np.broadcast_to(rested(world, behaviour.actions), (EPISODES, world.horizon, *(world.space.shape or ())))
    return world.play(starts, disturbed_actions(world.space, whole, noise, rng))


def disturbed_actions(space: Space, actions: Actions, noise: float, rng: Rng) -> Actions:
    """The actions, normal noise of `noise` times half the range added and clipped; of choices, some are others.

    An action without bounds has the range 2.
    """
    given = np.asarray(actions)
    if isinstance(space, gymnasium.spaces.Discrete):
        other = rng.integers(1, max(int(space.n), 2), given.shape)
        others = (given - space.start + other) % space.n + space.start
        return np.where(rng.random(given.shape) < noise, others, given)
    bounded = np.isfinite(space.low) & np.isfinite(space.high)
    half = np.where(bounded, np.where(bounded, space.high, 1.0) - np.where(bounded, space.low, -1.0), 2.0) / 2.0
    moved = given + noise * half * rng.standard_normal(given.shape)
    return np.clip(moved, space.low, space.high).astype(space.dtype)


def rested(world: World, actions: Actions) -> Actions:
    """The actions of an episode, (steps, ...), and until the horizon zeros or the last choice again, (horizon, ...)."""
    missing = world.horizon - len(actions)
    if missing <= 0:
        return actions[: world.horizon]
    if isinstance(world.space, gymnasium.spaces.Discrete):
        return np.concatenate([actions, np.repeat(actions[-1:], missing)])
    middle = np.clip(np.zeros(world.space.shape), world.space.low, world.space.high)
    return np.concatenate([actions, np.tile(middle, (missing, 1)).astype(actions.dtype)])


def paid_at(world: World, start: int, actions: Actions) -> float:
    """What actions are paid in a world that may go on for longer than they do."""
    return float(world.play(np.array([start]), rested(world, actions)[np.newaxis]).paid[0])


def noise_curve(
    world: World, shown: Mapping[Role, Behaviour], acts: Mapping[Role, Acting], rng: Rng
) -> tuple[Disturbed, ...]:
    """What behaviours are paid at every noise, from none on.

    Args:
        world: Where.
        shown: By role.
        acts: The policies of those that have one.
        rng: Draws the noise.
    """
    rows = []
    for role, behaviour in shown.items():
        rows.append(Disturbed(role, 0.0, behaviour.paid, float(behaviour.success), 1))
        for noise in NOISES:
            outcomes = disturb(world, behaviour, noise, rng, acts.get(role))
            rows.append(Disturbed(role, noise, float(outcomes.paid.mean()), float(outcomes.success.mean()), EPISODES))
    return tuple(rows)


@dataclass(frozen=True)
class Strength:
    """Whether an alarm stands while actions are disturbed as much as is tried.

    Attributes:
        word: `ROBUST` or `FRAGILE`.
        stands: On so many starts it does.
        count: Of so many.
        tempting: What tempts is paid then, on average over these starts.
        task: What it is compared with is paid, likewise.
    """

    word: str
    stands: int
    count: int
    tempting: float
    task: float


def strength_of(world: World, alarmed: Sequence[tuple[Case, Mapping[Role, Acting]]], rng: Rng) -> Strength:
    """Whether an alarm is a knife's edge.

    Args:
        world: Where.
        alarmed: The cases of an alarm, with the policies of behaviours that have one.
        rng: Draws the noise.
    """
    paid = []
    for case, acts in alarmed:
        roles = case.three.by_role()
        both = [disturb(world, roles[role], NOISES[-1], rng, acts.get(role)) for role in (case.tempting, case.against)]
        paid.append([(of.paid if case.discount == 1.0 else of.discounted).mean() for of in both])
    stands = sum(bool(tempting > task + case.margin) for (tempting, task), (case, _) in zip(paid, alarmed, strict=True))
    word = ROBUST if 2 * stands >= len(alarmed) else FRAGILE
    return Strength(word, stands, len(alarmed), *np.mean(paid, axis=0).tolist())
