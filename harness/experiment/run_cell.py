"""Train and evaluate one cell: the only place that does. It needs the cell and a folder, nothing else."""

import shutil
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Generic, Self, TypeVar

import numpy as np

from harness.algorithm import Algorithm
from harness.errors import one_line
from harness.eta.manner import ACTED_AT_RANDOM, OWN_AND_OTHER
from harness.executor import CellOptions, Word
from harness.experiment.checkpoints.checkpoint import Attempt, Checkpoint, begin_attempt, discard_rings, store
from harness.experiment.workers.order import Report
from harness.experiment.world import CellWorld
from harness.files.bounded import whole_file
from harness.files.plain import Plain
from harness.policy import Policy, load_policy
from harness.record.cell import Cell, Ending, Manifest, now
from harness.record.folder import (
    CHECKPOINT,
    EVALUATION,
    EVALUATIONS,
    LOG,
    POLICY,
    RANDOM,
    evaluation_files,
    partial_folder,
    publish,
    recording_of,
)
from harness.record.progress import Progress, TrainingState
from harness.registry.choice import Registry
from harness.registry.registry import load_registry

Kind = TypeVar("Kind", bound=Ending)


class Draft(Generic[Kind]):
    """The record of work that is not yet done.

    Attributes:
        partial: Where the folder grows until it is complete.
        record: What will be written about it.
    """

    def __init__(self, partial: Path, record: Kind) -> None:
        self.partial, self.record = partial, record

    def note(self, **fields: Any) -> Self:
        """Put fields into the record; they stay there if the work fails later."""
        self.record = replace(self.record, **fields)
        return self


@contextmanager
def draft_of(folder: Path, record: Kind) -> Iterator[Draft[Kind]]:
    """Work on a folder: it is written beside its final name and renamed when the block ends.

    What the block raises ends up in the record, as the reason of a failure, and in the log: a plugin may raise
    anything, and it costs this folder alone.

    Args:
        folder: To leave; replaced if it exists.
        record: What there is to say of it if the work is done; start and duration are filled in.
    """
    clock = time.perf_counter()
    partial = own_partial(folder)
    draft = Draft(partial, replace(record, started=now()))
    try:
        yield draft
    except (Exception, SystemExit) as error:
        with (partial / LOG).open("a") as log:
            traceback.print_exc(file=log)
        draft.note(status="failed", reason=one_line(error).replace(str(partial), str(folder)))
    draft.note(seconds=round(time.perf_counter() - clock, 3))
    draft.record = leave_record(folder, draft.record)


def leave_record(folder: Path, record: Kind) -> Kind:
    """Write a record into the partial folder of `folder`, with whatever is in it already, and complete it.

    Returns:
        What was written: the record with the digests of the files.
    """
    partial = partial_folder(folder)
    partial.mkdir(parents=True, exist_ok=True)
    written = record.write(partial)
    publish(partial, folder)
    return written


def own_partial(folder: Path) -> Path:
    """The partial folder of a folder, made if need be, in which what is written changes no file elsewhere.

    An earlier attempt may have left files in it, and logs are appended to. Where one has a second name, as in a copy
    that was made of hard links, a copy of its own takes its place.
    """
    partial = partial_folder(folder)
    partial.mkdir(parents=True, exist_ok=True)
    for path in partial.rglob("*"):
        if path.is_file() and path.stat().st_nlink > 1:
            with whole_file(path) as copy:
                shutil.copyfile(path, copy)
    return partial


def world_of(cell: Cell, registry: Registry, folder: Path, report: Report) -> CellWorld:
    """The world of a cell. It imports what such a cell needs, and no more.

    Args:
        cell: The cell.
        registry: The plugins.
        folder: Where its recordings are written.
        report: Told that something goes on.
    """
    if cell.is_in_environment:
        from harness.experiment.environments.world import EnvironmentWorld

        return EnvironmentWorld(cell, registry, folder, report)
    from harness.experiment.arm_world import ArmWorld

    return ArmWorld(cell, registry, folder, report)


class CellEvaluations:
    """Evaluates policies of a cell in envs of their own, so that the training does not change.

    Attributes:
        seconds: What the evaluations took during training.
    """

    def __init__(self, cell: Cell, world: CellWorld, attempt: Attempt, tracked: bool, report: Report) -> None:
        """Go on after the last evaluation that the attempt's checkpoint knows of; later ones are made again.

        Args:
            cell: The cell whose policies are evaluated.
            world: The cell's.
            attempt: Where the training begins.
            tracked: Whether the results are passed on.
            report: Told the results.
        """
        self._cell, self._world, self._report, self._tracked = cell, world, report, tracked
        self._folder = attempt.folder
        self.seconds = 0.0
        self._due = cell.evaluate_every
        for steps, path in evaluation_files(self._folder, world.suffix).items():
            if steps > attempt.begun_from:
                shutil.rmtree(path) if path.is_dir() else path.unlink()
            else:
                self._due = self._next_after(steps)

    def offer(self, steps: int, make: Callable[[], Policy]) -> None:
        """Evaluate what `make` gives if an evaluation is due after `steps`; the one at the end is `finish`'s."""
        if not self._cell.evaluate_every or not self._due <= steps < self._cell.steps:
            return
        clock = time.perf_counter()
        self._due = self._next_after(steps)
        path = self._folder / EVALUATIONS / f"{steps}{self._world.suffix}"
        path.parent.mkdir(exist_ok=True)
        partial = path.with_name(f".{path.name}")
        self._evaluate(make(), partial, after=steps)
        partial.rename(path)  # so a killed process leaves no half-written evaluation under this name
        self.seconds += time.perf_counter() - clock

    def finish(self, policy: Policy, floor: bool) -> None:
        """Evaluate the trained policy, as the cell says and in the other manner; for a `floor` random actions too."""
        (_, other), episodes = OWN_AND_OTHER[self._cell.deterministic], self._cell.evaluation_episodes
        self._evaluate(policy, self._named(EVALUATION))
        self._world.evaluate(policy, other, episodes, self._named(other))
        if floor:
            self._world.evaluate(policy.floor(), ACTED_AT_RANDOM, episodes, self._named(RANDOM))

    def _named(self, trace: str) -> Path:
        return self._folder / f"{recording_of(trace)}{self._world.suffix}"

    def _next_after(self, steps: int) -> int:
        every = self._cell.evaluate_every
        return (steps // every + 1) * every

    def _evaluate(self, policy: Policy, path: Path, after: int = 0) -> None:
        self._world.evaluate(policy, self._cell.acted, self._cell.evaluation_episodes, path, after=after)
        if not self._tracked:
            return
        try:
            scalars = self._world.scalars(path)
        except Exception:  # these numbers are only looked at, they change no result
            with (self._folder / LOG).open("a") as log:
                traceback.print_exc(file=log)
        else:
            self._report(Word(after or self._cell.steps, scalars))


SECONDS = 600.0
"""Seconds between two checkpoints, if no number of steps is given."""


class CellProgress(Progress):
    """Passes on steps and scalars to whoever watches, evaluates and writes checkpoints when they are due."""

    def __init__(
        self, report: Report, attempt: Attempt, world: CellWorld, evaluations: CellEvaluations, tracked: bool
    ) -> None:
        """Begin to count.

        Args:
            report: Told the steps and the scalars.
            attempt: What the training starts with, and how often it leaves a checkpoint.
            world: Where it takes place; it stands where the attempt begins.
            evaluations: Evaluates its policies.
            tracked: Whether what the algorithm tells is passed on.
        """
        self._report, self._attempt, self._world = report, attempt, world
        self._evaluations, self._tracked = evaluations, tracked
        self._last, self._since = attempt.begun_from, time.perf_counter()
        self._rings = attempt.checkpoint.rings if attempt.checkpoint else {}

    def __call__(self, steps: int) -> None:
        self._report(Word(int(steps), self._world.learned(int(steps), if_due=True)))

    def policy(self, steps: int, make: Callable[[], Policy]) -> None:
        self._evaluations.offer(int(steps), make)

    def scalars(self, steps: int, values: Mapping[str, float]) -> None:
        if self._tracked:
            self._report(Word(int(steps), {name: float(value) for name, value in values.items()}))

    def checkpoint(self, steps: int, make: Callable[[], TrainingState]) -> None:
        kept = self._world.kept() if self._is_due(steps) else None
        if kept is None:
            return
        (env, rows), attempt = kept, self._attempt
        seconds = attempt.seconds - self._evaluations.seconds
        stored = store(attempt.folder, make(), env, self._rings)
        Checkpoint(steps, attempt.origin, rows=rows, seconds=seconds, **stored).write(attempt.folder)
        self._last, self._since, self._rings = steps, time.perf_counter(), stored["rings"]

    def restored(self) -> TrainingState | None:
        checkpoint = self._attempt.checkpoint
        return checkpoint.restored(self._attempt.folder) if checkpoint else None

    def _is_due(self, steps: int) -> bool:
        every = self._attempt.every
        if every is None:
            return time.perf_counter() - self._since >= SECONDS
        return 0 < every <= steps - self._last


DEFAULTS = CellOptions()


def run_cell(cell: Cell, folder: Path, report: Report, options: CellOptions = DEFAULTS) -> Manifest:
    """Do `cell` and leave its trace, policy, evaluation and manifest in `folder`.

    The folder is written beside its final name and renamed when complete. What a plugin raises ends up in the
    manifest, as the reason of a failed cell, and in the log. If this process is killed, the next call goes on from the
    last checkpoint, if it left one.

    Args:
        cell: What to do.
        folder: Of the cell; replaced if it exists.
        report: Told how far it is.
        options: How to do it.
    """
    with draft_of(folder, Manifest(cell, status="done")) as draft:
        forget_peak()
        try:
            _Run(cell, load_registry(given=options.plugins), report, options).leave(draft)
        finally:
            draft.note(peak_memory=peak_memory())
            (draft.partial / CHECKPOINT).unlink(missing_ok=True)
            discard_rings(draft.partial)
    return draft.record


@dataclass(frozen=True)
class TrainCell(Plain):
    """`run_cell`, as a worker is told to do it."""

    cell: Cell
    options: CellOptions = DEFAULTS

    noun: ClassVar[str] = "cell"

    def do(self, folder: Path, report: Report) -> bool:
        return run_cell(self.cell, folder, report, self.options).status == "done"


@dataclass(frozen=True)
class _Run:
    """The run of one cell: what all its steps need."""

    cell: Cell
    registry: Registry
    report: Report
    options: CellOptions

    def leave(self, draft: Draft[Manifest]) -> None:
        """Train and evaluate; leave everything but the manifest, and put into that what there is to say."""
        cell, registry = self.cell, self.registry
        world = world_of(cell, registry, draft.partial, self.report)
        draft.note(environment=dict(world.runs_on))
        algorithm: Algorithm = cell.algorithm.build(registry, "algorithms")
        draft.note(**world.build(algorithm))
        attempt = begin_attempt(cell, draft.partial, world.runs_on, self.options.checkpoint_every, world.restore)
        machine = {**world.runs_on["machine"], "kernel": attempt.origin["kernel"]}
        ran_on = {**world.runs_on, "machine": machine}
        draft.note(environment=ran_on, resumed_from=attempt.begun_from, note=attempt.note)
        self.report(Word(attempt.begun_from))
        evaluations = CellEvaluations(cell, world, attempt, self.options.tracked, self.report)
        policy = self._train(algorithm, world, attempt, evaluations)
        draft.note(training_seconds=round(attempt.seconds - evaluations.seconds, 3))
        policy.save(draft.partial / POLICY, cell.to_json())
        evaluations.finish(load_policy(draft.partial / POLICY), self.options.floor)
        draft.note(note="; ".join(filter(None, (attempt.note, *world.finish(draft.partial)))))

    def _train(self, algorithm: Algorithm, world: CellWorld, attempt: Attempt, evaluations: CellEvaluations) -> Policy:
        """Train in the world, which stands where the attempt begins."""
        cell = self.cell
        env_seed, algorithm_seed = (int(seed) for seed in np.random.SeedSequence(cell.seed).generate_state(2))
        with world.training(attempt) as env:
            if attempt.checkpoint is None:
                env.reset(seed=env_seed)
            progress = CellProgress(self.report, attempt, world, evaluations, self.options.tracked)
            policy = algorithm.train(env, cell.steps, algorithm_seed, progress)
            steps = min(env.environment_steps, cell.steps)
            self.report(Word(steps, world.learned(steps)))
        return policy


FORGET, STATUS = Path("/proc/self/clear_refs"), Path("/proc/self/status")
PEAK = "VmHWM:"


def forget_peak() -> None:
    """Forget the peak so far. Only Linux can do that; elsewhere the peak stays that of the whole process."""
    try:
        FORGET.write_text("5")
    except OSError:
        return  # no Linux, or one that allows it to nobody


def peak_memory() -> int:
    """The peak in bytes; 0 if the system does not tell it, as on Windows."""
    try:
        lines = STATUS.read_text().splitlines()
        return 1024 * int(next(line.split()[1] for line in lines if line.startswith(PEAK)))
    except (OSError, StopIteration):
        return _peak_of_process()


def _peak_of_process() -> int:
    if sys.platform == "win32":
        return 0
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak
