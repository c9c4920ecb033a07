"""Whether a reward is another one but for scale and offset."""

import json

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.random import default_rng

from harness.eta import Rescaling, line_of, rescaling_of

PAID = default_rng(0).normal(size=1_000) * 10.0 ** default_rng(1).uniform(-6, 6, 1_000)
"""What a reward pays: of all sizes and both signs."""


def found(one, other, parts=3):
    """Of steps in several recordings."""
    pairs = zip(np.array_split(one, parts), np.array_split(other, parts), strict=True)
    return rescaling_of([line_of(*pair) for pair in pairs])


@given(st.floats(0.01, 100.0), st.floats(-100.0, 100.0), st.sampled_from([1.0, -1.0]))
def test_every_scale_and_offset_is_found(factor, offset, sign):
    """Whatever the signs; unknown steps, those of a reward that was given up, do not count."""
    rescaling = found(PAID, np.where(np.arange(1_000) < 900, sign * factor * PAID + offset, np.nan))
    assert rescaling.factor == pytest.approx(sign * factor, rel=1e-9)
    assert rescaling.offset == pytest.approx(offset, rel=1e-6, abs=1e-9)
    assert rescaling.steps == 900


@pytest.mark.parametrize(
    "compute",
    [
        lambda x: 0.3 * (x + 1_000.0),
        lambda x: (x - 1.0) / 3.0,
        lambda x: 0.1 * x + 0.2 * x,
        lambda x: -(7.0 - x) * 1e-3,
    ],
)
def test_rounding_does_not_matter(compute):
    """Of a few operations, in any order."""
    assert found(PAID, compute(PAID)) is not None


def test_rewards_in_single_precision_are_found():
    """Many environments compute so; a reward in double precision beside it differs by the rounding of the other."""
    single = PAID.astype(np.float32)
    assert found(single.astype(float), (np.float32(0.3) * single).astype(float)) is not None
    assert found(single.astype(float), 2.0 * PAID).factor == pytest.approx(2.0, rel=1e-6)


def test_a_reward_that_is_computed_again_from_observations_is_found():
    """The env pays by its state in double precision, and shows it in single precision."""
    state = default_rng(2).uniform(-3.0, 3.0, (1_000, 2))
    seen = state.astype(np.float32).astype(float)
    rescaling = found(-(state**2).sum(axis=1), -0.5 * (seen**2).sum(axis=1) + 3.0)
    assert (rescaling.factor, rescaling.offset) == (pytest.approx(0.5, rel=1e-6), pytest.approx(3.0, rel=1e-6))


@pytest.mark.parametrize(
    "other",
    [
        PAID + 1e-5 * np.abs(PAID) * np.sin(np.arange(1_000.0)),
        np.maximum(PAID, -5.0),
        PAID**2,
        np.where(np.arange(1_000) == 500, PAID + 1.0, PAID),
        np.concatenate([PAID[:500], 2.0 * PAID[500:]]),
    ],
    ids=["a small term more", "cut", "squared", "one step otherwise", "another scale in another recording"],
)
def test_another_reward_is_no_rescaling(other):
    """However near it is, beyond a millionth."""
    assert found(PAID, other) is None
    assert found(other, PAID) is None


def test_a_small_term_beside_whole_numbers_is_seen():
    """Whole numbers are exact, so that no rounding hides it."""
    whole = np.tile([-1.0, 0.0], 500)
    assert found(whole, whole - 1e-9 * np.abs(PAID)) is None
    assert found(whole, 3.0 * whole) is not None


def test_a_reward_that_never_changes_is_no_rescaling_of_one_that_does():
    """Nothing can be told from it, of either."""
    assert found(PAID, np.ones(1_000)) is None
    assert found(np.ones(1_000), PAID) is None


@pytest.mark.parametrize("factor", [0.1, 2.0, -3.0])
def test_two_rewards_that_never_change_differ_in_a_factor(factor):
    """As an alive bonus, and a tenth of it."""
    rescaling = found(np.ones(1_000), np.full(1_000, factor))
    assert rescaling == Rescaling(factor, 0.0, 1_000, 1)
    told = "b is 0.1 x a, in all 1,000 steps, for which a paid one number alone"
    assert (rescaling.sentence("b", "a") == told) is (factor == 0.1)
    assert ("the opposite reward" in rescaling.sentence("b", "a")) is (factor < 0.0)


@pytest.mark.parametrize(("one", "other", "is_same"), [(0.0, 0.0, True), (0.0, 1.0, False), (1.0, 0.0, False)])
def test_nothing_is_no_multiple_of_something(one, other, is_same):
    """Two rewards that never pay are one."""
    assert found(np.full(9, one), np.full(9, other)) == (Rescaling(1.0, 0.0, 9, 1) if is_same else None)


def test_a_factor_that_is_another_in_each_recording_is_none():
    """An alive bonus that was 1 and then 2, beside one that stayed, is another reward; so is the other way round."""
    changed = np.repeat([1.0, 2.0], 500)
    assert found(np.ones(1_000), changed, parts=2) is None
    assert found(changed, np.ones(1_000), parts=2) is None
    assert found(changed, 0.1 * changed, parts=2) == Rescaling(0.1, 0.0, 1_000, 2)


def test_what_is_no_mere_ruler_is_told(subtests):
    """A factor below 0; an offset where episodes can end."""
    for factor in [-0.21, 0.21]:
        for offset in [0.0, 0.21, -0.21]:
            for can_end in [False, True]:
                with subtests.test(factor=factor, offset=offset, can_end=can_end):
                    rescaling = rescaling_of(
                        [line_of(PAID, factor * PAID + offset, can_end=it) for it in (False, can_end)]
                    )
                    assert rescaling.is_ruler is (factor > 0.0 and (offset == 0.0 or not can_end))
                    told = rescaling.sentence("b", "a")
                    assert ("It is the opposite reward: it pays less where a pays more" in told) is (factor < 0.0)
                    assert ("so that the offset is no mere ruler" in told) is (offset != 0.0 and can_end)
                    assert told.endswith("pays for living longer") is (offset > 0.0 and can_end)
                    assert told.endswith("pays for ending sooner") is (offset < 0.0 and can_end)
                    assert rescaling.to_json().get("can_end", False) is can_end


def test_a_recording_without_a_change_does_not_contradict():
    """The others show the line, and it lies on it."""
    one = np.concatenate([np.full(500, 3.0), PAID[500:]])
    assert found(one, 2.0 * one + 1.0, parts=2) == found(one, 2.0 * one + 1.0, parts=1)
    assert found(one, np.where(np.arange(1_000) < 500, 8.0, 2.0 * one + 1.0), parts=2) is None


@pytest.mark.parametrize("steps", [0, 1])
def test_a_step_is_no_line(steps):
    """Any reward would be one."""
    assert rescaling_of([line_of(PAID[:steps], 2.0 * PAID[:steps])]) is None
    assert rescaling_of([]) is None


@pytest.mark.parametrize(
    ("factor", "offset", "told"),
    [
        (2.0, 0.0, "b is 2 x a"),
        (1.0, 0.0, "b pays the same as a"),
        (1.0, 0.5, "b is a + 0.5"),
        (-1.0, -2.0, "b is -1 x a - 2"),
        (0.1 + 0.2, 0.0, "b is 0.3 x a"),
    ],
)
def test_a_sentence_says_what_it_is_and_how_that_was_found(factor, offset, told):
    """By how many steps, and how much they can tell."""
    few = Rescaling(factor, offset, 12_000, 2).sentence("b", "a")
    assert few.startswith(f"{told}, in all 12,000 steps, for which a paid 2 different numbers")
    assert "a paid more than 100 different numbers" in Rescaling(factor, offset, 3, None).sentence("b", "a")


def test_payments_are_counted_over_all_recordings():
    """Up to a hundred."""
    assert found(np.repeat([1.0, 2.0, 3.0], 10), np.repeat([2.0, 4.0, 6.0], 10)).payments == 3
    many = np.arange(101.0)
    assert found(many, 2.0 * many).payments is None


def test_json_is_plain():
    """And has no other numbers than JSON has."""
    assert json.loads(json.dumps(Rescaling(2.0, 0.0, 3, None).to_json())) == {
        "factor": 2.0, "offset": 0.0, "steps": 3, "payments": None, "can_end": False,
    }  # fmt: skip
