"""Several ways to do the same work, timed taking turns.

What counts is the time that this process had a core for. On a machine that does other things too, the time on the wall
says more about these than about the work; docs/performance.md has both, measured.
"""

import math
import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from harness.bench.meter import Clock, Meter

CLOCK: Clock = time.process_time
"""[s] of all threads of this process; what it waits for does not count."""
FEWEST, MOST = 5, 25
"""Turns."""
LEAST = 0.02
"""Of a turn, [s]: work that takes less is repeated within the turn."""


def nothing() -> None:
    """What a contender does before a turn that needs no preparation."""


@dataclass(frozen=True)
class Contender:
    """One way to do the work.

    Attributes:
        run: Once the work; this is timed.
        steps: Environment steps of it, over all envs, >= 1.
        prepare: Called before; not timed.
        inside: Parts of the work that are told too, by name; each is a meter of what `run` calls, by the same clock.
    """

    run: Callable[[], object]
    steps: int
    prepare: Callable[[], object] = nothing
    inside: Mapping[str, Meter] = field(default_factory=dict)


def take_turns(contenders: Mapping[str, Contender], budget: float, clock: Clock = CLOCK) -> dict[str, list[float]]:
    """What an environment step took in each turn, [s], by contender and part of a contender.

    The contenders take turns, so that a slow moment of the machine meets all of them. The first time of each warms up
    and does not count; how long it takes decides how often the work is done in a turn, and how many turns there are:
    at least `FEWEST`, at most `MOST`.

    Args:
        contenders: By name.
        budget: About how long all turns may take together, [s].
        clock: Tells the time, [s].
    """
    first = {name: _seconds(name, it, 1, clock)[name] * it.steps for name, it in contenders.items()}
    repeats = {name: max(1, math.ceil(LEAST / max(seconds, 1e-6))) for name, seconds in first.items()}
    turn = sum(max(seconds, 1e-6) * repeats[name] for name, seconds in first.items())
    found: dict[str, list[float]] = {}
    for _ in range(min(max(int(budget / turn), FEWEST), MOST)):
        for name, contender in contenders.items():
            for part, seconds in _seconds(name, contender, repeats[name], clock).items():
                found.setdefault(part, []).append(seconds)
    return found


def _seconds(name: str, contender: Contender, repeats: int, clock: Clock) -> dict[str, float]:
    """Per environment step, of one turn: the contender's parts, and the whole under its name."""
    before = {part: meter.seconds for part, meter in contender.inside.items()}
    whole = 0.0
    for _ in range(repeats):
        contender.prepare()
        begin = clock()
        contender.run()
        whole += clock() - begin
    parts = {part: meter.seconds - before[part] for part, meter in contender.inside.items()}
    return {part: seconds / (repeats * contender.steps) for part, seconds in {**parts, name: whole}.items()}


@dataclass(frozen=True)
class Round:
    """What one process measured.

    Attributes:
        seconds: Of an environment step, by contender and part of one the median over the turns, [s].
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
