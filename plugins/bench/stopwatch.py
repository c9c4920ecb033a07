"""Measures a cell while it is run, without changing what it does: its time, in parts that add up to the whole."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

from harness.authoring.commands import Stage, Watch
from harness.reward import Array, Carry, Reward, Sample

if TYPE_CHECKING:
    from harness.authoring.commands import ReachVectorEnv

TRAINING = ("simulator", "reward", "trace", "env", "algorithm")
"""Parts that grow with the environment steps of the training."""
PARTS = ("start_up", *TRAINING, "evaluation", "saving")
"""All parts, in the order in which they are shown.

start_up    the process starts, imports, builds env and algorithm, up to the algorithm's first call of the env
simulator   calls into the engine, while the cell trains
reward      calls of the reward, while the cell trains
trace       rows are copied and written, the end of the file included
env         what is left of the env's step and reset: motion, observation, episodes, starts and targets
algorithm   what is left of the training: acting, updating, telling its progress
evaluation  the trained policy and random actions
saving      policy and manifest are written, the process ends
"""


@dataclass(frozen=True)
class CellTimes:
    """What one process took for one cell.

    Attributes:
        seconds: Of each of `PARTS`, [s]; they add up to the time from before the process started to after its end.
        steps: Environment steps of the training.
        calls: How many calls were timed.
        core_share: Of the time until these times were told, what the process had a core for. A one-thread process has
            it nearly all the time, but on a machine that does more than it has cores for.
    """

    seconds: Mapping[str, float]
    steps: int
    calls: int
    core_share: float

    @property
    def whole(self) -> float:
        """From before the process started to after its end, [s]."""
        return sum(self.seconds.values())

    def ended_after(self, seconds: float) -> "CellTimes":
        """The same, of a process that ended so many seconds after it had told these times."""
        longer = {**self.seconds, "saving": self.seconds["saving"] + seconds}
        return replace(self, seconds=longer)


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


METERED = ("simulator", "reward", "trace", "env")
"""Parts of the training that have a meter."""
ENGINE = ("reset", "drive", "place")
"""The methods of `harness.simulator.Simulation` that an env calls while it trains."""


class Stopwatch(Watch):
    """Sums up the time of one cell by parts.

    The stages of the cell follow one another, and each moment counts for one of them. Within the training the calls of
    the env are timed, and within these the calls of engine, reward and recorder: what is left is the part around them.
    """

    def __init__(self, begun: float, clock: Clock = CLOCK, core_clock: Clock = time.process_time) -> None:
        """Begin.

        Args:
            begun: What `clock` showed when the process was started.
            clock: Tells the time, [s].
            core_clock: Tells what this process had a core for, [s].
        """
        self._clock, self._core_clock = clock, core_clock
        self._since, self._stage = begun, "start_up"
        self._stages = dict.fromkeys(("start_up", "training", "trace", "evaluation", "saving"), 0.0)
        self._meters = {part: Meter(clock) for part in METERED}
        self._env: ReachVectorEnv | None = None

    def follow(self, env: "ReachVectorEnv") -> None:
        """See `harness.experiment.watch.Watch`.

        The training counts from the first call of the env: before, it is being built.
        """
        self._env, meters = env, self._meters
        env.simulation = TimedMethods(env.simulation, ENGINE, meters["simulator"])
        env.reward = TimedReward(env.reward, meters["reward"])
        recorder = env.recorder
        if recorder is not None:
            recorder.append = meters["trace"].timed(recorder.append)  # type: ignore[method-assign]
        env.reset = self._training(env.reset)  # type: ignore[method-assign]
        env.step = self._training(env.step)  # type: ignore[method-assign]

    def enter(self, stage: Stage) -> None:
        self._enter(stage)

    def stop(self) -> CellTimes:
        """The times up to now."""
        self._enter(self._stage)
        inside = {part: self._meters[part].seconds for part in ("simulator", "reward", "trace")}
        around = self._meters["env"].seconds
        seconds = {
            **self._stages,
            **inside,
            "trace": inside["trace"] + self._stages["trace"],
            "env": around - sum(inside.values()),
            "algorithm": self._stages["training"] - around,
        }
        steps = self._env.environment_steps if self._env else 0
        return CellTimes(
            {part: seconds[part] for part in PARTS},
            steps,
            calls=sum(meter.calls for meter in self._meters.values()),
            core_share=self._core_clock() / sum(self._stages.values()),
        )

    def _enter(self, stage: str) -> None:
        now = self._clock()
        self._stages[self._stage] += now - self._since
        self._since, self._stage = now, stage

    def _training(self, function: Callable[..., Any]) -> Callable[..., Any]:
        timed = self._meters["env"].timed(function)

        def call(*arguments: Any, **named: Any) -> Any:
            if self._stage == "start_up":
                self._enter("training")
            return timed(*arguments, **named)

        return call
