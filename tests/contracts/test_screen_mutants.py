"""Every check of a screen catches the mistake that it is there for."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from harness.screen import CANNOT_TELL, FAILING, NOTHING, Screened
from harness_plugins.kit import SCREEN_CHECKS, check_screen, screens, violations

RAISED = Screened(CANNOT_TELL, "It raised an error.")


@dataclass(frozen=True)
class Sound:
    """It has nothing against rewards that are named so, of arms: nothing is wrong with it."""

    def screen(self, cells, registry):
        return [None if cell.is_in_environment else self.of(cell) for cell in cells]

    def of(self, cell) -> Screened | None:
        return RAISED if cell.reward.name == "raises" else Screened(NOTHING, f"{cell.reward.name} has a name.")


@dataclass
class Thawed:
    """Its settings can be changed while it is asked."""

    screen = Sound.screen
    of = Sound.of


@dataclass(frozen=True)
class SetUpWithASet(Sound):
    """JSON knows no sets."""

    zones: frozenset[int] = frozenset({1})


class LeavesOut(Sound):
    """What it says nothing of is missing, so that the others are taken for one another."""

    def screen(self, cells, registry):
        return [it for it in super().screen(cells, registry) if it is not None]


class SaysSafe(Sound):
    """A word that nobody may say."""

    def of(self, cell):
        return Screened("SAFE", "Nothing was found.")  # type: ignore[arg-type]


class SaysNoMore(Sound):
    """A word without a reason."""

    def of(self, cell):
        return Screened(NOTHING, " ")


class SaysTwoLines(Sound):
    """More than fits."""

    def of(self, cell):
        return Screened(NOTHING, "One.\nTwo.")


class KnowsNothing(Sound):
    """Nothing of anything."""

    def of(self, cell):
        return None


@dataclass(frozen=True)
class Counts(Sound):
    """How often it was asked decides."""

    asked: list[int] = field(default_factory=list)

    def of(self, cell):
        self.asked.append(1)
        return Screened(NOTHING, f"Asked {len(self.asked)} times.")


class KnowsTheFirst(Sound):
    """The first reward is sound, and the others are not."""

    def screen(self, cells, registry):
        return [Screened(FAILING if number else NOTHING, "By place.") for number, _ in enumerate(cells)]


class AlarmsOfErrors(Sound):
    """What raises does not pay for failing."""

    def of(self, cell):
        return Screened(FAILING, "It raised an error.") if cell.reward.name == "raises" else super().of(cell)


class IsStopped(Sound):
    """The other rewards are not looked at any more."""

    def screen(self, cells, registry):
        is_raised = any(cell.reward.name == "raises" for cell in cells)
        return [RAISED if is_raised else it for it in super().screen(cells, registry)]


class LetsItThrough(Sound):
    """Whatever the reward raises."""

    def of(self, cell):
        if cell.reward.name == "raises":
            raise ValueError("no pay today")
        return super().of(cell)


class Writes(Sound):
    """A file that nobody asked for."""

    def of(self, cell):
        Path("screen.json").write_text("{}")
        return super().of(cell)


MUTANTS: dict[type[Any], Any] = {
    Thawed: screens.settings_are_frozen,
    SetUpWithASet: screens.settings_survive_json,
    LeavesOut: screens.each_cell_has_an_answer,
    SaysSafe: screens.each_cell_has_an_answer,
    SaysNoMore: screens.each_cell_has_an_answer,
    SaysTwoLines: screens.each_cell_has_an_answer,
    KnowsNothing: screens.each_cell_has_an_answer,
    Counts: screens.screening_twice_is_the_same,
    KnowsTheFirst: screens.screening_twice_is_the_same,
    AlarmsOfErrors: screens.a_reward_that_raises_stops_nothing,
    IsStopped: screens.a_reward_that_raises_stops_nothing,
    LetsItThrough: screens.a_reward_that_raises_stops_nothing,
    Writes: screens.nothing_is_written,
}


def test_sound_screen_keeps_the_contract(tmp_path: Path):
    """No check finds anything in it."""
    check_screen(Sound(), tmp_path)


@pytest.mark.parametrize(("mutant", "check"), MUTANTS.items(), ids=lambda it: it.__name__)
def test_mutant_is_caught(mutant: type[Any], check: Any, tmp_path: Path):
    """By the check that is there for it."""
    assert [it.check for it in violations([check], mutant(), tmp_path)] == [check.name]


def test_every_check_has_a_mutant():
    """None is there for nothing."""
    assert set(SCREEN_CHECKS) == set(MUTANTS.values())
