"""Everything that is registered keeps its contract, a plugin that was installed yesterday included."""

import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import harness
from harness.errors import ContractViolation
from harness.motion import MODES
from harness.reach import ReachTask
from harness.registry.registry import load_registry
from harness.testing import (
    ALGORITHM_CHECKS,
    EXECUTOR_CHECKS,
    METRIC_CHECKS,
    REWARD_CHECKS,
    SIMULATOR_CHECKS,
    TASK_CHECKS,
    IdealSimulator,
    check_algorithm,
    check_executor,
    check_metric,
    check_reward,
    check_simulator,
    check_task,
    violations,
)
from harness.testing.algorithms import (
    a_training_goes_on_where_it_stood,
    checkpoints_change_nothing,
    the_return_rises,
    the_same_seed_gives_the_same_policy,
)
from harness.testing.simulators import frames_show_the_target, render_gives_a_frame_or_says_why_not
from harness.testing.trainings import NegativeDistance, Training, train

REGISTRY = load_registry()
ROBOT = harness.load_robot("fd100", REGISTRY)
FRAME_CHECKS = (render_gives_a_frame_or_says_why_not, frames_show_the_target)
OTHER_CHECKS = tuple(check for check in SIMULATOR_CHECKS if check not in FRAME_CHECKS)
SLOW = {(name, the_return_rises) for name in ("sac", "td3", "dqn", "ddqn", "ppo")}
"""Whole trainings of up to half a minute; the other algorithms' show in every run that the check is able to fail."""
SLOW |= {
    (name, check)
    for name in ("sac", "td3", "dqn", "ddqn")
    for check in (checkpoints_change_nothing, a_training_goes_on_where_it_stood)
}
"""Several trainings with the default networks; `test_checkpoint_mutants` runs both checks with smaller ones."""
SLOW |= {("ray", check) for check in EXECUTOR_CHECKS}
"""Each starts a cluster; the other executors' show the checks in every run."""
NEED_A_CLUSTER = ("slurm",)
"""Executors that start none themselves; `tests/plugins/executors` does, and runs the checks there."""
CHECKS = [*SIMULATOR_CHECKS, *REWARD_CHECKS, *ALGORITHM_CHECKS, *METRIC_CHECKS, *TASK_CHECKS, *EXECUTOR_CHECKS]


def registered(kind: str, checks: tuple[Callable[..., None], ...]) -> pytest.MarkDecorator:
    """Every registered thing of a kind with every check."""
    cases = [
        pytest.param(check, name, id=f"{name}-{check.__name__}", marks=[pytest.mark.slow] * ((name, check) in SLOW))
        for name in REGISTRY.names(kind)
        for check in checks
    ]
    return pytest.mark.parametrize(("check", "name"), cases)


def build(kind: str, name: str) -> Any:
    """A registered thing with its defaults; the test is skipped where the library is not installed."""
    spec = REGISTRY.get(kind, name)
    if spec.missing:
        pytest.skip(f"{', '.join(spec.missing)} is not installed: {spec.remedy}")
    return spec.load()()


@registered("simulators", OTHER_CHECKS)
def test_simulator(check: Callable[..., None], name: str):
    """Every registered simulator keeps the contract on the FD100."""
    check(build("simulators", name), ROBOT)


@pytest.mark.usefixtures("egl")
@registered("simulators", FRAME_CHECKS)
def test_simulator_renders(check: Callable[..., None], name: str):
    """Every registered simulator keeps the contract of rendering, without a display."""
    check(build("simulators", name), ROBOT)


@registered("tasks", TASK_CHECKS)
def test_task(check: Callable[..., None], name: str):
    """Every registered task keeps the contract with its own robot."""
    task = build("tasks", name)
    check(task, harness.load_robot(task.robot, REGISTRY))


@pytest.mark.parametrize("action", MODES)
@pytest.mark.parametrize("name", REGISTRY.names("tasks"))
def test_task_with_every_action_mode(name: str, action: str, monkeypatch: pytest.MonkeyPatch):
    """Every registered task keeps the contract whatever the learner does in it."""
    monkeypatch.setattr("harness.testing.tasks.DECISIONS", 40)  # `test_task` takes as many as the kit does
    task = REGISTRY.get("tasks", name).load()(action=action)
    assert list(violations(TASK_CHECKS, task, harness.load_robot(task.robot, REGISTRY))) == []


@registered("rewards", REWARD_CHECKS)
def test_reward(check: Callable[..., None], name: str):
    """Every registered reward keeps the contract."""
    check(build("rewards", name))


@pytest.fixture(scope="module")
def train_once() -> Callable[..., Training]:
    """As `train`; a training that another check has done is not done again."""
    return cache(train)


@registered("algorithms", ALGORITHM_CHECKS)
def test_algorithm(check: Callable[..., None], name: str, train_once: Callable[..., Training], monkeypatch: Any):
    """Every registered algorithm keeps the contract, learning included."""
    if check is not the_same_seed_gives_the_same_policy:
        monkeypatch.setattr("harness.testing.algorithms.train", train_once)
        monkeypatch.setattr("harness.testing.trainings.train", train_once)
    check(build("algorithms", name))


@registered("metrics", METRIC_CHECKS)
def test_metric(check: Callable[..., None], name: str):
    """Every registered metric keeps the contract."""
    check(build("metrics", name))


@registered("executors", EXECUTOR_CHECKS)
def test_executor(check: Callable[..., None], name: str, tmp_path: Path):
    """Every registered executor keeps the contract, where the library that it needs is installed."""
    if name in NEED_A_CLUSTER:
        pytest.skip("needs a cluster")
    check(build("executors", name), tmp_path)


@pytest.mark.parametrize("check", SIMULATOR_CHECKS)
def test_ideal_simulator(check: Callable[..., None]):
    """The kit's own simulator keeps the contract."""
    check(IdealSimulator(), ROBOT)


@pytest.mark.parametrize("check", REWARD_CHECKS)
def test_reward_of_the_easy_task(check: Callable[..., None]):
    """The kit's own reward keeps the contract."""
    check(NegativeDistance())


@pytest.mark.parametrize("check", CHECKS)
def test_every_check_says_what_it_holds(check: Callable[..., None]):
    """Every check has a docstring for the author of a plugin."""
    assert len(check.__doc__ or "") > 40


@pytest.mark.parametrize(
    "check", [check_simulator, check_reward, check_algorithm, check_metric, check_task, check_executor]
)
def test_first_violation_is_raised(check: Callable[..., None]):
    """Something that is no plugin at all fails at the first check, which the error names."""
    with pytest.raises(ContractViolation, match="settings_are_frozen: object is no dataclass") as caught:
        check(object())
    assert caught.value.check == "settings_are_frozen"


def test_all_is_well_without_an_error():
    """What keeps the contract passes through all checks without a word, on the default robot."""
    assert check_simulator(IdealSimulator()) is None
    assert check_reward(NegativeDistance()) is None
    assert check_task(ReachTask()) is None


def test_whatever_a_check_meets_is_a_violation():
    """An exception of the plugin is told like a broken promise, with its cause."""

    def divides(_: object) -> None:
        raise ZeroDivisionError("by nothing")

    (violation,) = violations([divides], object())
    assert str(violation) == "divides: raised ZeroDivisionError: by nothing"
    assert isinstance(violation.__cause__, ZeroDivisionError)


def test_kit_imports_no_engine():
    """Importing the kit imports no engine, no learning library and no plugin."""
    heavy = ["mujoco", "pybullet", "dm_control", "torch", "stable_baselines3", "harness_plugins"]
    code = f"import sys, harness.testing; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
