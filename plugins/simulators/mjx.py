"""MJX: MuJoCo's equations in JAX, compiled by XLA for a processor or an accelerator."""

import warnings
from contextlib import redirect_stdout
from io import StringIO
from typing import Annotated, Any, ClassVar, NamedTuple

import jax
import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.arrays import Float, Mask
from harness.authoring.ground_contact import GroundContact
from harness.authoring.substeps import Substeps
from harness.errors import UsageError
from harness.robot import Robot
from harness.scene.still import StillFrames
from harness.simulator import State

from ..mujoco_model import build_model, mujoco

with redirect_stdout(StringIO()):  # it prints that Warp is not installed, which nothing here uses
    from mujoco import mjx

Count = Annotated[int, Field(gt=0)]
Array = Any
"""Of JAX, or of numpy on its way there."""


@dataclass(frozen=True)
class Mjx:
    """The model of `mujoco`, stepped by MJX: compiled by XLA, for accelerators above all.

    Masses, servos, integrator and contact forces are those of `mujoco` with drive=ideal, in double precision. Weight
    and its compensation cancel, so neither is computed. End effector and ground contact are told by the robot's own
    geometry, at the end of the period. Frames are drawn by the harness.

    The first drive of a process compiles for some 20 s. XLA's program for many arms at once is slower on a CPU than the
    one for a single arm, called for each: `at_once` says which. Every arm does the same, bit for bit, beside any others
    as long as `at_once` is the same number, but not where it is 0 on an accelerator.
    """

    family: ClassVar[str] = "MuJoCo"
    sources: ClassVar[tuple[str, ...]] = ("harness_plugins.mujoco_model",)
    substeps: Annotated[Count, Field(description="physics steps per control period")] = 20
    bandwidth: Annotated[float, Field(gt=0, description="of the joint servos, w [rad/s]")] = 100.0
    at_once: Annotated[
        int, Field(ge=0, description="arms that a call of the compiled program steps; 0: one on a CPU, else all")
    ] = 0

    def open(self, robot: Robot, num_envs: int, control_period: float) -> "MjxSimulation":
        """See `harness.simulator.Simulator`."""
        return MjxSimulation(self, robot, num_envs, control_period)


class Motion(NamedTuple):
    """What a physics step starts from and leads to; arrays with an axis for the arms, or of one arm."""

    qpos: Array
    qvel: Array
    act: Array
    """What the position servos hold."""


class MjxSimulation:
    """See `harness.simulator.Simulation`."""

    def __init__(self, settings: Mjx, robot: Robot, num_envs: int, control_period: float) -> None:
        self._robot, self._touches, self._frames = robot, GroundContact(robot), StillFrames(robot)
        self._substeps = Substeps(settings.substeps, control_period)
        self._model = _put_model(robot, control_period / settings.substeps, settings.bandwidth)
        self._at_once = settings.at_once or (1 if jax.default_backend() == "cpu" else num_envs)
        joints = (num_envs, robot.dof)
        self._motion = Motion(np.zeros(joints), np.zeros(joints), np.zeros(joints))
        self._state = State(self._motion.qpos, self._motion.qvel, np.zeros((num_envs, 3)), np.zeros(num_envs, bool))
        self._awake = np.ones(num_envs, bool)
        self.place(np.tile(robot.home, (num_envs, 1)))

    def reset(self, qpos: Float, mask: Mask) -> State:
        """See `harness.simulator.Simulation`."""
        self._awake |= mask
        motion = self._motion
        motion.qpos[mask] = motion.act[mask] = qpos[mask]
        motion.qvel[mask] = 0.0
        return self._look(np.flatnonzero(mask))

    def place(self, qpos: Float) -> State:
        """See `harness.simulator.Simulation`."""
        return self.reset(qpos, np.ones(len(qpos), bool))

    def drive(self, qpos: Float, duration: float) -> State:
        """See `harness.simulator.Simulation`."""
        steps = self._substeps.within(duration)
        # From where the servos hold now to the target: rounding cannot add up over periods.
        speeds = (qpos - self._motion.act) / duration
        awake = np.flatnonzero(self._awake)
        for start in range(0, len(awake), self._at_once):
            self._advance(awake[start : start + self._at_once], speeds, steps)
        return self._look(awake)

    def _advance(self, arms: NDArray[np.intp], speeds: Float, steps: int) -> None:
        """So many physics steps of the arms of these numbers, `at_once` of them or fewer."""
        rows = np.resize(arms, self._at_once)  # one program for any number: where there are fewer, some go twice
        before = Motion(*(array[rows] for array in self._motion))
        with jax.enable_x64(True):  # in this thread, until the end of the block
            after = COMPILED(self._model, before, speeds[rows], steps)
        for array, new in zip(self._motion, after, strict=True):
            array[arms] = np.asarray(new)[: len(arms)]

    def _look(self, arms: NDArray[np.intp]) -> State:
        """The state, with links and contacts of the arms of these numbers brought up to date."""
        if arms.size:
            qpos = self._motion.qpos[arms]
            self._state.end_effector[arms] = self._robot.end_effector(qpos)
            self._state.ground_contact[arms] = self._touches(qpos)
        return self._state

    def rest(self, mask: Mask) -> None:
        """See `harness.simulator.Simulation`."""
        self._awake = ~mask

    def read(self) -> State:
        """See `harness.simulator.Simulation`."""
        return self._state

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """See `harness.simulator.Simulation`; drawn without the engine."""
        return self._frames.frame(self._state.qpos[env], target, width, height)

    def close(self) -> None:
        """See `harness.simulator.Simulation`; what was compiled stays for the next one."""
        self._model = None


def advance(model: Any, motion: Motion, speeds: Array, steps: Array) -> Motion:
    """So many physics steps of arms whose servos are fed `speeds`, (arms, dof)."""

    def advance_one(one: Motion, speed: Array) -> Motion:
        still = mjx.make_data(model).replace(ctrl=jax.numpy.concatenate([speed, speed]))

        def step(_: Array, now: Motion) -> Motion:
            data = mjx.step(model, still.replace(**now._asdict()))
            return Motion(data.qpos, data.qvel, data.act)

        after: Motion = jax.lax.fori_loop(0, steps, step, one)
        return after

    if len(speeds) > 1:
        several: Motion = jax.vmap(advance_one)(motion, speeds)
        return several
    # Not mapped, branches stay branches: mapped, both ways of each are computed, the line search in full length too.
    alone = advance_one(Motion(*(array[0] for array in motion)), speeds[0])
    return Motion(*(array[None] for array in alone))


COMPILED = jax.jit(advance)
"""Compiled once for each robot and number of arms, in this process."""


def _put_model(robot: Robot, timestep: float, bandwidth: float) -> Any:
    model = build_model(robot, timestep, bandwidth)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_GRAVITY)
    try:
        with jax.enable_x64(True), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of faces with many corners: contacts with a plane take corners, no faces
            return mjx.put_model(model)
    except NotImplementedError as error:
        reason = " ".join(str(error).split())
        raise UsageError(f"MJX cannot simulate robot '{robot.name}': {reason}. Take the simulator 'mujoco'.") from error
