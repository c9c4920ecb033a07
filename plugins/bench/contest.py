"""Several ways to do the same work, timed taking turns.

What counts is the time that this process had a core for. On a machine that does other things too, the time on the wall
says more about these than about the work; docs/performance.md has both, measured.
"""

import math
import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from .meter import Clock, Meter

CLOCK: Clock = time.process_time
"""[s] of all threads of this process; what it waits for does not count."""
FEWEST, MOST = 5, 25
"""Turns."""
LEAST = 0.02
"""The least time of a turn, [s]: work that takes less is repeated within the turn."""


def nothing() -> None:
    """What a contender does before a turn that needs no preparation."""


@dataclass(frozen=True)
class Contender:
    """One way to do the work.

    Attributes:
        run: Once the work; this is timed.
        steps: Environment steps of it, over all envs, >= 1.
        prepare: Called before; not timed.
        part: Of the work, what counts: a meter of what `run` calls, by the same clock. None: all of it.
    """

    run: Callable[[], object]
    steps: int
    prepare: Callable[[], object] = nothing
    part: Meter | None = None


def take_turns(contenders: Mapping[str, Contender], budget: float, clock: Clock = CLOCK) -> dict[str, list[float]]:
    """What an environment step took in each turn, [s], by contender.

    The contenders take turns, so that a slow moment of the machine meets all of them. The first time of each warms up
    and does not count; how long it takes decides how often the work is done in a turn, and how many turns there are:
    at least `FEWEST`, at most `MOST`.

    Args:
        contenders: By name.
        budget: About how long all turns may take together, [s].
        clock: Tells the time, [s].
    """
    first = {name: _seconds(it, 1, clock) * it.steps for name, it in contenders.items()}
    repeats = {name: max(1, math.ceil(LEAST / max(seconds, 1e-6))) for name, seconds in first.items()}
    turn = sum(max(seconds, 1e-6) * repeats[name] for name, seconds in first.items())
    found: dict[str, list[float]] = {name: [] for name in contenders}
    for _ in range(min(max(int(budget / turn), FEWEST), MOST)):
        for name, contender in contenders.items():
            found[name].append(_seconds(contender, repeats[name], clock))
    return found


def _seconds(contender: Contender, repeats: int, clock: Clock) -> float:
    """Per environment step, of one turn."""
    whole, part = 0.0, contender.part
    before = part.seconds if part else 0.0
    for _ in range(repeats):
        contender.prepare()
        begin = clock()
        contender.run()
        whole += clock() - begin
    return (part.seconds - before if part else whole) / (repeats * contender.steps)


@dataclass(frozen=True)
class Round:
    """What one process measured.

    Attributes:
        seconds: Of an environment step, by contender the median over the turns, [s].
        speeds: The same without the reference: how many times as fast as the reference, the median over the turns of
            what they had beside one another. Empty where there is no reference.
    """

    seconds: Mapping[str, float]
    speeds: Mapping[str, float]


def round_of(turns: Mapping[str, list[float]], reference: str) -> Round:
    """Medians of what `take_turns` found.

    Args:
        turns: By contender.
        reference: The contender that the others are measured against; empty for none.
    """
    others = [name for name in turns if name != reference] if reference else []
    speeds = {
        name: statistics.median(theirs / own for theirs, own in zip(turns[reference], turns[name], strict=True))
        for name in others
    }
    return Round({name: statistics.median(seconds) for name, seconds in turns.items()}, speeds)
