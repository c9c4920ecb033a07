"""Runs the cells of an experiment: from what a user asks for to the folder of each cell."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.experiment.experiment import ExperimentRun as ExperimentRun
    from harness.experiment.plan import (
        Plan as Plan,
        check_experiment as check_experiment,
        expand as expand,
        read_experiment as read_experiment,
    )
    from harness.experiment.run_options import RunOptions as RunOptions
    from harness.experiment.workers.order import Order as Order
else:
    __all__, __getattr__ = face_of(__name__, __file__)
