"""Every executor check has a broken executor that fails it."""

import queue
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from harness.executor import CellOptions, Event, Job, OnEvent
from harness.experiment.jobs import run_jobs
from harness_plugins.kit import EXECUTOR_CHECKS, check_executor, executors, violations


@dataclass(frozen=True)
class Sound:
    """What the mutants are made of."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        run_jobs(jobs, at_once, on_event)


@dataclass
class Thawed:
    """Its settings can be changed while it runs."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        run_jobs(jobs, at_once, on_event)


@dataclass(frozen=True)
class SetUpWithASet(Sound):
    """JSON knows no sets."""

    nodes: frozenset[int] = frozenset({0})


@dataclass(frozen=True)
class NeedsAJob(Sound):
    """It looks at the first one."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        on_event(Event("started", jobs[0].cell))


@dataclass(frozen=True)
class LosesAnEnd(Sound):
    """The last word of the last cell is not waited for."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        ends = 0

        def tell(event: Event) -> None:
            nonlocal ends
            ends += event.kind == "ended"
            if not jobs[1:] or event.kind != "ended" or ends < len(jobs):
                on_event(event)

        run_jobs(jobs, at_once, tell)


@dataclass(frozen=True)
class TellsInAThread(Sound):
    """The thread that hears of something tells it."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        thread = threading.Thread(target=run_jobs, args=(jobs, at_once, on_event))
        thread.start()
        thread.join()


@dataclass(frozen=True)
class CutsTheEvaluation(Sound):
    """It does another cell than the one that it was given."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        other = {replace(job.cell, evaluation_episodes=2): job.cell for job in jobs}
        given = [job._replace(cell=cell) for job, cell in zip(jobs, other, strict=True)]
        run_jobs(given, at_once, lambda event: on_event(event._replace(cell=other[event.cell])))


@dataclass(frozen=True)
class GivesUp(Sound):
    """After a cell that failed, the rest is not begun."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        for job in jobs:
            run_jobs([job], 1, on_event)
            if b"failed" in (job.folder / "manifest.json").read_bytes():
                return


@dataclass(frozen=True)
class HidesAFailure(Sound):
    """A process that was killed is one that has ended."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        run_jobs(jobs, at_once, lambda event: on_event(event._replace(reason="")))


@dataclass(frozen=True)
class WatchesNothing(Sound):
    """Limits are for others."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        run_jobs([job._replace(options=CellOptions()) for job in jobs], at_once, on_event)


@dataclass(frozen=True)
class RunsOneMore(Sound):
    """It counts from zero."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        run_jobs(jobs, at_once + 1, on_event)


@dataclass(frozen=True)
class LeavesThemRunning(Sound):
    """The processes belong to a thread that hears of no interruption."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        told: queue.SimpleQueue[Event] = queue.SimpleQueue()
        threading.Thread(target=run_jobs, args=(jobs, at_once, told.put)).start()
        for _ in jobs:
            while (event := told.get()).kind != "ended":
                on_event(event)
            on_event(event)


@dataclass(frozen=True)
class SwallowsTheInterruption(Sound):
    """It ends as if all were done."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        with suppress(KeyboardInterrupt):
            run_jobs(jobs, at_once, on_event)


MUTANTS = {
    Thawed: executors.settings_are_frozen,
    SetUpWithASet: executors.settings_survive_json,
    NeedsAJob: executors.no_jobs_are_no_events,
    LosesAnEnd: executors.every_job_begins_and_ends_once,
    TellsInAThread: executors.events_are_told_in_the_callers_thread,
    CutsTheEvaluation: executors.a_done_cell_leaves_what_run_job_leaves,
    GivesUp: executors.what_raises_costs_itself_alone,
    HidesAFailure: executors.what_is_killed_costs_itself_alone,
    WatchesNothing: executors.what_hangs_is_ended,
    RunsOneMore: executors.no_more_at_once_than_asked,
    LeavesThemRunning: executors.an_interruption_leaves_nothing_running,
    SwallowsTheInterruption: executors.an_interruption_leaves_nothing_running,
}


SLOW = (WatchesNothing, SwallowsTheInterruption)
"""They wait for cells that hang; another mutant shows that the check of interruptions is able to fail."""
CASES = [pytest.param(*case, marks=[pytest.mark.slow] * (case[0] in SLOW)) for case in MUTANTS.items()]


@pytest.mark.parametrize(("mutant", "check"), CASES)
def test_mutant_fails_its_check(
    mutant: type, check: Callable[..., None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """An executor that is broken in one way fails the check of that fact."""
    monkeypatch.setattr(executors, "ENDS_WITHIN", 2.5)  # a cell that is left running does not end by itself
    assert [violation.check for violation in violations([check], mutant(), tmp_path)] == [check.name]


def test_every_check_has_a_mutant():
    """No check is without an executor that fails it."""
    assert set(MUTANTS.values()) == set(EXECUTOR_CHECKS)


@pytest.mark.slow
def test_the_mutants_are_made_of_a_sound_executor(tmp_path: Path):
    """What the mutants are made of fails nothing; the checks leave the folder that they are given as it was."""
    assert check_executor(Sound(), tmp_path) is None
    assert list(tmp_path.iterdir()) == []
