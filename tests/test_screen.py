"""Asking all registered screens."""

import sys
from dataclasses import dataclass

import pytest

from harness import load_registry
from harness.executor import Screened
from harness.experiment.plan import check_experiment, expand
from harness.experiment.screening import CANNOT_TELL, FAILING, NOTHING, screened
from harness.registry import Registry, Spec


@dataclass(frozen=True)
class Alarms:
    """Of every reward."""

    def screen(self, cells, registry):
        return [Screened(FAILING, cell.reward.label) for cell in cells]


class OfOne(Alarms):
    """It knows one reward alone."""

    def screen(self, cells, registry):
        return [Screened(NOTHING, "Known.") if cell.reward.label == "dense" else None for cell in cells]


class Raises(Alarms):
    """It fails."""

    def screen(self, cells, registry):
        raise KeyError("a mistake of the screen")


class Leaves(Alarms):
    """It wants to end the process."""

    def screen(self, cells, registry):
        raise SystemExit(0)


class SaysSafe(Alarms):
    """A word that there is not."""

    def screen(self, cells, registry):
        return [Screened("SAFE", "Nothing was found.")] * len(cells)  # type: ignore[arg-type]


class LeavesOut(Alarms):
    """Fewer answers than cells."""

    def screen(self, cells, registry):
        return []


@pytest.fixture
def ask(monkeypatch):
    """What screens of these classes say of two rewards, of two seeds each, by reward and word."""
    monkeypatch.setitem(sys.modules, __name__, sys.modules[__name__])
    settings = {"sim": "kinematic", "algo": "random", "reward": "dense", "seeds": 2, "steps": 32}
    cells = expand(check_experiment(settings), load_registry()).cells

    def said(*names, requires=()):
        registry = Registry()
        for name in names:
            spec = Spec("screens", name.lower(), f"{__name__}:{name}", "", requires, None, "mine", "screens", "0.1")
            registry.specs["screens", name.lower()] = [spec]
        found = screened(cells, registry)
        return [(cell.reward.label, *answer) for cell, answer in found.said], found.left_out

    return said


def test_each_reward_is_asked_once_in_its_place(ask):
    """Whatever the seeds, in the order of the plan."""
    assert ask("Alarms")[0] == [("baseline", FAILING, "baseline"), ("dense", FAILING, "dense")]


def test_all_screens_are_asked(ask):
    """What they say of one reward stands together."""
    said, left_out = ask("Alarms", "OfOne")
    assert [it[:2] for it in said] == [("baseline", FAILING), ("dense", FAILING), ("dense", NOTHING)]
    assert left_out == ()


def test_reward_that_no_screen_looks_at_cannot_be_told(ask):
    """It is not as good as one that was looked at."""
    assert ask("OfOne")[0] == [("baseline", CANNOT_TELL, "No screen looks here."), ("dense", NOTHING, "Known.")]
    assert [it[1] for it in ask()[0]] == [CANNOT_TELL] * 2


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("Raises", "raised KeyError: 'a mistake of the screen' while rewards were screened"),
        ("Leaves", "raised SystemExit: 0 while rewards were screened"),
        ("SaysSafe", "it has to give one of PAYS FOR FAILING, PAYS FOR LOITERING, NOTHING FOUND, CANNOT TELL"),
        ("LeavesOut", "for each cell"),
    ],
)
def test_screen_that_fails_cannot_tell(ask, name, reason):
    """It stops nothing, and is named with the reason."""
    said, _ = ask(name)
    assert [it[1] for it in said] == [CANNOT_TELL] * 2
    assert all(reason in line and f"'{name.lower()}'" in line for _, _, line in said)


def test_screen_without_its_library_is_left_out(ask):
    """In one line that says what to install; then nothing is known."""
    said, left_out = ask("Alarms", requires=("no_such_library",))
    assert [it[1] for it in said] == [CANNOT_TELL] * 2
    assert left_out == ("screen 'alarms' is left out: it needs no_such_library: pip install no_such_library",)
