"""What is written down, and how it is read again: formats, no behaviour."""

from typing import TYPE_CHECKING, Any

from harness.face import look_up

if TYPE_CHECKING:
    from harness.record.cell import Cell
    from harness.record.episode_facts import EpisodeFacts
    from harness.record.folder import (
        DERIVED,
        EVALUATION,
        EVALUATION_RECORDING,
        LOG,
        MANIFEST,
        POLICY,
        RANDOM,
        TRACE,
        partial_folder,
    )
    from harness.record.manifest import Manifest, read_manifest
    from harness.record.plan_file import EXPERIMENT, PLAN
    from harness.record.recording.facts import TrainingFacts
    from harness.record.recording.recorded_training import read_recording
    from harness.record.store import CELLS, REPORT, RESULTS, Store
    from harness.record.terms import Terms
    from harness.record.trace import COLUMN, SCALARS, TraceWriter, read_trace, trace_of

__all__ = [
    "CELLS",
    "COLUMN",
    "DERIVED",
    "EVALUATION",
    "EVALUATION_RECORDING",
    "EXPERIMENT",
    "LOG",
    "MANIFEST",
    "PLAN",
    "POLICY",
    "RANDOM",
    "REPORT",
    "RESULTS",
    "SCALARS",
    "TRACE",
    "Cell",
    "EpisodeFacts",
    "Manifest",
    "Store",
    "Terms",
    "TraceWriter",
    "TrainingFacts",
    "partial_folder",
    "read_manifest",
    "read_recording",
    "read_trace",
    "trace_of",
]

_HOMES = {
    "cell": "Cell",
    "episode_facts": "EpisodeFacts",
    "folder": "DERIVED EVALUATION EVALUATION_RECORDING LOG MANIFEST POLICY RANDOM TRACE partial_folder",
    "manifest": "Manifest read_manifest",
    "plan_file": "EXPERIMENT PLAN",
    "recording.facts": "TrainingFacts",
    "recording.recorded_training": "read_recording",
    "store": "CELLS REPORT RESULTS Store",
    "terms": "Terms",
    "trace": "COLUMN SCALARS TraceWriter read_trace trace_of",
}


def __getattr__(name: str) -> Any:
    return look_up(__name__, _HOMES, name)
