"""One proposed reward against the baseline."""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from harness.eta.behaviour_change import change_of
from harness.eta.curve import curve_of
from harness.eta.decompose import BB, BK, KB, KK, decompose
from harness.eta.index import Ratio
from harness.record.cell import Cell
from harness.registry.choice import Choice
from harness.results.combination import Combination, Group

GROUP = Group(
    "fd100", Choice("fd100-reach", (), "fd100-reach"), Choice("wander", (), "wander"), steps=12, evaluation_episodes=20,
    simulator=Choice("ideal", (), "ideal"),
)  # fmt: skip
CURVES = {pair: curve_of([np.array([-1.0, 3.0 * factor])] * 5) for pair, factor in ((BB, 1), (BK, 1), (KB, 2), (KK, 2))}
CHANGES = (
    change_of("final_distance", "m", "lower", [0.2] * 5, [0.1] * 5, [0.5] * 10),
    change_of("success_rate", "", "higher", [0.5] * 5, [0.75] * 5, [0.0] * 10),
)


@pytest.fixture(name="combination")
def _combination() -> Combination:
    return Combination(GROUP, "baseline", "arp", (0, 1, 2, 3, 4), decompose(CURVES), CHANGES, CURVES, {"success": 0.01})


@pytest.fixture(name="empty")
def _empty() -> Combination:
    return Combination(GROUP, "baseline", "arp", (), None, (), {})


@pytest.mark.parametrize(
    "field", ["simulator", "robot", "task", "algorithm", "steps", "evaluation_episodes", "evaluate_every"]
)
def test_cells_that_differ_are_in_other_groups(make_cell: Callable[..., Cell], field: str):
    """Whatever decides a result, reward and seed apart."""
    other: Any = Choice("other") if isinstance(getattr(make_cell(), field), Choice) else 99
    assert Group.of(make_cell()) != Group.of(make_cell(**{field: other}))


def test_manners_of_evaluation_are_not_mixed(make_cell: Callable[..., Cell]):
    """Policies that drew their actions are not compared with some that did not, and the group says which."""
    groups = [Group.of(make_cell(deterministic=given)) for given in (True, False)]
    assert [group.manner for group in groups] == ["deterministically", "stochastically"]
    assert [group.to_json()["deterministic"] for group in groups] == [True, False]


def test_rewards_and_seeds_share_a_group(make_cell: Callable[..., Cell]):
    """They are what is compared."""
    assert Group.of(make_cell()) == Group.of(make_cell(seed=7, reward=Choice("arp")))


def test_rewards_are_what_is_compared_in_a_combination(make_cell: Callable[..., Cell]):
    """So its group has a simulator and no reward; that of policies from several simulators has it the other way."""
    cell = make_cell()
    group, policies = Group.of(cell), Group.of(cell, compared="simulator")
    assert (group.simulator, group.reward) == (cell.simulator, None)
    assert (policies.simulator, policies.reward) == (None, cell.reward)
    assert policies == Group.of(make_cell(simulator=Choice("other")), compared="simulator")


def test_title_names_all_that_is_shared():
    """In one line, what is compared left out; JSON has the same names by kind."""
    assert GROUP.title == "ideal · wander · fd100 · fd100-reach"
    policies = GROUP._replace(simulator=None, reward=Choice("arp", (), "arp"))
    assert policies.title == "wander · arp · fd100 · fd100-reach"
    assert list(GROUP.to_json()) == ["simulator", "algorithm", "robot", "task", "steps", "deterministic"]


def test_runs_are_split_where_both_were_scored(combination: Combination, empty: Combination):
    """By the other's reward; without it, or without a seed, they are not."""
    alone = decompose({pair: CURVES[pair] for pair in (BB, KK)})
    assert combination.is_split
    assert not replace(combination, decomposition=alone).is_split
    assert not empty.is_split


def test_etas_and_indices_are_the_decompositions(combination: Combination):
    """They are at hand without it."""
    found = combination.decomposition
    assert (combination.eta_n, combination.eta_p) == (found.eta_n, found.eta_p)
    assert (combination.baseline_index, combination.proposed_index) == (found.baseline, found.proposed)


def test_success_is_found_among_the_changes(combination: Combination, empty: Combination):
    """By its name; there may be none."""
    assert combination.success is CHANGES[1]
    assert empty.success is None


def test_verdict_knows_the_corrected_p_value(combination: Combination):
    """What holds for all comparisons decides between `behaves` and `seems to behave`."""
    assert combination.verdict.startswith("The robot behaves better (success 75% against 50%). eta_N 1:")
    assert replace(combination, corrected={"success": 0.5}).verdict.startswith("The robot seems to behave better")


def test_basis_names_the_evaluation_episodes(combination: Combination):
    """As many as the group has."""
    assert combination.basis.startswith("Rests on 5 paired seeds, 20 evaluation episodes each")


def test_without_a_seed_the_reason_stands_everywhere(empty: Combination):
    """In both ratios, in the verdict, and nowhere a number."""
    reason = "no seed is done under both baseline and arp"
    assert empty.eta_n == empty.eta_p == Ratio(None, notes=(reason,))
    assert (empty.baseline_index, empty.proposed_index, empty.basis) == (None, None, "")
    assert empty.verdict == f"Nothing to compare: {reason}."


def test_json_is_plain_and_the_same_with_and_without_seeds(combination: Combination, empty: Combination):
    """The same keys in the same order, without NaN and without curves."""
    full, nothing = (json.loads(json.dumps(one.to_json(), allow_nan=False)) for one in (combination, empty))
    assert list(full) == list(nothing)
    assert full["success"] == {"baseline": 0.5, "proposed": 0.75, "random": 0.0}
    assert [change["name"] for change in full["behaviour"]] == ["final_distance", "success_rate"]
    assert full["p_corrected"] == {"success": 0.01}
    assert full["verdict"] == combination.verdict


def test_success_of_nobody_is_zero_and_not_null(combination: Combination):
    """A rate of 0 is a measurement."""
    never = change_of("success_rate", "", "higher", [0.0], [0.0], [0.0])
    success = replace(combination, changes=(never,)).to_json()["success"]
    assert success == {"baseline": 0.0, "proposed": 0.0, "random": 0.0}
