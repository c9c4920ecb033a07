"""What is written down, and how it is read again: formats, no behaviour."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.record.cell import Cell as Cell, Manifest as Manifest, read_manifest as read_manifest
    from harness.record.folder import (
        DERIVED as DERIVED,
        EVALUATION as EVALUATION,
        EVALUATION_RECORDING as EVALUATION_RECORDING,
        LOG as LOG,
        MANIFEST as MANIFEST,
        POLICY as POLICY,
        RANDOM as RANDOM,
        TRACE as TRACE,
        partial_folder as partial_folder,
    )
    from harness.record.plan_file import EXPERIMENT as EXPERIMENT, PLAN as PLAN
    from harness.record.recording.facts import TrainingFacts as TrainingFacts
    from harness.record.recording.recorded_training import read_recording as read_recording
    from harness.record.store import CELLS as CELLS, REPORT as REPORT, RESULTS as RESULTS, Store as Store
    from harness.record.terms import Terms as Terms
    from harness.record.trace import (
        COLUMN as COLUMN,
        SCALARS as SCALARS,
        EpisodeFacts as EpisodeFacts,
        TraceWriter as TraceWriter,
        read_trace as read_trace,
        trace_of as trace_of,
    )
else:
    __all__, __getattr__ = face_of(__name__)
