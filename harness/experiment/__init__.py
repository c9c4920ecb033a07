"""Runs the cells of an experiment: from what a user asks for to the folder of each cell."""

from typing import TYPE_CHECKING, Any

from harness.face import look_up

if TYPE_CHECKING:
    from harness.experiment.experiment import ExperimentRun
    from harness.experiment.plan import Plan, check_experiment, expand, read_experiment
    from harness.experiment.run_options import RunOptions
    from harness.experiment.workers.order import Order

__all__ = [
    "ExperimentRun",
    "Order",
    "Plan",
    "RunOptions",
    "check_experiment",
    "expand",
    "read_experiment",
]

_HOMES = {
    "experiment": "ExperimentRun",
    "plan": "Plan check_experiment expand read_experiment",
    "run_options": "RunOptions",
    "workers.order": "Order",
}


def __getattr__(name: str) -> Any:
    return look_up(__name__, _HOMES, name)
