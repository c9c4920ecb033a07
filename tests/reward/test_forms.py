"""A plain function of a step as a reward, and what one call of a reward shows."""

import dataclasses
import re

import pytest
from numpy.testing import assert_array_equal

from harness.errors import UsageError
from harness.registry import choose
from harness.reward import pay
from harness.reward.forms import FAILED, STEP, reward_class, takes_alone
from harness.reward.terms import Needs, made_up, needs_of, shown_needs
from harness_plugins.kit.trainings import NegativeDistance
from tests.refusals import refused
from tests.registered import REGISTRY


def gentle(step):
    """Reach the target, and move little."""
    return {"reach": -step.distance, "effort": -0.01 * (step.action**2).sum(-1), "late": -0.1 * step.before.ground}


def dense(step):
    """A number."""
    return -step.distance


def test_a_function_is_a_frozen_dataclass_of_its_weights():
    """So that they are parameters as those of any reward."""
    made = reward_class(gentle)
    assert [(it.name, it.default) for it in dataclasses.fields(made)] == [
        ("reach", 1.0),
        ("effort", 1.0),
        ("late", 1.0),
    ]
    assert made.__doc__ == "Reach the target, and move little."
    with pytest.raises(dataclasses.FrozenInstanceError):
        made().reach = 2.0


def test_a_weight_multiplies_its_term_alone():
    """The others stay to the last bit."""
    plain, heavy = (pay(reward_class(gentle)(**given), (), made_up(6, 6))[1] for given in ({}, {"effort": 5.0}))
    assert_array_equal(heavy.terms["effort"], 5.0 * plain.terms["effort"])
    assert_array_equal(heavy.terms["reach"], plain.terms["reach"])


def test_a_number_has_no_parameters():
    """There is nothing to weigh."""
    assert dataclasses.fields(reward_class(dense)) == ()


def test_the_call_shows_what_is_read_and_paid():
    """Of what was before, with its place."""
    needs = Needs(("action", "before.ground", "distance"), ("reach", "effort", "late"))
    assert needs_of(reward_class(gentle)()) == needs
    assert needs_of(NegativeDistance()) == Needs(("distance",), ())


def test_what_wraps_a_reward_reads_what_that_reads():
    """Rewards that build on another one pass the steps on."""
    built = choose(REGISTRY, "rewards", "scaled:reward=relative").build(REGISTRY, "rewards")
    assert needs_of(built).fields == ("distance", "previous_distance")


def test_what_a_reward_declares_counts_too():
    """What it reads in some steps alone."""

    class Declares(NegativeDistance):
        needs = ("qvel",)

    assert needs_of(Declares()).fields == ("distance", "qvel")


def test_a_function_for_an_arm_of_seven_joints_is_asked_with_seven():
    """Other numbers of joints are tried where nobody says for which arm it is."""

    def seventh(step):
        return {"tip": step.qpos[:, 6]}

    assert needs_of(reward_class(seventh)(), dof=7, action_size=7).terms == ("tip",)


@pytest.mark.parametrize(
    ("function", "told"),
    [
        (lambda step: -step.joint_speed, r"Reward '<lambda>': A step of an arm has no 'joint_speed'.*'qvel'\?"),
        (lambda step: step.before.previous_best, "has no 'before.previous_best'"),
        (lambda step: step.distance.no_such(), "fails on made-up steps of 2 arms: AttributeError"),
        (lambda step: (step.distance, {"a": -step.distance}), "is not the sum"),
    ],
)
def test_a_function_that_cannot_pay_says_why(function, told):
    """To whoever asks for a weight of it; else it fails where it is to pay, so that other candidates go on."""
    made = reward_class(function)
    assert dataclasses.fields(made) == ()
    assert re.search(told, getattr(made, FAILED))
    with pytest.raises((UsageError, AttributeError)):
        needs_of(made())


def test_terms_of_a_reward_that_fails_are_told_by_its_first_real_step():
    """A field that no step has is refused at once."""

    class Fails(NegativeDistance):
        def __call__(self, carry, steps):
            raise ValueError("no")

    class Misses(NegativeDistance):
        def __call__(self, carry, steps):
            return carry, steps.speedy

    assert shown_needs(Fails(), 6, 6) is None
    with refused("'speedy'"):
        shown_needs(Misses(), 6, 6)


def _helper(x):
    return x


def test_a_function_of_steps_has_an_argument_of_that_name(subtests):
    """Any other function is the file's own."""
    for found, is_one in [
        (gentle, True),
        (_helper, False),
        (lambda step, k=1.0: k, True),
        (lambda: 0, False),
        (lambda *, step: 0, False),
        (lambda step, other: 0, False),
        (NegativeDistance(), False),
        ("own", False),
    ]:
        with subtests.test(found=found):
            assert takes_alone(found, STEP) is is_one


def test_a_term_without_a_name_of_a_parameter_has_no_weight():
    """It is a term all the same."""

    def odd(step):
        return {"in": step.distance, "needs": step.distance, "a.b": step.distance, "c": step.distance}

    made = reward_class(odd)
    assert [it.name for it in dataclasses.fields(made)] == ["c"]
    assert needs_of(made()).terms == ("in", "needs", "a.b", "c")


@pytest.mark.parametrize(
    ("returned", "told"),
    [
        (lambda step: -(step.action**2), r"values of shape \(2, 6\) for 2 arms: return one number an arm"),
        (lambda step: (step.distance, step.distance), r"values of shape \(2, 2\) for 2 arms"),
        (lambda step: None, "None for 2 arms"),
        (lambda step: -1.0, "-1.0 for 2 arms"),
    ],
)
def test_what_is_no_number_an_arm_is_said_before_a_run(returned, told):
    """By the shape, and what to return instead."""
    with refused(told):
        needs_of(reward_class(returned)())
