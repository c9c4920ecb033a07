"""What in a folder is not what was written, and mending it."""

import json
import random
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from harness.errors import UsageError
from harness.experiment.plan import Plan
from harness.files.sums import FIRST_LINE, SUMS, note_made
from harness.record.folder import MANIFEST, POLICY, TRACE
from harness.record.plan_file import EXPERIMENT, PLAN
from harness.record.store import CELLS, LOCK, REPORT, RESULTS, Store
from harness.record.verify import DAMAGED, missing_cells, repair, verify
from harness.registry.registry import load_registry
from harness.results import Results


def _files(folder: Path) -> list[Path]:
    """Everything that a flipped bit could change."""
    return sorted(path for path in folder.rglob("*") if path.is_file() and path.stat().st_size and path.name != LOCK)


def _first_cell(folder: Path) -> Path:
    return sorted((folder / CELLS).iterdir())[0]


def test_folder_as_it_was_written_is_sound(ran: Path):
    """Nothing is found, and there is nothing to repair."""
    assert verify(ran) == []
    assert repair(ran) == []


def test_every_file_can_be_found_damaged(ran: Path):
    """The first byte of each: the problem names the file, or the folder that it belongs to."""
    for path in _files(ran):
        before = path.read_bytes()
        path.write_bytes(bytes([before[0] ^ 1]) + before[1:])
        [problem] = verify(ran)
        assert path.is_relative_to(ran / problem.path) or path.name in problem.what
        path.write_bytes(before)


def test_missing_data_is_damage(ran: Path):
    """A report cannot do without a trace."""
    (_first_cell(ran) / TRACE).unlink()
    [problem] = verify(ran)
    assert problem.what.endswith(f"{TRACE} is missing")


def test_policies_may_be_taken_away(ran: Path):
    """To make a folder smaller: no report reads them."""
    shutil.rmtree(_first_cell(ran) / POLICY)
    assert verify(ran) == []


def test_folder_of_another_cell_is_damage(ran: Path):
    """A cell under another one's name would be counted for it."""
    first, second = sorted((ran / CELLS).iterdir())[:2]
    shutil.rmtree(second)
    shutil.copytree(first, second)
    [problem] = verify(ran)
    assert problem.what == f"it holds another cell, {first.name}"


def test_other_folders_cannot_be_verified(tmp_path: Path):
    """They hold nothing that was written here."""
    with pytest.raises(UsageError, match="is no experiment"):
        verify(tmp_path)


def test_damaged_cell_is_set_aside_and_done_again(
    ran: Path, make_plan: Callable[..., Plan], run_here: Callable[..., Results]
):
    """Nothing is thrown away; the same run then gives the same rows."""
    cell = _first_cell(ran)
    before = (cell / TRACE).read_bytes()
    (cell / TRACE).write_bytes(b"PAR1")
    repair(ran)
    assert (ran / DAMAGED / f"{cell.name}-0" / TRACE).read_bytes() == b"PAR1"
    assert verify(ran) == []
    run_here(make_plan(*Store(ran).read_plan().cells), ran)
    assert (cell / TRACE).read_bytes() == before


def test_damaged_cell_is_replaced_by_the_next_run(
    ran: Path, make_plan: Callable[..., Plan], run_here: Callable[..., Results]
):
    """Without any repair."""
    cell = _first_cell(ran)
    before = (cell / TRACE).read_bytes()
    (cell / MANIFEST).write_bytes((cell / MANIFEST).read_bytes()[:100])
    run_here(make_plan(*Store(ran).read_plan().cells), ran)
    assert (cell / TRACE).read_bytes() == before
    assert verify(ran) == []


@pytest.mark.parametrize("damage", ["{", None], ids=["damaged", "gone"])
def test_plan_is_put_together_from_the_cells(ran: Path, damage: str | None):
    """A report says so and shows all that has ended; repair writes it."""
    known = Store(ran).read_plan()
    (ran / PLAN).unlink()
    if damage:
        (ran / PLAN).write_text(damage)
    results = Results(ran, load_registry())
    assert "was put together from 4 cells" in results.plan.note
    assert {cell.id for cell in results.done_cells} == {cell.id for cell in known.cells}
    assert [action.what for action in repair(ran)] == ["put together from 4 cells"]
    assert verify(ran) == []
    assert set(Store(ran).read_plan().cells) == set(known.cells)
    assert Store(ran).read_plan().baseline == known.baseline


def test_changed_experiment_is_written_again(ran: Path):
    """The plan holds it too."""
    before = (ran / EXPERIMENT).read_text()
    (ran / EXPERIMENT).write_text("seeds = 9\n")
    assert [str(problem.path) for problem in verify(ran)] == [EXPERIMENT]
    repair(ran)
    assert (ran / EXPERIMENT).read_text() == before


def test_damaged_page_is_set_aside(ran: Path):
    """It can be made again; what is there may be somebody's work."""
    (ran / REPORT).write_text("<html>9</html>")
    repair(ran)
    assert not (ran / REPORT).exists()
    assert (ran / DAMAGED / f"{REPORT}-0").read_text() == "<html>9</html>"
    assert verify(ran) == []


def test_damaged_plan_is_kept_beside_the_new_one(ran: Path):
    """As it was."""
    (ran / PLAN).write_text("{")
    repair(ran)
    assert (ran / DAMAGED / f"{PLAN}-0").read_text() == "{"


@pytest.mark.parametrize("names", [(PLAN, EXPERIMENT), (f"{CELLS}",), (REPORT, PLAN)])
def test_a_list_of_digests_that_the_user_made_is_not_believed(ran: Path, names: tuple[str, ...]):
    """Files that changed after it are sound; it stays as it is, and so do they."""
    text = "".join(f"{'0' * 64}  {name}\n" for name in names)
    (ran / SUMS).write_text(text)
    before = {path: path.read_bytes() for path in _files(ran)}
    assert verify(ran) == []
    assert repair(ran) == []
    assert {path: path.read_bytes() for path in _files(ran)} == before


def test_a_forged_list_of_digests_takes_no_sound_file(ran: Path):
    """Plan, experiment, manifests and what manifests name were made by no report."""
    for folder, names in ((ran, (PLAN, EXPERIMENT)), (_first_cell(ran), (MANIFEST, TRACE))):
        (folder / SUMS).write_text("".join([f"{FIRST_LINE}\n", *(f"{'0' * 64}  {name}\n" for name in sorted(names))]))
    before = {path: path.read_bytes() for path in _files(ran)}
    repair(ran)
    assert {path: path.read_bytes() for path in before if path.exists()} == before


@pytest.mark.parametrize(
    "name", ["..", ".", "cells", "policy", "../../plan.json", "/etc/passwd", "C:x", "x" * 300, "a\x1b[2J", "notes.txt"]
)
@pytest.mark.parametrize("is_in_cell", [False, True])
def test_a_list_of_digests_of_a_stranger_moves_nothing(ran: Path, name: str, is_in_cell: bool):
    """Whatever it names: `..` would take all cells away, `cells` all trainings."""
    folder = _first_cell(ran) if is_in_cell else ran
    if name == "notes.txt" and not is_in_cell:  # in a cell it was added, whatever a list says
        (folder / name).write_text("of a person")
    before = {path: path.read_bytes() for path in _files(ran) if path != folder / SUMS}
    (folder / SUMS).write_text(f"{FIRST_LINE}\n{'0' * 64}  {name}\n")
    assert len(verify(ran)) == 1
    assert len(repair(ran)) == 1
    assert {path: path.read_bytes() for path in before} == before
    assert {path.name for path in ran.parent.iterdir()} == {"ran"}


@pytest.mark.parametrize("name", [RESULTS, REPORT])
def test_only_a_file_is_set_aside_in_the_place_of_one(ran: Path, name: str):
    """A folder of its name is not what a report made: it is told and left."""
    (ran / name).unlink()
    (ran / name).mkdir()
    (ran / name / "of a person").write_text("kept")
    [problem] = verify(ran)
    assert f"'{name}'" in problem.what
    [action] = repair(ran)
    assert "It stays" in action.what
    assert (ran / name / "of a person").read_text() == "kept"


def test_a_folder_that_is_no_cell_stays(ran: Path):
    """Somebody's notes among the cells."""
    (ran / CELLS / "notes").mkdir()
    (ran / CELLS / "notes" / "a.txt").write_text("kept")
    [problem] = verify(ran)
    assert problem.path == Path(CELLS) / "notes"
    repair(ran)
    assert (ran / CELLS / "notes" / "a.txt").read_text() == "kept"


def test_a_file_in_place_of_the_folder_for_damage_is_told(ran: Path):
    """In a line, before anything is moved."""
    (ran / DAMAGED).write_text("a file")
    (ran / REPORT).write_text("<html>9</html>")
    with pytest.raises(UsageError, match=f"{DAMAGED}' is no folder"):
        repair(ran)
    assert (ran / REPORT).exists()


def test_a_long_name_is_set_aside_under_a_shorter_one(ran: Path):
    """A number follows it there."""
    (_first_cell(ran) / ("x" * 255)).write_text("kept")
    repair(ran)
    assert verify(ran) == []
    assert (ran / DAMAGED / f"{'x' * 200}-0").read_text() == "kept"


def test_a_text_of_the_table_that_stands_in_many_rows_takes_little_memory(ran: Path):
    """A megabyte in 100,000 rows is 100 GB, if each row gets its own."""
    text = pa.array(["x" * 1_000_000])
    many = pa.DictionaryArray.from_arrays(pa.array([0] * 100_000, pa.int32()), text)
    pq.write_table(pa.table({"id": many, "status": pa.array(["done"] * 100_000)}), ran / RESULTS)
    note_made(ran / RESULTS)
    assert verify(ran) == []


def test_link_is_found_and_noted(ran: Path, tmp_path: Path):
    """It leads out of the folder; what it leads to stays, and a text says where it led."""
    (tmp_path / "kept").mkdir()
    (ran / "cells" / ".x.partial").symlink_to(tmp_path / "kept")
    [problem] = verify(ran)
    assert str(problem.path) == "cells/.x.partial"
    repair(ran)
    assert (tmp_path / "kept").is_dir()
    assert (ran / DAMAGED / ".x.partial-0").read_text() == f"{tmp_path / 'kept'}\n"
    assert verify(ran) == []


def test_a_link_in_place_of_the_folder_for_damage_is_not_followed(ran: Path, tmp_path: Path):
    """Nothing is written where it leads."""
    (tmp_path / "elsewhere").mkdir()
    (ran / DAMAGED).symlink_to(tmp_path / "elsewhere")
    (ran / "another").symlink_to(tmp_path)
    repair(ran)
    assert not list((tmp_path / "elsewhere").iterdir())
    assert verify(ran) == []


@pytest.mark.parametrize("name", ["random.parquet", "evaluations/400.parquet", "notes.txt", "policy/more.safetensors"])
def test_a_file_that_no_cell_left_is_told_and_not_read(ran: Path, name: str):
    """A report says what it said; repair sets the file aside, and nothing else."""
    expected, cell = _numbers(ran), sorted((ran / CELLS).iterdir())[-1]
    (cell / name).parent.mkdir(exist_ok=True)
    shutil.copy(_first_cell(ran) / TRACE, cell / name)
    [problem] = verify(ran)
    assert problem.path == (cell / name).relative_to(ran)
    assert _numbers(ran) == expected
    repair(ran)
    assert verify(ran) == []
    assert (ran / DAMAGED / f"{Path(name).name}-0").is_file()
    assert _numbers(ran) == expected


def test_cells_that_are_gone_are_told(ran: Path):
    """The table of results tells of them."""
    gone = _first_cell(ran)
    shutil.rmtree(gone)
    [problem] = verify(ran)
    assert problem.path == gone.relative_to(ran)
    assert missing_cells(ran) == (1, 4)
    repair(ran)
    assert verify(ran) == []


@pytest.mark.parametrize(
    "told",
    [
        {"id": ["/etc"], "status": ["done"]},
        {"id": ["../../x"], "status": ["done"]},
        {"id": [None], "status": ["done"]},
    ],
)
def test_a_table_of_anybody_names_no_other_place(ran: Path, told: dict[str, list[str | None]]):
    """Its digest is right: whoever wrote it wrote that too."""
    pq.write_table(pa.table(told), ran / RESULTS)
    note_made(ran / RESULTS)
    assert verify(ran) == []


@pytest.mark.parametrize("told", [{"other": [1]}, {"id": [""] * 1_000_001, "status": [""] * 1_000_001}])
def test_a_table_that_is_none_is_one_problem(ran: Path, told: dict[str, list[object]]):
    """Repair sets it aside: a report makes it again."""
    pq.write_table(pa.table(told), ran / RESULTS)
    note_made(ran / RESULTS)
    [problem] = verify(ran)
    assert problem.path == Path(RESULTS)
    repair(ran)
    assert verify(ran) == []


def test_a_cell_that_cannot_be_read_is_one_problem(ran: Path, monkeypatch: pytest.MonkeyPatch):
    """The others are looked at."""
    first, is_file = _first_cell(ran), Path.is_file

    def refuse(self: Path) -> bool:
        if self.parent == first and self.name == TRACE:
            raise PermissionError(13, "Permission denied", str(self))
        return is_file(self)

    monkeypatch.setattr(Path, "is_file", refuse)
    [problem] = verify(ran)
    assert problem.path == first.relative_to(ran)
    assert "cannot be read: Permission denied" in problem.what


def _numbers(folder: Path) -> dict[str, object]:
    """What a report says of each cell that it believes, and of nothing else."""
    results = Results(folder, load_registry())
    return {cell.id: results.measured(cell) for cell in results.done_cells}


def _flips(folder: Path, count: int, seed: int) -> Iterator[tuple[Path, int]]:
    rng, files = random.Random(seed), _files(folder)
    for _ in range(count):
        path = rng.choice(files)
        yield path, rng.randrange(path.stat().st_size * 8)


@pytest.mark.parametrize("count", [40, pytest.param(1600, marks=pytest.mark.slow)])
def test_no_flipped_bit_is_read_as_another_number(ran: Path, count: int):
    """Every one is named by `verify`; a report says of a cell what it said, or that it is damaged."""
    expected = json.dumps(_numbers(ran), default=str)
    registry = load_registry()
    whole = Results(ran, registry)
    for path, bit in _flips(ran, count, seed=1):
        before = path.read_bytes()
        flipped = bytearray(before)
        flipped[bit // 8] ^= 1 << bit % 8
        path.write_bytes(flipped)
        [problem] = verify(ran)
        assert path.is_relative_to(ran / problem.path) or path.name in problem.what, (path, bit)
        believed = {cell.id for cell in Results(ran, registry).done_cells}
        owner = path.relative_to(ran).parts[1] if path.is_relative_to(ran / CELLS) else None
        assert believed == {cell.id for cell in whole.done_cells if cell.id != owner}
        path.write_bytes(before)
    assert json.dumps(_numbers(ran), default=str) == expected
