"""Measures a cell while it is run, without changing what it does."""

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from harness.authoring.commands import Stage, Watch

from .cell_times import PARTS, CellTimes
from .meter import CLOCK, Clock, Meter, TimedMethods, TimedReward

if TYPE_CHECKING:
    from harness.authoring.commands import ReachVectorEnv

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
        """See `harness.experiment.watch.Watch`."""
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
