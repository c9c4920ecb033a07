"""Random actions in an env, and what its rewards and measures say of each step."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from harness.environment import AnyEnv
from harness.experiment.environments.spaces import flat_observation
from harness.recorder.column import Column
from harness.recorder.recorder import kept


class RandomStep(NamedTuple):
    """One step of an env.

    Attributes:
        done: Steps up to and with this one, in all episodes.
        number: Of this step in its episode, from 1.
        before: The observation before it.
        action: What was done.
        after: The observation after it.
        paid: What the env paid.
        info: What it told beside that.
        ended: Whether the episode ended with it.
        numbers: The observation in one row, and what the env paid.
    """

    done: int
    number: int
    before: Any
    action: Any
    after: Any
    paid: Any
    info: Any
    ended: bool
    numbers: list[float]


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
    before, number = _begin(env, columns, seed), 0
    env.action_space.seed(seed)
    for done in range(1, count + 1):
        action, number = env.action_space.sample(), number + 1
        observation, paid, terminated, truncated, info = env.step(action)
        after, ended = kept(observation), bool(terminated or truncated)
        numbers = [*flat_observation(env.observation_space, after).tolist(), float(paid)]
        yield RandomStep(done, number, before, action, after, paid, info, ended, numbers)
        before = after
        if ended or done == cut_at:
            before, number = _begin(env, columns), 0


def value_of(column: Column, step: RandomStep) -> Any:
    """What a reward or a measure says of a step, as it says it; None of a key that info does not have."""
    if column.is_own:
        return step.paid
    if column.key is not None:
        return step.info.get(column.key)
    return column.measures[0](step.before, step.action, step.after, step.info)


def _begin(env: AnyEnv, columns: Sequence[Column], seed: int | None = None) -> Any:
    """Begin an episode; returns the first observation."""
    observation, _ = env.reset(seed=seed)
    for column in columns:
        if column.remembers:
            column.measures[0].reset()  # type: ignore[attr-defined] # it remembers
    return kept(observation)
