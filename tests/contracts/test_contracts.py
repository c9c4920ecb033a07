"""Everything that is registered keeps its contract, a plugin that was installed yesterday included."""

import io
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import harness
from harness.errors import ContractViolation, UsageError
from harness.log.format import HEAD
from harness.log.open_log import formats_of
from harness.motion.modes import MODES
from harness.robot import build_solids
from harness_plugins.kit import CHECKS, IdealSimulator, check_contract
from harness_plugins.kit.contract import Check, require, violations
from harness_plugins.kit.kits import KITS
from tests.registered import FD100 as ROBOT, REGISTRY

from .mutants import metrics, trackers

FRAMES = {"sim-render", "sim-render-target"}
DRAWS = {"task-starts", "task-targets", "task-targets-in-reach", "task-targets-count", "task-draws", "task-varies"}
"""Of a task, what looks at its starts and targets alone."""
LARGE = ("sb3-sac", "her", "td3", "dqn", "ddqn")
"""Their default networks take long to train; `SMALLER` ones show the same in most checks."""
SMALLER = {"net_arch": (16,), "batch_size": 32}
TWICE = {"algo-checkpoint-silent", "algo-resume"}
"""Several trainings; `test_checkpoint_mutants` does them with small networks in every run."""
LONG = {"algo-learns", "algo-acts-as-trained"} | TWICE
"""Whole trainings of up to half a minute."""
ALIKE = {"algo-every-env", "algo-same-seed", "algo-other-seed", "algo-budget", "algo-goes-on"}
"""The trainings of `her`, `td3` and `ddqn` are those of `sb3-sac` and `dqn`, which show these, with another update."""
SLOW = {"sac-fast": TWICE, "ppo": {"algo-learns"} | TWICE, "spg": TWICE, "sb3-sac": LONG, "dqn": LONG}
SLOW |= dict.fromkeys(("her", "td3", "ddqn"), LONG | ALIKE)
SERVO = {"pybullet": {"sim-servo"}}
"""All checks once more with the other drives; the other engines show them in every run, and this one opens slowly."""


def registered(kind):
    """Every registered thing of a kind."""
    return pytest.mark.parametrize("name", REGISTRY.names(kind))


def broken(kind, *subject, only=(), but=()):
    """What is wrong, each with the name of its check."""
    checks = [check for check in KITS[kind].contract if check.name not in but and (not only or check.name in only)]
    return [str(violation) for violation in violations(checks, *subject)]


def build(kind, name, **settings):
    """A registered thing; the test is skipped where the library is not installed."""
    spec = REGISTRY.get(kind, name)
    if spec.missing:
        pytest.skip(f"{', '.join(spec.missing)} is not installed: {spec.remedy}")
    return spec.load()(**settings)


@registered("simulators")
def test_simulator(name):
    """Every registered simulator keeps the contract on the FD100."""
    assert broken("simulators", build("simulators", name), ROBOT, but=FRAMES | SERVO.get(name, set())) == []


@pytest.mark.usefixtures("egl")
@registered("simulators")
def test_simulator_renders(name):
    """Every registered simulator keeps the contract of rendering, without a display."""
    assert broken("simulators", build("simulators", name), ROBOT, only=FRAMES) == []


@pytest.mark.slow
@registered("simulators")
def test_simulators_last(name):
    """10,000 periods of every installed simulator, and the contract with drives that have limits."""
    simulator = build("simulators", name)
    assert list(violations(KITS["simulators"].long, simulator, ROBOT)) == []
    assert broken("simulators", simulator, ROBOT, only={"sim-servo"}) == []


@pytest.mark.parametrize("without", ["a field", "drives"])
def test_servo_checks_are_left_out_where_there_are_no_such_drives(without, monkeypatch):
    """A simulator without the field, or a robot without `[servo]`, opens nothing for them."""
    mujoco = build("simulators", "mujoco")
    monkeypatch.setattr(type(mujoco), "open", lambda *_: pytest.fail("it was opened"))
    simulator, robot = (IdealSimulator(), ROBOT) if without == "a field" else (mujoco, replace(ROBOT, servo=None))
    servo = {check.name for check in KITS["simulators"].contract if check.name.startswith("sim-servo")}
    assert len(servo) == 7
    assert broken("simulators", simulator, robot, only=servo) == []


def with_its_robot(task):
    """A task, and its robot."""
    return task, harness.load_robot(task.robot, REGISTRY)


@registered("tasks")
def test_task(name):
    """Every registered task keeps the contract with its own robot."""
    assert broken("tasks", *with_its_robot(build("tasks", name))) == []


@registered("tasks")
def test_task_with_every_action_mode(name, monkeypatch, subtests):
    """Every registered task keeps the contract whatever the learner does in it; what is drawn is as in `test_task`."""
    monkeypatch.setattr("harness_plugins.kit.tasks.LONGEST", 25)  # `test_task` takes as many as the kit does
    for action in MODES:
        with subtests.test(action=action):
            task, robot = with_its_robot(build("tasks", name, action=action))
            assert broken("tasks", task, robot, but=DRAWS) == []
            assert all(map(np.array_equal, draws(task, robot), draws(build("tasks", name), robot)))


def draws(task, robot):
    """A start, some targets, and whether these are relative."""
    rng = np.random.default_rng(0)
    return task.draw_start(robot, rng), *task.draw_targets(robot, rng, 8)


@pytest.mark.parametrize(
    ("kind", "name"), [(kind, name) for kind in ("rewards", "metrics") for name in REGISTRY.names(kind)]
)
def test_function(kind, name):
    """Every registered reward and metric keeps the contract."""
    assert broken(kind, build(kind, name)) == []


@registered("algorithms")
def test_algorithm(name):
    """Every registered algorithm keeps the contract."""
    settings = SMALLER if name in LARGE else {}
    assert broken("algorithms", build("algorithms", name, **settings), but=SLOW.get(name, ())) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", SLOW)
def test_algorithm_with_its_default_networks(name):
    """All of it, learning included."""
    assert broken("algorithms", build("algorithms", name)) == []


@registered("robots")
def test_robot(name):
    """Every registered robot keeps the contract, and nothing is warned of."""
    kit, robot = KITS["robots"], harness.load_robot(name, REGISTRY)
    but = {"robot-simulators"} if name != "fd100" else ()
    assert broken("robots", robot, but=but) == []
    assert list(violations(kit.advice, robot)) == []


def test_an_arm_that_a_simulator_drops_a_solid_of_is_found(monkeypatch):
    """With the simulator's name and the link's, as ``harness check --robot`` says it."""
    monkeypatch.setattr("harness_plugins.simulators.kinematic.build_solids", lambda shapes: build_solids(shapes[:-1]))
    (violation,) = broken("robots", ROBOT, only={"robot-simulators"})
    assert "robot-simulators: " in violation
    assert "Simulator 'kinematic' has no solid for link 'tool0'" in violation


@registered("logs")
def test_log_format(name, tmp_path):
    """Every registered log format keeps the contract, where the library that it needs is installed."""
    for check in KITS["logs"].contract:
        (own := tmp_path / check.name).mkdir()
        assert broken("logs", build("logs", name), own, only={check.name}) == []


@registered("logs")
def test_log_format_is_told_apart(name, tmp_path):
    """The example of a log format is recognised by that format, and by no other."""
    example = build("logs", name).write_example(tmp_path)
    with example.open("rb") if example.is_file() else io.BytesIO() as file:
        head = file.read(HEAD)
    assert [each for each, it in formats_of(REGISTRY).items() if it.recognises(example, head)] == [name]


@pytest.mark.parametrize("kind", sorted(set(CHECKS) - {"robot"}))
def test_first_violation_is_raised(kind):
    """Something that is no plugin at all fails at the first check, which the error names."""
    with pytest.raises(ContractViolation, match="settings-frozen: object is no dataclass") as caught:
        check_contract(kind, object())
    assert caught.value.check == "settings-frozen"


@pytest.mark.parametrize(
    ("given", "named", "message"),
    [
        (("rewards", metrics.Sound()), {}, r"No kind of contract 'rewards'\. .* Did you mean 'reward'\?"),
        (("metric", metrics.Sound(), ROBOT), {}, r"A metric is checked without a robot: leave robot= out"),
        (("task", object()), {"folder": Path()}, r"A task is checked without a folder: leave folder= out"),
        (("robot", "no-such-arm"), {}, r"no-such-arm"),
    ],
)
def test_contract_that_there_is_not_is_refused(given, named, message):
    """Nothing that is given is passed over."""
    with pytest.raises(UsageError, match=message):
        check_contract(*given, **named)


def test_names_of_0_3_check_as_before(tmp_path):
    """They warn; a folder stands in the place where it stood."""
    from harness_plugins import kit

    with pytest.warns(DeprecationWarning, match=r"works until fd100-harness 0\.6: write CHECKS\['log'\]$"):
        assert kit.LOG_CHECKS is CHECKS["log"]
    with pytest.warns(DeprecationWarning, match=r"write check_contract\('tracker', ...\)$"):
        check = kit.check_tracker
    check(trackers.SOUND[0], tmp_path)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(ImportError, match="check_screen is no longer in fd100-harness: type `harness check NAME`"):
        _ = kit.check_screen


def test_all_is_well_without_an_error():
    """What keeps the contract passes through all checks without a word."""
    assert check_contract("metric", metrics.Sound()) is None


def test_a_check_writes_what_it_was_given():
    """What a check says no to stands in its message, braces and all, where the check fails."""
    with pytest.raises(AssertionError, match=r"^the start \[0.5\] leaves \{'a': 1\}$"):
        require(False, "the start {} leaves {}", np.array([0.5]), {"a": 1})
    with pytest.raises(AssertionError, match=r"^\{\} is no name$"):
        require(False, "{} is no name")
    require(True, "nothing is wrong with {}", 1)


def test_whatever_a_check_meets_is_a_violation():
    """An exception of the plugin is told like a broken promise, with its cause."""

    def divides(_):
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
