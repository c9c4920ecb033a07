"""An experiment's folder: what is done is what it says is done."""

import json
import os
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

from harness.errors import NewerFormat, SchemaError, UsageError
from harness.record import EXPERIMENT, LOG, MANIFEST, PLAN, TRACE, Manifest, Store, partial_folder, read_manifest
from tests.stores import create_store


def _finish(store, cell, **fields):
    folder = store.cell_folder(cell)
    folder.mkdir(exist_ok=True)
    (folder / TRACE).write_bytes(b"rows")
    Manifest(cell, **{"status": "done", **fields}).write(folder)


@pytest.fixture
def cell(make_cell):
    """A cell of seed 0."""
    return make_cell()


@pytest.fixture
def create(make_cell, make_plan, tmp_path):
    """Make a plan of these seeds in a folder of `tmp_path`, or in it."""

    def create(*seeds, out=".", **more):
        return create_store(tmp_path / out, make_plan(*(make_cell(seed=seed) for seed in seeds), **more))

    return create


def _seeds(folder):
    return [cell.seed for cell in Store.open(folder).read_plan().cells]


def test_new_folder_holds_the_plan(create):
    """The cells, in their order, and the label of the baseline are read as they were planned; JSON that others read."""
    store = create(1, 0, out="deep/down", baseline="base")
    plan = store.read_plan()
    assert ([cell.seed for cell in plan.cells], plan.baseline) == ([1, 0], "base")
    told = json.loads((store.folder / PLAN).read_text())
    assert (told["baseline"], told["a_a"], told["control"]) == ("base", False, [])
    assert told["cells"] == [cell.to_json() for cell in plan.cells]


def test_new_folder_holds_the_experiment(cell, make_plan, tmp_path):
    """`experiment.toml` is the resolved experiment; TOML has no null, so what is None is left out at every depth."""
    resolved = {"sim": [{"name": "ideal", "dt": None, "k": 1}], "task": {"name": "x", "limit": None}, "robot": None}
    store = create_store(tmp_path, replace(make_plan(cell), resolved=resolved))
    written = tomllib.loads((store.folder / EXPERIMENT).read_text())
    assert written == {"sim": [{"name": "ideal", "k": 1}], "task": {"name": "x"}}


FOREIGN = {
    "another file": ["thesis.tex"],
    "a summary": [EXPERIMENT, "cells.csv"],
    "an experiment that somebody wrote": [EXPERIMENT],
    "cells without a plan": ["cells/theirs"],
}


@pytest.mark.parametrize("names", FOREIGN.values(), ids=FOREIGN)
def test_foreign_folder_is_left_alone(create, tmp_path, names):
    """It is not opened, not run in, and stays as it is."""
    for name in names:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("kept")
    with pytest.raises(UsageError, match=r"is no experiment: it holds no plan\.json"):
        Store.open(tmp_path)
    with pytest.raises(UsageError, match="holds something else than an experiment: name a new or empty folder"):
        create(0)
    found = {path.relative_to(tmp_path).as_posix(): path.read_text() for path in tmp_path.rglob("*") if path.is_file()}
    assert found == dict.fromkeys(names, "kept")


@pytest.mark.parametrize(
    ("lay", "out", "told"),
    [
        (Path.touch, "out", r"--out '.*out' is a file: name a folder"),
        (Path.touch, "out/deep", r"cannot be written: '.*out' allows no writing here"),
        (lambda path: path.symlink_to("nowhere"), "out", r"--out '.*out' cannot be made: File exists"),
    ],
)
def test_folder_that_cannot_be_made_is_refused(create, tmp_path, lay, out, told):
    """What is in the way is named, and kept."""
    lay(tmp_path / "out")
    with pytest.raises(UsageError, match=told):
        create(0, out=out)
    assert not (tmp_path / "out").is_dir()


@pytest.mark.parametrize("out", [".", "new/deep"])
def test_unwritable_folder_is_refused(create, tmp_path, monkeypatch, out):
    """Where the folder, or the nearest parent that exists, allows no writing, nothing is written."""
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # root may write anywhere
    with pytest.raises(UsageError, match=rf"cannot be written: '{tmp_path}' allows no writing here"):
        create(0, out=out)
    assert not list(tmp_path.iterdir())


def test_folder_that_is_no_experiment_is_not_opened(tmp_path):
    """The message says what to name; whoever names the folder around some sees their names."""
    with pytest.raises(UsageError, match=r"^No folder '.*nowhere'\. Name the --out folder of a run$"):
        Store.open(tmp_path / "nowhere")
    with pytest.raises(UsageError, match=r"is no experiment: it holds no plan.json. Name the --out folder of a run$"):
        Store.open(tmp_path)
    for name in ("second", "first"):
        (tmp_path / name).mkdir()
        (tmp_path / name / PLAN).touch()
    with pytest.raises(UsageError, match=r"Name the --out folder of a run. Experiments in it: first, second$"):
        Store.open(tmp_path)
    with pytest.raises(UsageError, match=r"Did you mean 'second'\? Name the --out folder of a run$"):
        Store.open(tmp_path / "secnd")


@pytest.mark.parametrize("left", [(), (".lock",), (".lock", EXPERIMENT)])
def test_run_killed_before_its_plan_goes_on(create, tmp_path, left):
    """The folder is no experiment yet, and may be run in."""
    (tmp_path / "cells").mkdir()
    for name in left:
        (tmp_path / name).touch()
    with pytest.raises(UsageError, match="is no experiment"):
        Store.open(tmp_path)
    create(0)
    assert _seeds(tmp_path) == [0]


def test_a_folder_grows(create, cell, tmp_path):
    """Cells of earlier plans stay, done ones too, and each is listed once; a file that a kill cost is written again."""
    _finish(create(0, 1), cell)
    (tmp_path / EXPERIMENT).unlink()
    assert _seeds(tmp_path) == [0, 1]
    again = create(1, 2)
    assert _seeds(tmp_path) == [0, 1, 2]
    assert [again.examine(it).status for it in again.read_plan().cells] == ["done", "pending", "pending"]
    assert (tmp_path / EXPERIMENT).is_file()


def test_damaged_plan_is_made_anew_by_the_next_run(create, cell, tmp_path):
    """Cells that have ended stay; what had not begun is asked for by the same command again."""
    _finish(create(0, 1), cell)
    (tmp_path / PLAN).write_text("{")
    create(2)
    assert _seeds(tmp_path) == [0, 2]


@pytest.mark.parametrize(("plan", "told"), [('{"format": 3}', "plan"), ("{", "manifest")])
def test_what_a_newer_version_wrote_is_not_written_over(create, cell, tmp_path, plan, told):
    """Nothing is wrong with its plan; where that is damaged, one without its cells would lose them."""
    store = create(0)
    _finish(store, cell)
    (store.cell_folder(cell) / MANIFEST).write_text('{"format": 3}')
    (tmp_path / PLAN).write_text(plan)
    with pytest.raises(NewerFormat, match=rf"{told}\.json has format 3, this version reads up to 2"):
        create(1)
    assert (tmp_path / PLAN).read_text() == plan


def test_partial_folder_is_no_result(create, cell, make_cell, tmp_path):
    """Not even with a manifest: its cell was killed before its folder got its name. What has ended stays."""
    store, other = create(0), make_cell(seed=1)
    _finish(store, cell)
    partial = partial_folder(store.cell_folder(other))
    partial.mkdir()
    Manifest(other, status="done").write(partial)
    assert [manifest.cell for manifest in store.manifests()] == [cell]
    assert store.examine(other).status == "pending"
    store.discard_partial()
    assert [path.name for path in (tmp_path / "cells").iterdir()] == [cell.id]


def test_recording_a_failure_keeps_the_log(create, cell):
    """The folder of a killed cell gets its name, with a manifest and what the cell had printed; the last one counts."""
    store = create(0)
    folder = store.cell_folder(cell)
    partial_folder(folder).mkdir()
    (partial_folder(folder) / LOG).write_text("last words")
    store.record(cell, "failed", "killed")
    assert (read_manifest(folder).status, read_manifest(folder).reason) == ("failed", "killed")
    assert (folder / LOG).read_text() == "last words"
    assert not partial_folder(folder).exists()
    store.record(cell, "failed", "second")
    assert [manifest.reason for manifest in store.manifests()] == ["second"]
    assert [path.name for path in folder.iterdir()] == [MANIFEST]


def test_manifests_come_by_start(create, make_cell):
    """Whatever the names of their folders, cells are listed in the order in which they began."""
    store = create(*range(5))
    for seed in range(5):
        _finish(store, make_cell(seed=seed), started=f"2026-01-01T0{9 - seed}:00:00+00:00")
    assert [manifest.cell.seed for manifest in store.manifests()] == [4, 3, 2, 1, 0]


def test_second_run_in_one_folder_is_refused(create, tmp_path):
    """While one run holds the folder, another can neither run there nor add its plan; afterwards it can."""
    store = create(0)
    with store.locked():
        with pytest.raises(UsageError, match="Another run is using"), Store.open(tmp_path).locked():
            pass
        with pytest.raises(UsageError, match="wait for it, or name another --out"):
            create(1)
    assert _seeds(tmp_path) == [0]
    with Store.open(tmp_path).locked():
        assert (tmp_path / ".lock").exists()


def test_done_cell_is_never_touched(create, cell):
    """Neither by a plan that would skip it now, as when a plugin says otherwise than before, nor by a late failure."""
    store = create(0)
    _finish(store, cell)
    create(skipped=((cell, "it cannot any more"),))
    store.record(cell, "failed", "too late")
    assert (store.cell_folder(cell) / TRACE).read_bytes() == b"rows"
    assert store.examine(cell).status == "done"


@pytest.mark.parametrize("name", [PLAN, EXPERIMENT])
def test_plan_is_whole_at_every_moment(create, tmp_path, monkeypatch, name):
    """A process that ends while it writes, as on a full disk, leaves what was there before."""
    create(0)
    before = (tmp_path / name).read_bytes()

    def half(path, content):
        with path.open("wb") as file:
            file.write(content[: len(content) // 2])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", half)
    with pytest.raises(OSError, match="No space left"):
        create(1)
    assert (tmp_path / name).read_bytes() == before
    assert _seeds(tmp_path) == [0]


def test_damaged_plan_is_refused(create, tmp_path, subtests):
    """The error names the file."""
    store = create(0)
    for content in ["", "{}", "[]", '"x"', '{"baseline": "b", "cells": [3]}', '{"baseline": "b"}']:
        (tmp_path / PLAN).write_text(content)
        with subtests.test(content=content), pytest.raises(SchemaError, match=r"plan\.json is no readable plan"):
            store.read_plan()
