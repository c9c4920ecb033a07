"""Where a row of numbers has its goals."""

import numpy as np
import pytest
from gymnasium.spaces import Box, Dict, Discrete, Text

from harness.experiment.environments.spaces import flat_observations, goal_columns, rows_of
from tests.refusals import refused

PAIR, TRIPLE = Box(-1.0, 1.0, (2,)), Box(-1.0, 1.0, (3,))


def test_columns_are_those_of_the_goals():
    """In the order of the space's keys, whatever lies between."""
    space = Dict({"achieved_goal": PAIR, "before": Discrete(3), "desired_goal": PAIR, "zone": TRIPLE})
    row = rows_of(space).of(
        {"achieved_goal": np.array([1, 2]), "before": 1, "desired_goal": np.array([3, 4]), "zone": np.zeros(3)},
    )
    achieved, desired = goal_columns(space)
    assert (row[achieved].tolist(), row[desired].tolist()) == ([1.0, 2.0], [3.0, 4.0])


@pytest.mark.parametrize(
    "space",
    [
        PAIR,
        Dict({"achieved_goal": PAIR}),
        Dict({"achieved_goal": PAIR, "desired_goal": TRIPLE}),
        Dict({"achieved_goal": Discrete(2), "desired_goal": Discrete(2)}),
    ],
)
def test_other_observations_have_no_goals(space):
    """The message says what they would be."""
    with refused("they would be a dict with achieved_goal and desired_goal"):
        goal_columns(space)


def test_numbers_beside_a_text_are_a_row():
    """The text is left out; where there is nothing else the space is refused."""
    space = Dict({"far": PAIR, "said": Text(3)})
    assert flat_observations(space).shape == (2,)
    assert rows_of(space).batch({"far": np.array([1.0, 2.0]), "said": "abc"}).tolist() == [[1.0, 2.0]]
    with refused("of 0 numbers: 1 to 1,000,000 are allowed"):
        flat_observations(Text(3))
