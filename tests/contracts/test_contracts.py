"""Everything that is registered keeps its contract, a plugin that was installed yesterday included."""

import io
import subprocess
import sys
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import harness
from harness.errors import ContractViolation
from harness.log.format import HEAD
from harness.log.open_log import formats_of
from harness.motion import MODES
from harness.reach import ReachTask
from harness.registry.registry import load_registry
from harness.robot import Robot
from harness_plugins.kit import (
    ALGORITHM_CHECKS,
    LOG_CHECKS,
    METRIC_CHECKS,
    REWARD_CHECKS,
    ROBOT_CHECKS,
    SIMULATOR_CHECKS,
    TASK_CHECKS,
    Check,
    IdealSimulator,
    check_algorithm,
    check_metric,
    check_reward,
    check_simulator,
    check_task,
    violations,
)
from harness_plugins.kit.algorithms import (
    a_training_goes_on_where_it_stood,
    checkpoints_change_nothing,
    the_policy_acts_as_it_trained,
    the_return_rises,
)
from harness_plugins.kit.contract import require
from harness_plugins.kit.simulators.states import frames_show_the_target, render_gives_a_frame_or_says_why_not
from harness_plugins.kit.tasks import (
    draws_depend_on_the_stream_alone,
    episodes_are_alike_where_it_says_so,
    starts_are_in_the_joint_ranges,
    targets_are_points,
    targets_can_be_reached,
    targets_do_not_depend_on_the_count,
)
from harness_plugins.kit.trainings import NegativeDistance

REGISTRY = load_registry()
ROBOT = harness.load_robot("fd100", REGISTRY)
FRAME_CHECKS = (render_gives_a_frame_or_says_why_not, frames_show_the_target)
DRAW_CHECKS = (
    starts_are_in_the_joint_ranges,
    targets_are_points,
    targets_can_be_reached,
    targets_do_not_depend_on_the_count,
    draws_depend_on_the_stream_alone,
    episodes_are_alike_where_it_says_so,
)
"""Of a task, what looks at its starts and targets alone."""
OTHER_CHECKS = tuple(check for check in SIMULATOR_CHECKS if check not in FRAME_CHECKS)
LARGE = ("sb3-sac", "her", "td3", "dqn", "ddqn")
"""Their default networks take long to train; `SMALLER` ones show the same in most checks."""
SMALLER = {"net_arch": (16,), "batch_size": 32}
SLOW = {(name, the_return_rises) for name in (*LARGE, "ppo")}
"""Whole trainings of up to half a minute; the other algorithms' show in every run that the check is able to fail."""
SLOW |= {
    (name, check)
    for name in LARGE
    for check in (the_policy_acts_as_it_trained, checkpoints_change_nothing, a_training_goes_on_where_it_stood)
}
"""The same, or several trainings; `test_checkpoint_mutants` runs the last two with smaller networks."""
SLOW |= {
    (name, check)
    for name in ("her", "td3", "ddqn")
    for check in ALGORITHM_CHECKS
    if check.name in {"algo-every-env", "algo-same-seed", "algo-other-seed", "algo-budget"}
}
"""Their trainings are those of `sb3-sac` and `dqn`, which show it in every run, with another update."""
CHECKS = [
    *SIMULATOR_CHECKS,
    *REWARD_CHECKS,
    *ALGORITHM_CHECKS,
    *METRIC_CHECKS,
    *TASK_CHECKS,
    *LOG_CHECKS,
]


def registered(kind: str) -> pytest.MarkDecorator:
    """Every registered thing of a kind."""
    return pytest.mark.parametrize("name", REGISTRY.names(kind))


def registered_with_slow_ones(kind: str, checks: tuple[Check, ...]) -> pytest.MarkDecorator:
    """Every registered thing of a kind with the checks that are quick, and once more with those that are `SLOW`."""
    cases = []
    for name in REGISTRY.names(kind):
        quick, slow = ([check for check in checks if ((name, check) in SLOW) is is_slow] for is_slow in (False, True))
        cases += [pytest.param(name, quick, id=name)] if quick else []
        cases += [pytest.param(name, slow, id=f"{name}-slow", marks=pytest.mark.slow)] if slow else []
    return pytest.mark.parametrize(("name", "checks"), cases)


def broken(checks: Iterable[Check], *subject: Any) -> list[str]:
    """What is wrong, each with the name of its check."""
    return [str(violation) for violation in violations(checks, *subject)]


def broken_in(folder: Path, checks: Iterable[Check], *subject: Any) -> list[str]:
    """The same of checks that work in a folder: each has an empty one of its own."""
    found: list[str] = []
    for check in checks:
        (own := folder / check.name).mkdir()
        found += broken([check], *subject, own)
    return found


@cache
def robot_of(task: str) -> Robot:
    """The robot of a registered task."""
    return harness.load_robot(REGISTRY.get("tasks", task).load()().robot, REGISTRY)


def build(kind: str, name: str) -> Any:
    """A registered thing with its defaults; the test is skipped where the library is not installed."""
    spec = REGISTRY.get(kind, name)
    if spec.missing:
        pytest.skip(f"{', '.join(spec.missing)} is not installed: {spec.remedy}")
    return spec.load()()


@registered("simulators")
def test_simulator(name: str):
    """Every registered simulator keeps the contract on the FD100."""
    assert broken(OTHER_CHECKS, build("simulators", name), ROBOT) == []


@pytest.mark.usefixtures("egl")
@registered("simulators")
def test_simulator_renders(name: str):
    """Every registered simulator keeps the contract of rendering, without a display."""
    assert broken(FRAME_CHECKS, build("simulators", name), ROBOT) == []


@registered("tasks")
def test_task(name: str):
    """Every registered task keeps the contract with its own robot."""
    assert broken(TASK_CHECKS, build("tasks", name), robot_of(name)) == []


@registered("tasks")
def test_task_with_every_action_mode(name: str, monkeypatch: pytest.MonkeyPatch, subtests: pytest.Subtests):
    """Every registered task keeps the contract whatever the learner does in it; what is drawn is as in `test_task`."""
    monkeypatch.setattr("harness_plugins.kit.tasks.LONGEST", 25)  # `test_task` takes as many as the kit does
    checks = [check for check in TASK_CHECKS if check not in DRAW_CHECKS]
    for action in MODES:
        with subtests.test(action=action):
            task, robot = REGISTRY.get("tasks", name).load()(action=action), robot_of(name)
            assert broken(checks, task, robot) == []
            assert all(map(np.array_equal, draws(task, robot), draws(build("tasks", name), robot)))


def draws(task: Any, robot: Robot) -> tuple[Any, ...]:
    """A start, some targets, and whether these are relative."""
    rng = np.random.default_rng(0)
    return task.draw_start(robot, rng), *task.draw_targets(robot, rng, 8)


@registered("rewards")
def test_reward(name: str):
    """Every registered reward keeps the contract."""
    assert broken(REWARD_CHECKS, build("rewards", name)) == []


@registered_with_slow_ones("algorithms", ALGORITHM_CHECKS)
def test_algorithm(name: str, checks: list[Check]):
    """Every registered algorithm keeps the contract, learning included."""
    is_smaller = name in LARGE and (name, checks[0]) not in SLOW
    algorithm = REGISTRY.get("algorithms", name).load()(**SMALLER) if is_smaller else build("algorithms", name)
    assert broken(checks, algorithm) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", LARGE)
def test_algorithm_with_its_default_networks(name: str):
    """Every check of those that the runs before did with smaller ones."""
    assert broken([check for check in ALGORITHM_CHECKS if (name, check) not in SLOW], build("algorithms", name)) == []


@registered("robots")
def test_robot(name: str):
    """Every registered robot keeps the contract."""
    assert broken(ROBOT_CHECKS, harness.load_robot(name, REGISTRY)) == []


@registered("metrics")
def test_metric(name: str):
    """Every registered metric keeps the contract."""
    assert broken(METRIC_CHECKS, build("metrics", name)) == []


@registered("logs")
def test_log_format(name: str, tmp_path: Path):
    """Every registered log format keeps the contract, where the library that it needs is installed."""
    assert broken_in(tmp_path, LOG_CHECKS, build("logs", name)) == []


@registered("logs")
def test_log_format_is_told_apart(name: str, tmp_path: Path):
    """The example of a log format is recognised by that format, and by no other."""
    example = build("logs", name).write_example(tmp_path)
    with example.open("rb") if example.is_file() else io.BytesIO() as file:
        head = file.read(HEAD)
    assert [each for each, it in formats_of(REGISTRY).items() if it.recognises(example, head)] == [name]


def test_ideal_simulator():
    """The kit's own simulator keeps the contract."""
    assert broken(SIMULATOR_CHECKS, IdealSimulator(), ROBOT) == []


def test_reward_of_the_easy_task():
    """The kit's own reward keeps the contract."""
    assert broken(REWARD_CHECKS, NegativeDistance()) == []


def test_every_check_says_what_it_holds():
    """Every check has a docstring for the author of a plugin."""
    assert [check.name for check in CHECKS if len(check.fact) <= 40] == []


@pytest.mark.parametrize("check", [check_simulator, check_reward, check_algorithm, check_metric, check_task])
def test_first_violation_is_raised(check: Callable[..., None]):
    """Something that is no plugin at all fails at the first check, which the error names."""
    with pytest.raises(ContractViolation, match="settings-frozen: object is no dataclass") as caught:
        check(object())
    assert caught.value.check == "settings-frozen"


def test_all_is_well_without_an_error():
    """What keeps the contract passes through all checks without a word, on the default robot."""
    assert check_simulator(IdealSimulator()) is None
    assert check_reward(NegativeDistance()) is None
    assert check_task(ReachTask()) is None


def test_a_check_writes_what_it_was_given():
    """What a check says no to stands in its message, braces and all, where the check fails."""
    with pytest.raises(AssertionError, match=r"^the start \[0.5\] leaves \{'a': 1\}$"):
        require(False, "the start {} leaves {}", np.array([0.5]), {"a": 1})
    with pytest.raises(AssertionError, match=r"^\{\} is no name$"):
        require(False, "{} is no name")
    require(True, "nothing is wrong with {}", 1)


def test_whatever_a_check_meets_is_a_violation():
    """An exception of the plugin is told like a broken promise, with its cause."""

    def divides(_: object) -> None:
        raise ZeroDivisionError("by nothing")

    (violation,) = violations([Check("divides", divides)], object())
    assert str(violation) == "divides: raised ZeroDivisionError: by nothing"
    assert isinstance(violation.__cause__, ZeroDivisionError)


def test_kit_imports_no_engine():
    """Importing the kit imports no engine, no learning library and no other plugin."""
    heavy = ["mujoco", "pybullet", "dm_control", "torch", "stable_baselines3", "harness_plugins.sb3"]
    code = f"import sys, harness_plugins.kit; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
