"""One type for everything that was kept of a training: what a reader of logs gives, and what an author of one imports.

A `Log` is facts and named columns of rows. A row is a step, an episode, or a point of a curve. `LogFormat` is the
interface that a reader fills.
"""

from typing import TYPE_CHECKING

from harness.face import face_of
from harness.log.facts import Failed as Failed, LogFacts as LogFacts, Unit as Unit
from harness.log.format import LogFormat as LogFormat
from harness.log.log import (
    ACTION as ACTION,
    BEFORE as BEFORE,
    BEHAVIOUR as BEHAVIOUR,
    EPISODES as EPISODES,
    FILE as FILE,
    INFO as INFO,
    LARGEST as LARGEST,
    OBSERVATION as OBSERVATION,
    OPERATOR as OPERATOR,
    RECORDED as RECORDED,
    REWARD as REWARD,
    SEEN as SEEN,
    SINCE as SINCE,
    START as START,
    SUCCESS as SUCCESS,
    TASK as TASK,
    Log as Log,
    Rows as Rows,
    in_memory as in_memory,
    require_columns as require_columns,
)

if not TYPE_CHECKING:
    __all__, __getattr__ = face_of(__name__, __file__)
