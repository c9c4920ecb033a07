"""The committed records: what their pages say is what they hold, and they can be computed again from themselves."""

import csv
import json
import math
import re
import tomllib
from collections import Counter

import pyarrow.parquet as pq
import pytest
import scipy.stats

from tests.project import ROOT, page_of

REFERENCE = ROOT / "results" / "reference"
ALL = sorted(path.parent for path in REFERENCE.glob("**/results.json"))
RACES = [folder for folder in ALL if json.loads((folder / "results.json").read_text()).get("choosing")]
"""Those in which one of several rewards is chosen; `tests/test_race_page.py` is about them."""
RECORDS = [folder for folder in ALL if folder not in RACES]
STUDIES = [folder for folder in RECORDS if "studies" in json.loads((folder / "results.json").read_text())]
"""Those in environments; `tests/test_study_records.py` is about them."""
FOLDERS = [folder for folder in RECORDS if folder not in STUDIES]
INDICES = {"eta_N": "I_N", "eta_P": "I_P"}
SHARES = ("success_rate", "ground_hits", "obstacle_hits", "timeouts", "spl")
CLAIM = re.compile(r"\b(better|worse|helps|hurts|(ahead|behind) so far)\b", re.IGNORECASE)
NO_CLAIM = re.compile(r"(called|made|counts as) (better|worse)|better or worse|helps or hurts|say(s)? better|\?$")
QUOTED_P = re.compile(r"corrected p (< )?(\d\.\d+)")
QUOTED_BOUNDS = re.compile(r"([-+][\d.]+) to ([-+][\d.]+)")


def page_about(folder):
    """The page that tells of a record; those in one folder share one, as do those of what the sources leave open."""
    if folder.parent != REFERENCE:
        return page_of(f"studies/{folder.parent.name}")
    name = "arp-2021-settings" if folder.name.startswith("arp-2021-") else folder.name
    return page_of(name)


def records_of(folder):
    """All records that the same page tells of."""
    return [other for other in FOLDERS if page_about(other) == page_about(folder)]


def comparisons_of(record):
    """Every comparison of a record in environments, with its study."""
    for place in record["studies"]:
        for comparison in place["study"]["comparisons"]:
            yield place["study"], comparison


def over_places(folder):
    """What a record says of each reward over all places; nothing where there is one place."""
    return json.loads((folder / "results.json").read_text()).get("over_places", [])


def combinations(folder):
    """What a record says of each pair of rewards."""
    return json.loads((folder / "results.json").read_text())["combinations"]


def text(ratio):
    """As pages write it: three digits, or why there are none."""
    if ratio["value"] is None:
        return "n/a"
    return "near zero" if "near zero" in ratio["note"] else three(ratio["value"])


def three(value):
    """Three significant digits, trailing zeros kept."""
    return f"{value:#.3g}".rstrip(".")


def with_interval(ratio):
    """A ratio and its interval, if it has one that says something."""
    known = ratio["low"] is not None and "near zero" not in ratio["note"]
    return f"{text(ratio)} [{three(ratio['low'])}, {three(ratio['high'])}]" if known else text(ratio)


def test_there_are_records():
    """Of the published experiment and what its sources leave open, of drives, of four engines, and of the FD100."""
    changed = ["bonus", "budget", "k1", "settings", "target"]
    engines = [f"engines/{name}" for name in ("reach-ppo", "reach-sac-fast", "target-ppo", "target-sac-fast")]
    expected = ["arp-2021", *(f"arp-2021-{name}" for name in changed), "drives/until-decided", *engines, "fd100"]
    assert [folder.relative_to(REFERENCE).as_posix() for folder in FOLDERS] == expected


def test_page_says_what_the_record_holds(subtests):
    """Every eta with its interval, ruler and behaviour stand in the page as they stand in the record.

    Where a page leads to the records for every row, it need not say them again.
    """
    for folder in FOLDERS:
        with subtests.test(folder=folder):
            page, summary = page_about(folder), f"results/reference/{folder.relative_to(REFERENCE)}/summary.md"
            if summary in page.partition("## Every row")[2]:
                page += (ROOT / summary).read_text()
            missing = [
                (combination["algorithm"], combination["proposed"], name, needle)
                for combination in combinations(folder)
                for name in INDICES
                for needle in (
                    with_interval(combination[name]["eta"]),
                    f"{text(combination[name]['ruler'])} x {text(combination[name]['behaviour'])}",
                )
                if needle not in page
            ]
            assert missing == []


def test_page_gives_the_answer_of_the_record(subtests):
    """Each combination's row begins with its reward and the record's answer about the robot.

    Where a study has many places, a row counts the answers of a reward in all of them.
    """
    for folder in FOLDERS:
        with subtests.test(folder=folder):
            page, answers = (
                page_about(folder),
                Counter((it["proposed"], it["headline"]["answer"]) for it in combinations(folder)),
            )
            counted = [line for line in page.splitlines() if line.startswith(f"| {folder.name} |")]
            missing = [
                (reward, answer, count)
                for (reward, answer), count in answers.items()
                if not (
                    any(f"| {reward} |" in line and f"{count} {answer.upper()}" in line for line in counted)
                    if counted
                    else f"| {reward} | {answer.upper()} |" in page
                )
            ]
            assert missing == []


def corrected(folder):
    """Every corrected p of a record that carries a claim."""
    told = combinations(folder)
    values = [it[name]["p_corrected"] for it in told for name in INDICES]
    values += [change["p_corrected"] for it in told for change in it["behaviour"]]
    values += [change["p_corrected"] for it in told for at in it["along_the_budget"] for change in at["behaviour"]]
    values += [it["test"]["p_corrected"] for it in over_places(folder)]
    return {p for p in values if p is not None and p <= 0.05}


def bounds(folder):
    """The intervals, as pages write them, that leave out 0, of what decides where a plain word is said."""
    pooled = [measure for it in over_places(folder) if it["test"]["is_decided"] for measure in it["measures"]]
    alone = [change for it in combinations(folder) if it["test"]["is_decided"] for change in it["behaviour"]]
    return {
        tuple(f"{it[end] * (1 if it.get('unit') else 100):+.{digits}f}" for end in ("low", "high"))
        for it in (*pooled, *alone)
        if it["low"] is not None and it["low"] * it["high"] > 0.0
        for digits in (1, 2)
    }


def unfounded(page, known, plain=frozenset()):
    """Passages that say better, worse or so far without a corrected p of the record, or an interval of a plain word."""
    passages = [" ".join(it.split()) for it in re.split(r"\n\s*\n|\n(?=[*|#])", page)]
    return [
        passage
        for passage in passages
        if CLAIM.search(NO_CLAIM.sub("", passage)) and not _founded(passage, known, plain)
    ]


def _founded(passage, known, plain):
    quoted, ends = QUOTED_P.findall(passage), QUOTED_BOUNDS.findall(passage)
    return (
        bool(quoted or ends)
        and set(ends) <= plain
        and all(
            any(p < float(number) if less else f"{p:.{len(number) - 2}f}" == number for p in known)
            for less, number in quoted
        )
    )


def test_page_claims_what_a_test_found(subtests):
    """Where a page says better or worse it quotes a corrected p or the interval of a plain word, as the record does."""
    for folder in FOLDERS:
        with subtests.test(folder=folder):
            known, plain = (set().union(*map(told, records_of(folder))) for told in (corrected, bounds))
            assert unfounded(page_about(folder), known, plain) == []


@pytest.mark.parametrize(
    ("passage", "is_founded"),
    [
        ("The robot is worse.", False),
        ("The robot is worse (corrected p 0.031).", True),
        ("The robot is worse (corrected p 0.030).", False),
        ("The robot is better (corrected p < 0.001).", False),
        ("The robot is ahead so far.", False),
        ("The robot is better (+2.4 to +20.7).", True),
        ("The robot is better (-2.4 to +20.7).", False),
        ("eta_N below 1 is called better.", True),
    ],
)
def test_a_claim_without_its_p_is_found(passage, is_founded):
    """The check fails on a claim that no record carries."""
    assert (unfounded(passage, {0.03125}, {("+2.4", "+20.7")}) == []) == is_founded


def beyond(data, least, greatest):
    """Whatever has an interval that leaves this range."""
    if isinstance(data, list):
        return [it for part in data for it in beyond(part, least, greatest)]
    if not isinstance(data, dict):
        return []
    inside = [it for part in data.values() for it in beyond(part, least, greatest)]
    leaves = data.get("low") is not None and not least <= data["low"] <= data["high"] <= greatest
    return [*inside, data] if leaves else inside


def test_no_interval_of_a_share_leaves_what_it_can_be(subtests):
    """A share lies between 0 and 1, and two of them are 1 apart at most."""
    for folder in RECORDS:
        with subtests.test(folder=folder):
            record = json.loads((folder / "results.json").read_text())
            told = record["combinations"] if folder in FOLDERS else [it for _, it in comparisons_of(record)]
            changes = [
                change
                for it in told
                for changes in (it["behaviour"], *(moment["behaviour"] for moment in it.get("along_the_budget", ())))
                for change in changes
            ]
            curves = [it["learning"]["metrics"] for it in told if it.get("learning")] if folder in FOLDERS else []
            assert beyond([change for change in changes if change["episodes"] is not None], -1.0, 1.0) == []
            assert beyond([metrics[name] for metrics in curves for name in SHARES if name in metrics], 0.0, 1.0) == []


def test_every_cell_is_done(subtests):
    """None failed, none is missing; where training ends with the answer, some are not needed."""
    for folder in FOLDERS:
        with subtests.test(folder=folder):
            with (folder / "cells.csv").open(newline="") as file:
                cells = list(csv.DictReader(file))
            experiment = tomllib.loads((folder / "experiment.toml").read_text())
            terms = json.loads((folder / "results.json").read_text()).get("terms", {"looks": []})
            rewards = [json.dumps(reward, sort_keys=True) for reward in [experiment["baseline"], *experiment["reward"]]]
            assert {cell["status"] for cell in cells} == ({"done", "not needed"} if terms["looks"] else {"done"})
            # A baseline among the proposed rewards is the null control, trained with seeds of its own.
            seeds = terms["looks"][-1] if terms["looks"] else len(experiment["seeds"])
            assert len(cells) == len(experiment["sim"]) * len(experiment["algo"]) * len(rewards) * seeds


def test_indices_follow_from_the_curves(subtests):
    """I_N and I_P of both rewards, summed over the thinned mean curves, to a hundredth of the larger one."""
    for folder in FOLDERS:
        with subtests.test(folder=folder):
            curves = {}
            for row in pq.read_table(folder / "curves.parquet").to_pylist():
                key = (row["simulator"], row["algorithm"], row["seeds"], row["trained_with"], row["scored_by"])
                curves.setdefault(key, []).append((row["value"], row["every"]))
            for combination in combinations(folder):
                names = combination["simulator"], combination["algorithm"], " ".join(map(str, combination["seeds"]))
                for side in ("baseline", "proposed"):
                    again = " (other seeds)" * (side == "proposed" and combination["is_control"])
                    own = curves[(*names, combination[side] + again, combination[side])]
                    index = combination[f"{side}_index"]
                    room = 0.01 * max(-index["I_N"], index["I_P"])
                    assert sum(min(value, 0.0) * every for value, every in own) == pytest.approx(index["I_N"], abs=room)
                    assert sum(max(value, 0.0) * every for value, every in own) == pytest.approx(index["I_P"], abs=room)


def test_eta_is_ruler_times_behaviour(subtests):
    """Along both paths and in their geometric means, where all parts have a value."""
    for folder in FOLDERS:
        with subtests.test(folder=folder):
            for combination in combinations(folder):
                for name in INDICES:
                    split = combination[name]
                    for path in (split, *split["paths"]):
                        parts = [path[part]["value"] for part in ("ruler", "behaviour")]
                        if None not in parts:
                            assert parts[0] * parts[1] == pytest.approx(split["eta"]["value"])


def test_change_of_the_sum_is_ruler_and_behaviour(subtests):
    """I_N + I_P, NOTE eq. 38."""
    for folder in FOLDERS:
        with subtests.test(folder=folder):
            for combination in combinations(folder):
                parts = {name: part["mean"] for name, part in combination["total"].items()}
                assert parts["ruler"] + parts["behaviour"] == pytest.approx(parts["change"], rel=1e-6, abs=1e-6)


def test_published_etas_are_those_of_the_published_sums():
    """The table is consistent in itself."""
    published = tomllib.loads((REFERENCE / "arp-2021" / "published.toml").read_text())
    for eta, index in INDICES.items():
        ratio = published["proposed"][index] / published["baseline"][index]
        assert published[eta.lower()] == pytest.approx(ratio, abs=5e-9)


def test_page_quotes_the_published_table():
    """As the sources print it, rounded."""
    published = tomllib.loads((REFERENCE / "arp-2021" / "published.toml").read_text())
    page = page_of("arp-2021")
    assert f"| eta_N | {three(published['eta_n'])} |" in page
    assert f"| eta_P | {three(published['eta_p'])} |" in page
    for side, title in (("baseline", "baseline"), ("proposed", "ARP")):
        assert f"| cross-over step, {title} | {published[side]['crossover']:,} |" in page


def seed_by_seed(cells, reward, index):
    """Geometric mean of single seeds' etas, and its interval by Student's t."""
    values = {(cell["reward"], int(cell["seed"])): float(cell[index]) for cell in cells}
    seeds = sorted(seed for label, seed in values if label == reward)
    logs = [math.log(values[reward, seed] / values["baseline", seed]) for seed in seeds]
    interval = scipy.stats.ttest_1samp(logs, 0.0).confidence_interval()
    return math.exp(sum(logs) / len(logs)), math.exp(interval.low), math.exp(interval.high)


@pytest.mark.parametrize("reward", ["arp", "arp:k2=2"])
@pytest.mark.parametrize("name", INDICES)
def test_sac_and_sac_fast_give_the_same_etas(reward, name):
    """The same experiment by stable-baselines3's SAC: each eta lies within the other's interval, seed by seed."""
    with (REFERENCE / "arp-2021" / "sac-cells.csv").open(newline="") as file:
        value, low, high = seed_by_seed(list(csv.DictReader(file)), reward, INDICES[name])
    lean = next(
        it[name]["per_seed"]
        for it in combinations(REFERENCE / "arp-2021")
        if (it["algorithm"], it["proposed"]) == ("sac-fast", reward)
    )
    assert low <= lean["value"] <= high
    assert lean["low"] <= value <= lean["high"]
