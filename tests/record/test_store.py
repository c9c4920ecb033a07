"""An experiment's folder: what is done is what it says is done."""

import json
import os
import subprocess
import sys
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from harness.errors import NewerFormat, SchemaError, UsageError
from harness.experiment.plan import Plan
from harness.record.cell import Cell
from harness.record.folder import LOG, MANIFEST, TRACE, partial_folder
from harness.record.manifest import Manifest, read_manifest
from harness.record.plan_file import EXPERIMENT, PLAN, read_plan
from harness.record.store import CELLS, LOCK, Store

MakeCell = Callable[..., Cell]
MakePlan = Callable[..., Plan]


def _finish(store: Store, cell: Cell, status: str = "done") -> None:
    folder = store.cell_folder(cell)
    folder.mkdir()
    (folder / TRACE).write_bytes(b"rows")
    Manifest(cell, status=status).write(folder)


def test_new_folder_holds_the_plan(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """The cells, in their order, and the label of the baseline are read as they were planned."""
    cells = [make_cell(seed=seed) for seed in (1, 0)]
    store = Store.create(tmp_path / "deep" / "down", make_plan(*cells, baseline="base"))
    assert Store.open(store.folder).read_plan().cells == tuple(cells)


def test_new_folder_holds_the_experiment(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """`experiment.toml` is the resolved experiment; TOML has no null, so what is None is left out at every depth."""
    resolved = {"sim": [{"name": "ideal", "dt": None, "k": 1}], "task": {"name": "x", "limit": None}, "robot": None}
    store = Store.create(tmp_path, replace(make_plan(make_cell()), resolved=resolved))
    written = tomllib.loads((store.folder / EXPERIMENT).read_text())
    assert written == {"sim": [{"name": "ideal", "k": 1}], "task": {"name": "x"}}


def test_empty_folder_may_be_used(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """A folder that was made beforehand is as good as a new one."""
    assert Store.create(tmp_path, make_plan(make_cell())).read_plan().cells == (make_cell(),)


def test_foreign_folder_is_left_alone(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """A folder that holds something else is refused, and nothing is written into it."""
    (tmp_path / "thesis.tex").touch()
    with pytest.raises(UsageError, match="holds something else than an experiment: name a new or empty folder"):
        Store.create(tmp_path, make_plan(make_cell()))
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_file_is_no_folder(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """A file in the place of the folder is refused, and kept."""
    (tmp_path / "out").write_text("mine")
    with pytest.raises(UsageError, match=r"--out '.*out' is a file: name a folder"):
        Store.create(tmp_path / "out", make_plan(make_cell()))
    assert (tmp_path / "out").read_text() == "mine"


def test_folder_below_a_file_is_refused(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """A file among the parents is named."""
    (tmp_path / "out").touch()
    with pytest.raises(UsageError, match=r"cannot be written: '.*out' allows no writing here"):
        Store.create(tmp_path / "out" / "deep", make_plan(make_cell()))


def test_folder_that_cannot_be_made_is_refused(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """A link to nowhere, for one: the reason of the system is repeated."""
    (tmp_path / "out").symlink_to(tmp_path / "nowhere")
    with pytest.raises(UsageError, match=r"--out '.*out' cannot be made: File exists"):
        Store.create(tmp_path / "out", make_plan(make_cell()))


@pytest.mark.parametrize("out", [".", "new/deep"])
def test_unwritable_folder_is_refused(
    make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, out: str
):
    """Where the folder, or the nearest parent that exists, allows no writing, nothing is written."""
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # root may write anywhere
    with pytest.raises(UsageError, match=rf"cannot be written: '{tmp_path}' allows no writing here"):
        Store.create(tmp_path / out, make_plan(make_cell()))
    assert not list(tmp_path.iterdir())


def test_folder_that_is_no_experiment_is_not_opened(tmp_path: Path):
    """Whether it is missing or holds something else, the message says what to name."""
    with pytest.raises(UsageError, match=r"^No folder '.*nowhere'\. Name the --out folder of a run$"):
        Store.open(tmp_path / "nowhere")
    with pytest.raises(UsageError, match=r"is no experiment: it holds no plan.json. Name the --out folder of a run$"):
        Store.open(tmp_path)


def test_folder_above_experiments_is_told_which_they_are(tmp_path: Path):
    """Whoever names the folder around them sees their names."""
    for name in ("second", "first"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "plan.json").touch()
    with pytest.raises(UsageError, match=r"Name the --out folder of a run. Experiments in it: first, second$"):
        Store.open(tmp_path)


def test_summary_is_no_experiment(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """It has an `experiment.toml` too: it is not opened, not run in, and left as it is."""
    for name in (EXPERIMENT, "cells.csv"):
        (tmp_path / name).write_text("kept")
    with pytest.raises(UsageError, match=r"is no experiment: it holds no plan\.json"):
        Store.open(tmp_path)
    with pytest.raises(UsageError, match="holds something else than an experiment"):
        Store.create(tmp_path, make_plan(make_cell()))
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {EXPERIMENT: "kept", "cells.csv": "kept"}


def test_experiment_file_alone_is_no_experiment(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """It may be the one that somebody wrote."""
    (tmp_path / EXPERIMENT).write_text("kept")
    with pytest.raises(UsageError, match="holds something else than an experiment"):
        Store.create(tmp_path, make_plan(make_cell()))
    assert (tmp_path / EXPERIMENT).read_text() == "kept"


@pytest.mark.parametrize("left", [(), (LOCK,), (LOCK, EXPERIMENT)])
def test_run_killed_before_its_plan_goes_on(
    make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path, left: tuple[str, ...]
):
    """The folder is no experiment yet, and may be run in."""
    (tmp_path / CELLS).mkdir()
    for name in left:
        (tmp_path / name).touch()
    with pytest.raises(UsageError, match="is no experiment"):
        Store.open(tmp_path)
    assert Store.create(tmp_path, make_plan(make_cell())).read_plan().cells == (make_cell(),)


def test_cells_without_a_plan_are_left_alone(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """Whose they are is not known."""
    (tmp_path / CELLS / "theirs").mkdir(parents=True)
    with pytest.raises(UsageError, match="holds something else than an experiment"):
        Store.create(tmp_path, make_plan(make_cell()))


def test_run_killed_behind_its_plan_goes_on(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """The plan says all; run again there are both files."""
    Store.create(tmp_path, make_plan(make_cell()))
    (tmp_path / EXPERIMENT).unlink()
    assert Store.open(tmp_path).read_plan().cells == (make_cell(),)
    Store.create(tmp_path, make_plan(make_cell(seed=1)))
    assert Store.open(tmp_path).read_plan().cells == (make_cell(), make_cell(seed=1))
    assert (tmp_path / EXPERIMENT).is_file()


def test_damaged_plan_is_made_anew_by_the_next_run(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """Cells that have ended stay; what had not begun is asked for by the same command again."""
    store = Store.create(tmp_path, make_plan(make_cell(), make_cell(seed=1)))
    _finish(store, make_cell())
    (tmp_path / PLAN).write_text("{")
    Store.create(tmp_path, make_plan(make_cell(seed=2)))
    assert read_plan(tmp_path).cells == (make_cell(), make_cell(seed=2))


def test_plan_of_a_newer_version_is_not_written_over(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """Nothing is wrong with it."""
    Store.create(tmp_path, make_plan(make_cell()))
    (tmp_path / PLAN).write_text('{"format": 3}')
    with pytest.raises(NewerFormat, match=r"plan\.json has format 3, this version reads up to 2"):
        Store.create(tmp_path, make_plan(make_cell(seed=1)))
    assert (tmp_path / PLAN).read_text() == '{"format": 3}'


def test_cells_of_a_newer_version_are_not_left_out_of_a_new_plan(
    make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path
):
    """Where the plan is damaged, a plan without them would lose them."""
    store = Store.create(tmp_path, make_plan(make_cell()))
    _finish(store, make_cell())
    (store.cell_folder(make_cell()) / MANIFEST).write_text('{"format": 3}')
    (tmp_path / PLAN).write_text("{")
    with pytest.raises(NewerFormat, match="has format 3"):
        Store.create(tmp_path, make_plan(make_cell(seed=1)))
    assert (tmp_path / PLAN).read_text() == "{"


def test_second_plan_is_added(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """A folder grows: cells of earlier plans stay, each cell is listed once."""
    one, two, three = (make_cell(seed=seed) for seed in range(3))
    Store.create(tmp_path, make_plan(one, two))
    Store.create(tmp_path, make_plan(two, three))
    assert Store.open(tmp_path).read_plan().cells == (one, two, three)


def test_skipped_cells_are_recorded_with_their_reason(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """A combination that cannot work is in the plan and has a manifest that says why."""
    odd = make_cell(seed=9)
    store = Store.create(tmp_path, make_plan(make_cell(), skipped=((odd, "takes discrete actions"),)))
    assert store.read_plan().cells == (make_cell(), odd)
    assert [(item.cell, item.status, item.reason) for item in store.manifests()] == [
        (odd, "skipped", "takes discrete actions")
    ]


@pytest.mark.parametrize(("status", "done"), [("done", True), ("failed", False), ("skipped", False)])
def test_cell_is_done_when_its_manifest_says_so(
    make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path, status: str, done: bool
):
    """A failed cell is run again, a done one is not."""
    store = Store.create(tmp_path, make_plan(make_cell()))
    assert not store.is_done(make_cell())
    _finish(store, make_cell(), status)
    assert store.is_done(make_cell()) is done


def test_done_cells_outlive_a_second_plan(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """Creating an experiment where one is goes on with it."""
    store = Store.create(tmp_path, make_plan(make_cell()))
    _finish(store, make_cell())
    again = Store.create(tmp_path, make_plan(make_cell(), make_cell(seed=1)))
    assert [again.is_done(make_cell(seed=seed)) for seed in (0, 1)] == [True, False]


def test_partial_folders_are_discarded(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """What a killed run left is removed; what has ended stays."""
    store = Store.create(tmp_path, make_plan(make_cell()))
    _finish(store, make_cell())
    partial = partial_folder(store.cell_folder(make_cell(seed=1)))
    partial.mkdir()
    (partial / LOG).touch()
    store.discard_partial()
    assert [path.name for path in (tmp_path / CELLS).iterdir()] == [make_cell().id]


def test_partial_folder_is_no_result(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """A cell that was killed after it wrote its manifest, and before its folder got its name, has not ended."""
    store = Store.create(tmp_path, make_plan(make_cell()))
    partial = partial_folder(store.cell_folder(make_cell()))
    partial.mkdir()
    Manifest(make_cell(), status="done").write(partial)
    assert store.manifests() == []
    assert not store.is_done(make_cell())


def test_recording_a_failure_keeps_the_log(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """The folder of a killed cell gets its name, with a manifest and what the cell had printed."""
    store = Store.create(tmp_path, make_plan(make_cell()))
    partial = partial_folder(store.cell_folder(make_cell()))
    partial.mkdir()
    (partial / LOG).write_text("last words")
    store.record(make_cell(), "failed", "killed")
    folder = store.cell_folder(make_cell())
    assert (read_manifest(folder).status, read_manifest(folder).reason) == ("failed", "killed")
    assert (folder / LOG).read_text() == "last words"
    assert not partial.exists()


def test_record_replaces_an_earlier_failure(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """The latest reason counts."""
    store = Store.create(tmp_path, make_plan(make_cell()))
    for reason in ("first", "second"):
        store.record(make_cell(), "failed", reason)
    assert [manifest.reason for manifest in store.manifests()] == ["second"]


def test_manifests_come_by_start(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """Whatever the names of their folders, cells are listed in the order in which they began."""
    cells = [make_cell(seed=seed) for seed in range(5)]
    store = Store.create(tmp_path, make_plan(*cells))
    for hour, cell in enumerate(cells):
        _finish(store, cell)
        Manifest(cell, status="done", started=f"2026-01-01T0{9 - hour}:00:00+00:00").write(store.cell_folder(cell))
    assert [manifest.cell for manifest in store.manifests()] == cells[::-1]


def test_second_run_in_one_folder_is_refused(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """While one run holds the folder, another can neither run there nor add its plan; afterwards it can."""
    store = Store.create(tmp_path, make_plan(make_cell()))
    with store.locked():
        with pytest.raises(UsageError, match="Another run is using"), Store.open(tmp_path).locked():
            pass
        with pytest.raises(UsageError, match="wait for it, or name another --out"):
            Store.create(tmp_path, make_plan(make_cell(seed=1)))
    assert store.read_plan().cells == (make_cell(),)
    with Store.open(tmp_path).locked():
        assert (tmp_path / LOCK).exists()


def test_run_of_another_process_keeps_the_folder(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """The lock holds between processes, and ends with the process that held it, however it ended."""
    store = Store.create(tmp_path, make_plan(make_cell()))
    script = (
        "import sys; from pathlib import Path; from harness.record.store import Store\n"
        "with Store.open(Path(sys.argv[1])).locked(): print(flush=True); sys.stdin.read()\n"
    )
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", script, str(tmp_path)], **pipes) as other:
        assert other.stdout.readline() == b"\n"
        with pytest.raises(UsageError, match="Another run is using"), store.locked():
            pass
        other.kill()
        other.wait()
        with store.locked():
            assert other.returncode < 0


def test_damaged_plan_is_refused(
    make_cell: MakeCell, make_plan: MakePlan, tmp_path_factory: pytest.TempPathFactory, subtests: pytest.Subtests
):
    """The error names the file."""
    for content in ["", "{}", "[]", '"x"', '{"baseline": "b", "cells": [3]}', '{"baseline": "b"}']:
        with subtests.test(content=content):
            tmp_path = tmp_path_factory.mktemp("case")
            store = Store.create(tmp_path, make_plan(make_cell()))
            (tmp_path / PLAN).write_text(content)
            with pytest.raises(SchemaError, match=r"plan\.json is no readable plan"):
                store.read_plan()


def test_plan_is_plain_json(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """Another program can read which cells there are to be."""
    Store.create(tmp_path, make_plan(make_cell()))
    told = json.loads((tmp_path / PLAN).read_text())
    assert (told["baseline"], told["a_a"], told["control"]) == ("baseline", False, [])
    assert told["cells"] == [make_cell().to_json()]


def test_null_control_is_read_as_it_was_planned(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """By each seed the other one; JSON has no numbers as keys."""
    cells = [make_cell(seed=seed) for seed in (0, 7, 8, 15)]
    Store.create(tmp_path, make_plan(*cells, control={0: 8, 7: 15}))
    assert json.loads((tmp_path / PLAN).read_text())["control"] == [[0, 8], [7, 15]]
    plan = Store.open(tmp_path).read_plan()
    assert (plan.baseline, plan.a_a, plan.control) == ("baseline", True, {0: 8, 7: 15})
    assert plan.cells == tuple(cells)


def test_plan_of_version_0_1_has_no_control(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """It compared the baseline's runs with the very same runs."""
    store = Store.create(tmp_path, make_plan(make_cell()))
    (tmp_path / PLAN).write_text(json.dumps({"baseline": "base", "a_a": True, "cells": [make_cell().to_json()]}))
    plan = store.read_plan()
    assert (plan.baseline, plan.a_a, plan.control, plan.cells) == ("base", True, {}, (make_cell(),))


def test_done_cell_is_never_touched(make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path):
    """Neither by a plan that would skip it now, as when a plugin says otherwise than before, nor by a late failure."""
    cell = make_cell()
    store = Store.create(tmp_path / "out", make_plan(cell))
    folder = store.cell_folder(cell)
    _finish(store, cell)
    Store.create(tmp_path / "out", make_plan(skipped=((cell, "it cannot any more"),)))
    store.record(cell, "failed", "too late")
    assert (folder / TRACE).read_bytes() == b"rows"
    assert read_manifest(folder).status == "done"


@pytest.mark.parametrize("name", [PLAN, EXPERIMENT])
def test_plan_is_whole_at_every_moment(
    make_cell: MakeCell, make_plan: MakePlan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
):
    """A process that ends while it writes, as on a full disk, leaves what was there before."""
    Store.create(tmp_path / "out", make_plan(make_cell()))
    before = (tmp_path / "out" / name).read_bytes()

    def half(path: Path, content: bytes) -> int:
        with path.open("wb") as file:
            file.write(content[: len(content) // 2])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", half)
    with pytest.raises(OSError, match="No space left"):
        Store.create(tmp_path / "out", make_plan(make_cell(seed=1)))
    assert (tmp_path / "out" / name).read_bytes() == before
    assert Store.open(tmp_path / "out").read_plan().cells == (make_cell(),)
