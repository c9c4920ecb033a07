"""dm_control: as `mujoco` to 1e-9, each arm an environment of its own, divergence, frames with and without a screen."""

import hashlib
import importlib.util
import os
import subprocess
import sys
from collections.abc import Callable
from ctypes.util import find_library

import numpy as np
import pytest
from dm_control.rl import control

import harness
from harness.errors import SimulationDiverged, UsageError
from harness.registry.registry import load_registry
from harness.simulator import Simulation, State
from harness_plugins.simulators.dm_control import DmControl
from harness_plugins.simulators.mujoco import Mujoco

ROBOT = harness.load_robot("fd100")
PERIOD = 0.1
MAX_SPEED = 0.8 * ROBOT.max_speed
SETTINGS = ({}, {"substeps": 7, "bandwidth": 60.0})


def open_arms(num_envs: int, simulator: Callable[..., Simulation] = DmControl, **settings: float) -> Simulation:
    """Arms at home."""
    simulation = simulator(**settings).open(ROBOT, num_envs, PERIOD)
    simulation.reset(home(num_envs), np.ones(num_envs, bool))
    return simulation


def home(num_envs: int) -> np.ndarray:
    """The home pose for each env."""
    return np.tile(ROBOT.home, (num_envs, 1))


def wander(simulation: Simulation, num_envs: int, periods: int = 200, same: bool = False) -> list[State]:
    """Random speeds, held for a while; an arm is reset to home in the second period in which it touches the ground.

    Returns copies of the states.
    """
    rng = np.random.default_rng(0)
    target, states = home(num_envs), []
    speed, touched = np.zeros_like(target), np.zeros(num_envs, bool)
    for period in range(periods):
        if period % 8 == 0:
            speed = np.repeat(rng.uniform(-MAX_SPEED, MAX_SPEED, (1, ROBOT.dof)), num_envs, axis=0)
            speed *= 1.0 if same else rng.uniform(0.5, 1.0, (num_envs, 1))
        target = np.clip(target + speed * PERIOD, ROBOT.lower, ROBOT.upper)
        states.append(State._make(np.array(array) for array in simulation.drive(target, PERIOD)))
        fallen = touched & states[-1].ground_contact
        touched = states[-1].ground_contact & ~fallen
        target = np.where(fallen[:, None], ROBOT.home, target)
        simulation.reset(target, fallen)
    return states


def assert_same(first: list[State], second: list[State]) -> None:
    """Bit for bit."""
    for one, other in zip(first, second, strict=True):
        for field, array, another in zip(State._fields, one, other, strict=True):
            np.testing.assert_array_equal(array, another, err_msg=field)


@pytest.fixture(scope="module", params=SETTINGS, ids=str)
def beside_mujoco(request) -> tuple[State, State]:
    """The states of 200 periods, fields (200, 3, ...), of dm_control and of mujoco with equal settings."""
    runs = [wander(open_arms(3, simulator, **request.param), 3) for simulator in (DmControl, Mujoco)]
    return tuple(State._make(np.stack(field) for field in zip(*run, strict=True)) for run in runs)


@pytest.mark.parametrize("field", ["qpos", "qvel", "end_effector"])
def test_moves_as_mujoco(beside_mujoco: tuple[State, State], field: str):
    """With equal settings 200 periods of random moves, ground contacts included, agree to 1e-9."""
    ours, theirs = (getattr(state, field) for state in beside_mujoco)
    assert np.ptp(ours, axis=0).min() > 0.1
    np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=1e-9)


def test_touches_the_ground_when_mujoco_does(beside_mujoco: tuple[State, State]):
    """In the same periods, of which there are some."""
    ours, theirs = (state.ground_contact for state in beside_mujoco)
    assert 5 < ours.sum() < 300
    np.testing.assert_array_equal(ours, theirs)


def test_placed_arms_are_as_those_of_mujoco():
    """Poses anywhere in the joint ranges give the same end effectors and the same contacts."""
    poses = np.random.default_rng(1).uniform(ROBOT.lower, ROBOT.upper, (200, ROBOT.dof))
    ours, theirs = (open_arms(200, simulator).place(poses) for simulator in (DmControl, Mujoco))
    assert 20 < ours.ground_contact.sum() < 180
    np.testing.assert_array_equal(ours.ground_contact, theirs.ground_contact)
    np.testing.assert_allclose(ours.end_effector, theirs.end_effector, rtol=0.0, atol=1e-9)


def test_every_arm_has_a_physics_of_its_own():
    """Each env is a `control.Environment` with its own data; the model is shared."""
    arms = open_arms(3).arms
    assert all(isinstance(arm, control.Environment) for arm in arms)
    assert len({id(arm.physics.data.ptr) for arm in arms}) == 3
    assert len({id(arm.physics.model.ptr) for arm in arms}) == 1


def test_a_period_is_one_step_of_the_environment():
    """Driving steps dm_control's physics by the control period, in as many substeps as asked for."""
    simulation = open_arms(1, substeps=5)
    simulation.drive(home(1), PERIOD)
    (arm,) = simulation.arms
    assert arm.control_timestep() == pytest.approx(PERIOD)
    assert (arm.physics.time(), arm.physics.timestep()) == pytest.approx((PERIOD, PERIOD / 5))


def test_actions_are_joint_positions_within_their_ranges():
    """dm_control's own description of an arm's actions has the robot's ranges."""
    spec = open_arms(1).arms[0].action_spec()
    assert spec.shape == (ROBOT.dof,)
    np.testing.assert_array_equal([spec.minimum, spec.maximum], [ROBOT.lower, ROBOT.upper])


def test_arm_can_be_used_as_dm_control_uses_it():
    """Reset and stepped as any environment of dm_control, an arm goes where the action says and observes it."""
    (arm,) = open_arms(1).arms
    assert arm.reset().first()
    goal = ROBOT.home + 0.02
    step = arm.step(goal)
    assert step.mid()
    np.testing.assert_allclose(step.observation["qpos"], goal, atol=1e-2)
    assert {name: spec.shape for name, spec in arm.observation_spec().items()} == {
        "qpos": (6,), "qvel": (6,), "end_effector": (3,), "touch": (1,),
    }  # fmt: skip


def test_joints_are_in_the_order_of_the_robot():
    """Where each joint is told another angle, each has its own, by dm_control's names too."""
    pose = np.radians([-50.0, -30.0, 20.0, 70.0, 110.0, 200.0])
    simulation = open_arms(1)
    np.testing.assert_array_equal(simulation.place(pose[None]).qpos[0], pose)
    named = simulation.arms[0].physics.named.data.qpos[list(ROBOT.joint_names)]
    np.testing.assert_array_equal(named, pose)


def test_arm_that_is_told_to_stay_stays():
    """Gravity does not pull the arm down: after 10 s every joint is within a thousandth of a degree of home."""
    simulation = open_arms(1)
    for _ in range(100):
        state = simulation.drive(home(1), PERIOD)
    assert np.degrees(np.abs(state.qpos - ROBOT.home).max()) < 1e-3


def test_placed_arm_stays_where_it_is_placed():
    """After `place` the servos hold the new pose: driving to it moves nothing."""
    simulation = open_arms(1)
    pose = ROBOT.home[None] + 0.5
    simulation.place(pose)
    state = simulation.drive(pose, PERIOD)
    assert np.degrees(np.abs(state.qpos - pose).max()) < 1e-3


@pytest.mark.parametrize("num_envs", [1, 2, 5])
def test_batch_moves_as_one_arm_alone(num_envs: int):
    """Each env of a batch moves, bit for bit, as an arm alone, whatever the number of envs."""
    alone, batch = (wander(open_arms(count), count, 60, same=True) for count in (1, num_envs))
    for env in range(num_envs):
        assert_same([State._make(array[[env]] for array in state) for state in batch], alone)


def test_reset_in_the_middle_starts_anew():
    """What follows a reset is, bit for bit, what followed the first, on whichever way the arms were."""
    simulation = open_arms(2)
    first = wander(simulation, 2, 40)
    simulation.drive(home(2) + np.array([[0.05], [-0.03]]), PERIOD)
    simulation.reset(home(2), np.ones(2, bool))
    assert_same(first, wander(simulation, 2, 40))


DIGEST = """
import hashlib, sys, tempfile, pathlib, numpy as np, harness
from harness.record.trace import TraceWriter
env = harness.make_env("dm_control", num_envs=3)
path = pathlib.Path(tempfile.mkdtemp(), "trace.parquet")
env.recorder = TraceWriter(path, env.robot.dof, env.robot.dof)
env.reset(seed=7)
for action in np.random.default_rng(0).uniform(-1.0, 1.0, (150, 3, 6)).astype(np.float32):
    env.step(action)
env.recorder.close()
env.close()
sys.stdout.write(hashlib.sha256(path.read_bytes()).hexdigest())
"""


def test_same_seed_gives_the_same_trace_in_another_process():
    """Two processes with the same seed and actions leave the same trace, byte for byte."""
    digests = {python(DIGEST).stdout for _ in range(2)}
    assert [len(digest) for digest in digests] == [hashlib.sha256().digest_size * 2]


@pytest.mark.parametrize("target", [np.nan, np.inf])
def test_invalid_state_is_a_diverged_simulation(target: float):
    """What dm_control calls a PhysicsError ends the cell as SimulationDiverged, which names the env and the cause."""
    simulation = open_arms(2)
    targets = home(2)
    targets[1, 2] = target
    with pytest.raises(SimulationDiverged, match=r"env 1: Physics state is invalid.*mjWARN_BADCTRL") as caught:
        simulation.drive(targets, PERIOD)
    assert isinstance(caught.value.__cause__, control.PhysicsError)


def test_state_that_runs_away_is_a_diverged_simulation():
    """An arm whose speed leaves what can be computed is stopped at the step in which it does."""
    simulation = open_arms(1)
    simulation.arms[0].physics.data.qvel[0] = 1e12
    with pytest.raises(SimulationDiverged, match="env 0: Physics state is invalid"):
        simulation.drive(home(1), PERIOD)


def test_diverged_arm_can_be_reset():
    """After a reset an arm that diverged moves as a new one."""
    simulation = open_arms(1)
    with pytest.raises(SimulationDiverged):
        simulation.drive(np.full((1, ROBOT.dof), np.nan), PERIOD)
    simulation.reset(home(1), np.ones(1, bool))
    assert_same(wander(simulation, 1, 20), wander(open_arms(1), 1, 20))


@pytest.mark.parametrize("given", ["substeps=0", "substeps=1.5", "bandwidth=0", "bandwidth=nan", "threads=2"])
def test_bad_setting_is_a_usage_error(given: str):
    """A setting that cannot be is refused, in one line that names it."""
    with pytest.raises(UsageError, match=given.partition("=")[0]):
        harness.make_env(f"dm_control:{given}")


def test_without_the_library_the_extra_is_named(monkeypatch: pytest.MonkeyPatch):
    """Where dm_control is not installed, the simulator is listed as missing, with the extra that brings it."""
    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *package: None if name == "dm_control" else found(name, *package)
    )
    spec = load_registry().get("simulators", "dm_control")
    assert (spec.missing, spec.remedy) == (("dm_control",), "pip install 'fd100-harness[dm-control]'")


def test_listing_does_not_import_it():
    """The registry knows the simulator without importing dm_control, or even looking at how it renders."""
    done = python(
        "import sys\nfrom harness.registry.registry import load_registry\n"
        "assert load_registry().get('simulators', 'dm_control').missing == ()\n"
        "sys.stdout.write(str({'dm_control', 'mujoco', 'glfw', 'OpenGL'} & set(sys.modules)))"
    )
    assert done.stdout == "set()"


needs_egl = pytest.mark.skipif(find_library("EGL") is None, reason="no EGL library on this machine: install libegl1")

ARMS = """
import os, harness, numpy as np
from harness.errors import UsageError
from harness_plugins.simulators.dm_control import DmControl
robot = harness.load_robot('fd100')
arms = DmControl().open(robot, 2, 0.1)
poses = np.stack([robot.home, robot.home + 0.5])
arms.place(poses)
near, far = np.array([0.6, 0.3, 0.6]), np.array([0.9, -0.4, 0.9])
"""


def python(code: str, library: str | None = None) -> "subprocess.CompletedProcess[str]":
    """Run code in a process of its own, without a screen: dm_control chooses what renders when it is imported."""
    without = ("DISPLAY", "WAYLAND_DISPLAY", "MUJOCO_GL", "PYOPENGL_PLATFORM")
    env = {name: value for name, value in os.environ.items() if name not in without}
    return subprocess.run(
        [sys.executable, "-c", code],
        env=env if library is None else {**env, "MUJOCO_GL": library}, capture_output=True, text=True, check=False,
    )  # fmt: skip


def assert_fine(done: "subprocess.CompletedProcess[str]") -> None:
    """The code ran to its end and said nothing."""
    assert (done.returncode, done.stderr) == (0, "")


@needs_egl
def test_frame_shows_something():
    """A frame has the size asked for and is not of one colour."""
    assert_fine(
        python(
            f"{ARMS}frame = arms.render(0, near, 320, 240)\n"
            "assert frame.shape == (240, 320, 3) and frame.dtype == np.uint8\n"
            "assert frame.std() > 10.0\narms.close()",
            "egl",
        )
    )


@needs_egl
def test_frame_shows_the_arm_and_the_target():
    """Another arm, another pose and another target give another frame; the same ones give the same."""
    assert_fine(
        python(
            f"{ARMS}frame = arms.render(0, near, 320, 240)\n"
            "assert (arms.render(0, near, 320, 240) == frame).all()\n"
            "assert (arms.render(0, far, 320, 240) != frame).any()\n"
            "assert (arms.render(1, near, 320, 240) != frame).any()\n"
            "arms.place(poses[::-1])\n"
            "assert (arms.render(1, near, 320, 240) == frame).all()\narms.close()",
            "egl",
        )
    )


@needs_egl
def test_frame_shows_what_a_frame_of_mujoco_shows():
    """The same camera looks at the same arm: hardly a pixel differs from a frame of simulator `mujoco`."""
    assert_fine(
        python(
            f"{ARMS}from harness_plugins.simulators.mujoco import Mujoco\n"
            "others = Mujoco().open(robot, 1, 0.1)\nothers.place(poses[:1])\n"
            "ours, theirs = (sim.render(0, near, 320, 240).astype(float) for sim in (arms, others))\n"
            "assert (np.abs(ours - theirs).max(axis=-1) > 8.0).mean() < 0.01\narms.close()\nothers.close()",
            "egl",
        )
    )


@needs_egl
@pytest.mark.parametrize("size", [(64, 48), (1024, 768)])
def test_each_frame_has_the_size_asked_for(size: tuple[int, int]):
    """A second frame may have another size than the first, also one beyond MuJoCo's usual 640 x 480."""
    width, height = size
    assert_fine(
        python(
            f"{ARMS}arms.render(0, near, 320, 240)\n"
            f"assert arms.render(0, near, {width}, {height}).shape == ({height}, {width}, 3)\narms.close()",
            "egl",
        )
    )


@needs_egl
def test_machine_without_a_screen_renders_unasked():
    """Where no library is chosen and there is no screen, dm_control takes EGL, without a word."""
    assert_fine(python(f"{ARMS}assert arms.render(0, near, 320, 240).std() > 10.0\narms.close()"))


@pytest.mark.parametrize("library", ["glfw", "off"])
def test_library_that_cannot_render_says_what_to_do(library: str):
    """Where the chosen library cannot render, UsageError names the others and what to install."""
    done = python(f"{ARMS}arms.render(0, near, 320, 240)", library)
    assert done.returncode == 1
    assert "harness.errors.UsageError" in done.stderr
    assert "MUJOCO_GL=egl" in done.stderr
    assert "libegl1" in done.stderr


@pytest.mark.parametrize("library", ["glfw", "off", None])
def test_arms_move_where_nothing_renders(library: str | None):
    """A library that cannot render here keeps no arm from moving, says nothing, and stays the user's choice."""
    assert_fine(
        python(
            f"{ARMS}assert np.abs(arms.drive(poses, 0.1).qpos - poses).max() < 1e-3\n"
            f"assert os.environ.get('MUJOCO_GL') == {library!r}\narms.close()",
            library,
        )
    )
