"""Rewards of arms are asked in an episode without an engine."""

import pytest

from harness import load_registry
from harness.experiment.plan import check_experiment, expand
from harness.experiment.trials.arm_trial import try_arm
from harness.experiment.trials.tried import Fault, Tried
from harness.registry import read_given
from tests.experiment.trials.conftest import ARM


@pytest.fixture
def tried(tmp_path):
    """The trial of a reward file, by what it pays."""

    def trial(paid, *, without=()):
        (tmp_path / "mine.py").write_text(ARM.replace("{paid}", paid))
        registry = load_registry(given=read_given([tmp_path / "mine.py"]))
        asked = {"sim": "kinematic", "algo": "random", "reward": "mine:k=2", "seeds": 1, "steps": 100}
        plan = expand(check_experiment(asked), registry)
        rewards = tuple(dict.fromkeys(cell.reward for cell in plan.cells))
        return try_arm(plan.cells[0], rewards, registry, without, lambda column: None)

    return trial


def test_what_works_is_not_spoken_of(tried):
    """Beside one of ours."""
    assert tried("-self.k * sample.distance") == Tried()


@pytest.mark.parametrize(
    ("paid", "told"),
    [
        (
            "-sample.distanse",
            "fails in step 0: MissingField: A step of an arm has no 'distanse'. It has: begin_distance, previous_best",
        ),
        ("float(sample.distance[0])", "fails in step 0: ValueError: it pays 2 arms"),
        ("sample.distance * float('nan')", "fails in step 0: ValueError: it pays 2 arms"),
        ("sample.distance / (sample.step[0] != 3)", "fails in step 2: "),
    ],
)
def test_what_fails_is_named(tried, paid, told):
    """By the label that the cells have."""
    (fault,) = tried(paid).faults
    assert (fault.noun, fault.name) == ("reward", "mine:k=2")
    assert fault.reason.startswith(told)


def test_what_is_left_out_is_not_asked(tried):
    """It may be what ends a process."""
    assert tried("1 / 0", without=("reward_mine:k=2",)) == Tried()
    assert tried("1 / 0").faults == (Fault("reward", "mine:k=2", tried("1 / 0").faults[0].reason),)
