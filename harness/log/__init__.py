"""One type for everything that was kept of a training: what a reader of logs gives, and what an author of one imports.

A `Log` is facts and named columns of rows. A row is a step, an episode, or a point of a curve. `LogFormat` is the
interface that a reader fills.
"""

from typing import TYPE_CHECKING

from harness.face import face_of
from harness.log.facts import Failed as Failed, LogFacts as LogFacts
from harness.log.format import LogFormat as LogFormat
from harness.log.log import (
    Log as Log,
    Rows as Rows,
    in_memory as in_memory,
    require_columns as require_columns,
)

if TYPE_CHECKING:
    from harness.log.measure import Measure as Measure
    from harness.log.open_log import open_logs as open_logs
    from harness.record.dataset.open_dataset import DatasetFacts as DatasetFacts
    from harness.record.trace import episode_facts as episode_facts, trace_of as trace_of
else:
    __all__, __getattr__ = face_of(__name__)
