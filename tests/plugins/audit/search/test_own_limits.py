"""Environments that end episodes by themselves, and say so nowhere, are asked after how many steps."""

import gymnasium
import pytest

from harness.recorder.env_facts import Columns
from harness_plugins.audit.search.environment_world import of_env
from tests.plugins.audit.search.contracts import CONTRACTS, ContractEnv
from tests.plugins.audit.search.toy_worlds import Graph


class Edge(Graph):
    """A line of 6 places; stepping off it to the east truncates after 5 steps; waiting goes on for longer."""

    def __init__(self):
        super().__init__([[(min(at + 1, 5), 0.0, False, False), (at, 0.0, False, False)] for at in range(6)])

    def step(self, action):
        """Go on, or wait."""
        after, paid, ended, _, info = super().step(action)
        return after, paid, ended, after == 5, info


ENVS = {
    **{it.name: (ContractEnv(it), it.horizon) for it in CONTRACTS[:8]},
    "a graph without an exit": (Graph([[(0, 1.0, False, False), (0, 0.0, False, False)]]), 500),
    "an edge that truncates": (Edge(), 500),
    "a limit that Gymnasium knows": (gymnasium.wrappers.TimeLimit(ContractEnv(CONTRACTS[0]), 17), 17),
}


@pytest.mark.parametrize(("env", "horizon"), ENVS.values(), ids=ENVS)
def test_the_horizon_is_what_ends_episodes(env, horizon):
    """Also where random actions mostly end an episode before; what nothing ends is cut, and that is told."""
    world = of_env(env, "own", Columns({"own": "own"}, {}, ()), 0.99)
    assert world.horizon == horizon
    assert any("Nothing limits" in note for note in world.notes) == (horizon == 500)
