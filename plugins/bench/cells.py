"""The times of several cells, measured in turns, and how a terminal shows them."""

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from rich.console import Group, RenderableType
from rich.text import Text

from harness.authoring.commands import Cell, Plan, Registry, describe_machine, specs_of, versions_behind
from harness.authoring.pages import Grid, show_grid
from harness.executor import OnEvent

from .stopwatch import PARTS, TRAINING, CellTimes, seconds_per_call
from .timed_cell import Failed, time_cell

FORMAT = 1


@dataclass(frozen=True)
class Timing:
    """One combination, over all rounds.

    Attributes:
        cell: What was trained.
        rounds: Its times, at least one round's.
        clock_seconds: What it costs to time one call, [s].
    """

    cell: Cell
    rounds: tuple[CellTimes, ...]
    clock_seconds: float

    @cached_property
    def seconds(self) -> dict[str, float]:
        """The median over the rounds for each part, [s]."""
        return {part: statistics.median(times.seconds[part] for times in self.rounds) for part in PARTS}

    @property
    def whole(self) -> float:
        """Sum of the parts' medians, [s]."""
        return sum(self.seconds.values())

    @property
    def training(self) -> float:
        """Sum of the medians of the training's parts, [s]."""
        return sum(self.seconds[part] for part in TRAINING)

    @property
    def steps(self) -> int:
        """Environment steps of one training."""
        return self.rounds[0].steps

    @property
    def steps_per_second(self) -> float:
        """Environment steps of one training by what it takes, [1/s]."""
        return self.steps / self.training if self.training else 0.0

    @property
    def overhead(self) -> float:
        """What the timing adds to one training, [s]."""
        return self.rounds[0].calls * self.clock_seconds

    @property
    def core_share(self) -> float:
        """Median over the rounds of `CellTimes.core_share`."""
        return statistics.median(times.core_share for times in self.rounds)

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        cell = self.cell
        return {
            "simulator": cell.simulator.label,
            "algorithm": cell.algorithm.label,
            "reward": cell.reward.label,
            "task": cell.task.label,
            "robot": cell.robot,
            "environment_steps": self.steps,
            "seconds": self.seconds,
            "whole_s": self.whole,
            "training_s": self.training,
            "steps_per_second": self.steps_per_second,
            "timing_overhead_s": self.overhead,
            "core_share": self.core_share,
            "rounds": [{"seconds": dict(times.seconds), "whole_s": times.whole} for times in self.rounds],
        }


@dataclass(frozen=True)
class Bench:
    """What was measured.

    Attributes:
        rounds: How often each combination was to be trained.
        timings: Of those that worked.
        failed: Those that did not, each with the reason.
        skipped: Those that cannot, each with the reason.
        cpu: What it was measured on.
        versions: Of the distributions that the results depend on.
    """

    rounds: int
    timings: tuple[Timing, ...]
    failed: tuple[tuple[Cell, str], ...]
    skipped: tuple[tuple[Cell, str], ...]
    cpu: str
    versions: Mapping[str, str]

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "format": FORMAT,
            "rounds": self.rounds,
            "cpu": self.cpu,
            "versions": dict(self.versions),
            "combinations": [timing.to_json() for timing in self.timings],
            "failed": _reasons(self.failed),
            "skipped": _reasons(self.skipped),
        }


def measure(plan: Plan, registry: Registry, rounds: int, on_event: OnEvent) -> Bench:
    """Time every cell of a plan, one process at a time.

    The cells take turns: a slow moment of the machine meets all of them. One that fails is not tried again.

    Args:
        plan: What to train; nothing of it is kept.
        registry: The plugins.
        rounds: How often, >= 1.
        on_event: Told what happens to the cells.
    """
    found: dict[Cell, list[CellTimes]] = {cell: [] for cell in plan.cells}
    failed: dict[Cell, str] = {}
    with TemporaryDirectory(prefix="harness-bench-") as folder:
        for _ in range(rounds):
            for cell in _without(plan.cells, failed):
                times = time_cell(cell, Path(folder) / cell.id, on_event, registry.given)
                if isinstance(times, Failed):
                    failed[cell] = times.reason
                else:
                    found[cell].append(times)
    price = seconds_per_call()
    timings = tuple(Timing(cell, tuple(found[cell]), price) for cell in _without(plan.cells, failed))
    specs = [spec for cell in plan.cells for spec in specs_of(cell, registry).values()]
    machine = describe_machine()["cpu"]
    return Bench(rounds, timings, tuple(failed.items()), plan.skipped, machine, versions_behind(specs))


def _without(cells: Sequence[Cell], failed: dict[Cell, str]) -> list[Cell]:
    return [cell for cell in cells if cell not in failed]


def _reasons(cells: Sequence[tuple[Cell, str]]) -> list[dict[str, str]]:
    return [{"name": cell.title, "reason": reason} for cell, reason in cells]


LABELS = {"start_up": "start-up", "env": "rest of the env", "saving": "saving, end"}
HEADINGS = ("part", "seconds", "share", "us per step")
MICRO = 1e6
BUSY = 0.85
"""A smaller share of a core is told: the times are those of a busy machine."""


def bench_table(bench: Bench) -> RenderableType:
    """What ``harness bench`` prints: a block per combination, then what did not work."""
    blocks = [_block(timing) for timing in bench.timings]
    left_out = [("failed", *entry) for entry in bench.failed] + [("skipped", *entry) for entry in bench.skipped]
    return Group(*blocks, *(Text(f"{word}: {cell.title}: {reason}") for word, cell, reason in left_out))


def time_grid(timing: Timing) -> Grid:
    """Every part and the whole; per environment step what grows with them."""
    rows = [_row(timing, LABELS.get(part, part), timing.seconds[part], part in TRAINING) for part in PARTS]
    training = _row(timing, "training", timing.training, True)
    return Grid(HEADINGS, [*rows, training, _row(timing, "whole", timing.whole, False)], _notes(timing))


def _block(timing: Timing) -> RenderableType:
    cell = timing.cell
    names = (cell.simulator.label, cell.algorithm.label, cell.reward.label, cell.robot, cell.task.label)
    rounds = len(timing.rounds)
    told = f"{timing.steps:,} environment steps, {f'medians of {rounds} rounds' if rounds > 1 else 'one round'}"
    return Group(Text(" · ".join(names), style="bold"), Text(told), *show_grid(time_grid(timing)), Text())


def _row(timing: Timing, label: str, seconds: float, grows: bool) -> tuple[str, ...]:
    per_step = f"{MICRO * seconds / timing.steps:,.1f}" if grows and timing.steps else ""
    return label, f"{seconds:.3f}", f"{seconds / timing.whole:.1%}", per_step


def _notes(timing: Timing) -> list[str]:
    overhead = timing.overhead / timing.steps if timing.steps else 0.0
    busy = (
        f"Its process had a core for {timing.core_share:.0%} of the time: the machine did more than it has cores for."
    )
    return [
        *([busy] if timing.core_share < BUSY else []),
        f"{timing.steps_per_second:,.0f} environment steps per second of training: {', '.join(map(_name, TRAINING))}.",
        f"The timing itself took some {MICRO * overhead:.1f} us of each step.",
    ]


def _name(part: str) -> str:
    return LABELS.get(part, part)
