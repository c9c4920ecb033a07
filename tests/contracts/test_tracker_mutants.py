"""Every tracker check has a broken tracker that fails it, and no other."""

import math
import signal
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from harness_plugins.kit import TRACKER_CHECKS, check_tracker, trackers, violations


class Lines:
    """Keeps the numbers of a cell in a file."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def log(self, steps, scalars):
        with self._path.open("a") as file:
            file.writelines(f"{steps} {name} {value}\n" for name, value in scalars.items())

    def end(self, outcome, reason):
        self._path.with_suffix(".end").write_text(f"{outcome} {reason}")


@dataclass
class Thawed:
    """Its settings can be changed while it runs."""

    def why_not(self):
        return ""

    def begin(self, cell):
        return Lines(cell.folder / f"{cell.id}.txt")


@dataclass(frozen=True)
class Sound:
    """A file for each cell: nothing is wrong with it."""

    def why_not(self):
        return ""

    def begin(self, cell):
        return Lines(cell.folder / f"{cell.id}.txt")


@dataclass(frozen=True)
class SetUpWithASet(Sound):
    """JSON knows no sets."""

    zones: frozenset[int] = frozenset({1})


class SaysNothing(Sound):
    """Whether it can be used is None."""

    def why_not(self):
        return None


class CannotHere(Sound):
    """It has no server."""

    def why_not(self):
        return "no server"


class KnowsTwoOutcomes(Sound):
    """It does not expect an interruption."""

    def begin(self, cell):
        track = super().begin(cell)
        end = track.end
        track.end = lambda outcome, reason: end({"done": 0, "failed": 1}[outcome], reason)
        return track


@dataclass(frozen=True)
class OneAtATime(Sound):
    """It has one open cell, whose numbers it takes."""

    open: list[str] = field(default_factory=list)

    def begin(self, cell):
        self.open[:] = [cell.id]
        track = super().begin(cell)
        log = track.log

        def log_if_open(steps, scalars):
            if self.open != [cell.id]:
                raise RuntimeError("another cell is open")
            log(steps, scalars)

        track.log = log_if_open
        return track


class WholeNumbers(Sound):
    """It rounds."""

    def begin(self, cell):
        track = super().begin(cell)
        log = track.log
        track.log = lambda steps, scalars: log(steps, {name: math.floor(value) for name, value in scalars.items()})
        return track


class NamesFilesAfterTitles(Sound):
    """A title may hold what no name of a file holds."""

    def begin(self, cell):
        (cell.folder / cell.title).touch()
        return super().begin(cell)


class MakesAFolderOnce(Sound):
    """It does not expect that the folder is there."""

    def begin(self, cell):
        (cell.folder / cell.id).mkdir()
        return super().begin(cell)


class CatchesSignals(Sound):
    """Only the main thread may."""

    def begin(self, cell):
        signal.signal(signal.SIGUSR2, signal.SIG_DFL)
        return super().begin(cell)


class Greets(Sound):
    """It prints."""

    def begin(self, cell):
        print("hello")  # noqa: T201
        return super().begin(cell)


class LeavesALink(Sound):
    """To the latest cell."""

    def begin(self, cell):
        latest = cell.folder / "latest"
        latest.unlink(missing_ok=True)
        latest.symlink_to(cell.id)
        return super().begin(cell)


class TakesThePlansPlace(Sound):
    """Its own file has the name of another."""

    def begin(self, cell):
        (cell.folder / "plan.json").write_text(cell.id)
        return super().begin(cell)


MUTANTS = {
    Thawed: trackers.settings_are_frozen,
    SetUpWithASet: trackers.settings_survive_json,
    SaysNothing: trackers.whether_it_can_be_used_is_a_text,
    CannotHere: trackers.whether_it_can_be_used_is_a_text,
    KnowsTwoOutcomes: trackers.every_outcome_is_taken,
    OneAtATime: trackers.cells_are_tracked_side_by_side,
    WholeNumbers: trackers.odd_numbers_are_taken,
    NamesFilesAfterTitles: trackers.odd_texts_are_taken,
    MakesAFolderOnce: trackers.a_killed_cell_goes_on,
    CatchesSignals: trackers.another_thread_may_call_it,
    Greets: trackers.nothing_is_printed,
    LeavesALink: trackers.the_experiment_is_left_alone,
    TakesThePlansPlace: trackers.the_experiment_is_left_alone,
}


def failing(mutant: type, folder: Path) -> list[str]:
    """Names of the checks that a mutant fails."""
    found = []
    for check in TRACKER_CHECKS:
        place = folder / check.name
        place.mkdir()
        found += [violation.check for violation in violations([check], mutant(), place)]
    return found


def test_mutant_fails_one_check(tmp_path_factory: pytest.TempPathFactory, subtests: pytest.Subtests):
    """A tracker that is broken in one way fails the check of that fact, and no other."""
    for mutant, check in MUTANTS.items():
        with subtests.test(mutant=mutant, check=check):
            tmp_path = tmp_path_factory.mktemp("case")
            assert failing(mutant, tmp_path) == [check.name]


def test_every_check_has_a_mutant():
    """No check is without a tracker that fails it alone."""
    assert set(MUTANTS.values()) == set(TRACKER_CHECKS)


def test_the_mutants_are_made_of_a_sound_tracker(tmp_path: Path):
    """What the mutants are made of fails nothing."""
    check_tracker(Sound(), tmp_path)
