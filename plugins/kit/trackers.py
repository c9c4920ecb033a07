"""What a tracker must satisfy. Each check takes the tracker and an empty folder, which stands for an experiment's."""

import contextlib
import hashlib
import io
import math
import threading
from pathlib import Path
from typing import get_args

from harness.tracker import Outcome, TrackedCell, Tracker

from .contract import Check, check, raise_first_in_folders, require, settings_are_frozen, settings_survive_json

SCALARS = {"Training/Success Rate": 0.5, "Training/Episode Return": -3.25}
CONFIG = {"reward": "arp", "reward.k1": 1.0, "algorithm.net_arch": [64, 64], "seed": 0, "task.target": None, "on": True}
LONG = "a/b\\c: 'ü' \"%s\" ../.. " * 500


def check_tracker(tracker: Tracker, folder: Path | None = None) -> None:
    """Run all `TRACKER_CHECKS`; give settings with which nothing leaves this machine.

    Args:
        tracker: To be checked.
        folder: To work in; one for temporary files if None.

    Raises:
        ContractViolation: At the first check that fails.
    """
    raise_first_in_folders(TRACKER_CHECKS, tracker, folder)


@check("tracker-why-not")
def whether_it_can_be_used_is_a_text(tracker: Tracker, folder: Path) -> None:
    """`why_not` returns a text. It is empty if the tracker can be used, as it has to be here."""
    reason = tracker.why_not()
    require(isinstance(reason, str), f"why_not returned {reason!r}, not a text")
    require(not reason, f"it cannot be used here: {reason}")


@check("tracker-outcomes")
def every_outcome_is_taken(tracker: Tracker, folder: Path) -> None:
    """The tracker copes with cells that are done, fail or are interrupted, also without a single number."""
    for number, outcome in enumerate(get_args(Outcome)):
        track = tracker.begin(_cell(folder, number))
        track.end(outcome, "the arm fell off" if outcome == "failed" else "")


@check("tracker-side-by-side")
def cells_are_tracked_side_by_side(tracker: Tracker, folder: Path) -> None:
    """The tracker copes with two cells at once, whose numbers come in turns."""
    first, second = (tracker.begin(_cell(folder, number)) for number in range(2))
    for steps in (100, 200):
        first.log(steps, SCALARS)
        second.log(steps, SCALARS)
    first.end("done", "")
    second.log(300, SCALARS)
    second.end("done", "")


@check("tracker-numbers")
def odd_numbers_are_taken(tracker: Tracker, folder: Path) -> None:
    """The tracker copes with numbers that are NaN or infinite, and several numbers for one step."""
    track = tracker.begin(_cell(folder))
    for name, value in {"nan": math.nan, "infinite": math.inf, "huge": -1e300}.items():
        track.log(100, {name: value})
    track.end("done", "")


@check("tracker-texts")
def odd_texts_are_taken(tracker: Tracker, folder: Path) -> None:
    """The tracker copes with long labels and reasons with any characters."""
    track = tracker.begin(_cell(folder, title=LONG))
    track.log(100, SCALARS)
    track.end("failed", LONG)


@check("tracker-goes-on")
def a_killed_cell_goes_on(tracker: Tracker, folder: Path) -> None:
    """The tracker copes with a cell that begins again with its old id after its run was killed."""
    track = tracker.begin(_cell(folder))
    track.log(100, SCALARS)
    track.end("done", "")  # a kill cannot be had here, and some libraries allow one writer at a time
    track = tracker.begin(_cell(folder))
    track.log(200, SCALARS)
    track.end("done", "")


@check("tracker-thread")
def another_thread_may_call_it(tracker: Tracker, folder: Path) -> None:
    """The tracker works in a thread that is not the main one, where all calls but `why_not` come from."""
    errors: list[BaseException] = []

    def follow() -> None:
        try:
            _follow(tracker, folder)
        except Exception as error:  # a plugin may raise anything
            errors.append(error)

    thread = threading.Thread(target=follow)
    thread.start()
    thread.join()
    require(not errors, f"in another thread it raised {errors}")


@check("tracker-silent")
def nothing_is_printed(tracker: Tracker, folder: Path) -> None:
    """The tracker prints nothing: standard output belongs to the results."""
    told = io.StringIO()
    with contextlib.redirect_stdout(told):
        _follow(tracker, folder)
    require(not told.getvalue(), f"it printed {told.getvalue()[:100]!r}")


@check("tracker-folder")
def the_experiment_is_left_alone(tracker: Tracker, folder: Path) -> None:
    """The tracker changes no file of the experiment's folder and leaves no link in it, which would end the run."""
    (folder / "plan.json").write_text("{}")
    _follow(tracker, folder)
    require((folder / "plan.json").read_text() == "{}", "plan.json is not what it was")
    links = [path.name for path in folder.rglob("*") if path.is_symlink()]
    require(not links, f"it left links: {links}")


TRACKER_CHECKS: tuple[Check, ...] = (
    settings_are_frozen,
    settings_survive_json,
    whether_it_can_be_used_is_a_text,
    every_outcome_is_taken,
    cells_are_tracked_side_by_side,
    odd_numbers_are_taken,
    odd_texts_are_taken,
    a_killed_cell_goes_on,
    another_thread_may_call_it,
    nothing_is_printed,
    the_experiment_is_left_alone,
)


def _cell(folder: Path, number: int = 0, title: str = "ideal · wander · arp · seed 0") -> TrackedCell:
    """A cell of the experiment in `folder`; its id is its own, wherever trackers keep what they are told."""
    digest = hashlib.sha256(str(folder).encode()).hexdigest()
    return TrackedCell(f"{digest[:16]}-{number:x}", title, "ideal · wander · arp", dict(CONFIG), folder)


def _follow(tracker: Tracker, folder: Path) -> None:
    """One cell, from its beginning to its end."""
    track = tracker.begin(_cell(folder))
    track.log(100, SCALARS)
    track.end("done", "")
