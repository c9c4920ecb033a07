"""One type for everything that was kept of a training: what a reader of logs gives, and what an author of one imports.

A `Log` is facts and named columns of rows. A row is a step, an episode, or a point of a curve. `LogFormat` is the
interface that a reader fills; `harness.log.open_log` finds the reader of a file or a folder.
"""

from harness.log.facts import Failed, LogFacts, Unit
from harness.log.format import LogFormat
from harness.log.log import (
    ACTION,
    BEFORE,
    BEHAVIOUR,
    EPISODES,
    FILE,
    INFO,
    LARGEST,
    OBSERVATION,
    OPERATOR,
    RECORDED,
    REWARD,
    SEEN,
    SINCE,
    START,
    SUCCESS,
    TASK,
    Log,
    OpenEpisodes,
    Rows,
    episode_sum,
    episode_sums,
    in_memory,
    sums_so_far,
)

__all__ = [
    "ACTION",
    "BEFORE",
    "BEHAVIOUR",
    "EPISODES",
    "FILE",
    "INFO",
    "LARGEST",
    "OBSERVATION",
    "OPERATOR",
    "RECORDED",
    "REWARD",
    "SEEN",
    "SINCE",
    "START",
    "SUCCESS",
    "TASK",
    "Failed",
    "Log",
    "LogFacts",
    "LogFormat",
    "OpenEpisodes",
    "Rows",
    "Unit",
    "episode_sum",
    "episode_sums",
    "in_memory",
    "sums_so_far",
]
