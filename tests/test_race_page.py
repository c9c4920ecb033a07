"""The page of two races says what their records hold, and the races follow from their cells."""

import csv
import hashlib
import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

from harness.eta import race
from harness.report.rows.ratios import format_number
from tests.test_reference import RACES, REFERENCE

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "studies" / "race.md").read_text()
PROSE = " ".join(PAGE.split())
DECIDING = {"pendulum": "behaviour_success", "arm": "success_rate"}
EACH = pytest.mark.parametrize("name", DECIDING)


def record_of(name):
    """Everything that the report says."""
    return json.loads((REFERENCE / "race" / name / "results.json").read_text())


def cells_of(name):
    """A row for each, in the order of the plan."""
    with (REFERENCE / "race" / name / "cells.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def successes(name):
    """Of each reward, by seed; NaN where a seed was not needed."""
    found = {}
    for cell in cells_of(name):
        found.setdefault(cell["reward"], []).append(float(cell[DECIDING[name]] or "nan"))
    return {reward: np.array([values]) for reward, values in found.items()}


def means(name, reward, column):
    """Over the seeds of a reward that were trained."""
    rows = [cell for cell in cells_of(name) if (cell["reward"], cell["status"]) == (reward, "done")]
    return float(np.mean([float(cell[column]) for cell in rows]))


def test_there_are_two_races():
    """Both are told here, and by no other page."""
    assert [folder.name for folder in RACES] == ["arm", "pendulum"]


@EACH
def test_the_race_follows_from_its_cells(name):
    """Who left when, and who is left."""
    told, looks = record_of(name)["looks"], record_of(name)["terms"]["looks"]
    values = successes(name)
    complete = {
        reward: sum(int(np.isfinite(of_reward).sum()) >= seeds for seeds in looks)
        for reward, of_reward in values.items()
    }
    assert json.loads(json.dumps(race(values, looks, complete).to_json())) == told["race"]


@EACH
def test_no_training_was_needed_beyond_the_race(name):
    """Every cell is done, or not needed; the page says how many there are of each."""
    ended = [cell["status"] for cell in cells_of(name)]
    assert set(ended) == {"done", "not needed"}
    assert f"{ended.count('done')} trainings" in PROSE
    assert f"{len(ended)}." in PROSE


def ends(name, reward):
    """How it ended for a reward, as the page says."""
    told = record_of(name)["looks"]["race"]
    if reward in told["beaten"]:
        return f"worse than {told['beaten'][reward]['by']}"
    return "within 5 points of the best" if told["is_close"] else "can be the best"


def test_the_page_has_each_candidate_of_the_pendulum(subtests):
    """Seeds, success, what it paid itself, and how it ended."""
    for reward in sorted(successes("pendulum")):
        with subtests.test(reward=reward):
            seeds = int(np.isfinite(successes("pendulum")[reward]).sum())
            success, pay = means("pendulum", reward, "behaviour_success"), means("pendulum", reward, f"return_{reward}")
            row = f"| {seeds} | {success:.1%} | {pay:.1f} | {ends('pendulum', reward)} |"
            (line,) = (line for line in PAGE.splitlines() if line.startswith(f"| {reward} | ") and line.endswith(row))
            assert line


def test_the_page_has_each_reward_of_the_arm(subtests):
    """Seeds, success, its I_N and the ruler in it, and how it ended."""
    for reward in sorted(successes("arm")):
        with subtests.test(reward=reward):
            seeds = int(np.isfinite(successes("arm")[reward]).sum())
            split = next((it["eta_N"] for it in record_of("arm")["combinations"] if it["proposed"] == reward), None)
            number = [""] * 2 if split is None else [_times(split[part]) for part in ("eta", "ruler")]
            told = " | ".join([f"| {reward}", str(seeds), f"{means('arm', reward, 'success_rate'):.1%}", *number])
            assert f"{told} | {ends('arm', reward)} |".replace("|  |", "| |").replace("|  |", "| |") in PAGE


def _times(ratio):
    known = ratio["value"] is not None and "near zero" not in ratio["note"]
    return f"x {format_number(ratio['value'])}" if known else "n/a"


def test_the_page_says_what_choosing_by_pay_would_have_chosen():
    """The candidate that pays itself most succeeds least."""
    pay = {it: means("pendulum", it, f"return_{it}") for it in successes("pendulum")}
    most, next_one, *_ = sorted(pay, key=lambda it: -pay[it])
    assert most == "kinetic"
    assert means("pendulum", most, "behaviour_success") == 0.0
    assert f"It paid its own trainings {pay[most]:,.1f} an episode, the next candidate {pay[next_one]:.1f}." in PROSE
    (told,) = (it for it in record_of("pendulum")["combinations"] if it["proposed"] == most)
    ruler = told["returns"]["in evaluations"]["difference"]["ruler"]["mean"]
    assert f"makes {format_number(ruler)} of its lead" in PROSE


def test_the_files_of_the_candidates_are_those_that_raced():
    """Nobody has edited them since: their digests stand in the record."""
    needs = tomllib.loads((REFERENCE / "race" / "pendulum" / "experiment.toml").read_text())["plugins"]
    assert len(needs) == 8
    for need in needs:
        assert hashlib.sha256((ROOT / need["path"]).read_bytes()).hexdigest() == need["sha256"]
