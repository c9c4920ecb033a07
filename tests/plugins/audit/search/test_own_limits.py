"""Environments that end episodes by themselves, and say so nowhere, are asked after how many steps."""

import gymnasium
import pytest

from harness.authoring.commands import Columns
from harness_plugins.audit.search.environment_world import CUT_AT, of_env
from tests.plugins.audit.search.contracts import CONTRACTS, ContractEnv
from tests.plugins.audit.search.toy_worlds import Graph


def world_of(env):
    """The env, paid by itself."""
    return of_env(env, "own", Columns({"own": "own"}, {}, ()), 0.99)


@pytest.mark.parametrize("contract", CONTRACTS[:8], ids=lambda it: it.name)
def test_a_counter_of_steps_is_the_horizon(contract):
    """Also where random actions mostly end an episode before."""
    world = world_of(ContractEnv(contract))
    assert world.horizon == contract.horizon
    assert not any("Nothing limits" in note for note in world.notes)


def test_what_nothing_ends_is_cut():
    """A graph without an exit."""
    world = world_of(Graph([[(0, 1.0, False, False), (0, 0.0, False, False)]]))
    assert world.horizon == CUT_AT
    assert any("Nothing limits" in note for note in world.notes)


def test_an_edge_that_truncates_is_no_limit():
    """Leaving to the east is truncated after 5 steps; waiting goes on for longer."""

    class Edge(Graph):
        """A line of 6 places; stepping off it truncates."""

        def __init__(self):
            super().__init__([[(min(at + 1, 5), 0.0, False, False), (at, 0.0, False, False)] for at in range(6)])

        def step(self, action):
            """Go on, or wait."""
            after, paid, ended, _, info = super().step(action)
            return after, paid, ended, after == 5, info

    assert world_of(Edge()).horizon == CUT_AT


def test_a_limit_that_gymnasium_knows_is_taken():
    """A TimeLimit tells."""
    assert world_of(gymnasium.wrappers.TimeLimit(ContractEnv(CONTRACTS[0]), 17)).horizon == 17
