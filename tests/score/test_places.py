"""A map of places gives positions, distances, and what an arm's reward pays."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.registry import choose
from harness.reward import Sample
from harness.score.places import ArmPay, parse_place, parse_places
from tests.refusals import refused
from tests.registered import REGISTRY

ROWS = np.arange(12.0).reshape(2, 6)


@pytest.mark.parametrize(
    ("text", "given", "tips", "targets"),
    [
        ("end_effector=0:3,target=3:6", ROWS, [[0, 1, 2], [6, 7, 8]], [[3, 4, 5], [9, 10, 11]]),
        ("end_effector=a,target=b[1:4]", {"a": ROWS[:, :3], "b": ROWS}, [[0, 1, 2], [6, 7, 8]], [[1, 2, 3], [7, 8, 9]]),
        ("end_effector=0:3,target=0.3/0.1/-0.2", ROWS, [[0, 1, 2], [6, 7, 8]], [[0.3, 0.1, -0.2]] * 2),
        ("joints_deg=0:2,target=3:6", 180.0 + 0.0 * ROWS, np.full((2, 3), np.pi), [[180.0] * 3] * 2),
    ],
    ids=["numbers of a vector", "parts of a table", "a constant", "joints"],
)
def test_a_map_takes_positions(text, given, tips, targets):
    """Degrees are turned into radians before they go through the function; distances are Euclidean, in metres."""
    arm = parse_places(text, lambda joints: np.hstack([joints, joints[:, :1]]))
    np.testing.assert_allclose(arm.end_effector(given), tips)
    np.testing.assert_array_equal(arm.target(given), targets)
    np.testing.assert_allclose(arm.distances(given), np.linalg.norm(np.subtract(tips, targets), axis=1))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "name target and one of"),
        ("end_effector=0:3", "name target and one of"),
        ("end_effector=0:3,joints=0:6,target=3:6", "name target and one of"),
        ("tip=0:3,target=3:6", "once at most"),
        ("target=0:3,target=3:6", "once at most"),
        ("end_effector=3:3,target=3:6", "first number is below"),
        ("end_effector=0:9999999999,target=3:6", "first number is below"),
        ("end_effector=[0:3],target=3:6", "is no place"),
        ("end_effector=0:3,target=0.3/0.1", "three numbers in metres"),
        ("end_effector=0:3,target=0.3/0.1/nan", "three numbers in metres"),
        ("end_effector=0:2,target=3:6", "has 2 numbers"),
        ("joints=0:3,target=3:6", "name the robot"),
        ("end_effector=4:7,target=3:6", "beyond the 6 numbers"),
        ("end_effector=c,target=a", "that has a, b"),
    ],
)
def test_a_map_that_is_none_is_refused(text, told):
    """In one line, which says what to write; two numbers would give a distance too, a place beyond would be empty."""
    given = {"a": ROWS, "b": ROWS} if "=c" in text else ROWS
    with refused(told):
        parse_places(text).distances(given)


@given(st.from_regex(r"[a-z]{1,5}(\[[0-4]:[5-9]\])?|[0-4]:[5-9]", fullmatch=True))
def test_a_place_says_what_was_typed(text):
    """Messages show it."""
    assert parse_place(text).text == text


FAR = st.lists(st.integers(0, 200).map(lambda it: it / 100.0), min_size=2, max_size=30)
REWARDS = ("baseline", "arp:k1=2,k2=1.5", "aarp", "potential")


@pytest.mark.parametrize("name", REWARDS)
@given(FAR, st.integers(1, 29))
def test_an_episode_is_paid_as_an_env_pays_it(name, far, cut):
    """Step by step with the carry, whole, or in two stretches: the same numbers."""
    reward = choose(REGISTRY, "rewards", name).build(REGISTRY, "rewards")
    carry, best, expected = reward.initial_carry(np.array(far[:1])), far[0], []
    for step, (before, after) in enumerate(pairwise(far), 1):
        values = (far[0], best, before, after, after - best, step)
        carry, value = reward(carry, Sample(*(np.array([float(it)]) for it in values)))
        expected.append(float(value[0]))
        best = min(best, after)
    pay = ArmPay(reward)
    pay.begin(far[0])
    parts = [pay.pay(np.array(part)).total for part in (far[1 : 1 + cut], far[1 + cut :]) if part]
    assert np.concatenate(parts) == pytest.approx(expected)
