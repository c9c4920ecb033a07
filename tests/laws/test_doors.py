"""One experiment through every door: however its files are changed, the answer is the same, or something is asked."""

import csv
import gzip
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from harness.executor import Cell
from harness.experiment.plan import Plan
from harness.record import TRACE
from harness.registry import Choice
from tests.laws.said import INTERIM, REFUSED, answered, remedies, say, typed
from tests.laws.writers import chart, evaluations, events, files, lines, monitor, paid, progress, table
from tests.results.folders import ARP, BASELINE, fail, finish
from tests.results.recordings.conftest import record
from tests.stores import create_store

NEAR = 0.6
"""Points of success that two ways of keeping the same trainings may lie apart."""
TOTAL, LENGTH, SEEDS, EPISODES = 100_000, 10, 5, 80
RIGHT = "ahead so far", (SEEDS, SEEDS)


class Kept(NamedTuple):
    """What was kept of a training: success by step, of the points of a curve or of episodes."""

    name: str
    steps: np.ndarray
    success: np.ndarray


class Door(NamedTuple):
    """A program that keeps trainings."""

    write: Callable
    is_curve: bool = True
    """Whether a row is a point of a curve, and not an episode."""
    is_text: bool = True
    """Whether its files are tables of text."""
    rows: int = 40


def trained(door):
    """Ten trainings, of which those of `prop` end better; each rises on a line, and then stays."""
    for reward, final in (("base", 0.5), ("prop", 0.85)):
        for seed in range(SEEDS):
            steps = TOTAL // door.rows * np.arange(1, door.rows + 1)
            share = (final + 0.02 * (seed - 2)) * np.minimum(steps / TOTAL / 0.6, 1.0)
            drawn = np.random.default_rng(seed + int(100 * final)).random(len(steps)) < share
            yield Kept(f"{reward}_{seed}", steps, share if door.is_curve else drawn.astype(float))


def _returns(kept):
    """What episodes paid, which differs a little."""
    return paid(kept.success) + np.random.default_rng(len(kept.name)).normal(0, 0.5, 1_000)[: len(kept.steps)]


def _progress(folder, kept):
    for name, steps, success in kept:
        progress(folder / name / "progress.csv", steps, success, **{"rollout/ep_len_mean": np.full(len(steps), LENGTH)})


def _events(folder, kept):
    for name, steps, success in kept:
        events(folder / name, steps, success)


def _chart(folder, kept):
    chart(folder / "export.csv", "global_step", {name: (steps, success) for name, steps, success in kept})


def _points(folder, kept):
    for name, steps, success in kept:
        table(folder / f"{name}.csv", {"timesteps": steps, "success_rate": success, "return": paid(success)})


def _lines(folder, kept):
    for name, *rows in kept:
        told = zip(*(it.tolist() for it in rows), strict=True)
        lines(folder / name / "metrics.jsonl", ({"env_steps": step, "episode": {"success": of}} for step, of in told))


def _evaluations(folder, kept):
    for name, steps, success in kept:
        told = np.arange(50) < np.round(50 * np.nan_to_num(success[:, None], nan=0.5))
        evaluations(folder / name / "evaluations.npz", steps, np.where(np.isnan(success[:, None]), np.nan, told))


def _monitor(folder, kept):
    for number, it in enumerate(kept):
        lengths = np.diff(it.steps, prepend=0)
        monitor(folder / it.name / "monitor.csv", _returns(it), lengths, it.success == 1, 1.7e9 + 1e5 * number)


def _tidy(folder, kept):
    rows = [
        (*it.name.rsplit("_", 1), *told)
        for it in kept
        for told in zip(_returns(it), np.diff(it.steps, prepend=0), it.success, strict=True)
    ]
    names = ("reward_fn", "seed", "return", "length", "success")
    table(folder / "results.csv", dict(zip(names, zip(*rows, strict=True), strict=True)))


def _recordings(folder, kept):
    for name, _, success in kept:
        reward, seed = name.replace("prop_9", "prop_4").split("_")[-2:]  # a copied folder has the seed that it had
        pays = {name: lambda arms: arms + 1.0 for name in ("base", "prop")}
        record(folder / name, reward, int(seed), success, pays=pays)


def _own(folder, kept):
    sim, task, learner = (Choice(name, (), name) for name in ("kinematic", "fd100-reach", "random"))
    acted = {it.name: it.success[-EPISODES:] == 1 for it in kept}
    cells = {
        name: Cell(sim, "fd100", task, learner, ARP if reward == "prop" else BASELINE, int(seed), 6, EPISODES)
        for name, (reward, seed) in ((it.name, it.name.split("_")) for it in kept)
    }
    store = create_store(folder, Plan(BASELINE.label, (*cells.values(),), (), {"sim": ["kinematic"]}))
    for it in kept:
        if len(it.steps) < DOORS["own"].rows:
            fail(store, cells[it.name], "out of memory")
        else:
            finish(store, cells[it.name], [1.0, 1.5, 0.75, 0.5, 0.25, 0.125], acted[it.name], [False] * EPISODES)


DOORS = {
    "progress": Door(_progress),
    "events": Door(_events, is_text=False),
    "chart": Door(_chart),
    "points": Door(_points),
    "lines": Door(_lines),
    "evaluations": Door(_evaluations, is_text=False, rows=16),
    "monitor": Door(_monitor, is_curve=False, rows=400),
    "tidy": Door(_tidy, is_curve=False, rows=400),
    "recordings": Door(_recordings, is_curve=False, is_text=False, rows=400),
    "own": Door(_own, is_curve=False, is_text=False, rows=400),
}


# What is done to the trainings before they are written


def of_prop(change):
    """The same, with those of `prop` changed."""
    return lambda kept: [it if it.name.startswith("base") else change(it) for it in kept]


def of_one(change):
    """The same, with one of `prop` changed."""
    return lambda kept: [change(it) if it.name == "prop_2" else it for it in kept]


def rows(kept, chosen):
    """Some rows of a training."""
    return kept._replace(steps=kept.steps[chosen], success=kept.success[chosen])


def blank(kept):
    """A value in the middle is missing."""
    success = kept.success.copy()
    success[len(success) // 2] = np.nan
    return kept._replace(success=success)


def jittered(kept):
    """Points stand up to a third of their distance off."""
    apart = np.diff(kept.steps)[0]
    steps = kept.steps + np.random.default_rng(0).integers(-apart // 3, apart // 3, len(kept.steps))
    return Kept(kept.name, steps, np.interp(steps, [0, *kept.steps], [0, *kept.success]))


def shifted(kept):
    """Points stand a little later."""
    steps = kept.steps + 700
    return Kept(kept.name, steps, np.interp(steps, kept.steps, kept.success))


CURVES = {
    "shift": of_prop(shifted),
    "thin": of_prop(lambda it: rows(it, slice(2, None, 3))),
    "jitter": of_prop(jittered),
}
"""What may be done to curves alone."""
ANY = {
    "rename": lambda kept: [it._replace(name=f"Reach_{it.name}") for it in kept],
    "reorder": lambda kept: kept[::-1],
    "copy": lambda kept: [*kept, kept[-1]._replace(name="prop_9")],
    "copy a beginning": lambda kept: [*kept, rows(kept[-1]._replace(name="prop_9"), slice(-1))],
    "cut": of_one(lambda it: rows(it, slice(len(it.steps) // 2))),
    "blank": of_one(blank),
    "percent": lambda kept: [it._replace(success=100 * it.success) for it in kept],
    "percent in one": of_one(lambda it: it._replace(success=100 * it.success)),
}
MAY_BE_ASKED = ("copy", "copy a beginning", "cut", "blank", "percent", "percent in one", "split", "damage")
"""What files do not tell by themselves."""


# What is done to files


def with_tables(change):
    """Changes the cells of every table of text."""

    def changed(folder):
        for path in files(folder).values():
            if path.suffix == ".csv":
                head, *rest = path.read_text().splitlines(keepends=True)
                kept = "" if not head.startswith("#") else head
                cells = list(csv.reader(rest if kept else [head, *rest]))
                path.write_text(
                    kept + "".join(f"{','.join(change(number, row))}\n" for number, row in enumerate(cells))
                )

    return changed


def compressed(folder):
    """By gzip."""
    for path in files(folder).values():
        path.with_name(f"{path.name}.gz").write_bytes(gzip.compress(path.read_bytes()))
        path.unlink()


def split(folder):
    """Each table into two, of the first half of its rows and of the others."""
    for path in files(folder).values():
        lines = path.read_text().splitlines(keepends=True)
        begin = (path.suffix == ".csv") + lines[0].startswith("#")
        half = (len(lines) + begin) // 2
        path.write_text("".join(lines[:half]))
        path.with_name(f"{path.stem}_more{path.suffix}").write_text("".join([*lines[:begin], *lines[half:]]))


def damaged(folder):
    """The second half of a file is lost."""
    path = [path for name, path in files(folder).items() if "prop_2" in name or path.name == TRACE][-1]
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def emptied(folder):
    """A training left a folder alone."""
    for name, path in files(folder).items():
        if "prop_2" in name:
            path.unlink()


FILES = {
    "split": split,
    "turn columns": with_tables(lambda number, row: row[::-1]),
    "add a column": with_tables(lambda number, row: [*row, f"{number * 0.5}" if number else "entropy"]),
    "compress": compressed,
}
BINARY = {"damage": damaged, "empty": emptied}
"""The same at doors of files that are no text."""
NOT_SO = {
    "chart": ("turn columns",),  # its first column is what it counts
    "evaluations": ("percent", "percent in one", "thin"),  # 0 or 1 alone is kept, and final policies alone count
    "monitor": ("percent", "percent in one", "turn columns", "split"),  # it counts from where a file begins
    "recordings": ("percent", "percent in one", "blank"),
    "own": ("percent", "percent in one", "blank", "rename", "copy", "copy a beginning", "empty"),
}
"""What cannot be done at a door."""


def changes():
    """Every change at every door at which it can be made."""
    for name, door in DOORS.items():
        possible = [*(CURVES if door.is_curve else ()), *ANY, *(FILES if door.is_text else BINARY)]
        for change in possible:
            if change not in NOT_SO.get(name, ()):
                yield name, change


@pytest.fixture(scope="module")
def said(tmp_path_factory):
    """What is said of an experiment at a door, of which the trainings or files are changed; questions are answered."""

    @cache
    def write(name, change=""):
        folder, door = tmp_path_factory.mktemp("laws") / name, DOORS[name]
        kept = list(trained(door))
        door.write(folder, {**CURVES, **ANY}.get(change, list)(kept))
        {**FILES, **BINARY}.get(change, lambda _: None)(folder)
        return answered(["report", str(folder)], {"N": str(LENGTH)})

    return write


@pytest.mark.parametrize("name", DOORS)
def test_every_door_says_what_is_right(said, name):
    """Of ten trainings by two rewards: success in the last fifth of steps, and that who ends better is ahead so far."""
    found = said(name)
    assert (found.word, found.trainings) == RIGHT, found.text
    ends = {"base": [], "prop": []}
    for kept in trained(DOORS[name]):
        ends[kept.name[:4]].append(100 * kept.success[kept.steps > 0.8 * TOTAL].mean())
    assert found.shares == pytest.approx([*map(np.mean, ends.values())], abs=NEAR)


@pytest.mark.parametrize(("name", "change"), [*changes()])
def test_a_change_of_the_files_changes_nothing_that_is_said(said, name, change):
    """Or it is asked what they mean; no verdict is given where a training is cut, or a value is missing."""
    found = said(name, change)
    if found.word == REFUSED and change in MAY_BE_ASKED:
        said_why = "percent" if "percent" in change else "line "  # and otherwise what to type
        assert remedies(found.text) or said_why in found.text, found.text
    elif change in ("cut", "blank", "split", *BINARY) and found.word == INTERIM:
        without = _without(found)
        assert change == "split" or (without.word, *sorted(without.trainings)) == (RIGHT[0], SEEDS - 1, SEEDS), (
            without.text
        )
    else:
        assert change not in ("cut", *BINARY, "percent", "percent in one"), found
        assert (found.word, found.trainings) == RIGHT, found.text
        assert found.shares == pytest.approx(said(name).shares, abs=NEAR)


@pytest.mark.parametrize("name", DOORS)
def test_an_audit_gives_no_verdict_either_where_a_training_is_cut(said, name):
    """Or damaged, until it is left out, as its answer tells."""
    for change in ("cut", "damage")[: 2 - DOORS[name].is_text]:
        _without(say(["audit", said(name, change).line[1]]))


def _without(found):
    """What is said when what is missing is left out, as the answer tells to."""
    assert found.word == INTERIM, found.text
    without = say(typed(found.line, remedies(found.text)[0], {}))
    assert without.word not in (INTERIM, REFUSED), without.text
    return without
