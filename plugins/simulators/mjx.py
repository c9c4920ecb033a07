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

from harness import Float, Mask
from harness.errors import UsageError
from harness.robot import Robot
from harness.simulator import GroundContact, State, StillFrames, Substeps

from ..mujoco_model import build_model, mujoco

with redirect_stdout(StringIO()):  # MJX prints that Warp is not installed; nothing here uses it
    from mujoco import mjx

Count = Annotated[int, Field(gt=0)]
Array = Any
"""An array of JAX, or of numpy before JAX converts it."""


@dataclass(frozen=True)
class Mjx:
    """The model of `mujoco`, stepped by MJX. XLA compiles it, above all for accelerators.

    Masses, servos, integrator and contact forces are those of `mujoco` with drive=ideal, in double precision. Weight
    and its compensation cancel, so neither is computed. End effector and ground contact are computed from the robot's
    own geometry, at the end of the period. The harness draws the frames.

    The first drive in a process compiles for about 20 s. On a CPU, one program for many arms at once is slower than a
    program for a single arm that is called for each; `at_once` chooses. An arm moves the same, bit for bit, no matter
    which arms are beside it, if `at_once` is the same number. On an accelerator this does not hold with at_once=0.
    """

    family: ClassVar[str] = "MuJoCo"
    sources: ClassVar[tuple[str, ...]] = ("harness_plugins.mujoco_model",)
    substeps: Annotated[Count, Field(description="physics steps per control period")] = 20
    bandwidth: Annotated[float, Field(gt=0, description="bandwidth w of the joint servos [rad/s]")] = 100.0
    at_once: Annotated[
        int, Field(ge=0, description="arms that one call of the compiled program steps; 0: one on a CPU, else all")
    ] = 0

    def open(self, robot: Robot, num_envs: int, control_period: float) -> "MjxSimulation":
        return MjxSimulation(self, robot, num_envs, control_period)


class Motion(NamedTuple):
    """The state before or after a physics step. The arrays are (arms, dof), or (dof,) for one arm."""

    qpos: Array
    qvel: Array
    act: Array
    """The positions that the position servos hold."""


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
        self._awake |= mask
        motion = self._motion
        motion.qpos[mask] = motion.act[mask] = qpos[mask]
        motion.qvel[mask] = 0.0
        return self._look(np.flatnonzero(mask))

    def place(self, qpos: Float) -> State:
        return self.reset(qpos, np.ones(len(qpos), bool))

    def drive(self, qpos: Float, duration: float) -> State:
        steps = self._substeps.within(duration)
        # The speeds lead from the positions that the servos hold now, so rounding cannot add up over periods.
        speeds = (qpos - self._motion.act) / duration
        awake = np.flatnonzero(self._awake)
        for start in range(0, len(awake), self._at_once):
            self._advance(awake[start : start + self._at_once], speeds, steps)
        return self._look(awake)

    def _advance(self, arms: NDArray[np.intp], speeds: Float, steps: int) -> None:
        """Do `steps` physics steps of the arms with these numbers, which are `at_once` or fewer."""
        rows = np.resize(arms, self._at_once)  # one program for any number: if there are fewer arms, some go twice
        before = Motion(*(array[rows] for array in self._motion))
        with jax.enable_x64(True):  # in this thread, until the end of the block
            after = COMPILED(self._model, before, speeds[rows], steps)
        for array, new in zip(self._motion, after, strict=True):
            array[arms] = np.asarray(new)[: len(arms)]

    def _look(self, arms: NDArray[np.intp]) -> State:
        """The state, after an update of end effector and contact of the arms with these numbers."""
        if arms.size:
            qpos = self._motion.qpos[arms]
            self._state.end_effector[arms] = self._robot.end_effector(qpos)
            self._state.ground_contact[arms] = self._touches(qpos)
        return self._state

    def rest(self, mask: Mask) -> None:
        self._awake = ~mask

    def read(self) -> State:
        return self._state

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """See `harness.simulator.Simulation`; drawn without the engine."""
        return self._frames.frame(self._state.qpos[env], target, width, height)

    def close(self) -> None:
        """See `harness.simulator.Simulation`. The compiled program stays for the next simulation."""
        self._model = None


def advance(model: Any, motion: Motion, speeds: Array, steps: Array) -> Motion:
    """Do `steps` physics steps of arms whose servos are fed `speeds`, (arms, dof), [rad/s] or [m/s]."""

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
    # Without vmap a branch computes only the side that it takes. With vmap it computes both, and the line search always
    # has its full length.
    alone = advance_one(Motion(*(array[0] for array in motion)), speeds[0])
    return Motion(*(array[None] for array in alone))


COMPILED = jax.jit(advance)
"""Compiled once for each robot and number of arms, in this process."""


def _put_model(robot: Robot, timestep: float, bandwidth: float) -> Any:
    model = build_model(robot, timestep, bandwidth)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_GRAVITY)
    try:
        with jax.enable_x64(True), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # MJX warns of faces with many corners; contacts with a plane use no faces
            return mjx.put_model(model)
    except NotImplementedError as error:
        reason = " ".join(str(error).split())
        raise UsageError(f"MJX cannot simulate robot '{robot.name}': {reason}. Take the simulator 'mujoco'.") from error
