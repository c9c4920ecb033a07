"""What an executor must satisfy. Each check takes the executor and an empty folder that its processes can see."""

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from harness.algorithm import ActionSpace
from harness.authoring import run_job
from harness.authoring.checking import LOG, MANIFEST, examine
from harness.authoring.commands import Cell, Choice, partial_folder, read_manifest
from harness.executor import CellOptions, Event, Executor, Job, Limits, OnEvent
from harness.hookspecs import Register, hookimpl
from harness.policy import Gaussian, Policy
from harness.progress import Progress

from .contract import Check, check, raise_first_in_folders, require, settings_are_frozen, settings_survive_json

if TYPE_CHECKING:
    from harness.env import ReachVectorEnv


NAME = "harness-testing"
"""The name of the simulator, the task, the reward and the algorithm."""
STEPS = 3
LASTS = 0.5
"""Seconds that a cell lasts which shows that it runs."""
BEAT = 0.05
"""Seconds from one sign of life to the next."""
LONGEST = 12.0
"""Seconds after which a cell that hangs gives up: an executor that is broken leaves nothing behind for long."""
STOP = "stop"
"""File in the folder of notes that ends such a cell earlier."""


@hookimpl
def register_simulators(register: Register) -> None:
    """Announce the simulator of the kit."""
    register(NAME, "harness.env.ideal:IdealSimulator", summary="no dynamics, for the checks of executors")


@hookimpl
def register_tasks(register: Register) -> None:
    """Announce the FD100's task under a name of the kit."""
    register(NAME, "harness.reach:ReachTask", summary="the FD100's, for the checks of executors")


@hookimpl
def register_rewards(register: Register) -> None:
    """Announce the reward of the kit."""
    register(NAME, "harness_plugins.kit.trainings:NegativeDistance", summary="for the checks of executors")


@hookimpl
def register_algorithms(register: Register) -> None:
    """Announce the algorithm that goes wrong."""
    register(NAME, f"{__name__}:Odd", summary="goes wrong as it is told, for the checks of executors")


@dataclass(frozen=True)
class Odd:
    """Acts at random, then does what `then` says, one of `WAYS`; leaves notes in the folder `notes`."""

    then: str = ""
    notes: str = ""

    num_envs: ClassVar[int] = 1
    action_spaces: ClassVar[frozenset[ActionSpace]] = frozenset({"continuous"})

    def train(self, env: "ReachVectorEnv", steps: int, seed: int, progress: Progress) -> Policy:
        rng, dof = np.random.default_rng(seed), env.robot.dof
        env.reset()
        for done in range(1, steps + 1):
            env.step(rng.uniform(-1.0, 1.0, (1, dof)))
            progress(done)
        if self.then:
            WAYS[self.then](Path(self.notes), str(seed))
        (seen,) = env.single_observation_space.shape or ()
        arrays = {"hidden.0.weight": rng.normal(size=(1, seen)), "hidden.0.bias": np.zeros(1)}
        arrays |= {"mean.weight": rng.normal(size=(dof, 1)), "mean.bias": np.zeros(dof), "log_std": np.zeros(dof)}
        weights = {name: array.astype(np.float32) for name, array in arrays.items()}
        return Gaussian(weights, "tanh", (-1.0,) * dof, (1.0,) * dof, NAME)


def odd_cell(seed: int = 0, then: str = "", notes: Path = Path()) -> Cell:
    """A cell of a moment.

    Args:
        seed: Its own.
        then: What it does after its training, one of `WAYS`; empty for nothing.
        notes: Where it leaves notes.
    """
    plain, task = Choice(NAME, (), NAME), Choice(NAME, (("horizon", 5),), f"{NAME}:horizon=5")
    algorithm = Choice(NAME, (("then", then), ("notes", str(notes))), f"{NAME}:then={then}")
    return Cell(plain, "fd100", task, algorithm, plain, seed, STEPS, evaluation_episodes=1)


@contextmanager
def installed(folder: Path) -> Iterator[None]:
    """These plugins are installed for this process and for those that it starts, within the block.

    Args:
        folder: Gets the metadata that an installer leaves.
    """
    metadata = folder / "harness_testing-1.0.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {NAME}\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(f"[harness]\n{NAME} = {__name__}\n")
    before = os.environ.get("PYTHONPATH")
    sys.path.insert(0, str(folder))
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(folder), before]))
    try:
        yield
    finally:
        sys.path.remove(str(folder))
        if before is None:
            del os.environ["PYTHONPATH"]
        else:
            os.environ["PYTHONPATH"] = before


def _raise(notes: Path, name: str) -> None:
    raise RuntimeError("the arm fell off")


def _be_killed(notes: Path, name: str) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def _last(notes: Path, name: str) -> None:
    """Show for a moment that this cell runs."""
    _beat_for(LASTS, notes, name)


def _hang(notes: Path, name: str) -> None:
    """Tell no more progress, but live on."""
    _beat_for(LONGEST, notes, name)


def _beat_for(seconds: float, notes: Path, name: str) -> None:
    """Append the time to a file again and again."""
    until = time.monotonic() + seconds
    with (notes / name).open("a") as file:
        while time.monotonic() < until and not (notes / STOP).exists():
            file.write(f"{time.time()}\n")
            file.flush()
            time.sleep(BEAT)


WAYS: dict[str, Callable[[Path, str], None]] = {
    "raise": _raise,
    "be killed": _be_killed,
    "last": _last,
    "hang": _hang,
}


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
    raise_first_in_folders(EXECUTOR_CHECKS, executor, folder)


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
