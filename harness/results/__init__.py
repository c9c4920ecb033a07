"""Reads the results in an experiment's folder. Importing it loads no robot, policy, environment or engine."""

from typing import TYPE_CHECKING, Any

from harness.face import look_up
from harness.results.comparison import Comparison, Group
from harness.results.load import load_results
from harness.results.results import Results

if TYPE_CHECKING:
    from harness.results.comparison import Behaviour, StepChange
    from harness.results.logs.trainings import sort_files, sort_logs
    from harness.results.measured import measure
    from harness.results.metrics import load_metrics
    from harness.results.overview import pay_texts
    from harness.results.pairs import Pairs
    from harness.results.ranking import ranking_of
    from harness.results.recordings.episodes import episodes_of
    from harness.results.replay import first_show, show_cells, shows_of
    from harness.results.score_matrix import score_matrices
    from harness.results.standing import standing_of, told_manifests
    from harness.results.terms_paid import TermPaid, TermsPaid
    from harness.results.trajectories import Trajectories, Trajectory, trajectories_of

__all__ = [
    "Behaviour",
    "Comparison",
    "Group",
    "Pairs",
    "Results",
    "StepChange",
    "TermPaid",
    "TermsPaid",
    "Trajectories",
    "Trajectory",
    "episodes_of",
    "first_show",
    "load_metrics",
    "load_results",
    "measure",
    "pay_texts",
    "ranking_of",
    "score_matrices",
    "show_cells",
    "shows_of",
    "sort_files",
    "sort_logs",
    "standing_of",
    "told_manifests",
    "trajectories_of",
]

_HOMES = {
    "comparison": "Behaviour StepChange",
    "logs.trainings": "sort_files sort_logs",
    "measured": "measure",
    "metrics": "load_metrics",
    "overview": "pay_texts",
    "pairs": "Pairs",
    "ranking": "ranking_of",
    "recordings.episodes": "episodes_of",
    "replay": "first_show show_cells shows_of",
    "score_matrix": "score_matrices",
    "standing": "standing_of told_manifests",
    "terms_paid": "TermPaid TermsPaid",
    "trajectories": "Trajectories Trajectory trajectories_of",
}


def __getattr__(name: str) -> Any:
    return look_up(__name__, _HOMES, name)
