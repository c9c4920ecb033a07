"""What a reward must satisfy. Each check takes the reward."""

import copy
from collections.abc import Iterator

import numpy as np

from harness.reward import Array, Carry, Reward, Sample
from harness.testing.rewards.long_episodes import a_long_episode_is_paid, nothing_is_kept_of_a_step
from harness.testing.rewards.samples import HORIZON, NUM_ENVS, edge_samples, pay, play, random_samples, sample_of
from harness.testing.rewards.standard_array import StandardArray
from harness.testing.violations import Check, check, raise_first, require, settings_are_frozen, settings_survive_json

BONUS = 0.5
"""Half of what the task pays for an event: a jump of the value by more is an event's."""


def check_reward(reward: Reward) -> None:
    """Run all `REWARD_CHECKS`.

    Raises:
        ContractViolation: At the first check that fails.
    """
    raise_first(REWARD_CHECKS, reward)


@check("reward-shape")
def values_have_one_float_per_env(reward: Reward) -> None:
    """The value of a step has the shape (num_envs,), also for one env, and is a float."""
    for num_envs in (1, NUM_ENVS):
        for value in play(reward, random_samples(0, num_envs))[1]:
            require(value.shape == (num_envs,), f"the value for {num_envs} envs has shape {value.shape}")
            require(value.dtype.kind == "f", f"the value is {value.dtype}, not a float")


@check("reward-finite")
def values_are_finite(reward: Reward) -> None:
    """No value is NaN or infinite in random episodes of 100 steps, which is as long as the default task's may be."""
    for seed in range(10):
        _require_finite(reward, random_samples(seed, steps=HORIZON))


@check("reward-finite-edges")
def values_are_finite_at_the_edges(reward: Reward) -> None:
    """No value is NaN or infinite where a distance or a gain is exactly 0."""
    _require_finite(reward, edge_samples())


@check("reward-arguments")
def arguments_are_left_alone(reward: Reward) -> None:
    """Neither the sample nor the carry is changed: the environment owns them and goes on with them."""
    samples = random_samples(0)
    untouched = copy.deepcopy(samples)
    carry = reward.initial_carry(samples[0].begin_distance)
    for sample, before in zip(samples, untouched, strict=True):
        carry_before = copy.deepcopy(carry)
        after, _ = pay(reward, carry, sample)
        for name, old, new in zip(Sample._fields, before, sample, strict=True):
            require(_equal(old, new), "{} was changed from {} to {}", name, old, new)
        require(_same(carry_before, carry), "the carry was changed in place from {} to {}", carry_before, carry)
        carry = after


@check("reward-episodes")
def episodes_do_not_depend_on_one_another(reward: Reward) -> None:
    """An episode is paid the same whatever was scored before: only the carry remembers anything."""
    first = play(reward, random_samples(0))[1]
    play(reward, random_samples(1, num_envs=2))
    again = play(reward, random_samples(0))[1]
    require(_equal(first, again), "the same episode was paid differently the second time")


@check("reward-memory")
def the_carry_is_all_that_is_remembered(reward: Reward) -> None:
    """The same carry and sample are always paid the same, in whatever order they come."""
    samples = random_samples(0)
    carries, values = play(reward, samples)
    for step in reversed(range(len(samples))):
        _, value = pay(reward, carries[step], samples[step])
        require(_equal(value, values[step]), "step {} is paid {} when asked again, not {}", step, value, values[step])


@check("reward-carry-shape")
def the_carry_has_one_entry_per_env(reward: Reward) -> None:
    """The carry is an array with a leading num_envs axis, or a tuple of such, or ``()``, at every step."""
    for num_envs in (1, NUM_ENVS):
        for carry in play(reward, random_samples(0, num_envs))[0]:
            for array in _arrays(carry):
                shape = getattr(array, "shape", None)
                require(shape and shape[0] == num_envs, f"the carry of {num_envs} envs has a part of shape {shape}")


@check("reward-batch-as-alone")
def a_batch_is_paid_as_its_envs_alone(reward: Reward) -> None:
    """Each env of a batch is paid as if it were alone."""
    samples = random_samples(0)
    alone, batch = copy.deepcopy(reward), np.stack(play(reward, samples)[1], axis=-1)
    for env in range(NUM_ENVS):
        one = [Sample(*(part[env : env + 1] for part in sample)) for sample in samples]
        values = np.concatenate(play(copy.deepcopy(alone), one)[1])
        require(
            np.allclose(values, batch[env], rtol=1e-12, equal_nan=True),
            "env {} is paid {}, alone {}",
            env,
            batch[env],
            values,
        )


@check("reward-array-library")
def any_array_library_will_do(reward: Reward) -> None:
    """Arrays of another library give the same values: the reward uses their namespace and the standard's names."""
    samples = random_samples(0)
    expected = play(copy.deepcopy(reward), samples)[1]
    values = play(reward, [Sample(*map(StandardArray, sample)) for sample in samples])[1]
    for value, known in zip(values, expected, strict=True):
        require(isinstance(value, StandardArray), f"the value is a {type(value).__name__}, not an array as was given")
        require(
            np.allclose(value.values, known, rtol=1e-12, equal_nan=True),
            "the value is {}, with numpy {}",
            value.values,
            known,
        )


@check("reward-no-event")
def no_event_is_paid(reward: Reward) -> None:
    """The value never jumps while the arm comes nearer: the task pays for reaching the target, apart from it."""
    distances = np.linspace(0.01, 0.4, 391)
    values = _values_at(reward, distances)
    for index in np.flatnonzero(np.abs(np.diff(values)) > BONUS):
        jump = _jump_between(reward, distances[index], distances[index + 1])
        require(jump <= BONUS, f"the value jumps by {jump:.2g} near a distance of {distances[index]:.3f} m")


REWARD_CHECKS: tuple[Check, ...] = (
    settings_are_frozen,
    settings_survive_json,
    values_have_one_float_per_env,
    values_are_finite,
    values_are_finite_at_the_edges,
    arguments_are_left_alone,
    episodes_do_not_depend_on_one_another,
    the_carry_is_all_that_is_remembered,
    the_carry_has_one_entry_per_env,
    a_batch_is_paid_as_its_envs_alone,
    any_array_library_will_do,
    no_event_is_paid,
    a_long_episode_is_paid,
    nothing_is_kept_of_a_step,
)


def _require_finite(reward: Reward, samples: list[Sample]) -> None:
    for step, (sample, value) in enumerate(zip(samples, play(reward, samples)[1], strict=True), 1):
        require(np.isfinite(value).all(), "the value is {} at distances {} m, step {}", value, sample.distance, step)


def _values_at(reward: Reward, distances: Array) -> Array:
    """What the first step of an episode pays that begins at 0.5 m and ends at `distances`, nearer than that."""
    begin = np.full(len(distances), 0.5)
    return play(reward, [sample_of(begin, begin, begin, distances, 1)])[1][0]


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


def _same(first: Carry, second: Carry) -> bool:
    return all(_equal(old, new) for old, new in zip(_arrays(first), _arrays(second), strict=True))


def _equal(first: Array, second: Array) -> bool:
    return np.array_equal(first, second, equal_nan=True)
