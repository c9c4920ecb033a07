"""The ceiling: the arm is told where to go by its own kinematics."""

from typing import TYPE_CHECKING, Annotated, ClassVar, cast

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.algorithm import ActionSpace
from harness.authoring.act_without_learning import act_for
from harness.env.arm_observation import ArmObservation
from harness.motion import MoveJ, MoveJAbsolute, SetJoints
from harness.policy import InverseKinematics
from harness.progress import Progress
from harness.robot import Robot
from harness.task import Task

if TYPE_CHECKING:
    from harness.env import ReachVectorEnv

MODES: dict[type, str] = {MoveJ: "movej", MoveJAbsolute: "movej-absolute", SetJoints: "set-joints"}


@dataclass(frozen=True)
class Ik:
    """Reaches by inverse kinematics and learns nothing: what a learner could do that knew the arm.

    It knows nothing else: it looks at the same observations, and does not look out for the ground.
    """

    num_envs: Annotated[int, Field(gt=0, description="envs that it acts in at once")] = 10

    action_spaces: ClassVar[frozenset[ActionSpace]] = frozenset({"continuous"})
    learns: ClassVar[bool] = False

    def why_not(self, task: Task, robot: Robot) -> str:
        """See `harness.algorithm.why_not`."""
        motion = task.motion(robot)
        if type(motion) not in MODES:
            return f"ik knows the action modes {', '.join(MODES.values())}, not that of the task: '{task.action}'"
        if not isinstance(task.observation(robot), ArmObservation):
            return "ik reads joint angles and target from the observation of fd100-reach, and the task has another"
        return ""

    def train(self, env: "ReachVectorEnv", steps: int, seed: int, progress: Progress) -> InverseKinematics:
        """See `harness.algorithm.Algorithm`."""
        motion = cast(MoveJ | MoveJAbsolute | SetJoints, env.task.motion(env.robot))  # see why_not
        policy = InverseKinematics.of(env.robot, motion.limits, MODES[type(motion)], "ik")
        act_for(env, steps, policy, seed, progress)
        return policy
