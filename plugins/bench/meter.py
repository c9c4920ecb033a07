"""Seconds spent in calls."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from harness.reward import Array, Carry, Reward, Sample

Clock: TypeAlias = Callable[[], float]
CLOCK: Clock = time.perf_counter
"""[s]. On Linux it is one clock for all processes: a worker goes on where its parent began to count."""


@dataclass(eq=False)
class Meter:
    """Sums up what calls took.

    Attributes:
        seconds: All calls together, [s].
        calls: How many.
    """

    clock: Clock = CLOCK
    seconds: float = 0.0
    calls: int = 0

    def timed(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """A function that does the same as `function`; what it takes is added to this meter."""
        clock = self.clock

        def call(*arguments: Any, **named: Any) -> Any:
            begin = clock()
            result = function(*arguments, **named)
            self.seconds += clock() - begin
            self.calls += 1
            return result

        return call


class TimedMethods:
    """Stands for an object, some of whose methods are timed; all else is the object's own."""

    def __init__(self, inner: Any, names: tuple[str, ...], meter: Meter) -> None:
        """Time the methods `names`, those that `inner` has."""
        self._inner = inner
        for name in names:
            if hasattr(inner, name):
                setattr(self, name, meter.timed(getattr(inner, name)))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)


class TimedReward(TimedMethods):
    """Stands for a reward."""

    def __init__(self, reward: Reward, meter: Meter) -> None:
        """Time both of its calls."""
        super().__init__(reward, ("initial_carry",), meter)
        self._call = meter.timed(reward)

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        """See `harness.reward.Reward`."""
        result: tuple[Carry, Array] = self._call(carry, sample)
        return result


def seconds_per_call(calls: int = 20_000, rounds: int = 5) -> float:
    """What a timed call of a function that does nothing takes, [s]: the least of some rounds.

    Some of it falls in what is timed, the rest in what is around it.
    """

    def nothing() -> None:
        pass

    return min(_seconds(Meter().timed(nothing), calls) for _ in range(rounds)) / calls


def _seconds(function: Callable[[], object], calls: int) -> float:
    begin = CLOCK()
    for _ in range(calls):
        function()
    return CLOCK() - begin
