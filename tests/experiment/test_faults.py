"""A full or failing disk at every single write: no traceback, nothing lost, and the same command goes on."""

import errno
import os
from contextlib import suppress

import pytest

from harness.errors import HarnessError, StorageError
from harness.experiment.verify import verify
from harness.record import Store
from tests.experiment.faults import faults
from tests.left import left_by_cells
from tests.results.folders import ARP
from tests.stores import create_store

__all__ = ["faults"]


@pytest.fixture
def plan(make_cell, make_plan):
    """Two cells."""
    return make_plan(*(make_cell(reward=reward) for reward in (make_cell().reward, ARP)))


def _fail(number):
    def fault():
        raise OSError(number, os.strerror(number))

    return fault


@pytest.mark.parametrize(
    ("numbers", "stride"),
    [
        ((errno.ENOSPC,), 17),
        pytest.param((errno.ENOSPC, errno.EIO, errno.EMFILE), 1, marks=pytest.mark.slow),
    ],
    ids=["some", "every"],
)
def test_fault_at_any_write_loses_nothing(faults, run_here, plan, tmp_path, numbers, stride):
    """Cells fail, or the run stops with an error of ours; the same run then leaves what an undisturbed one leaves."""
    with faults.armed(tmp_path / "whole"):
        run_here(plan, tmp_path / "whole")
    expected, writes = left_by_cells(tmp_path / "whole"), faults.count
    assert writes > 40
    for number in numbers:
        for at in range(0, writes, stride):
            folder = tmp_path / f"{number}-{at}"
            with faults.armed(folder, at, _fail(number)), suppress(HarnessError):
                run_here(plan, folder)
            done = {m.cell.id for m in Store(folder).manifests() if m.status == "done"}
            kept = {path: digest for path, digest in left_by_cells(folder).items() if path.split("/")[1] in done}
            run_here(plan, folder)
            assert left_by_cells(folder) == expected, at
            assert kept.items() <= expected.items()
            assert verify(folder) == [], at


def test_full_disk_is_told_in_one_line(run_here, plan, tmp_path, monkeypatch):
    """What was given, what is wrong, what to do."""
    folder = tmp_path / "out"
    monkeypatch.setattr(os, "replace", lambda *names: _fail(errno.ENOSPC)())
    with pytest.raises(StorageError) as told:
        run_here(plan, folder)
    assert str(told.value) == (
        f"'{folder}' cannot be written: No space left on device. "
        "What is done is kept. Solve that, then run the same command to go on"
    )


def test_kill_at_any_write_of_the_plan_leaves_one_that_can_be_read(faults, make_cell, make_plan, tmp_path):
    """The earlier one or the new one; the process ends without another word, as when it is killed."""
    folder = tmp_path / "out"
    first, second = make_plan(make_cell()), make_plan(make_cell(), make_cell(seed=1))
    create_store(folder, first)
    for at in range(1000):
        child = os.fork()
        if child == 0:
            with faults.armed(folder, at, lambda: os._exit(9)):
                create_store(folder, second)
            os._exit(0)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        assert status in (0, 9)
        assert Store.open(folder).read_plan().cells in (first.cells, second.cells)
        assert Store.open(folder).read_plan().note == ""
        if status == 0:
            break
        create_store(folder, first)
    assert 5 < at < 1000
    assert Store.open(folder).read_plan().cells == second.cells
