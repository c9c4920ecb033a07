"""Reads the results in an experiment's folder. Importing it loads no robot, policy, environment or engine."""

from typing import TYPE_CHECKING

from harness.face import face_of
from harness.results.comparison import Comparison as Comparison, Group as Group
from harness.results.load import load_results as load_results
from harness.results.results import Results as Results

if TYPE_CHECKING:
    from harness.results.cell_results import CellResults as CellResults
    from harness.results.comparison import Behaviour as Behaviour, StepChange as StepChange
    from harness.results.logs.told import Deciding as Deciding, Told as Told, parse_deciding as parse_deciding
    from harness.results.logs.trainings import (
        require_several as require_several,
        sort_files as sort_files,
        sort_logs as sort_logs,
    )
    from harness.results.metrics import load_metrics as load_metrics, measure as measure
    from harness.results.overview import pay_texts as pay_texts
    from harness.results.pairs import Pairs as Pairs
    from harness.results.ranking import ranking_of as ranking_of
    from harness.results.recordings.episodes import episodes_of as episodes_of
    from harness.results.replay import (
        Trajectories as Trajectories,
        Trajectory as Trajectory,
        first_show as first_show,
        show_cells as show_cells,
        shows_of as shows_of,
        trajectories_of as trajectories_of,
    )
    from harness.results.results import standing_of as standing_of, told_manifests as told_manifests
    from harness.results.score_matrix import score_matrices as score_matrices
    from harness.results.traces import Traces as Traces
    from harness.results.trainings import TermPaid as TermPaid, TermsPaid as TermsPaid
    from harness.results.under_way import are_flags as are_flags, hint_of as hint_of, measure_of as measure_of
else:
    __all__, __getattr__ = face_of(__name__, __file__)
