"""What is noted of the calls that an env gets, so that another env can get the same."""

import numpy as np
import pytest
from gymnasium.spaces import Box, Dict, Discrete, MultiDiscrete, Text

from harness.record.recording.facts import ActionFacts
from harness.recorder.recorder import Calls, action_facts, action_of, checksum


def _calls(shape=(2,), num_envs=1):
    calls = Calls(ActionFacts(shape), num_envs, lambda facts: None)
    for env in range(num_envs):
        calls.note_reset(env, 7, None)
    return calls


def test_actions_of_few_numbers_are_recorded(subtests):
    """Those of no numbers, or of very many, are not."""
    rows = [
        (Box(-1, 1, (2, 3)), (2, 3)),
        (Discrete(4), ()),
        (MultiDiscrete([2, 3]), (2,)),
        (Box(-1, 1, (257,)), None),
        (Text(3), None),
        (Dict({"a": Discrete(2)}), None),
    ]
    for space, shape in rows:
        with subtests.test(space=space, shape=shape):
            facts = action_facts(space)
            assert (None if facts is None else facts.shape) == shape


@pytest.mark.parametrize(
    "action",
    [
        *(np.array([0.1, -2.5]).astype(kind) for kind in ("float16", "float32", "float64", "int8", "int64", "uint16")),
        *(np.array([True, False]), np.float32(0.1), np.int64(3), 3, -0.1, True),
    ],
)
def test_action_comes_back_as_it_was_given(action):
    """Bit for bit, and in its type: an env may compute otherwise with another one."""
    calls = _calls(np.shape(action))
    back = action_of(calls.take([action])[0, 3:], calls.facts)
    assert type(back) is type(action)
    assert np.array_equal(back, action)
    assert np.asarray(back).dtype == np.asarray(action).dtype


def test_row_tells_what_was_called_before_the_step():
    """The seed of the last reset that had one, and the resets after it; in the next step nothing."""
    calls = _calls((1,))
    for seed in (1, None, 5, None, None):
        calls.note_reset(0, seed, None)
    calls.mark(0, 0, "seen")
    assert calls.take([np.zeros(1)] * 2)[:, :3].tolist() == [[5, 2, checksum("seen")], [-1, 0, -1]]
    assert calls.take([np.zeros(1)])[:, :3].tolist() == [[-1, 0, -1]]


def test_answers_are_told_by_their_checksum():
    """Where they are checked."""
    calls, answer = _calls((1,)), np.arange(3.0)
    calls.mark(0, 0, answer)
    assert calls.take([np.zeros(1)])[0, 2] == checksum(answer) != checksum(answer + 1e-12)


def test_checksum_takes_whatever_envs_observe():
    """Arrays in any order, numbers, texts, and such in dicts and tuples; each difference counts."""
    seen = {"at": np.arange(6).reshape(2, 3).T, "left": 3, "text": ("go", [1.5])}
    sums = {checksum({**seen, **other}) for other in ({}, {"left": 4}, {"text": ("go", [1.6])}, {"at": np.arange(6)})}
    assert len(sums) == 4
    assert checksum(seen) == checksum({**seen, "at": seen["at"].copy()})
    assert checksum(object()) == 0


PROBLEMS = {
    "options": (lambda calls: calls.note_reset(0, 1, {"low": 0}), "its env was reset with options"),
    "a seed of another kind": (lambda calls: calls.note_reset(0, "x", None), "reset with the seed 'x'"),
    "a list": (lambda calls: calls.take([[1.0, 2.0]]), "an action was given as a list"),
    "another shape": (lambda calls: calls.take([np.zeros(3)]), "has the shape (3,), not (2,)"),
    "two types": (
        lambda calls: calls.take([np.ones(2, "float32"), np.ones(2, "float64")]),
        "actions were given as float32 and as float64",
    ),
    "a large number": (lambda calls: calls.take([np.full(2, 2**60)]), "an action is beyond 9,007"),
}


@pytest.mark.parametrize(("call", "told"), PROBLEMS.values(), ids=PROBLEMS)
def test_what_cannot_be_told_again_is_a_problem(call, told):
    """It is noted once, and from there on only zeros."""
    calls = _calls()
    call(calls)
    found = calls.take([np.ones(2, np.float32)])
    assert told in calls.facts.problem
    assert not found[-1, 3:].any()


def test_env_that_was_not_seeded_is_a_problem():
    """Nobody knows what it drew."""
    calls = Calls(ActionFacts(()), 1, lambda facts: None)
    calls.note_reset(0, None, None)
    calls.mark(0, 0, 1)
    assert calls.facts.problem == "its env was not reset with a seed"


def test_envs_of_a_batch_have_seeds_of_their_own():
    """A reset of one is none of the other."""
    calls = _calls((), num_envs=2)
    calls.note_reset(1, None, None)
    for env in (0, 1):
        calls.mark(env, env, 1)
    assert calls.take([1, 1])[:, :2].tolist() == [[7, 0], [7, 1]]
