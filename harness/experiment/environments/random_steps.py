"""Random actions in an env, and what its rewards and measures say of each step."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from harness.environment import AnyEnv
from harness.experiment.environments.spaces import flat_observation
from harness.recorder.column import Column
from harness.recorder.guard import Guard
from harness.reward import Steps
from harness.reward.given import Before, Now, told_under, zeros_of


class RandomStep(NamedTuple):
    """One step of an env.

    Attributes:
        done: Steps up to and with this one, in all episodes.
        number: Of this step in its episode, from 1.
        seen: It as functions are given it, `harness.reward.given.Now`: copies that nobody can write into.
        paid: What it paid.
        ended: Whether the episode ended with it.
        numbers: The observation in one row, and what the env paid.
        guard: Asks rewards and measures about it.
    """

    done: int
    number: int
    seen: Steps
    paid: Any
    ended: bool
    numbers: list[float]
    guard: Guard


def random_steps(
    env: AnyEnv, seed: int, count: int, columns: Sequence[Column] = (), cut_at: int = 0
) -> Iterator[RandomStep]:
    """So many steps of random actions, in as many episodes as that takes.

    Rewards and measures with a memory are begun with each episode. Ask them by `value_of` before the next step.

    Args:
        env: Makes the steps.
        seed: Of the first episode and of the actions.
        count: How many steps.
        columns: The rewards and measures.
        cut_at: After so many steps another episode begins.
    """
    guard = Guard()
    before, number = _begin(env, columns, guard, seed), 0
    env.action_space.seed(seed)
    for done in range(1, count + 1):
        action, number = env.action_space.sample(), number + 1
        observation, paid, terminated, truncated, info = env.step(action)
        ended, sealed = bool(terminated or truncated), map(guard.seal, (observation, action, info))
        if number == 1:
            before = before._replace(action=zeros_of(guard.seal(action)))
        seen = Now._make((*sealed, before))
        numbers = [*flat_observation(env.observation_space, seen.observation).tolist(), float(paid)]
        yield RandomStep(done, number, seen, paid, ended, numbers, guard)
        before = Before._make(seen[:-1])
        if ended or done == cut_at:
            before, number = _begin(env, columns, guard), 0


def value_of(column: Column, step: RandomStep) -> Any:
    """What a reward or a measure says of a step, as it says it.

    Raises:
        Untold: It is a key that info does not have.
    """
    if column.is_own:
        return step.paid
    if column.key is not None:
        return told_under(step.seen.info, column.key)
    return step.guard.answer(column.measures[0], column.arguments(step.seen))


def _begin(env: AnyEnv, columns: Sequence[Column], guard: Guard, seed: int | None = None) -> Steps:
    """Begin an episode; returns what there is before its first step, whose action is not known yet."""
    observation, info = env.reset(seed=seed)
    for column in columns:
        if column.remembers:
            guard.answer(column.measures[0].reset, ())
    return Before._make((guard.seal(observation), None, guard.seal(info)))
