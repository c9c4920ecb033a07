"""The same contracts for reward-contract-fuzzer: what it finds is found here too, without the table and what was meant.

It has to be given every transition and what a designer meant; a search here is given ``reset``, ``step`` and what
success is. The comparison itself is skipped where rcfuzz is not installed.
"""

import json
import time

import pytest

from harness_plugins.audit import find_cheats
from tests.plugins.audit.search.contracts import CONTRACTS, ContractEnv

ALARMS = {"PAYS FOR FAILING", "PAYS FOR LOITERING"}


def word_of(contract, seed=0):
    """What a search here says of a contract."""
    make = {"success": "success", "budget": 20_000, "starts": 2, "seed": seed}
    return find_cheats(lambda: ContractEnv(contract), {"own": "own"}, **make).cheats[0].word


def is_found_by_the_other(contract):
    """Whether reward-contract-fuzzer finds an exploit."""
    mdp, audit, stochastic = (pytest.importorskip(f"rcfuzz.{name}") for name in ("mdp", "audit", "stochastic"))
    common = {
        "id": contract.name,
        "description": contract.name,
        "horizon": contract.horizon,
        "initial_state": contract.begin,
        "actions_fn": lambda state: contract.actions.split(),
        "is_terminal_fn": lambda state: False,
        "intended_policy_fn": contract.intended,
    }
    if not contract.slips:
        return audit.audit_spec(mdp.Spec(step_fn=contract.step, intended_actions=[], **common)).flagged

    def outcomes(state, action):
        return [(chance, *came) for chance, came in contract.outcomes(state, action)]

    return stochastic.audit_stochastic(stochastic.ProbSpec(outcomes_fn=outcomes, **common)).flagged


@pytest.mark.parametrize("contract", CONTRACTS, ids=lambda it: it.name)
def test_every_hack_is_found_and_no_honest_contract_is_blamed(contract):
    """An alarm for each hacked one, none for the others."""
    assert (word_of(contract) in ALARMS) == contract.is_hacked


@pytest.mark.slow
def test_nothing_that_the_other_finds_is_missed(tmp_path):
    """On all contracts, with three seeds; times are told in a file."""
    rows = []
    for contract in CONTRACTS:
        begun = time.perf_counter()
        theirs = bool(is_found_by_the_other(contract))
        between = time.perf_counter()
        words = [word_of(contract, seed) for seed in range(3)]
        seconds = (time.perf_counter() - between) / 3
        rows.append({
            "contract": contract.name, "hacked": contract.is_hacked, "fuzzer": theirs, "words": words,
            "fuzzer_seconds": round(between - begun, 4), "seconds": round(seconds, 3),
        })  # fmt: skip
    (tmp_path / "against.json").write_text(json.dumps(rows, indent=1))
    assert not [row for row in rows if row["fuzzer"] and not {*row["words"]} <= ALARMS]
