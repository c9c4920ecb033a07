"""The screen of rewards: scripts and a search, in few words."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

import harness
from harness import load_registry
from harness.experiment.plan import check_experiment, expand
from harness.experiment.screening import CANNOT_TELL, FAILING, NOTHING
from harness.registry import read_given
from harness_plugins.audit import Cheats
from harness_plugins.audit.search import find

REWARDS = '''"""One that pays for staying away, one for coming."""


def aloof(step):
    """Pay for every step."""
    return 1.0 + 0.0 * step.distance


def honest(step):
    """Cost for every step, and more the farther the target."""
    return -1.0 - step.distance
'''
ENVIRONMENT = {"task": "gymnasium:id=CartPole-v1", "baseline": "none", "reward": ["own"]}
QUICK = Cheats(steps=8_000, steps_elsewhere=2_000, starts=1)


@pytest.fixture
def screen(tmp_path):
    """What the screen says of rewards of an arm, or of what an experiment asks for, by reward."""
    (tmp_path / "mine.py").write_text(REWARDS)
    registry = load_registry(given=read_given([str(tmp_path / "mine.py")]))

    def said(*rewards, by=QUICK, algo="random", **settings):
        asked = settings or {"sim": "kinematic", "baseline": rewards[0], "reward": list(rewards[1:])}
        cells = expand(check_experiment({**asked, "algo": algo, "seeds": [0], "steps": 32}), registry).cells
        return {cell.reward.label: of for cell, of in zip(cells, by.screen(cells, registry), strict=True)}

    return said


@pytest.fixture
def searches(monkeypatch):
    """Every search finds nothing; what was asked of each, with its world's name and discount."""
    asked = []

    def note(world, wanted):
        asked.append((world.name, world.gamma, wanted.budget, wanted.starts))
        return SimpleNamespace(word=NOTHING, strength="", lines=("Nothing was found.", "A second line."))

    monkeypatch.setattr(find, "find_in", note)
    return asked


@pytest.fixture
def fails(monkeypatch):
    """Every search fails."""

    def fail(world, wanted):
        raise ZeroDivisionError("no search today")

    monkeypatch.setattr(find, "find_in", fail)


def test_reward_for_staying_away_is_told_from_one_for_coming(screen):
    """By a search of a moment, in the order of the cells; what scripts say stands behind it."""
    found = screen("honest", "aloof")
    assert list(found) == ["honest", "aloof"]
    assert {name: answer.word for name, answer in found.items()} == {"honest": NOTHING, "aloof": FAILING}
    assert found["aloof"].line.startswith(("ROBUST. Failing earns ", "FRAGILE. Failing earns "))
    assert "Not finishing pays more than finishing: " in found["aloof"].line


def test_environment_without_a_measure_of_success_cannot_be_told(screen):
    """There is nothing to fail at."""
    (answer,) = screen(**ENVIRONMENT).values()
    assert answer.word == CANNOT_TELL
    assert answer.line.startswith("Nothing measures success.")


def test_search_is_short_and_discounts_as_the_learner_does(screen, searches):
    """Of an arm, of an environment, and where the algorithm says its discount."""
    screen("honest", by=Cheats())
    screen(by=Cheats(), **ENVIRONMENT)
    screen(by=replace(Cheats(), starts=7), algo="sac-fast:gamma=0.9", sim="kinematic", baseline="honest", reward=[])
    usual = Cheats()
    assert searches == [
        ("fd100-reach, fd100", 0.95, usual.steps, usual.starts),
        ("gymnasium:id=CartPole-v1", 0.99, usual.steps_elsewhere, usual.starts),
        ("fd100-reach, fd100", 0.9, usual.steps, 7),
    ]
    assert usual.steps < find.ARM.budget
    assert usual.steps_elsewhere < find.ENVIRONMENT.budget


def test_first_line_of_a_search_is_told(screen, searches):
    """The others are an audit's."""
    (answer,) = screen("honest").values()
    assert answer.line.startswith("Nothing was found. ")
    assert "A second line." not in answer.line


def test_scripts_answer_where_a_search_fails(screen, fails):
    """They know what tempts; that they found nothing is no answer."""
    found = screen("honest", "aloof")
    assert {name: answer.word for name, answer in found.items()} == {"honest": CANNOT_TELL, "aloof": FAILING}
    assert "raised ZeroDivisionError: no search today while it was searched. Finishing pays" in found["honest"].line


def test_environment_where_the_search_fails_cannot_be_told(screen, fails):
    """No script moves there."""
    (answer,) = screen(**ENVIRONMENT).values()
    assert answer == (
        CANNOT_TELL,
        f"Not searched: Environment 'gymnasium' of package fd100-harness {harness.__version__} raised "
        "ZeroDivisionError: no search today while it was searched.",
    )
