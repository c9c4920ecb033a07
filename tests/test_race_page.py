"""The page of eight rewards says what its records hold, and what choosing one of them comes to."""

import csv
import hashlib
import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

from harness.eta import SHARE, Question, halve, rule, schedule_of
from harness.report.rows.ratios import format_number
from tests.test_reference import RACES, REFERENCE

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "studies" / "race.md").read_text()
PROSE = " ".join(PAGE.split())
DECIDING = {"pendulum": "behaviour_success", "arm": "success_rate"}
CHOICES = {"pendulum": ("own", 48), "arm": ("baseline", 31)}
"""The baseline of each, and the budget."""
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


def chosen(name):
    """How far the candidates of a record go, and with how many new trainings the last one is asked about."""
    baseline, budget = CHOICES[name]
    values = {reward: it for reward, it in successes(name).items() if reward != baseline}
    schedule = schedule_of(len(values), budget, 1)
    complete = {reward: int(np.isfinite(it).sum()) for reward, it in values.items()}
    return halve(values, schedule.rungs, complete, [SHARE]), schedule


def test_there_are_two_records():
    """Both are told here, and by no other page."""
    assert [folder.name for folder in RACES] == ["arm", "pendulum"]


@EACH
def test_the_page_says_who_goes_furthest_and_what_new_trainings_say(name):
    """On seeds that had no part in choosing."""
    (found, schedule), all_of, (baseline, budget) = chosen(name), successes(name), CHOICES[name]
    new = slice(schedule.seeds, schedule.seeds + schedule.fresh)
    both = np.stack([all_of[baseline][0, new], all_of[found.furthest][0, new]])
    ruling = rule([Question.of(both[..., None, None], np.array([[SHARE]]))])[0]
    assert (ruling.is_ahead, ruling.sign) == (True, 1)
    told = f"`{found.furthest}` goes furthest of 7 ({schedule.trainings(1) - 2 * schedule.fresh} trainings)."
    assert f"{told} On {schedule.fresh} new trainings of each it is ahead so far:**" in PROSE
    assert f"With {budget} trainings" in PROSE
    of_baseline, of_chosen = both.mean(axis=1)
    assert f"{of_chosen:.1%} succeed instead of {of_baseline:.1%}" in PROSE.replace(" of the episodes", "")


@EACH
def test_the_page_has_each_candidate(name, subtests):
    """Its means at each stage, those of all of its trainings, and what is paid."""
    found, _ = chosen(name)
    for reward in found.means[0]:
        with subtests.test(reward=reward):
            went = " | ".join(f"{of[reward]:.1%}" if reward in of else "" for of in found.means)
            count = int(np.isfinite(successes(name)[reward]).sum())
            told = f"| {went} | {count} | {means(name, reward, DECIDING[name]):.1%} | {_paid(name, reward)} |"
            assert any(
                line.startswith(f"| {reward} |") and line.endswith(told.replace("|  |", "| |").replace("|  |", "| |"))
                for line in PAGE.splitlines()
            )


def _paid(name, reward):
    if name == "pendulum":
        return f"{means(name, reward, f'return_{reward}'):.1f}"
    split = next(it["eta_N"] for it in record_of(name)["combinations"] if it["proposed"] == reward)
    return " | ".join(_times(split[part]) for part in ("eta", "ruler"))


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


def test_the_files_of_the_candidates_are_those_that_were_trained():
    """Nobody has edited them since: their digests stand in the record."""
    needs = tomllib.loads((REFERENCE / "race" / "pendulum" / "experiment.toml").read_text())["plugins"]
    assert len(needs) == 8
    for need in needs:
        assert hashlib.sha256((ROOT / need["path"]).read_bytes()).hexdigest() == need["sha256"]
