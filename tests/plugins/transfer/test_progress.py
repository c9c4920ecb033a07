import io
from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import Console

from harness.record import Store
from harness.registry import Choice
from harness_plugins.transfer.jobs import TransferEvent, TransferJob, TransferPlan
from harness_plugins.transfer.progress import TransferProgress


@pytest.fixture
def plan(make_cell):
    """Two jobs, one of them done, and a simulator that cannot be used."""
    job = TransferJob(make_cell(), Choice("stuck", (), "stuck"), Path("a"))
    return TransferPlan(Store(Path()), (job, replace(job, folder=Path("b"))), (job,), ("gone is left out: no",))


@pytest.mark.parametrize("terminal", [True, False])
def test_what_is_left_out_done_and_failed_is_said(plan, terminal):
    """On a terminal and without one; an evaluation that ends has a line, with the reason if it failed."""
    console = Console(file=io.StringIO(), width=120, force_terminal=terminal)
    with TransferProgress(plan, console) as progress:
        progress(TransferEvent("started", plan.missing[0]))
        progress(TransferEvent("ended", plan.missing[0], "it [b]fell[/b]"))
    shown = console.file.getvalue()
    assert "gone is left out: no" in shown
    assert "1 of 2 evaluations were done before" in shown
    assert "[2/2] ideal · wander · baseline · seed 0 in stuck: FAILED: it [b]fell[/b]" in shown
    assert ("━" in shown) is terminal


def test_jobs_of_one_title_are_told_apart(make_cell, tmp_path):
    """Two that run at once may differ in steps, task or robot alone, which no title says."""
    jobs = tuple(
        TransferJob(make_cell(steps=steps), Choice("stuck", (), "stuck"), tmp_path / str(steps)) for steps in (12, 24)
    )
    console = Console(file=io.StringIO(), width=200)
    with TransferProgress(TransferPlan(Store(tmp_path), jobs, jobs, ()), console) as progress:
        for kind in ("started", "ended"):
            for job in jobs:
                progress(TransferEvent(kind, job))
    assert jobs[0].title == jobs[1].title
    assert "[2/2]" in console.file.getvalue()
