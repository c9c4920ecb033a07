"""What in a folder is not what was written, and mending it."""

import json
import random
import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file

from harness import load_registry, load_results
from harness.errors import NewerFormat, UsageError
from harness.experiment.verify import missing_cells, repair, verify
from harness.record import EXPERIMENT, MANIFEST, PLAN, REPORT, RESULTS, TRACE, Store
from harness.record.cell import read_manifest
from harness.record.folder import CARD, WEIGHTS

SUMS = "SHA256SUMS"


def _files(folder):
    """Everything that a flipped bit could change."""
    return sorted(path for path in folder.rglob("*") if path.is_file() and path.stat().st_size and path.name != ".lock")


def _contents(folder):
    return {path: path.read_bytes() for path in _files(folder) if path.name != SUMS}


@pytest.fixture
def first(ran):
    """The folder of its first cell, by name."""
    return min((ran / "cells").iterdir())


@pytest.fixture
def run_again(ran, make_plan, run_here):
    """Run the experiment once more."""
    cells = Store(ran).read_plan().cells
    return lambda: run_here(make_plan(*cells), ran)


def test_folder_as_it_was_written_is_sound(ran, first):
    """Nothing is found, and there is nothing to repair; policies may be taken away, as no report reads them."""
    assert verify(ran) == repair(ran) == []
    shutil.rmtree(first / "policy")
    assert verify(ran) == []


def _spoil_policy(cell, how, **changed):
    """Change a cell's policy, and what its manifest says of the cell and of the digests."""
    how(cell / "policy")
    replace(read_manifest(cell), **changed).write(cell)


def _fill_with_nan(policy):
    weights = load_file(policy / WEIGHTS)
    save_file({name: np.full_like(it, np.nan) for name, it in weights.items()}, policy / WEIGHTS)


def _cut(policy):
    (policy / WEIGHTS).write_bytes((policy / WEIGHTS).read_bytes()[:-4])


def _tell(policy, **told):
    card = json.loads((policy / CARD).read_text())
    (policy / CARD).write_text(json.dumps({**card, **told}))


@pytest.mark.parametrize(
    "how", [_fill_with_nan, _cut, partial(_tell, kind="oracle"), lambda policy: (policy / WEIGHTS).unlink()]
)
def test_a_policy_that_no_command_reads_is_damage(ran, first, how):
    """Though its digest is right; another run does the cell again."""
    _spoil_policy(first, how)
    [problem] = verify(ran)
    assert (ran / problem.path, problem.remedy) == (first, "run again to replace it")
    assert f"{first / 'policy'} holds no readable policy: " in problem.what
    repair(ran)
    assert (verify(ran), missing_cells(ran)[:2]) == ([], (1, 4))


def test_a_cell_that_failed_by_its_policy_is_sound(ran, first):
    """It says itself that nothing was done."""
    _spoil_policy(first, _fill_with_nan, status="failed", reason="SchemaError: it holds no readable policy")
    assert verify(ran) == []


def test_a_policy_of_a_newer_version_is_no_damage(ran, first):
    """Nothing may set it aside."""
    _spoil_policy(first, partial(_tell, format=99))
    with pytest.raises(NewerFormat, match="has format 99"):
        repair(ran)


def test_every_file_can_be_found_damaged(ran):
    """The first byte of each: the problem names the file, or the folder that it belongs to."""
    for path in _files(ran):
        before = path.read_bytes()
        path.write_bytes(bytes([before[0] ^ 1]) + before[1:])
        [problem] = verify(ran)
        assert path.is_relative_to(ran / problem.path) or path.name in problem.what
        path.write_bytes(before)


def test_folder_of_another_cell_is_damage(ran, first):
    """A cell under another one's name would be counted for it."""
    shutil.copytree(first, sorted((ran / "cells").iterdir())[1], dirs_exist_ok=True)
    [problem] = verify(ran)
    assert problem.what.endswith(f"holds another cell, {first.name}")


def test_damaged_cell_is_replaced_by_the_next_run(ran, first, run_again):
    """Without any repair."""
    before = (first / TRACE).read_bytes()
    (first / MANIFEST).write_bytes((first / MANIFEST).read_bytes()[:100])
    run_again()
    assert (first / TRACE).read_bytes() == before
    assert verify(ran) == []


@pytest.mark.parametrize("damage", ["{", None], ids=["damaged", "gone"])
def test_plan_is_put_together_from_the_cells(ran, damage):
    """A report says so and shows all that has ended; repair writes it, and keeps beside it what was there."""
    known = Store(ran).read_plan()
    (ran / PLAN).unlink()
    if damage:
        (ran / PLAN).write_text(damage)
    results = load_results(ran)
    assert "was put together from 4 cells" in results.plan.note
    assert {cell.id for cell in results.done_cells} == {cell.id for cell in known.cells}
    assert [told for _, told in repair(ran)] == ["put together from 4 cells"]
    assert verify(ran) == []
    again = Store(ran).read_plan()
    assert (set(again.cells), again.baseline) == (set(known.cells), known.baseline)
    assert [path.read_text() for path in ran.glob(f"damaged/{PLAN}-0")] == [damage] * bool(damage)


def test_changed_experiment_is_written_again(ran):
    """The plan holds it too."""
    before = (ran / EXPERIMENT).read_text()
    (ran / EXPERIMENT).write_text("seeds = 9\n")
    assert [str(problem.path) for problem in verify(ran)] == [EXPERIMENT]
    repair(ran)
    assert (ran / EXPERIMENT).read_text() == before


def test_damaged_page_is_set_aside(ran):
    """It can be made again; what is there may be somebody's work. Where its place is taken, a line says so."""
    (ran / REPORT).write_text("<html>9</html>")
    (ran / "damaged").write_text("a file")
    with pytest.raises(UsageError, match="damaged' is no folder"):
        repair(ran)
    assert (ran / REPORT).exists()
    (ran / "damaged").unlink()
    repair(ran)
    assert not (ran / REPORT).exists()
    assert (ran / "damaged" / f"{REPORT}-0").read_text() == "<html>9</html>"
    assert verify(ran) == []


@pytest.mark.parametrize("names", [(PLAN, EXPERIMENT), ("cells",), (REPORT, PLAN)])
def test_a_list_of_digests_that_the_user_made_is_not_believed(ran, names):
    """Files that changed after it are sound; it stays as it is, and so do they."""
    text = "".join(f"{'0' * 64}  {name}\n" for name in names)
    (ran / SUMS).write_text(text)
    before = _contents(ran)
    assert verify(ran) == repair(ran) == []
    assert (_contents(ran), (ran / SUMS).read_text()) == (before, text)


@pytest.mark.parametrize("name", [RESULTS, REPORT])
def test_only_a_file_is_set_aside_in_the_place_of_one(ran, name):
    """A folder of its name is not what a report made: it is told and left."""
    (ran / name).unlink()
    (ran / name).mkdir()
    (ran / name / "of a person").write_text("kept")
    [problem], [(_, told)] = verify(ran), repair(ran)
    assert f"'{name}'" in problem.what
    assert "It stays" in told
    assert (ran / name / "of a person").read_text() == "kept"


def test_a_folder_that_is_no_cell_stays(ran):
    """Somebody's notes among the cells."""
    notes = ran / "cells" / "notes"
    notes.mkdir()
    (notes / "a.txt").write_text("kept")
    [problem] = verify(ran)
    assert ran / problem.path == notes
    repair(ran)
    assert (notes / "a.txt").read_text() == "kept"


def test_a_long_name_is_set_aside_under_a_shorter_one(ran, first):
    """A number follows it there."""
    (first / ("x" * 255)).write_text("kept")
    repair(ran)
    assert verify(ran) == []
    assert (ran / "damaged" / f"{'x' * 200}-0").read_text() == "kept"


def test_link_is_found_and_noted(ran, tmp_path):
    """It leads out of the folder; what it leads to stays, and a text says where it led."""
    (tmp_path / "kept").mkdir()
    (ran / "cells" / ".x.partial").symlink_to(tmp_path / "kept")
    [problem] = verify(ran)
    assert str(problem.path) == "cells/.x.partial"
    repair(ran)
    assert (tmp_path / "kept").is_dir()
    assert (ran / "damaged" / ".x.partial-0").read_text() == f"{tmp_path / 'kept'}\n"
    assert verify(ran) == []


@pytest.mark.parametrize("name", ["random.parquet", "evaluations/400.parquet", "notes.txt", "policy/more.safetensors"])
def test_a_file_that_no_cell_left_is_told_and_not_read(ran, first, name):
    """A report says what it said; repair sets the file aside, and nothing else."""
    expected, path = _numbers(ran), max((ran / "cells").iterdir()) / name
    path.parent.mkdir(exist_ok=True)
    shutil.copy(first / TRACE, path)
    [problem] = verify(ran)
    assert (ran / problem.path, _numbers(ran)) == (path, expected)
    repair(ran)
    assert verify(ran) == []
    assert (ran / "damaged" / f"{path.name}-0").is_file()
    assert _numbers(ran) == expected


def test_cells_that_are_gone_are_counted(ran, first):
    """Nothing else in the folder is damaged by that."""
    shutil.rmtree(first)
    assert (verify(ran), missing_cells(ran)) == ([], (1, 4, ""))


def test_a_cell_that_cannot_be_read_is_one_problem(ran, first, monkeypatch):
    """The others are looked at."""
    is_file = Path.is_file

    def refuse(self):
        if self == first / TRACE:
            raise PermissionError(13, "Permission denied", str(self))
        return is_file(self)

    monkeypatch.setattr(Path, "is_file", refuse)
    [problem] = verify(ran)
    assert ran / problem.path == first
    assert "cannot be read: Permission denied" in problem.what


def _numbers(folder):
    """What a report says of each cell that it believes, and of nothing else."""
    results = load_results(folder)
    return {cell.id: results.measured(cell) for cell in results.done_cells}


@pytest.mark.parametrize("count", [40, pytest.param(1600, marks=pytest.mark.slow)])
def test_no_flipped_bit_is_read_as_another_number(ran, count):
    """Every one is named by `verify`; a report says of a cell what it said, or that it is damaged."""
    expected = json.dumps(_numbers(ran), default=str)
    registry, rng, files = load_registry(), random.Random(1), _files(ran)
    whole = {cell.id for cell in load_results(ran, registry=registry).done_cells}
    for _ in range(count):
        path = rng.choice(files)
        before = path.read_bytes()
        bit = rng.randrange(len(before) * 8)
        flipped = bytearray(before)
        flipped[bit // 8] ^= 1 << bit % 8
        path.write_bytes(flipped)
        [problem] = verify(ran)
        assert path.is_relative_to(ran / problem.path) or path.name in problem.what, (path, bit)
        owner = path.relative_to(ran).parts[1] if path.is_relative_to(ran / "cells") else None
        assert {cell.id for cell in load_results(ran, registry=registry).done_cells} == whole - {owner}
        path.write_bytes(before)
    assert json.dumps(_numbers(ran), default=str) == expected
