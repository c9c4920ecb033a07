"""What a training takes, by a few steps of one: for ``harness run --dry-run``, before any cell is done."""

import json
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from harness.algorithm import Algorithm
from harness.executor import Limits, Word
from harness.experiment.checkpoints.checkpoint import Attempt
from harness.experiment.environments.paid_again import HORIZON
from harness.experiment.run_cell import peak_memory, world_of
from harness.experiment.workers.order import Order, Report
from harness.experiment.workers.workers import News, run_orders
from harness.experiment.world import CellWorld
from harness.files.plain import Plain
from harness.policy import Policy
from harness.record.cell import Cell
from harness.record.folder import partial_folder, publish
from harness.record.progress import Progress
from harness.record.recording.recorded_training import read_facts
from harness.registry.choice import Registry
from harness.registry.given import Given
from harness.registry.registry import load_registry

SECONDS, MOST = 1.5, 8.0
"""How long steps are measured, and at most before a first update is over, [s]."""
EPISODES = 5
"""How many episodes of an evaluation are timed in an environment, where they come one after the other."""
LIMITS = Limits(cell_time=60.0)
ANSWER, EVALUATED = "measured.json", "measured"


@dataclass(frozen=True)
class Measured(Plain):
    """What a few steps of a kind of cells took.

    Attributes:
        steps: How many were measured.
        per_step: Seconds for each.
        setup: Seconds before the first, once for each process.
        evaluation: Seconds of an evaluation; 0 where the algorithm offered no policy.
        horizon: Steps after which the environment ends an episode; 0 if that is not known.
        memory: The most that the process had at once, in bytes; 0 if it is not known.
    """

    steps: int
    per_step: float
    setup: float
    evaluation: float
    horizon: int
    memory: int = 0

    def of_cell(self, cell: Cell) -> tuple[float, float]:
        """Seconds of training, and of evaluations: at the end in both manners, and on the way."""
        on_the_way = (cell.steps - 1) // cell.evaluate_every if cell.evaluate_every else 0
        return cell.steps * self.per_step, (2 + on_the_way) * self.evaluation


class _Enough(Exception):
    """Raised by `Watched` to end a training."""


class Watched(Progress):
    """Ends a training when its speed is known: of whole rounds of acting and learning, after the first update.

    Attributes:
        make: Makes the last policy that was offered; None if none was.
    """

    def __init__(self, first: int, every: int, now: Callable[[], float] = time.perf_counter) -> None:
        """Begin before the first step.

        Args:
            first: Environment steps before the algorithm learns.
            every: Environment steps from one update to the next, where that is long; else 1.
            now: The time, [s].
        """
        self._first, self._every, self._now = first, every, now
        self._start = now()
        self._marks: list[tuple[float, int]] = []  # the first report, that after the first update, the last
        self.make: Callable[[], Policy] | None = None

    def policy(self, steps: int, make: Callable[[], Policy]) -> None:
        self.make = make

    def __call__(self, steps: int) -> None:
        mark = self._now(), steps
        if len(self._marks) < 2:
            self._marks.append(mark)  # of the second the last report takes the place, until it has learned
            return
        is_new_round = (steps - 1) // self._every > (self._marks[-1][1] - 1) // self._every
        if len(self._marks) == 2 and steps > self._first and is_new_round:
            self._marks[1:] = [mark, mark]
            return
        self._marks[-1] = mark
        is_known = len(self._marks) == 3 and is_new_round and mark[0] - self._marks[1][0] >= SECONDS
        if is_known or mark[0] - self._marks[0][0] >= MOST:
            raise _Enough

    @property
    def setup(self) -> float:
        """Seconds until the first report: libraries are imported, and envs are made."""
        return self._marks[0][0] - self._start if self._marks else 0.0

    @property
    def speed(self) -> tuple[int, float]:
        """How many steps were measured, and the seconds of each."""
        end = self._marks[-1] if self._marks else (self._now(), 0)
        begun = [*reversed(self._marks[:-1]), (self._start, 0)]
        begin = next((mark for mark in begun if mark[1] < end[1]), end)
        steps = end[1] - begin[1]
        return steps, (end[0] - begin[0]) / max(steps, 1)


@dataclass(frozen=True)
class MeasureKind(Plain):
    """The measurement of a kind of cells, as a worker is told to do it."""

    cell: Cell
    plugins: tuple[Given, ...]

    noun: ClassVar[str] = "measurement"

    def do(self, folder: Path, report: Report) -> bool:
        partial = partial_folder(folder)
        report(Word(0))
        measured = self._measure(load_registry(given=self.plugins), partial, report)
        (partial / ANSWER).write_text(json.dumps(measured.to_json()), encoding="utf-8")
        publish(partial, folder, is_lasting=False)
        return True

    def _measure(self, registry: Registry, folder: Path, report: Report) -> Measured:
        begun, cell = time.perf_counter(), self.cell
        world = world_of(cell, registry, folder, report)
        algorithm: Algorithm = cell.algorithm.build(registry, "algorithms")
        world.build(algorithm)
        with world.training(Attempt(folder, {})) as env:
            env.reset(seed=cell.seed)
            period = getattr(getattr(env, "task", None), "decision_period", 1)
            first, every = (period * getattr(algorithm, name, 0) for name in ("learning_starts", "rollout"))
            watched = Watched(first, max(every, 1))
            made = time.perf_counter() - begun
            try:
                policy: Policy | None = algorithm.train(env, cell.steps, cell.seed, watched)
            except _Enough:
                policy = watched.make() if watched.make else None
        steps, per_step = watched.speed
        evaluation = self._evaluate(world, policy, folder / f"{EVALUATED}{world.suffix}") if policy else 0.0
        horizon = self._horizon(folder / EVALUATED)
        return Measured(steps, per_step, made + watched.setup, evaluation, horizon, peak_memory())

    def _evaluate(self, world: CellWorld, policy: Policy, path: Path) -> float:
        """Seconds of one evaluation; in an environment by a few of its episodes."""
        asked = self.cell.evaluation_episodes
        episodes = min(asked, EPISODES) if self.cell.is_in_environment else asked
        begun = time.perf_counter()
        world.evaluate(policy, self.cell.acted, episodes, path)
        return (time.perf_counter() - begun) * asked / episodes

    def _horizon(self, path: Path) -> int:
        return horizon_in(path) if self.cell.is_in_environment and path.exists() else 0


def horizon_in(recording: Path) -> int:
    """After how many steps a recorded environment itself ends an episode; 0 if it does not say so."""
    return int(read_facts(recording).spec.get(HORIZON) or 0)


def measure_kinds(cells: Sequence[Cell], given: tuple[Given, ...], at_once: int) -> Mapping[Cell, Measured | str]:
    """What cells take, or why that is not known, by a short training of each in a process of its own.

    As many are measured at a time as the run will do, so that they share the machine as its cells will.

    Args:
        cells: One of each kind.
        given: Plugins that were given by hand.
        at_once: How many cells the run does at a time.
    """
    with tempfile.TemporaryDirectory(prefix="harness-measure-", ignore_cleanup_errors=True) as folder:
        several = [*cells, *(cells[number % len(cells)] for number in range(at_once - len(cells)))] if cells else []
        orders = [
            Order(Path(folder) / str(number), MeasureKind(cell, given), LIMITS, fresh=True)
            for number, cell in enumerate(several)
        ]
        reasons: dict[Path, str] = {}

        def hear(news: News) -> None:
            if news.kind == "ended":
                reasons[news.folder] = news.reason

        run_orders(orders, at_once, hear)
        found: dict[Cell, Any] = {}
        for cell, order in zip(several, orders, strict=True):
            path = order.folder / ANSWER
            told = Measured.from_json(json.loads(path.read_text("utf-8"))) if path.exists() else reasons[order.folder]
            before = found.get(cell)
            found[cell] = (
                _together(before, told) if isinstance(before, Measured) and isinstance(told, Measured) else told
            )
    return found


def _together(one: Measured, other: Measured) -> Measured:
    """What two measurements of a kind say together: the steps of both, the slower of each time, the larger memory."""
    most = {
        name: max(getattr(one, name), getattr(other, name)) for name in ("per_step", "setup", "evaluation", "memory")
    }
    return replace(one, steps=one.steps + other.steps, **most)
