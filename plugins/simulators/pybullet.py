"""PyBullet: every arm in a physics client of its own, driven by velocity motors or by torques."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.robot import Robot
from harness.simulator import Substeps, servo_of

from ..arms.apart import ArmsApart
from ..arms.servo import ServoArms
from ..bullet_arms import Arm, Clients, FreeArm, ServoArm, file_of_arm

Count = Annotated[int, Field(gt=0)]


@dataclass(frozen=True)
class PyBullet:
    """Bullet with velocity motors that track a joint ramp.

    Over a control period each motor holds the speed that leads from the joint's present position to its target. The
    motors are constraints of the solver, so they carry the arm against gravity. With drive=servo each joint has the
    drive that robot.toml describes, which applies a torque in each physics step. Every arm has a client of Bullet's,
    with a world of its own. A client takes about 36 MB of memory, and a process has at most 1,024 of them.
    """

    family: ClassVar[str] = "Bullet"
    arm_bytes: ClassVar[int] = 36_000_000
    later: ClassVar[tuple[str, ...]] = ("drive", "self_collision")
    sources: ClassVar[tuple[str, ...]] = (
        "harness_plugins.bullet_arms",
        "harness_plugins.arms.apart",
        "harness_plugins.arms.dry_friction",
        "harness_plugins.arms.servo",
    )
    substeps: Annotated[Count, Field(description="physics steps per control period")] = 20
    iterations: Annotated[Count, Field(description="fewest iterations of the constraint solver per physics step")] = 50
    drive: Annotated[Literal["ideal", "servo"], Field(description="kind of joint drives; see docs/drives.md")] = "ideal"
    self_collision: Annotated[bool, Field(description="whether the arm's links collide with one another")] = False

    def open(self, robot: Robot, num_envs: int, control_period: float) -> ArmsApart | ServoArms:
        clients, substeps = Clients(robot), Substeps(self.substeps, control_period)
        options = substeps, self.iterations, self.self_collision
        with file_of_arm(robot) as path:
            if self.drive == "servo":
                servo = servo_of(robot)
                free = FreeArm(clients.connect(), robot, path, servo.armature)
                return ServoArms(
                    robot, num_envs, substeps,
                    lambda: ServoArm(clients.connect(), robot, path, servo, free, *options), clients,
                )  # fmt: skip
            return ArmsApart(robot, num_envs, lambda: Arm(clients.connect(), robot, path, *options), clients)
