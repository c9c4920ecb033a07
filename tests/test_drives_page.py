"""The page of drives says what its record holds: two answers over four places, and what they cost."""

import csv
import json
from pathlib import Path

import pytest

from tests.test_reference import REFERENCE, three

ROOT = Path(__file__).parents[1]
FOLDER = REFERENCE / "drives" / "until-decided"
PAGE = (ROOT / "docs" / "studies" / "drives.md").read_text()
PROSE = " ".join(PAGE.split())
RECORD = json.loads((FOLDER / "results.json").read_text())
POOLS = RECORD["over_places"]
LOOKS = RECORD["terms"]["looks"]


def seeds_of(reward):
    """How many seeds of a reward were trained in a place."""
    (seeds,) = {len(it["seeds"]) for it in RECORD["combinations"] if it["proposed"] == reward}
    return seeds


@pytest.mark.parametrize("pool", POOLS, ids=lambda it: it["proposed"])
def test_page_has_each_answer_over_all_places(pool):
    """With what decided, after how many seeds."""
    success, time = pool["measures"]
    values = [f"{100 * success[side]:.1f}%" for side in ("baseline", "proposed")]
    values += [f"{time[side]:.3g}" for side in ("baseline", "proposed")]
    by = f"{pool['decided_by'].replace('_', ' ')} after {seeds_of(pool['proposed'])} seeds a place"
    p = f"corrected p {pool['test']['p_corrected']:.3f}"
    assert f"| {pool['proposed']} | {pool['answer'].upper()} | {' | '.join(values)} | {by}, {p} |" in PAGE
    assert f"in at least {pool['better_in']}" in PROSE


def test_both_questions_are_decided_at_the_looks_that_the_page_names():
    """The first and the second of those that were planned."""
    assert [(pool["proposed"], LOOKS.index(seeds_of(pool["proposed"]))) for pool in POOLS] == [("arp", 1), ("dense", 0)]
    assert all(pool["test"]["is_decided"] for pool in POOLS)
    *others, last = LOOKS
    assert f"at {', '.join(map(str, others))} and {last} seeds of each reward in each of the four places" in PROSE


def test_page_says_what_it_cost():
    """Trainings that were done, the most that there could have been, and those of ten seeds each."""
    with (FOLDER / "cells.csv").open(newline="") as file:
        statuses = [row["status"] for row in csv.DictReader(file)]
    places, rewards = len(POOLS[0]["places"]), 1 + len(POOLS)
    assert f"{statuses.count('done')} trainings of at most {len(statuses)}" in PROSE
    assert f"Ten seeds of everything would have taken {10 * places * rewards} trainings" in PROSE


def test_the_number_says_the_opposite_everywhere():
    """By eta_N `arp` is better and `dense` worse, in every place."""
    etas = {(it["proposed"], it["simulator"]): it["eta_N"]["eta"]["value"] for it in RECORD["combinations"]}
    assert all((eta < 1.0) == (reward == "arp") for (reward, _), eta in etas.items())
    dense = [eta for (reward, _), eta in etas.items() if reward == "dense"]
    assert (round(min(dense)), round(max(dense))) == (4, 11)
    assert "four to eleven times" in PROSE


def test_page_says_how_wide_the_interval_is():
    """Of the time with `arp`."""
    time = POOLS[0]["measures"][1]
    assert f"from +{three(time['low'])} to +{three(time['high'])} s" in PROSE
