"""The page of drives says what its record holds: two answers over four places."""

import json

import pytest

from tests.project import page_of
from tests.test_reference import REFERENCE

FOLDER = REFERENCE / "drives" / "until-decided"
PAGE = page_of("studies/drives")
PROSE = " ".join(PAGE.split())
RECORD = json.loads((FOLDER / "results.json").read_text())
POOLS = RECORD["over_places"]
LOOKS = RECORD["terms"]["looks"]


def seeds_of(reward):
    """How many seeds of a reward were trained in a place."""
    (seeds,) = {len(it["seeds"]) for it in RECORD["combinations"] if it["proposed"] == reward}
    return seeds


def seconds_of(reward, side):
    """The mean time to the target over the places."""
    rows = [row for it in RECORD["combinations"] if it["proposed"] == reward for row in it["behaviour"]]
    found = [row[side] for row in rows if (row["name"], row["manner"]) == ("time_to_target", "in the last evaluations")]
    assert len(found) == 4
    return sum(found) / len(found)


@pytest.mark.parametrize("pool", POOLS, ids=lambda it: it["proposed"])
def test_page_has_each_answer_over_all_places(pool):
    """That nothing decided, after how many seeds."""
    reward, success, sides = pool["proposed"], pool["measures"][0], ("baseline", "proposed")
    values = [f"{100 * success[side]:.1f}%" for side in sides] + [f"{seconds_of(reward, side):.3g}" for side in sides]
    assert (pool["decided_by"], pool["test"]["is_decided"]) == (None, False)
    by = f"nothing, after {seeds_of(reward)} seeds a place"
    assert f"| {reward} | {pool['answer'].upper()} | {' | '.join(values)} | {by} |" in PAGE


def test_training_ended_at_the_first_looks():
    """The first and the second of those that were planned."""
    assert [(pool["proposed"], LOOKS.index(seeds_of(pool["proposed"]))) for pool in POOLS] == [("arp", 1), ("dense", 0)]
    *others, last = LOOKS
    assert f"at {', '.join(map(str, others))} and {last} seeds of each reward in each of the four places" in PROSE


def test_the_number_says_the_opposite_everywhere():
    """By eta_N `arp` is better and `dense` worse, in every place."""
    etas = {(it["proposed"], it["simulator"]): it["eta_N"]["eta"]["value"] for it in RECORD["combinations"]}
    assert all((eta < 1.0) == (reward == "arp") for (reward, _), eta in etas.items())
    dense = [eta for (reward, _), eta in etas.items() if reward == "dense"]
    assert (round(min(dense)), round(max(dense))) == (4, 11)
    assert "four to eleven times" in PROSE
