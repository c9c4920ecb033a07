"""Contracts as reward-contract-fuzzer is given them: every hack is found, without the table and what was meant.

That one has to be given every transition and what a designer meant; a search here is given ``reset``, ``step`` and what
success is.
"""

import pytest

from harness_plugins.audit import find_cheats
from tests.plugins.audit.search.contracts import CONTRACTS, ContractEnv

SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("contract", CONTRACTS, ids=lambda it: it.name)
def test_every_hack_is_found_and_no_honest_contract_is_blamed(contract, seed):
    """An alarm for each hacked one, none for the others."""
    make = {"success": "success", "budget": 20_000, "starts": 2, "seed": seed}
    (found,) = find_cheats(lambda: ContractEnv(contract), {"own": "own"}, **make).cheats
    assert (found.word in {"PAYS FOR FAILING", "PAYS FOR LOITERING"}) == contract.is_hacked
