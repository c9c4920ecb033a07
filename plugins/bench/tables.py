"""A bench as a terminal shows it."""

from rich.console import Group, RenderableType
from rich.text import Text

from harness.authoring.pages import Grid, show_grid

from .cell_times import PARTS, TRAINING
from .cells import Bench, Timing

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
