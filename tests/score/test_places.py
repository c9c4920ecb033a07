"""A map of places gives positions, distances, and what an arm's reward pays."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.errors import UsageError
from harness.registry import choose, load_registry
from harness.reward import Sample
from harness.score import ArmPay, Place, distances, parse_place, parse_places

ROWS = np.arange(12.0).reshape(2, 6)


def pay_episode(reward, end_effector, target):
    """What an arm's reward pays each step of an episode, by positions before each step and after the last."""
    pay, far = ArmPay(reward), distances(end_effector, target)
    pay.begin(far[0])
    return pay.pay(far[1:]).total


def test_a_map_takes_positions_from_a_vector():
    """By the numbers that it names."""
    arm = parse_places("end_effector=0:3,target=3:6")
    assert arm.end_effector(ROWS).tolist() == [[0, 1, 2], [6, 7, 8]]
    assert arm.target(ROWS).tolist() == [[3, 4, 5], [9, 10, 11]]


def test_distances_are_euclidean():
    """In metres."""
    assert parse_places("end_effector=0:3,target=3:6").distances(ROWS) == pytest.approx([27**0.5] * 2)


def test_a_map_takes_parts_of_a_table():
    """By the keys of goal environments."""
    arm = parse_places("end_effector=achieved_goal,target=desired_goal[1:4]")
    table = {"achieved_goal": ROWS[:, :3], "desired_goal": ROWS}
    assert arm.target(table).tolist() == [[1, 2, 3], [7, 8, 9]]


def test_a_target_may_be_constant():
    """A log of a real arm often does not have it."""
    assert parse_places("end_effector=0:3,target=0.3/0.1/-0.2").target(ROWS).tolist() == [[0.3, 0.1, -0.2]] * 2


def test_joints_go_through_the_function():
    """Degrees are turned into radians first."""
    arm = parse_places("joints_deg=0:2,target=3:6", lambda joints: np.hstack([joints, joints[:, :1]]))
    assert arm.end_effector(np.full((1, 6), 180.0)) == pytest.approx(np.full((1, 3), np.pi))


def test_a_map_that_is_none_is_refused(subtests):
    """In one line, which says what to write."""
    rows = [
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
    ]
    for text, told in rows:
        with subtests.test(text=text, told=told), pytest.raises(UsageError, match=told):
            parse_places(text)


def test_a_place_beyond_the_vector_is_refused():
    """It would silently be empty."""
    with pytest.raises(UsageError, match="beyond the 6 numbers"):
        parse_place("4:7").rows(ROWS)


def test_a_part_that_is_not_there_names_those_that_are():
    """So that the map can be corrected."""
    with pytest.raises(UsageError, match="that has a, b"):
        parse_place("c").rows({"a": ROWS, "b": ROWS})


def test_a_position_has_three_numbers():
    """Two would give a distance, too."""
    with pytest.raises(UsageError, match="has 2 numbers"):
        parse_places("end_effector=0:2,target=3:6").distances(ROWS)


def test_joints_without_a_robot_are_refused():
    """The message says what is missing."""
    with pytest.raises(UsageError, match="name the robot"):
        parse_places("joints=0:3,target=3:6").distances(ROWS)


@given(st.from_regex(r"[a-z]{1,5}(\[[0-4]:[5-9]\])?|[0-4]:[5-9]", fullmatch=True))
def test_a_place_says_what_was_typed(text):
    """Messages show it."""
    assert str(parse_place(text)) == text


FAR = st.lists(st.integers(0, 200).map(lambda it: it / 100.0), min_size=2, max_size=30)
REWARDS = ("baseline", "arp:k1=2,k2=1.5", "aarp", "potential")


@pytest.mark.parametrize("name", REWARDS)
@given(FAR, st.integers(1, 29))
def test_an_episode_is_paid_as_an_env_pays_it(name, far, cut):
    """Step by step with the carry, whole, or in two stretches: the same numbers."""
    registry = load_registry()
    reward = choose(registry, "rewards", name).build(registry, "rewards")
    end_effector, target = np.array([[it, 0.0, 0.0] for it in far]), np.zeros((len(far), 3))
    carry, best, expected = reward.initial_carry(np.array(far[:1])), far[0], []
    for step, (before, after) in enumerate(pairwise(far), 1):
        values = (far[0], best, before, after, after - best, step)
        carry, value = reward(carry, Sample(*(np.array([float(it)]) for it in values)))
        expected.append(float(value[0]))
        best = min(best, after)
    pay = ArmPay(reward)
    pay.begin(far[0])
    parts = [pay.pay(np.array(part)).total for part in (far[1 : 1 + cut], far[1 + cut :]) if part]
    assert pay_episode(reward, end_effector, target) == pytest.approx(expected)
    assert np.concatenate(parts) == pytest.approx(expected)


def test_distances_take_two_arrays():
    """Of the same length."""
    assert distances(np.zeros((2, 3)), np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 1.0]])).tolist() == [5.0, 1.0]


def test_a_constant_needs_no_vector_of_its_own():
    """The number of rows may be told."""
    assert Place(constant=(1.0, 2.0, 3.0)).rows(None, 2).tolist() == [[1, 2, 3]] * 2
