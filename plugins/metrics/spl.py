"""How often, and how directly, the target is reached."""

from dataclasses import dataclass
from typing import ClassVar

from harness.log import Log

from ..way_to_target import paths_to_target


@dataclass(frozen=True)
class Spl:
    """Success weighted by path length, mean over all finished episodes, in [0, 1] (Anderson et al. 2018, SPL).

    An episode that reaches the target counts the straight line divided by the end effector's path, both as in
    `path_ratio`. An episode that fails, or ends where it began, counts 0.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"
    is_share: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        path, straight = paths_to_target(trace).T
        counts = straight > 0.0
        return float((straight[counts] / path[counts]).sum() / len(path)) if len(path) else None
