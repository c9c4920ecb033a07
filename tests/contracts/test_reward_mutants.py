"""Every reward check has a broken reward that fails it, and no other."""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from harness.reward import Array, Carry, Sample, Steps
from harness.reward.forms import reward_class
from harness_plugins.kit import REWARD_CHECKS, rewards, violations
from harness_plugins.kit.trainings import NegativeDistance


@dataclass
class Thawed:
    """Its parameters can be changed while it runs."""

    def initial_carry(self, begin_distance: Array) -> Carry:
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        return carry, -sample.distance


@dataclass(frozen=True)
class SetUpWithASet(NegativeDistance):
    """JSON knows no sets."""

    zones: frozenset[int] = frozenset({1})


class PaysWholeNumbers(NegativeDistance):
    """Values are integers."""

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        return carry, sample.distance.__array_namespace__().where(sample.delta_distance > 0.0, -1, 1)


class TakesTheRootOfALoss(NegativeDistance):
    """Farther away than in the beginning, there is no number to pay."""

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        return carry, sample.distance.__array_namespace__().sqrt(sample.begin_distance - sample.distance)


class DividesByNothing(NegativeDistance):
    """Coming from the target, the relative loss has no bound."""

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        return carry, (sample.previous_distance - sample.distance) / sample.previous_distance


class UpdatesTheBest(NegativeDistance):
    """It does what the environment does, a step too early."""

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        best = sample.previous_best
        best += sample.distance.__array_namespace__().minimum(sample.delta_distance, sample.delta_distance * 0.0)
        return carry, -sample.distance


class CountsInItsCarry(NegativeDistance):
    """The carry is changed in place."""

    def initial_carry(self, begin_distance: Array) -> Carry:
        return begin_distance * 0.0

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        carry += 1.0
        return carry, -sample.distance


class GetsTired(NegativeDistance):
    """It pays less with every episode."""

    episodes = 0

    def initial_carry(self, begin_distance: Array) -> Carry:
        object.__setattr__(self, "episodes", self.episodes + 1)
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        return carry, -sample.distance - 1e-3 * self.episodes


class RemembersOnSelf(NegativeDistance):
    """The last distance is kept on the reward instead of in the carry."""

    def initial_carry(self, begin_distance: Array) -> Carry:
        object.__setattr__(self, "last", begin_distance)
        return begin_distance

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        last = self.last
        object.__setattr__(self, "last", sample.distance)
        return sample.distance, last - sample.distance


class CarriesOneNumber(NegativeDistance):
    """All envs share an entry of the carry."""

    def initial_carry(self, begin_distance: Array) -> Carry:
        return (begin_distance.__array_namespace__().zeros(1),)

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        return (carry[0] + 1.0,), -sample.distance


class ComparesEnvs(NegativeDistance):
    """It pays the distance to the mean of the batch."""

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        return carry, sample.distance.__array_namespace__().mean(sample.distance) - sample.distance


class UsesNumpy(NegativeDistance):
    """It computes with numpy, whatever it is given."""

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        return carry, np.where(sample.delta_distance > 0.0, -sample.delta_distance, 0.0)


class UsesMethodsOfNumpy(NegativeDistance):
    """It asks an array for a method that only numpy's have."""

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        return carry, -sample.distance.clip(0.0, 1.0)


class UsesNamesOfNumpy(NegativeDistance):
    """It asks a namespace for a function that only numpy's has."""

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        return carry, -sample.distance.__array_namespace__().fmin(sample.distance, sample.begin_distance)


class LooksBeforeItPays(NegativeDistance):
    """It branches on a value."""

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        return carry, -sample.distance if sample.step[0] > 3 else -1.5 * sample.distance


class PaysForTheTarget(NegativeDistance):
    """It pays the event that the task pays."""

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        near = sample.distance.__array_namespace__().where(sample.distance <= 0.05, 1.0, 0.0)
        return carry, near - sample.distance


class PaysTheBatch(NegativeDistance):
    """It sums over the envs."""

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        return carry, -sample.distance.__array_namespace__().sum(sample.distance, axis=0)


class DrawsItsPay(NegativeDistance):
    """It adds noise."""

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        return carry, sample.distance * np.random.default_rng().normal()


class LosesTheNumbersInTime(NegativeDistance):
    """Late in an episode it pays no number."""

    when: ClassVar[int]

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        late = sample.step == self.when
        return carry, sample.distance.__array_namespace__().where(late, sample.distance * np.nan, -sample.distance)


class LosesTheNumbersAtStep37(LosesTheNumbersInTime):
    """In the first half of an episode."""

    when = 37


class LosesTheNumbersAtStep77(LosesTheNumbersInTime):
    """In the second half."""

    when = 77


class Overflows(NegativeDistance):
    """What it adds up leaves the numbers after a thousand steps."""

    def initial_carry(self, begin_distance: Array) -> Carry:
        return begin_distance * 0.0 + 1.0

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        return carry * 2.0, -sample.distance * carry


class CarriesItsHistory(NegativeDistance):
    """Every step adds a column to the carry."""

    def initial_carry(self, begin_distance: Array) -> Carry:
        return begin_distance[:, None]

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        return sample.distance.__array_namespace__().concat([carry, sample.distance[:, None]], axis=1), -sample.distance


class PaysAWholeTerm(NegativeDistance):
    """A term is an integer; the sum of all terms is none."""

    def __call__(self, carry: Carry, sample: Steps) -> tuple[Carry, dict[str, Array]]:
        loss = sample.distance.__array_namespace__().where(sample.delta_distance > 0.0, -1, 0)
        return carry, {"reach": -sample.distance, "loss": loss}


class PaysAnotherTermToSixEnvs(NegativeDistance):
    """Terms depend on the size of the batch."""

    def __call__(self, carry: Carry, sample: Steps) -> tuple[Carry, dict[str, Array]]:
        return carry, {"six" if sample.distance.shape[0] == 6 else "reach": -sample.distance}


class SharesATerm(NegativeDistance):
    """A term is the mean of the batch; another term takes it back, so that each env is paid for itself in all."""

    def __call__(self, carry: Carry, sample: Steps) -> tuple[Carry, dict[str, Array]]:
        mean = sample.distance.__array_namespace__().mean(sample.distance)
        return carry, {"shared": mean, "own": -mean - sample.distance}


class DividesByTheSpeed(NegativeDistance):
    """A step in which no joint moves has no bound."""

    def __call__(self, carry: Carry, sample: Steps) -> tuple[Carry, Array]:
        return carry, sample.distance / (sample.qvel**2).sum(-1)


class ChangesTheActionBefore(NegativeDistance):
    """It writes into what was before the step."""

    def __call__(self, carry: Carry, sample: Steps) -> tuple[Carry, Array]:
        action = sample.before.action
        action *= 0.5
        return carry, -sample.distance


class UsesNumpyOnTheAction(NegativeDistance):
    """It computes with numpy in a term."""

    def __call__(self, carry: Carry, sample: Steps) -> tuple[Carry, dict[str, Array]]:
        return carry, {"reach": -sample.distance, "effort": -np.abs(sample.action).sum(-1)}


class PaysATermAtTimes(NegativeDistance):
    """A term comes late in an episode."""

    def __call__(self, carry: Carry, sample: Steps) -> tuple[Carry, dict[str, Array]]:
        late = {"late": 0.0 * sample.distance} if sample.step[0] > 3 else {}
        return carry, {"reach": -sample.distance, **late}


class PaysAnotherTotal(NegativeDistance):
    """The total is not the sum of the terms."""

    def __call__(self, carry: Carry, sample: Steps) -> tuple[Carry, tuple[Array, dict[str, Array]]]:
        return carry, (sample.distance, {"reach": -sample.distance})


class KeepsEverySample(NegativeDistance):
    """A history that nobody reads."""

    history: ClassVar[list[Sample]] = []

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        self.history.append(sample)
        return carry, -sample.distance


class KeepsAWord(NegativeDistance):
    """Of each step it keeps no more than that there was one; a list would have spare room for a while."""

    history: ClassVar[deque[bool]] = deque()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        self.history.append(True)
        return carry, -sample.distance


class RaisesInTime(NegativeDistance):
    """Late in an episode it raises an exception."""

    def initial_carry(self, begin_distance: Array) -> Carry:
        return begin_distance * 0.0

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        if float(np.asarray(carry).max()) >= 36:
            raise IndexError("no more entries")
        return carry + 1.0, -sample.distance


MUTANTS = {
    LosesTheNumbersAtStep37: rewards.values_are_finite,
    LosesTheNumbersAtStep77: rewards.values_are_finite,
    Overflows: rewards.a_long_episode_is_paid,
    CarriesItsHistory: rewards.a_long_episode_is_paid,
    KeepsEverySample: rewards.nothing_is_kept_of_a_step,
    KeepsAWord: rewards.nothing_is_kept_of_a_step,
    Thawed: rewards.settings_are_frozen,
    SetUpWithASet: rewards.settings_survive_json,
    PaysWholeNumbers: rewards.values_have_one_float_per_env,
    TakesTheRootOfALoss: rewards.values_are_finite,
    DividesByNothing: rewards.values_are_finite_at_the_edges,
    UpdatesTheBest: rewards.arguments_are_left_alone,
    CountsInItsCarry: rewards.arguments_are_left_alone,
    GetsTired: rewards.episodes_do_not_depend_on_one_another,
    RemembersOnSelf: rewards.the_carry_is_all_that_is_remembered,
    CarriesOneNumber: rewards.the_carry_has_one_entry_per_env,
    ComparesEnvs: rewards.a_batch_is_paid_as_its_envs_alone,
    UsesNumpy: rewards.any_array_library_will_do,
    UsesMethodsOfNumpy: rewards.any_array_library_will_do,
    UsesNamesOfNumpy: rewards.any_array_library_will_do,
    LooksBeforeItPays: rewards.any_array_library_will_do,
    PaysForTheTarget: rewards.no_event_is_paid,
    PaysAWholeTerm: rewards.terms_have_one_float_per_env,
    PaysAnotherTermToSixEnvs: rewards.terms_are_the_same_in_every_step,
    SharesATerm: rewards.a_batch_is_paid_as_its_envs_alone,
    DividesByTheSpeed: rewards.values_are_finite_at_the_edges,
    ChangesTheActionBefore: rewards.arguments_are_left_alone,
    UsesNumpyOnTheAction: rewards.any_array_library_will_do,
}

COARSE_MUTANTS = {
    RaisesInTime: rewards.values_are_finite,
    PaysTheBatch: rewards.values_have_one_float_per_env,
    DrawsItsPay: rewards.episodes_do_not_depend_on_one_another,
    PaysATermAtTimes: rewards.terms_are_the_same_in_every_step,
    PaysAnotherTotal: rewards.values_have_one_float_per_env,
}


def usual(step: Steps) -> dict[str, Array]:
    """What people write: methods of arrays, and no numpy."""
    jerk = ((step.action - step.before.action) ** 2).sum(-1)
    return {"reach": -step.distance, "jerk": -0.1 * jerk, "low": -1.0 * step.ground, "high": step.qpos.max(axis=1)}


def with_total(step: Steps) -> tuple[Array, dict[str, Array]]:
    """A total beside its terms."""
    terms = {"reach": -step.distance, "speed": -0.1 * (step.qvel**2).mean(-1)}
    return terms["reach"] + terms["speed"], terms


def with_numpy(step: Steps) -> Array:
    """A function of numpy on an array of it."""
    return np.exp(-step.distance)


def of_seven_joints(step: Steps) -> Array:
    """For an arm that has a seventh joint."""
    return -(step.qpos[:, 6] ** 2)


@pytest.fixture(autouse=True)
def forget() -> Iterator[None]:
    """Give back what the mutants keep, also in tests of others: a long list has room for many a step."""
    for mutant in (KeepsEverySample, KeepsAWord):
        mutant.history.clear()
    yield
    for mutant in (KeepsEverySample, KeepsAWord):
        mutant.history.clear()


def failing(mutant: type) -> list[str]:
    """Names of the checks that a mutant fails."""
    return [violation.check for violation in violations(REWARD_CHECKS, mutant())]


def test_mutant_fails_one_check(subtests: pytest.Subtests):
    """A reward that is broken in one way fails the check of that fact, and no other."""
    for mutant, check in MUTANTS.items():
        with subtests.test(mutant=mutant, check=check):
            assert failing(mutant) == [check.name]


@pytest.mark.parametrize(("mutant", "check"), COARSE_MUTANTS.items())
def test_coarse_mutant_fails_its_check(mutant: type, check: Callable[..., None]):
    """A reward that is broken in many ways fails, among others, the check that is nearest."""
    assert check.name in failing(mutant)


@pytest.mark.parametrize("function", [usual, with_total, of_seven_joints])
def test_a_plain_function_keeps_the_contract(function: Callable[..., object]):
    """And nothing warns of it."""
    assert failing(reward_class(function)) == []
    assert list(violations(rewards.REWARD_WARNINGS, reward_class(function)())) == []


def test_numpy_in_a_plain_function_is_a_warning():
    """It trains as it is; the sentence of the check says what JAX needs."""
    reward = reward_class(with_numpy)
    assert failing(reward) == []
    (warning,) = violations(rewards.REWARD_WARNINGS, reward())
    assert (warning.check, warning.level) == ("reward-numpy", "warning")
    assert "__array_namespace__()" in rewards.a_plain_function_works_with_any_array_library.fact


def test_numpy_in_a_class_is_no_warning():
    """It is an error, see the mutants."""
    assert list(violations(rewards.REWARD_WARNINGS, UsesNumpy())) == []


def test_every_check_has_a_mutant():
    """No check is without a reward that fails it alone."""
    assert set(MUTANTS.values()) == set(REWARD_CHECKS)
