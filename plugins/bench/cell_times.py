"""The time of one cell, in parts that add up to the whole."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

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

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> "CellTimes":
        """The times that `to_json` wrote."""
        return cls(**data)
