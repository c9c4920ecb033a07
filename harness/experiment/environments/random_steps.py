"""Random actions in an env, and what its rewards and measures say of each step."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from harness.environment import AnyEnv
from harness.experiment.environments.spaces import flat_observation
from harness.recorder.column import Column
from harness.recorder.guard import Guard, Step


class RandomStep(NamedTuple):
    """One step of an env.

    Attributes:
        done: Steps up to and with this one, in all episodes.
        number: Of this step in its episode, from 1.
        before: The observation before it; this and the next three are copies that nobody can write into.
        action: What was done.
        after: The observation after it.
        info: What the env told.
        paid: What it paid.
        ended: Whether the episode ended with it.
        numbers: The observation in one row, and what the env paid.
        guard: Asks rewards and measures about it.
    """

    done: int
    number: int
    before: Any
    action: Any
    after: Any
    info: Any
    paid: Any
    ended: bool
    numbers: list[float]
    guard: Guard

    @property
    def given(self) -> Step:
        """What functions are given of it."""
        return self.before, self.action, self.after, self.info


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
        after, ended = guard.seal(observation), bool(terminated or truncated)
        numbers = [*flat_observation(env.observation_space, after).tolist(), float(paid)]
        seen = before, guard.seal(action), after, guard.seal(info)
        yield RandomStep(done, number, *seen, paid, ended, numbers, guard)
        before = after
        if ended or done == cut_at:
            before, number = _begin(env, columns, guard), 0


def value_of(column: Column, step: RandomStep) -> Any:
    """What a reward or a measure says of a step, as it says it; None of a key that info does not have."""
    if column.is_own:
        return step.paid
    if column.key is not None:
        return step.info.get(column.key)
    return step.guard.answer(column.measures[0], step.given)


def _begin(env: AnyEnv, columns: Sequence[Column], guard: Guard, seed: int | None = None) -> Any:
    """Begin an episode; returns the first observation."""
    observation, _ = env.reset(seed=seed)
    for column in columns:
        if column.remembers:
            guard.answer(column.measures[0].reset, ())  # type: ignore[attr-defined] # it remembers
    return guard.seal(observation)
