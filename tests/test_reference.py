"""The committed records: what their pages say is what they hold, and they can be computed again from themselves."""

import csv
import json
import tomllib
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

ROOT = Path(__file__).parents[1]
REFERENCE = ROOT / "results" / "reference"
FOLDERS = sorted(path.parent for path in REFERENCE.glob("*/results.json"))
LETTERS = {"n": "I_N", "p": "I_P"}


def combinations(folder: Path) -> list[dict[str, Any]]:
    """What a record says of each pair of rewards."""
    found: list[dict[str, Any]] = json.loads((folder / "results.json").read_text())["combinations"]
    return found


def text(ratio: dict[str, Any]) -> str:
    """As pages write it: three digits, or why there are none."""
    if ratio["value"] is None:
        return "n/a"
    return "near zero" if "near zero" in ratio["note"] else three(ratio["value"])


def three(value: float) -> str:
    """Three significant digits, trailing zeros kept."""
    return f"{value:#.3g}".rstrip(".")


def with_interval(ratio: dict[str, Any]) -> str:
    """A ratio and its interval, if it has one that says something."""
    known = ratio["low"] is not None and "near zero" not in ratio["note"]
    return f"{text(ratio)} [{three(ratio['low'])}, {three(ratio['high'])}]" if known else text(ratio)


def test_there_are_records():
    """Of the published experiment and of the FD100."""
    assert [folder.name for folder in FOLDERS] == ["arp-2021", "fd100"]


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)
def test_page_says_what_the_record_holds(folder: Path):
    """Every eta with its interval, ruler and behaviour stand in the page as they stand in the record."""
    page = (ROOT / "docs" / f"{folder.name}.md").read_text()
    missing = [
        (combination["algorithm"], combination["proposed"], letter, needle)
        for combination in combinations(folder)
        for letter in LETTERS
        for needle in (
            with_interval(combination[f"eta_{letter}"]),
            f"{text(combination[f'ruler_{letter}'])} x {text(combination[f'behaviour_{letter}'])}",
        )
        if needle not in page
    ]
    assert missing == []


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)
def test_every_cell_is_done(folder: Path):
    """None failed, none is missing."""
    with (folder / "cells.csv").open(newline="") as file:
        cells = list(csv.DictReader(file))
    experiment = tomllib.loads((folder / "experiment.toml").read_text())
    rewards = {json.dumps(reward, sort_keys=True) for reward in [experiment["baseline"], *experiment["reward"]]}
    assert {cell["status"] for cell in cells} == {"done"}
    assert len(cells) == len(experiment["sim"]) * len(experiment["algo"]) * len(rewards) * len(experiment["seeds"])


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)
def test_indices_follow_from_the_curves(folder: Path):
    """I_N and I_P of both rewards, summed over the thinned mean curves, to a hundredth of the larger one."""
    curves: dict[tuple[str, ...], list[tuple[float, int]]] = {}
    for row in pq.read_table(folder / "curves.parquet").to_pylist():
        key = (row["simulator"], row["algorithm"], row["trained_with"], row["scored_by"])
        curves.setdefault(key, []).append((row["value"], row["every"]))
    for combination in combinations(folder):
        names = combination["simulator"], combination["algorithm"]
        for side in ("baseline", "proposed"):
            own = curves[(*names, combination[side], combination[side])]
            index = combination[f"{side}_index"]
            room = 0.01 * max(-index["I_N"], index["I_P"])
            assert sum(min(value, 0.0) * every for value, every in own) == pytest.approx(index["I_N"], abs=room)
            assert sum(max(value, 0.0) * every for value, every in own) == pytest.approx(index["I_P"], abs=room)


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)
def test_eta_is_ruler_times_behaviour_along_both_paths(folder: Path):
    """Where all parts have a value."""
    for combination in combinations(folder):
        for letter in LETTERS:
            for path in (combination, combination["other_path"]):
                parts = [path[f"{part}_{letter}"]["value"] for part in ("ruler", "behaviour")]
                if None not in parts:
                    assert parts[0] * parts[1] == pytest.approx(combination[f"eta_{letter}"]["value"])


def test_published_etas_are_those_of_the_published_sums():
    """The table is consistent in itself."""
    published = tomllib.loads((REFERENCE / "arp-2021" / "published.toml").read_text())
    for letter, name in LETTERS.items():
        ratio = published["proposed"][name] / published["baseline"][name]
        assert published[f"eta_{letter}"] == pytest.approx(ratio, abs=5e-9)


def test_page_quotes_the_published_table():
    """As the sources print it, rounded."""
    published = tomllib.loads((REFERENCE / "arp-2021" / "published.toml").read_text())
    page = (ROOT / "docs" / "arp-2021.md").read_text()
    assert f"| eta_N | {three(published['eta_n'])} |" in page
    assert f"| eta_P | {three(published['eta_p'])} |" in page
    for side, title in (("baseline", "baseline"), ("proposed", "ARP")):
        assert f"| cross-over step, {title} | {published[side]['crossover']:,} |" in page
