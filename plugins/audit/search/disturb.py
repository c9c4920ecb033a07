"""Whether what a search found is a knife's edge: behaviours again, while their actions are disturbed."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

import gymnasium
import numpy as np

from harness import Float
from harness.payoff.rollout import FRAGILE, NOISE, ROBUST

from .behaviour import Behaviour, Role
from .finding import Disturbed
from .judge import Case
from .world import Act, Actions, Outcomes, Rng, Shown, Space, World

NOISES = (0.01, NOISE)
"""Standard deviations as shares of half the range of actions; of choices, chances that another one is taken."""
EPISODES = 32
"""So many disturbed episodes of a behaviour tell its mean pay well enough beside a margin."""


Acting: TypeAlias = tuple[Act, Sequence[int]]
"""A policy and the starts that it acts from."""


def disturb(world: World, asked: Sequence[tuple[Behaviour, float, Acting | None]], rng: Rng) -> Float:
    """What `EPISODES` disturbed episodes of each behaviour come to; those of bare sequences are played side by side.

    Where an episode ended before the horizon and a disturbed one does not, it rests, see `rested`.

    Args:
        world: Where.
        asked: Behaviours, each with its noise, see `NOISES`. Its actions are taken on its start, whatever is observed,
            unless there is a policy, which acts from starts of its own.
        rng: Draws the noise.

    Returns:
        What they are paid, the same discounted, and whether they succeed, (asked, 3, EPISODES).
    """
    found, bare = np.empty((len(asked), 3, EPISODES)), dict[int, Actions]()
    for row, (behaviour, noise, acting) in enumerate(asked):
        if acting is None:
            whole = np.repeat(rested(world, behaviour.actions)[np.newaxis], EPISODES, axis=0)
            bare[row] = disturbed_actions(world.space, whole, noise, rng)
            continue
        act, starts = acting
        outcomes, _ = world.act(
            np.resize(np.array(starts), EPISODES),
            lambda seen, act=act, noise=noise: disturbed_actions(world.space, act(seen), noise, rng),  # type: ignore[misc]
        )
        found[row] = _sums(outcomes)
    if bare:
        begun = np.repeat([asked[row][0].start for row in bare], EPISODES)
        came = _sums(world.play(begun, np.concatenate([*bare.values()])))
        found[[*bare]] = came.reshape(3, -1, EPISODES).swapaxes(0, 1)
    return found


def _sums(outcomes: Outcomes) -> Float:
    return np.stack([outcomes.paid, outcomes.discounted, outcomes.success])


def disturbed_actions(space: Space, actions: Actions, noise: float, rng: Rng) -> Actions:
    """The actions, normal noise of `noise` times half the range added and clipped; of choices, some are others.

    An action without bounds has the range 2.
    """
    given = np.asarray(actions)
    if isinstance(space, gymnasium.spaces.Discrete):
        size = given.shape or None  # one choice: several times as fast as a shape of none, and drawn alike
        other = rng.integers(1, max(int(space.n), 2), size)
        others = (given - space.start + other) % space.n + space.start
        return np.where(rng.random(size) < noise, others, given)
    width = space.high - space.low
    half = np.where(np.isfinite(width), width, 2.0) / 2.0
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


def paid_at(world: World, episodes: Iterable[Behaviour | Shown]) -> list[float]:
    """What the actions of episodes are paid in a world that may go on for longer than they do."""
    starts, actions = zip(*((it.start, rested(world, it.actions)) for it in episodes), strict=True)
    paid: list[float] = world.play(np.array(starts), np.stack(actions)).paid.tolist()
    return paid


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
    asked = [(behaviour, noise, acts.get(role)) for role, behaviour in shown.items() for noise in NOISES]
    means, rows = iter(disturb(world, asked, rng).mean(axis=2).tolist()), list[Disturbed]()
    for role, behaviour in shown.items():
        rows.append(Disturbed(role, 0.0, behaviour.paid, float(behaviour.success), 1))
        for noise in NOISES:
            paid, _, success = next(means)
            rows.append(Disturbed(role, noise, paid, success, EPISODES))
    return tuple(rows)


def strength_of(
    world: World, alarmed: Sequence[tuple[Case, Mapping[Role, Acting]]], rng: Rng
) -> tuple[str, int, list[float]]:
    """Whether an alarm is a knife's edge: whether it stands while actions are disturbed as much as is tried.

    Args:
        world: Where.
        alarmed: The cases of an alarm, with the policies of behaviours that have one.
        rng: Draws the noise.

    Returns:
        `ROBUST` or `FRAGILE`; on how many starts it stands; what tempts is paid then, on average over these starts, and
        what it is compared with.
    """
    asked = [
        (case.three[role], NOISES[-1], acts.get(role))
        for case, acts in alarmed
        for role in (case.tempting, case.against)
    ]
    means, paid, stands = disturb(world, asked, rng).mean(axis=2).reshape(-1, 2, 3), list[Float](), 0
    for of, (case, _) in zip(means, alarmed, strict=True):
        paid.append(of[:, int(case.discount != 1.0)])
        stands += bool(paid[-1][0] > paid[-1][1] + case.margin)
    return ROBUST if 2 * stands >= len(alarmed) else FRAGILE, stands, np.mean(paid, axis=0).tolist()
