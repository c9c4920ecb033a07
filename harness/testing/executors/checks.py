"""What an executor must satisfy. Each check takes the executor and an empty folder that its processes can see."""

import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from harness.executor import CellOptions, Event, Executor, Job, Limits, OnEvent
from harness.experiment.jobs import run_job
from harness.record.cell import Cell
from harness.record.cell_folder import examine
from harness.record.folder import LOG, MANIFEST, partial_folder
from harness.record.manifest import read_manifest
from harness.testing.executors.odd_cells import BEAT, STEPS, STOP, installed, odd_cell
from harness.testing.violations import Check, check, raise_first, require, settings_are_frozen, settings_survive_json

STALL_AFTER = 4.0
"""Seconds: longer than a process takes to start, and much shorter than a cell of the kit hangs."""
ENDS_WITHIN = 5.0
"""Seconds that a cell may still run after its executor was interrupted: its process may be on another machine."""
NONE: Mapping[Cell, CellOptions] = MappingProxyType({})
WATCHED = 1.0
"""Seconds without a sign of life after which a cell counts as ended."""


def check_executor(executor: Executor, folder: Path | None = None) -> None:
    """Run all `EXECUTOR_CHECKS`, with cells that take a moment; some seconds with processes of this machine.

    Args:
        executor: To be checked. Its processes need the PYTHONPATH of this one: the kit's cells are a plugin that is
            installed by it while a check runs.
        folder: To work in, empty; one for temporary files if None. Every machine of the executor has to see it.

    Raises:
        ContractViolation: At the first check that fails.
    """
    for each in EXECUTOR_CHECKS:
        with tempfile.TemporaryDirectory(dir=folder) as place:
            raise_first([each], executor, Path(place))


@check("executor-no-jobs")
def no_jobs_are_no_events(executor: Executor, folder: Path) -> None:
    """Without jobs there is no event and no error."""
    told: list[Event] = []
    executor.run([], 2, told.append)
    require(not told, f"told {told} of no jobs")


@check("executor-events")
def every_job_begins_and_ends_once(executor: Executor, folder: Path) -> None:
    """Each job has the events ``started``, any ``progress`` within the cell's steps, then ``ended``, and no more."""
    cells = [odd_cell(seed) for seed in range(3)]
    told = _run(executor, cells, folder, at_once=2)
    require({event.cell for event in told} == set(cells), "told of other cells than those of the jobs, or not of all")
    for cell in cells:
        kinds = [event.kind for event in told if event.cell == cell]
        expected = ["started", *["progress"] * (len(kinds) - 2), "ended"]
        require(kinds == expected, f"told {kinds} of a cell, not {expected}")
    steps = [event.steps for event in told if event.kind == "progress"]
    require(all(0 <= done <= STEPS for done in steps), f"told {steps} steps of cells that have {STEPS}")


@check("executor-thread")
def events_are_told_in_the_callers_thread(executor: Executor, folder: Path) -> None:
    """`on_event` need not be safe for threads, and an error that it raises reaches the caller of `run`."""
    threads: set[int] = set()
    _run(executor, [odd_cell()], folder, on_event=lambda _: threads.add(threading.get_ident()))
    require(threads == {threading.get_ident()}, "on_event was called in another thread")


@check("executor-results")
def a_done_cell_leaves_what_run_job_leaves(executor: Executor, folder: Path) -> None:
    """The job's folder is complete; every file but log and manifest is the one of `run_job`, byte for byte."""
    cell = odd_cell()
    told = _run(executor, [cell], folder)
    left = examine(folder / cell.id, cell)
    require(left.status == "done", f"the cell is {left.status}: {left.reason}")
    require(told[-1].reason == "", f"a done cell ended with the reason '{told[-1].reason}'")
    require(not partial_folder(folder / cell.id).exists(), "the partial folder of a done cell is still there")
    with installed(folder / "here"):
        expected = run_job(Job(cell, folder / "expected" / cell.id)).files
    differing = [name for name, digest in expected.items() if left.files.get(name) != digest and name != LOG]
    require(not differing and {*left.files} >= {*expected} - {LOG}, f"other bytes than run_job's: {differing}")


@check("executor-raises")
def what_raises_costs_itself_alone(executor: Executor, folder: Path) -> None:
    """A cell whose plugin raises an error leaves a manifest that says so; the cells before and after it are done."""
    raising = odd_cell(1, "raise")
    _run(executor, [odd_cell(0), raising, odd_cell(2)], folder)
    _require_done([odd_cell(0), odd_cell(2)], folder)
    require((folder / raising.id / MANIFEST).is_file(), "a cell that raised left no manifest")
    left = read_manifest(folder / raising.id)
    require((left.status, "the arm fell off" in left.reason) == ("failed", True), f"it is {left.status}: {left.reason}")


@check("executor-killed")
def what_is_killed_costs_itself_alone(executor: Executor, folder: Path) -> None:
    """A cell whose process is killed ends with a reason, and leaves its log; the others are done."""
    killed = odd_cell(1, "be killed")
    told = _run(executor, [odd_cell(0), killed, odd_cell(2)], folder)
    _require_done([odd_cell(0), odd_cell(2)], folder)
    (end,) = [event for event in told if event.cell == killed and event.kind == "ended"]
    require(end.reason, "a cell whose process was killed ended without a reason")
    require((partial_folder(folder / killed.id) / LOG).is_file(), "its log is lost")


@check("executor-hangs")
def what_hangs_is_ended(executor: Executor, folder: Path) -> None:
    """A cell that makes no progress for longer than its limit is ended, with the reason; the others are done."""
    notes = _notes(folder)
    hanging = odd_cell(1, "hang", notes)
    try:
        # The other cell has no limits: on a busy machine its process alone may take as long to start.
        limited = {hanging: CellOptions(limits=Limits(STALL_AFTER))}
        told = _run(executor, [hanging, odd_cell(2)], folder, options=limited)
        require(not _lives(notes), "a cell that hung is told to have ended, and still runs")
    finally:
        (notes / STOP).touch()
    (end,) = [event for event in told if event.cell == hanging and event.kind == "ended"]
    require(f"{STALL_AFTER:g} s" in end.reason, f"a cell that hung for too long ended with the reason '{end.reason}'")
    _require_done([odd_cell(2)], folder)


@check("executor-at-once")
def no_more_at_once_than_asked(executor: Executor, folder: Path) -> None:
    """At most `at_once` cells run at a time, by the events and by what the cells themselves show."""
    notes = _notes(folder)
    cells = [odd_cell(seed, "last", notes) for seed in range(4)]
    running: set[Cell] = set()
    most = 0

    def count(event: Event) -> None:
        nonlocal most
        running.add(event.cell)
        most = max(most, len(running))
        if event.kind == "ended":
            running.remove(event.cell)

    _run(executor, cells, folder, at_once=2, on_event=count)
    require(most <= 2, f"the events tell of {most} cells at once, asked for 2")
    spans = [_span(note) for note in notes.iterdir()]
    require(len(spans) == len(cells), f"{len(spans)} of {len(cells)} cells ran")
    overlaps = max(sum(begin <= start < end for begin, end in spans) for start, _ in spans)
    require(overlaps <= 2, f"{overlaps} cells ran at once, asked for 2")


@check("executor-interruption")
def an_interruption_leaves_nothing_running(executor: Executor, folder: Path) -> None:
    """KeyboardInterrupt from `on_event` reaches the caller of `run`, and all cells end within a moment."""
    notes = _notes(folder)
    cells = [odd_cell(0), odd_cell(1, "hang", notes), odd_cell(2, "hang", notes)]

    def interrupt(event: Event) -> None:
        if event.kind == "ended":
            _wait_until(lambda: any(notes.iterdir()))  # where cells run beside one another, the second one runs
            raise KeyboardInterrupt

    try:
        _run(executor, cells, folder, at_once=2, on_event=interrupt)
    except KeyboardInterrupt:
        require(_wait_until(lambda: not _lives(notes)), "a cell was still running after the interruption")
    else:
        raise AssertionError("KeyboardInterrupt did not reach the caller")
    finally:
        (notes / STOP).touch()


EXECUTOR_CHECKS: tuple[Check, ...] = (
    settings_are_frozen,
    settings_survive_json,
    no_jobs_are_no_events,
    every_job_begins_and_ends_once,
    events_are_told_in_the_callers_thread,
    a_done_cell_leaves_what_run_job_leaves,
    what_raises_costs_itself_alone,
    what_is_killed_costs_itself_alone,
    what_hangs_is_ended,
    no_more_at_once_than_asked,
    an_interruption_leaves_nothing_running,
)


def _run(
    executor: Executor,
    cells: Sequence[Cell],
    folder: Path,
    at_once: int = 1,
    on_event: OnEvent = lambda event: None,
    options: Mapping[Cell, CellOptions] = NONE,
) -> list[Event]:
    """Have cells done, each in a folder of its name in `folder`; returns what was told."""
    told: list[Event] = []

    def hear(event: Event) -> None:
        told.append(event)
        on_event(event)

    with installed(folder / "installed"):
        executor.run([Job(cell, folder / cell.id, options.get(cell, CellOptions())) for cell in cells], at_once, hear)
    return told


def _require_done(cells: Sequence[Cell], folder: Path) -> None:
    for cell in cells:
        left = examine(folder / cell.id, cell)
        require(left.status == "done", f"a sound cell beside it is {left.status}: {left.reason}")


def _notes(folder: Path) -> Path:
    notes = folder / "notes"
    notes.mkdir()
    return notes


def _span(note: Path) -> tuple[float, float]:
    """When a cell gave its first and its last sign of life."""
    times = [float(line) for line in note.read_text().splitlines()]
    return times[0], times[-1]


def _lives(notes: Path) -> bool:
    """Whether a cell still gives signs of life."""
    before = _signs(notes)
    time.sleep(WATCHED)
    return _signs(notes) != before


def _signs(notes: Path) -> dict[str, int]:
    return {path.name: path.stat().st_size for path in notes.iterdir()}


def _wait_until(holds: Callable[[], bool]) -> bool:
    """Whether it comes to hold within `ENDS_WITHIN` seconds."""
    until = time.monotonic() + ENDS_WITHIN
    while not holds():
        if time.monotonic() > until:
            return False
        time.sleep(BEAT)
    return True
