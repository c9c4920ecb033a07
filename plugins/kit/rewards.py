"""What a reward must satisfy. Each check takes the reward."""

import copy
from collections.abc import Iterator

import numpy as np

from harness.reward import Array, Carry, Paid, Reward, Steps
from harness.reward.forms import is_plain_function
from harness.reward.steps import map_steps, rows_of

from .contract import check, require, settings_are_frozen, settings_survive_json
from .memory import require_nothing_kept
from .reward_samples import (
    HORIZON,
    NUM_ENVS,
    StandardArray,
    edge_samples,
    joints_of,
    pay,
    play,
    random_samples,
    sample_of,
    samples_for,
    state_at,
    values_of,
)

STEPS = 5_000
"""The steps of an episode of the longest built-in task, ``unity-reach``."""
EPISODES = 10


@check("reward-long-run")
def a_long_episode_is_paid(reward: Reward) -> None:
    """In an episode of 5,000 steps every value is finite, and the carry stays as large as it was in the beginning."""
    samples = samples_for(reward, 0, steps=STEPS)
    carries, paid = play(reward, samples[:HORIZON])
    carry, size = carries[-1], _bytes_of(carries[-1])
    is_known = not all(np.isfinite(value).all() for of in paid for value in values_of(of).values())  # another check's
    for step, sample in enumerate(samples[HORIZON:], HORIZON + 1):
        carry, of = pay(reward, carry, sample)
        for name, value in values_of(of).items():
            require(is_known or np.isfinite(value).all(), "{} of step {} is {}", name, f"{step:,}", value)
    grown = _bytes_of(carry)
    require(grown <= size, f"the carry has {size} bytes after {HORIZON} steps, {grown} after {STEPS:,}: it grows")


@check("reward-leak")
def nothing_is_kept_of_a_step(reward: Reward) -> None:
    """Only the carry remembers a step: the memory that the reward takes does not grow from episode to episode."""
    joints = joints_of(reward)

    def play_episodes() -> None:
        for seed in range(EPISODES):
            play(reward, random_samples(seed, steps=HORIZON, joints=joints))

    require_nothing_kept(play_episodes, EPISODES * HORIZON, "steps")


def _bytes_of(carry: Carry) -> int:
    return sum(np.asarray(array).nbytes for array in _arrays(carry))


BONUS = 0.5
"""Half of what the task pays for an event: a jump of the value by more is an event's."""


@check("reward-shape")
def values_have_one_float_per_env(reward: Reward) -> None:
    """The value of a step has the shape (num_envs,), also for one env, and is a float."""
    for num_envs in (1, NUM_ENVS):
        for paid in play(reward, samples_for(reward, 0, num_envs))[1]:
            _require_floats("the value", paid.total, num_envs)


@check("reward-terms-float")
def terms_have_one_float_per_env(reward: Reward) -> None:
    """So has each of its terms, if it has some; one that is a plain number is paid to every env."""
    for num_envs in (1, NUM_ENVS):
        for paid in play(reward, samples_for(reward, 0, num_envs))[1]:
            for name, value in paid.terms.items():
                _require_floats(f"the term '{name}'", value, num_envs)


@check("reward-terms")
def terms_are_the_same_in_every_step(reward: Reward) -> None:
    """A reward pays the same terms, in the same order, in every step: each is recorded in a column."""
    played = (samples_for(reward, 0, 1), samples_for(reward, 1, steps=HORIZON), edge_samples(joints_of(reward)))
    names = [tuple(paid.terms) for samples in played for paid in play(reward, samples)[1]]
    for other in names:
        told, first = (", ".join(each) or "none" for each in (other, names[0]))
        require(
            other == names[0], f"a step pays the terms {told}, and the first one {first}: pay 0 where it is nothing"
        )


@check("reward-finite")
def values_are_finite(reward: Reward) -> None:
    """No value is NaN or infinite in random episodes of 100 steps, which is as long as the default task's may be."""
    for seed in range(10):
        _require_finite(reward, samples_for(reward, seed, steps=HORIZON))


@check("reward-finite-edges")
def values_are_finite_at_the_edges(reward: Reward) -> None:
    """No value is NaN or infinite where a distance or a gain is exactly 0, or nothing moves."""
    _require_finite(reward, edge_samples(joints_of(reward)))


@check("reward-arguments")
def arguments_are_left_alone(reward: Reward) -> None:
    """Neither the steps nor the carry are changed: the environment owns them and goes on with them."""
    samples = samples_for(reward, 0)
    carry = reward.initial_carry(samples[0].begin_distance)
    for steps in samples:
        steps_before, carry_before = map_steps(np.array, steps), copy.deepcopy(carry)
        after, _ = pay(reward, carry, steps)
        for (name, old), (_, new) in zip(_fields(steps_before), _fields(steps), strict=True):
            require(_equal(old, new), "{} was changed from {} to {}", name, old, new)
        same = all(_equal(old, new) for old, new in zip(_arrays(carry_before), _arrays(carry), strict=True))
        require(same, "the carry was changed in place from {} to {}", carry_before, carry)
        carry = after


@check("reward-episodes")
def episodes_do_not_depend_on_one_another(reward: Reward) -> None:
    """An episode is paid the same whatever was scored before: only the carry remembers anything."""
    samples = samples_for(reward, 0)
    first = play(reward, samples)[1]
    play(reward, samples_for(reward, 1, num_envs=2))
    for known, again in zip(first, play(reward, samples)[1], strict=True):
        require(_pays_equal(known, again), "the same episode was paid differently the second time")


@check("reward-memory")
def the_carry_is_all_that_is_remembered(reward: Reward) -> None:
    """The same carry and steps are always paid the same, in whatever order they come."""
    samples = samples_for(reward, 0)
    carries, paid = play(reward, samples)
    for step in reversed(range(len(samples))):
        _, again = pay(reward, carries[step], samples[step])
        told = "step {} is paid {} when asked again, not {}"
        require(_pays_equal(again, paid[step]), told, step, again.total, paid[step].total)


@check("reward-carry-shape")
def the_carry_has_one_entry_per_env(reward: Reward) -> None:
    """The carry is an array with a leading num_envs axis, or a tuple of such, or ``()``, at every step."""
    for num_envs in (1, NUM_ENVS):
        for carry in play(reward, samples_for(reward, 0, num_envs))[0]:
            for array in _arrays(carry):
                shape = getattr(array, "shape", None)
                require(shape and shape[0] == num_envs, f"the carry of {num_envs} envs has a part of shape {shape}")


@check("reward-batch-as-alone")
def a_batch_is_paid_as_its_envs_alone(reward: Reward) -> None:
    """Each env of a batch is paid as if it were alone, by every term."""
    samples = samples_for(reward, 0)
    alone, batch = copy.deepcopy(reward), play(reward, samples)[1]
    for env in range(NUM_ENVS):
        one = play(copy.deepcopy(alone), [rows_of(steps, slice(env, env + 1)) for steps in samples])[1]
        for together, apart in zip(batch, one, strict=True):
            for name, value in values_of(apart).items():
                of_batch = values_of(together)[name][env]
                told = "{} of env {} is {}, alone {}"
                require(_near(value[0], of_batch), told, name, env, of_batch, value[0])


@check("reward-array-library")
def any_array_library_will_do(reward: Reward) -> None:
    """Arrays of another library give the same values: the reward uses their namespace and the standard's names."""
    if not is_plain_function(reward):
        _require_any_library(reward)


@check("reward-numpy", "warning")
def a_plain_function_works_with_any_array_library(reward: Reward) -> None:
    """A plain function works with JAX if xp = step.distance.__array_namespace__(), and xp.exp stands for np.exp.

    Training and scores need numpy alone, so this is a warning.
    """
    if is_plain_function(reward):
        _require_any_library(reward)


@check("reward-no-event")
def no_event_is_paid(reward: Reward) -> None:
    """The value never jumps while the arm comes nearer: the task pays for reaching the target, apart from it."""
    distances = np.linspace(0.01, 0.4, 391)
    values = _values_at(reward, distances)
    for index in np.flatnonzero(np.abs(np.diff(values)) > BONUS):
        jump = _jump_between(reward, distances[index], distances[index + 1])
        require(jump <= BONUS, f"the value jumps by {jump:.2g} near a distance of {distances[index]:.3f} m")


REWARD_CHECKS = (
    settings_are_frozen,
    settings_survive_json,
    values_have_one_float_per_env,
    terms_have_one_float_per_env,
    terms_are_the_same_in_every_step,
    values_are_finite,
    values_are_finite_at_the_edges,
    arguments_are_left_alone,
    episodes_do_not_depend_on_one_another,
    the_carry_is_all_that_is_remembered,
    the_carry_has_one_entry_per_env,
    a_batch_is_paid_as_its_envs_alone,
    any_array_library_will_do,
    no_event_is_paid,
    nothing_is_kept_of_a_step,
    a_long_episode_is_paid,
)
REWARD_WARNINGS = (a_plain_function_works_with_any_array_library,)


def _require_floats(name: str, value: Array, num_envs: int) -> None:
    require(np.shape(value) == (num_envs,), f"{name} for {num_envs} envs has shape {np.shape(value)}")
    require(value.dtype.kind == "f", f"{name} is {value.dtype}, not a float")


def _require_finite(reward: Reward, samples: list[Steps]) -> None:
    for step, (sample, paid) in enumerate(zip(samples, play(reward, samples)[1], strict=True), 1):
        for name, value in values_of(paid).items():
            told = "{} is {} at distances {} m, step {}"
            require(np.isfinite(value).all(), told, name, value, sample.distance, step)


def _require_any_library(reward: Reward) -> None:
    samples = samples_for(reward, 0)
    expected = play(copy.deepcopy(reward), samples)[1]
    found = play(reward, [map_steps(StandardArray, steps) for steps in samples])[1]
    for paid, known in zip(found, expected, strict=True):
        for name, value in values_of(paid).items():
            told = f"{name} is a {type(value).__name__}, not an array as was given"
            require(isinstance(value, StandardArray), told)
            wanted = values_of(known)[name]
            require(_near(value.values, wanted), "{} is {}, with numpy {}", name, value.values, wanted)


def _values_at(reward: Reward, distances: Array) -> Array:
    """What the first step of an episode pays that begins at 0.5 m and ends at `distances`, nearer than that."""
    begin, joints = np.full(len(distances), 0.5), joints_of(reward)
    states = state_at(begin, joints, speed=1.0), state_at(distances, joints, speed=1.0)
    return play(reward, [sample_of(*states, begin, begin, 1)])[1][0].total


def _jump_between(reward: Reward, low: float, high: float) -> float:
    """How much of the change between two distances is left when they are brought together around it."""
    for _ in range(40):
        distances = np.array([low, (low + high) / 2.0, high])
        changes = np.abs(np.diff(_values_at(reward, distances)))
        low, high = distances[:2] if changes[0] > changes[1] else distances[1:]
    return float(changes.max())


def _arrays(carry: Carry) -> Iterator[Array]:
    """The arrays of a carry."""
    if isinstance(carry, tuple):
        for part in carry:
            yield from _arrays(part)
    else:
        yield carry


def _fields(steps: Steps) -> Iterator[tuple[str, Array]]:
    """Names and arrays of the fields of steps, and of those of what was before."""
    for name, value in steps._asdict().items():
        if isinstance(value, tuple):
            yield from ((f"{name}.{field}", array) for field, array in _fields(value))
        else:
            yield name, value


def _pays_equal(one: Paid, other: Paid) -> bool:
    first, second = values_of(one), values_of(other)
    return first.keys() == second.keys() and all(_equal(value, second[name]) for name, value in first.items())


def _near(value: Array, known: Array) -> bool:
    return np.allclose(value, known, rtol=1e-12, equal_nan=True)


def _equal(first: Array, second: Array) -> bool:
    return np.array_equal(first, second, equal_nan=True)
