"""The committed records of studies in environments: their pages say what they hold, and they follow from themselves."""

import copy
import csv
import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from harness.eta import split_returns, swaps_of
from tests.test_reference import REFERENCE, ROOT, STUDIES, comparisons_of, three, unfounded, with_interval

PAGES = ROOT / "docs" / "studies"
SIDES = ("baseline", "proposed")
WITHOUT_RECORD = {"0", "1", "2", "95"}
"""Numbers that need none: counts of two, and of which size intervals are."""
NUMBER = re.compile(r"(?<![\w.,/-])[-+]?(\d[\d,]*(?:\.\d+)?(?:e[-+]\d+)?)( ?%| pp| points)?(?![\w])")
SHARES = re.compile(r"\[([-+\d.]+), ([-+\d.]+)\] pp")
"""An interval of percentage points."""
OUTSIDE = re.compile(r"\]\(<?https?:")


def name_of(folder):
    """As `meta-world/reach`."""
    return folder.relative_to(REFERENCE).as_posix()


def page_of(folder):
    """The page of all records of a folder."""
    return (PAGES / f"{folder.relative_to(REFERENCE).parts[0]}.md").read_text()


def beside(folder):
    """All records that the same page tells of."""
    return [other for other in STUDIES if other.parent == folder.parent]


def record_of(folder):
    """Everything that the report says."""
    return json.loads((folder / "results.json").read_text().replace('"mean":', '"value":'))  # what 0.3 called a mean


def needles(record, summary, label):
    """What a page has to say of a record: the answers, every eta and its parts, and the measure that decides."""
    found = []
    for _, told in comparisons_of(record):
        pair = f"{told['proposed']} against {told['baseline']}"
        found.append(f"| {label}{pair} | {told['headline']['answer'].upper()} |")
        for split in told["returns"].values():
            found += _parts(split)
        found.append(_deciding(told, summary))
    return found


def _parts(split):
    """Eta and ruler x behaviour with their intervals; where returns below 0 leave no ratio, those of the difference."""
    ratio, difference = split["ratio"], split["difference"]
    if ratio["eta"]["value"] is not None:
        parts = f"{with_interval(ratio['ruler'])} x {with_interval(ratio['behaviour'])}"
        return [f"| {with_interval(ratio['eta'])} | {parts} |"]
    told = [f"{three(it['value'])} [{three(it['low'])}, {three(it['high'])}]" for it in difference.values()]
    return [f"| {' | '.join(told)} |"]


def _deciding(told, summary):
    """Name, both values and the interval of the difference of the measure that decides, as the summary has them."""
    pair = summary.index(f"\n### {told['proposed']} against {told['baseline']}\n")
    table = summary[summary.index(f"\nBehaviour {told['decided_in']},", pair) :]
    name = f"| {told['deciding_measure'].replace('_', ' ')} |"
    return " | ".join(next(line for line in table.splitlines() if line.startswith(name)).split(" | ")[:4])


def strange_numbers(page, records, more):
    """Numbers of a page that no record holds, whose paragraph leads to no other source either."""
    known = _written([*(number for record in records for number in _numbers(record)), *more])
    prose = re.sub(r"```.*?```|`[^`\n]*`|(?<=\])\([^)]*\)", "", _without_sources(page), flags=re.DOTALL)
    return [
        found[0]
        for found in NUMBER.finditer(SHARES.sub(r"\1 pp, \2 pp", prose))
        if found[1].replace(",", "") not in WITHOUT_RECORD | (known["share"] if found[2] else set()) | known["number"]
    ]


def _without_sources(page):
    """The paragraphs that do not say where their numbers come from."""
    return "\n\n".join(text for text in re.split(r"\n\s*\n", page) if not OUTSIDE.search(text))


def _numbers(data):
    if isinstance(data, bool):
        return
    if isinstance(data, int | float):
        yield data
    elif isinstance(data, dict | list):
        for part in data.values() if isinstance(data, dict) else data:
            yield from _numbers(part)
        if isinstance(data, list):
            yield len(data)


def _written(values):
    """As pages may round them."""
    finite = [abs(value) for value in values]
    return {
        "number": {text for value in finite for text in _texts(value)},
        "share": {text for value in finite for text in _texts(100 * value)},
    }


def _texts(value):
    return {three(value), *(f"{value:.{digits}f}" for digits in range(5))}


def contradictions(record):
    """What does not follow from the single trainings that the record holds."""
    return [line for study, told in comparisons_of(record) for line in _contradictions(study, told)]


def _contradictions(study, told):
    trained = {(run["trained_by"], run["seed"]): run["parts"] for run in study["trainings"]}
    swaps = swaps_of(sorted({seed for _, seed in trained}))
    for manner, split in told["returns"].items():
        values = {
            (payer, taught): [trained[told[taught], seed][manner]["returns"][told[payer]] for seed in told["seeds"]]
            for payer, taught in ((side, other) for side in SIDES for other in SIDES)
        }
        again, before = (_in_order(it) for it in (split_returns(values, told["seeds"], swaps).to_json(), split))
        yield from (f"{manner}: {part}" for part in again if not _alike(again[part], before[part]))
    for change in told["behaviour"]:
        sides = [
            np.mean(
                [trained[told[side], seed][change["manner"]]["behaviour"][change["name"]] for seed in told["seeds"]]
            )
            for side in SIDES
        ]
        if not _alike([*sides, sides[1] - sides[0]], [change[key] for key in ("baseline", "proposed", "difference")]):
            yield f"{change['manner']}: {change['name']}"


def _in_order(split):
    """With its returns by who pays and who was taught."""
    return {**split, "returns": sorted(split["returns"], key=lambda it: (it["paid_by"], it["trained_by"]))}


def _alike(one, other):
    """Whether the numbers are the same, but for the last digits; a p-value may have been corrected since."""
    if isinstance(one, dict):
        return all(
            _alike(one[key], other[key]) for key in one if key != "p_corrected" and (key != "seeds" or key in other)
        )
    if isinstance(one, list):
        return len(one) == len(other) and all(map(_alike, one, other))
    if isinstance(one, float | int) and isinstance(other, float | int):
        return bool(np.isclose(one, other, rtol=1e-9, atol=1e-9))
    return bool(one == other)


def parts_do_not_fit(record):
    """Where ruler and behaviour do not come to the whole."""
    found = []
    for _, told in comparisons_of(record):
        for manner, split in told["returns"].items():
            ratio, difference = split["ratio"], split["difference"]
            for path in (ratio, *ratio["paths"]):
                parts = [path[part]["value"] for part in ("ruler", "behaviour")]
                if None not in parts and not np.isclose(parts[0] * parts[1], ratio["eta"]["value"]):
                    found.append(f"{manner}: eta")
            if not np.isclose(
                difference["ruler"]["value"] + difference["behaviour"]["value"], difference["change"]["value"]
            ):
                found.append(f"{manner}: difference")
    return found


def corrected(record):
    """Every corrected p that carries a claim."""
    told = [comparison for _, comparison in comparisons_of(record)]
    values = [split["ratio"]["p_corrected"] for it in told for split in it["returns"].values()]
    values += [change["p_corrected"] for it in told for change in it["behaviour"]]
    values += [it["indices"][name]["p_corrected"] for it in told if it["indices"] for name in ("eta_N", "eta_P")]
    return {p for p in values if p is not None and p <= 0.05}


def label_of(folder):
    """What tells records of one page apart; empty where there is one."""
    return f"{folder.name}: " if len(beside(folder)) > 1 else ""


def cells_of(folder):
    """A row for each."""
    with (folder / "cells.csv").open(newline="") as file:
        return list(csv.DictReader(file))


each_study = pytest.mark.parametrize("folder", STUDIES, ids=name_of)


@each_study
def test_page_says_what_the_record_holds(folder):
    """The answer, every eta with its interval, ruler and behaviour, and the measure that decides."""
    page, summary = page_of(folder), (folder / "summary.md").read_text()
    assert [it for it in needles(record_of(folder), summary, label_of(folder)) if it not in page] == []


@each_study
def test_every_number_of_the_page_stands_in_a_record(folder):
    """Or its paragraph leads to where it comes from."""
    folders = beside(folder)
    minutes = [sum(float(cell["seconds"]) for cell in cells_of(it)) / 60 for it in folders]
    settings = [tomllib.loads((it / "experiment.toml").read_text()) for it in folders]
    records = [record_of(it) for it in folders]
    assert strange_numbers(page_of(folder), [*records, *settings], minutes) == []


@each_study
def test_page_claims_what_a_test_found(folder):
    """Where a page says better or worse it quotes a corrected p, and a record holds it."""
    known = set().union(*(corrected(record_of(it)) for it in beside(folder)))
    assert unfounded(page_of(folder), known) == []


@each_study
def test_page_shows_what_the_robot_does(folder):
    """A film of the policies, small enough for a page, and the way to run the study again."""
    page = page_of(folder)
    films = [PAGES / link for link in re.findall(r"\]\((\.\./pictures/[\w.-]+\.gif)\)", page)]
    assert films
    assert all(film.stat().st_size <= 500_000 for film in films)
    assert f"results/reference/{name_of(folder)}/summary.md" in page
    assert f"make reference EXPERIMENT={experiment_of(folder)}" in page


def experiment_of(folder):
    """What make is told."""
    names = [path.relative_to(ROOT / "experiments").with_suffix("") for path in (ROOT / "experiments").rglob("*.toml")]
    (name,) = (it for it in names if it.as_posix().replace("_", "-") == name_of(folder))
    return name.as_posix()


@each_study
def test_every_cell_is_done(folder):
    """None failed, none is missing; of ten seeds or more."""
    cells, experiment = cells_of(folder), tomllib.loads((folder / "experiment.toml").read_text())
    rewards = {experiment["baseline"], *experiment["reward"]}
    assert {cell["status"] for cell in cells} == {"done"}
    assert len(cells) == len(experiment["algo"]) * len(rewards) * len(experiment["seeds"])
    assert len(experiment["seeds"]) >= 10


@each_study
def test_the_record_follows_from_its_trainings(folder):
    """Returns, eta, ruler and behaviour with their intervals, and the measures."""
    assert contradictions(record_of(folder)) == []


@each_study
def test_ruler_and_behaviour_come_to_the_whole(folder):
    """Their product is eta, their sum the difference."""
    assert parts_do_not_fit(record_of(folder)) == []


@each_study
def test_cells_hold_what_the_record_says(folder):
    """Row by row, to the last digit."""
    rows = {cell["id"]: cell for cell in cells_of(folder)}
    runs = [run for place in record_of(folder)["studies"] for run in place["study"]["trainings"]]
    assert len(runs) == len(rows)
    for run in runs:
        row = rows[Path(run["folder"]).parent.name]
        assert (row["reward"], int(row["seed"])) == (run["trained_by"], run["seed"])
        for manner, part in run["parts"].items():
            told = {**{f"return {name}": it for name, it in part["returns"].items()}, **part["behaviour"]}
            assert {name: float(row[f"{name}, {manner}"]) for name in told} == told


@pytest.fixture(scope="module")
def small():
    """A record of two rewards and ten seeds: `thrice` pays three times as much, and teaches to earn a tenth more."""
    seeds = list(range(10))
    trained = {("plain", seed): 10.0 + seed for seed in seeds} | {("thrice", seed): 11.0 + 1.1 * seed for seed in seeds}
    values = {
        (payer, taught): [factor * trained[name, seed] for seed in seeds]
        for payer, factor in (("baseline", 1.0), ("proposed", 3.0))
        for taught, name in (("baseline", "plain"), ("proposed", "thrice"))
    }
    trainings = [
        {
            "trained_by": name,
            "seed": seed,
            "parts": {
                "in evaluations": {"returns": {"plain": earned, "thrice": 3 * earned}, "behaviour": {"way": earned}}
            },
        }
        for (name, seed), earned in trained.items()
    ]
    told = {
        "baseline": "plain",
        "proposed": "thrice",
        "seeds": seeds,
        "headline": {"answer": "helps"},
        "decided_in": "in evaluations",
        "deciding_measure": "way",
        "returns": {"in evaluations": split_returns(values, seeds, swaps_of(seeds)).to_json()},
        "indices": None,
        "behaviour": [
            {
                "name": "way",
                "manner": "in evaluations",
                "baseline": 14.5,
                "proposed": 15.95,
                "difference": 1.45,
                "p_corrected": 0.004,
            }
        ],
    }
    return json.loads(json.dumps({"studies": [{"study": {"comparisons": [told], "trainings": trainings}}]}))


SUMMARY = """
### other against plain

Behaviour in evaluations, 9 episodes

| way | 14.5 | 0.1 | [-15.0, -13.8] | higher | 0.004 | worse |

### thrice against plain

Behaviour in evaluations, 9 episodes

| way | 14.5 | 15.9 | [1.27, 1.63] | higher | 0.004 | better |
"""
PAGE = """
| thrice against plain | HELPS |
| 3.30 [3.30, 3.30] | 3.00 [3.00, 3.00] x 1.10 [1.10, 1.10] |
| way | 14.5 | 15.9 | [1.27, 1.63] | higher | 0.004 | better |
"""


def test_a_whole_page_lacks_nothing(small):
    """And no number in it is strange."""
    assert [it for it in needles(small, SUMMARY, "") if it not in PAGE] == []
    assert strange_numbers(PAGE, [small], [1.27, 1.63]) == []
    assert contradictions(small) == parts_do_not_fit(small) == []


@pytest.mark.parametrize(
    ("there", "wrong"),
    [("HELPS", "HURTS"), ("3.30 [", "3.31 ["), ("x 1.10", "x 1.11"), ("| 15.9 |", "| 16.9 |"), ("1.63]", "1.64]")],
)
def test_a_page_that_says_something_else_is_found(small, there, wrong):
    """Whichever part it is."""
    page = PAGE.replace(there, wrong)
    assert [it for it in needles(small, SUMMARY, "") if it not in page] != []


def test_a_number_from_nowhere_is_found(small, subtests):
    """Code and links are no numbers, and a source may bring some."""
    for passage, strange in [
        ("It earned 14.5.", []),
        ("It earned 14.7.", ["14.7"]),
        ("It earned 77 %.", ["77 %"]),
        ("It earned [145, 145] pp more.", []),
        ("It earned [146, 145] pp more.", ["146 pp"]),
        ("It earned 77, [they say](https://example.org).", []),
        ("Of v4 and `77`, [here](pictures/77.gif).", []),
        ("It earned 1,450 more.", ["1,450"]),
    ]:
        with subtests.test(passage=passage):
            assert strange_numbers(passage, [small], []) == strange


def _set(*path):
    """Change what stands at a path, by a hundredth."""

    def change(record):
        at = record["studies"][0]["study"]
        for part in path[:-1]:
            at = at[part]
        at[path[-1]] *= 1.01

    return change


RETURNS = ("comparisons", 0, "returns", "in evaluations")
MUTANTS = {
    "a training": _set("trainings", 3, "parts", "in evaluations", "returns", "plain"),
    "eta": _set(*RETURNS, "ratio", "eta", "value"),
    "an interval": _set(*RETURNS, "ratio", "behaviour", "low"),
    "a difference": _set(*RETURNS, "difference", "ruler", "value"),
    "a p-value": _set(*RETURNS, "ratio", "p"),
    "a measure": _set("comparisons", 0, "behaviour", 0, "proposed"),
    "what was done": _set("trainings", 12, "parts", "in evaluations", "behaviour", "way"),
}


def test_a_record_that_contradicts_itself_is_found(small, subtests):
    """Whatever was changed in it."""
    for name, change in MUTANTS.items():
        with subtests.test(name=name):
            record = copy.deepcopy(small)
            change(record)
            assert contradictions(record) != []


@pytest.mark.parametrize("part", ["ruler", "behaviour"])
def test_parts_that_do_not_come_to_the_whole_are_found(small, part):
    """In the ratio, and in the difference."""
    for path in (("ratio", part, "value"), ("difference", part, "value")):
        record = copy.deepcopy(small)
        _set(*RETURNS, *path)(record)
        assert len(parts_do_not_fit(record)) == 1
