"""What an author gives for a reward of an environment, and the one way in which it is called."""

import functools

import numpy as np
import pytest

from harness.reward.given import Before, Now, Terms, Untold, opened, told_under, weights_of, zeros_of
from harness.reward.steps import MissingField
from tests.refusals import refused

STEP = Now._make((2.0, 3.0, {"left": 4.0}, False, True, Before._make((1.0, 0.5, {}))))


class Called:
    """An object that takes a step."""

    def __call__(self, step):
        """The action."""
        return float(step.action)


def four(observation, action, next_observation, info):
    """All that it is given."""
    return observation, action, next_observation, info["left"]


def test_four_arguments_are_those_of_the_step():
    """The observation before it, the action, the observation after it and the info."""
    assert Terms({"it": four})(STEP) == {"it": (1.0, 3.0, 2.0, 4.0)}


@pytest.mark.parametrize(
    "given",
    [lambda step: step.action, functools.partial(lambda step, by: step.action, by=2), Called(), lambda step, by=2: 3.0],
)
def test_what_takes_a_step_is_given_it(given):
    """A function, a partial one, an object, one with a default."""
    assert Terms({"it": given})(STEP) == {"it": 3.0}


def test_function_of_any_number_of_arguments_is_given_four():
    """Whatever it calls them."""
    assert len(Terms({"it": lambda *step: step})(STEP)["it"]) == 4


@pytest.mark.parametrize("read", [lambda step: step.distance, lambda step: step.before.distance])
def test_a_field_that_is_not_there_is_refused_by_name(read):
    """With what there is; the one before too."""
    with pytest.raises(MissingField, match=r"has no 'distance'\. It has: observation, action, info"):
        read(STEP)


def test_what_others_call_a_field_is_guessed():
    """As ``obs``."""
    with pytest.raises(MissingField, match="Did you mean 'observation'"):
        _ = STEP.obs


def test_key_may_be_of_a_dict_in_info():
    """And one with a dot in its own name comes first."""
    info = {"reward": {"forward": 1.0, "a.b": 2.0}, "x.y": 3.0, "x": {"y": 4.0}}
    assert [told_under(info, key) for key in ("reward.forward", "reward.a.b", "x.y")] == [1.0, 2.0, 3.0]


def test_missing_key_is_told_with_what_there_is():
    """And the nearest name."""
    with pytest.raises(Untold) as error:
        told_under({"x_position": 1.0, "y": 2.0}, "x_positon")
    assert str(error.value) == "info has no 'x_positon'; it has 'x_position', 'y'. Did you mean 'x_position'?"


def test_zeros_have_the_form_of_the_action(subtests):
    """Of arrays, choices, and of both in dicts and tuples."""
    for action, zeros in [
        (np.ones(3, np.float32), np.zeros(3, np.float32)),
        (2, 0),
        (1.5, 0.0),
        (np.int64(4), np.int64(0)),
        ({"a": np.ones(2), "b": 1}, {"a": np.zeros(2), "b": 0}),
        ((1, np.ones(1)), (0, np.zeros(1))),
    ]:
        with subtests.test(action=action):
            assert repr(zeros_of(action)) == repr(zeros)


REFUSED = {
    "no function": (3.0, "has to be a function of"),
    "a class": (Called, "has to be a function of"),
    "other arguments": (lambda x: x, r"takes \(x\): it has to take \(step\), or \(observation"),
    "no terms": ({}, "has no term"),
    "a term that is no function": ({"a": 1.0}, "term 'a' is 1.0"),
    "terms in terms": ({"a": {"b": "c"}}, "its term 'a' is"),
    "what the env pays as a term": ({"a": "own"}, "its term 'a' is 'own'"),
}


def test_what_cannot_be_asked_is_refused(subtests):
    """By its name."""
    for case, (given, told) in REFUSED.items():
        with subtests.test(case), refused(rf"^reward 'v1'.*{told}"):
            opened(given, "reward 'v1'")


def test_terms_by_name_are_functions_and_keys():
    """Each of them in its own form."""
    given = opened({"left": "left", "acted": lambda step: step.action, "seen": lambda s, a, n, i: n}, "reward 'v1'")
    assert dict(given(STEP)) == {"left": 4.0, "acted": 3.0, "seen": 2.0}


def test_weights_multiply_terms():
    """Others are what they are."""
    assert dict(Terms({"both": lambda step: {"a": 2.0, "b": 3.0}}, {"b": 5.0})(STEP)) == {"a": 2.0, "b": 15.0}


def test_weight_of_no_term_is_refused():
    """With the names of the terms."""
    with refused(r"Reward 'both' has no term 'c' to weigh\. It has: aa, b"):
        weights_of("both", {"c": 5.0}, ("aa", "b"))
