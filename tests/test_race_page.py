"""The page of eight rewards says what its records hold: who went furthest, and what new trainings say."""

import csv
import hashlib
import json
import tomllib

import numpy as np
import pytest

from tests.project import ROOT, page_of
from tests.test_reference import RACES, REFERENCE

PAGE = page_of("studies/race")
PROSE = " ".join(PAGE.split())
EACH = pytest.mark.parametrize("name", ["arm", "pendulum"])


def record_of(name):
    """Everything that the report says."""
    return json.loads((REFERENCE / "race" / name / "results.json").read_text())


def means(reward, column):
    """Over the trainings of a reward of the pendulum."""
    with (REFERENCE / "race/pendulum/cells.csv").open(newline="") as file:
        return np.mean([float(it[column]) for it in csv.DictReader(file) if it["reward"] == reward and it[column]])


def test_there_are_two_records():
    """Both are told here, and by no other page."""
    assert [folder.name for folder in RACES] == ["arm", "pendulum"]


@EACH
def test_the_page_says_who_went_furthest_and_what_new_trainings_say(name):
    """The answer, and every interval of success that the page quotes."""
    record = record_of(name)
    (told,), chosen = record["combinations"], record["choosing"]
    used = sum(rung["candidates"] * rung["seeds"] for rung in chosen["rungs"])
    before = [0, *(rung["seeds"] for rung in chosen["rungs"])]
    used -= sum(rung["candidates"] * seeds for rung, seeds in zip(chosen["rungs"], before, strict=False))
    furthest, answer = chosen["furthest"], told["headline"]["answer"]
    said = {"helps": f"`{furthest}` helps", "learns faster": "the answer is LEARNS FASTER"}[answer]
    went = f"`{furthest}` went furthest of 7 ({used} trainings). On {chosen['fresh']} new trainings of each, {said}"
    assert went in PROSE
    assert chosen["told"].startswith(went.replace("`", ""))
    assert f"its budget of {chosen['budget']} trainings" in PROSE
    decides = [it for it in told["behaviour"] if it["name"] in ("success", "success_rate") and it["unit"] in ("", "%")]
    quoted = {f"{100 * it['low']:+.1f} to {100 * it['high']:+.1f}" for it in decides if it["low"] is not None}
    assert any(it in PROSE for it in quoted)


@EACH
def test_the_page_has_each_candidate(name, subtests):
    """Its means at each stage, and what the pendulum's are paid by themselves."""
    stages = record_of(name)["choosing"]["means"]
    for reward in stages[0]:
        with subtests.test(reward=reward):
            cells = [f"{of[reward]:.1%}" if reward in of else "" for of in stages]
            cells += [f"{means(reward, f'return_{reward}'):.1f}"] if name == "pendulum" else []
            rows = [[part.strip() for part in line.split("|")[1:-1]] for line in PAGE.splitlines()]
            assert any(row[:1] == [reward] and row[-len(cells) :] == cells for row in rows)


def test_the_page_says_what_choosing_by_pay_would_have_chosen():
    """The candidate that pays itself most succeeds least."""
    pay = {it: means(it, f"return_{it}") for it in record_of("pendulum")["choosing"]["means"][0]}
    most, next_one, *_ = sorted(pay, key=lambda it: -pay[it])
    assert (most, means(most, "behaviour_success")) == ("kinetic", 0.0)
    assert f"It paid its own training {pay[most]:,.1f} an episode, the next candidate {pay[next_one]:.1f}." in PROSE


def test_the_page_says_what_the_number_would_have_chosen():
    """The ratio of the arm's I_N, and its ruler."""
    (told,) = record_of("arm")["combinations"]
    eta, ruler = (f"{told['eta_N'][part]['value']:.3g}" for part in ("eta", "ruler"))
    assert f"that of `dense` is {eta} times the baseline's" in PROSE
    assert f"makes {ruler} of that" in PROSE


def test_the_files_of_the_candidates_are_those_that_were_trained():
    """Nobody has edited them since: their digests stand in the record."""
    needs = tomllib.loads((REFERENCE / "race" / "pendulum" / "experiment.toml").read_text())["plugins"]
    assert len(needs) == 8
    for need in needs:
        assert hashlib.sha256((ROOT / need["path"]).read_bytes()).hexdigest() == need["sha256"]
