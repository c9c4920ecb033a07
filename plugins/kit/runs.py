"""What an executor and a tracker must satisfy at the least; their packages test by a run what else they do."""

import math
from pathlib import Path
from typing import get_args

from harness.executor import Event, Executor, Job, Outcome, TrackedCell, Tracker
from harness.experiment.plan import check_experiment, expand
from harness.record import read_manifest
from harness.registry import load_registry

from .contract import check, require, settings_are_frozen, settings_survive_json

SMALL = {"sim": "kinematic", "algo": "random", "baseline": "baseline", "reward": [], "seeds": [0, 1]}
"""An experiment of two cells of a moment."""


@check("executor-cells")
def every_cell_is_done(executor: Executor, folder: Path) -> None:
    """Each job begins once, ends once without a reason, and leaves the folder of a cell that is done."""
    settings = {**SMALL, "steps": 20, "evaluation_episodes": 1}
    cells = expand(check_experiment(settings, "the kit"), load_registry()).cells
    told: list[Event] = []
    executor.run([Job(cell, folder / cell.id) for cell in cells], 2, told.append)
    for cell in cells:
        events = [it for it in told if it.cell == cell]
        kinds = [it.kind for it in events if it.kind != "progress"]
        require(kinds == ["started", "ended"], f"told {kinds} of a cell, not that it started and ended")
        require(not events[-1].reason, f"a cell that can be done ended with '{events[-1].reason}'")
        require((folder / cell.id).is_dir(), "a cell that ended without a reason left no folder")
        require(read_manifest(folder / cell.id).status == "done", "a cell that ended without a reason is not done")


@check("tracker-cells")
def cells_are_tracked_side_by_side(tracker: Tracker, folder: Path) -> None:
    """It can be used, and takes two cells in turns, each outcome, and numbers that are not finite."""
    require(not tracker.why_not(), f"it cannot be used here: {tracker.why_not()}")
    tracks = [tracker.begin(TrackedCell(f"cell-{it}", "a title", "a group", {}, folder)) for it in range(3)]
    for steps, value in enumerate((0.5, math.nan, math.inf, -1e300)):
        for track in tracks:
            track.log(steps, {"Training/Success Rate": value})
    for track, outcome in zip(tracks, get_args(Outcome), strict=True):
        track.end(outcome, "the arm fell off" if outcome == "failed" else "")


EXECUTOR_CHECKS = (settings_are_frozen, settings_survive_json, every_cell_is_done)
TRACKER_CHECKS = (settings_are_frozen, settings_survive_json, cells_are_tracked_side_by_side)
