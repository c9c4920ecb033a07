"""Every check of drives with limits has a simulator that gets them wrong in that way, and fails no other of them."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

import harness
from harness.robot import Robot
from harness.robot.servo import Servo
from harness.simulator import Simulation
from harness_plugins.kit import IdealSimulator, violations
from harness_plugins.kit.simulators import servos
from harness_plugins.kit.simulators.checks import SERVO_CONTRACT
from harness_plugins.kit.simulators.servos import SERVO_CHECKS
from harness_plugins.simulators.mujoco import Mujoco

ROBOT = harness.load_robot("fd100")


@dataclass(frozen=True)
class Misread(Mujoco):
    """A simulator that takes other drives than the robot's."""

    def open(self, robot: Robot, num_envs: int, control_period: float) -> Simulation:
        return super().open(replace(robot, servo=self.misread(robot.servo)), num_envs, control_period)

    def misread(self, servo: Servo) -> Servo:
        raise NotImplementedError


@dataclass(frozen=True)
class TwiceAsStrong(Misread):
    """A limit holds in each direction, and is taken for the width of the range."""

    def misread(self, servo: Servo) -> Servo:
        return replace(servo, max_torque=2.0 * servo.max_torque)


@dataclass(frozen=True)
class OneStrength(Misread):
    """The limit is that of a small motor, whatever is asked for."""

    def misread(self, servo: Servo) -> Servo:
        return replace(servo, max_torque=np.minimum(servo.max_torque, 0.4 * ROBOT.servo.max_torque))


@dataclass(frozen=True)
class ActsAtOnce(Misread):
    """There is no latency."""

    def misread(self, servo: Servo) -> Servo:
        return replace(servo, latency=0.0)


@dataclass(frozen=True)
class RunsSmoothly(Misread):
    """There is no friction."""

    def misread(self, servo: Servo) -> Servo:
        return replace(servo, viscous_friction=0.0 * servo.viscous_friction, dry_friction=0.0 * servo.dry_friction)


@dataclass(frozen=True)
class SpinsLightly(Misread):
    """Motors have the inertia of the robot's, whatever is asked for."""

    def misread(self, servo: Servo) -> Servo:
        return replace(servo, armature=ROBOT.servo.armature)


@dataclass(frozen=True)
class ForgetsAPeriod(Mujoco):
    """A reset forgets as many commands as a control period has, of those that are still to come."""

    def open(self, robot: Robot, num_envs: int, control_period: float) -> Simulation:
        simulation = super().open(robot, num_envs, control_period)
        if self.drive == "servo":
            track = simulation._feed._track
            reset = track.reset

            def forget(qpos: np.ndarray, mask: np.ndarray) -> None:
                later = track._coming[self.substeps :].copy()
                reset(qpos, mask)
                track._coming[self.substeps :] = later

            track.reset = forget
        return simulation


@dataclass(frozen=True)
class TouchesNothing(Mujoco):
    """With drives of its own, the model has lost its sensor."""

    def open(self, robot: Robot, num_envs: int, control_period: float) -> Simulation:
        simulation = super().open(robot, num_envs, control_period)
        if self.drive == "servo":
            read = simulation._arms.read
            simulation._arms.read = lambda: read()._replace(ground_contact=np.zeros(num_envs, bool))
        return simulation


MUTANTS = {
    TwiceAsStrong: servos.drives_keep_their_limits,
    OneStrength: servos.stronger_drives_follow_better,
    ActsAtOnce: servos.commands_come_late,
    RunsSmoothly: servos.friction_holds_the_joints,
    SpinsLightly: servos.armature_makes_the_joints_slow,
    ForgetsAPeriod: servos.reset_forgets_commands,
}


def test_mutant_fails_one_check(subtests: pytest.Subtests):
    """A simulator that gets the drives wrong in one way fails the check of that fact, and no other."""
    for mutant, check in MUTANTS.items():
        with subtests.test(mutant=mutant, check=check):
            assert [violation.check for violation in violations(SERVO_CHECKS, mutant(), ROBOT)] == [check.name]


def test_what_is_wrong_with_servo_alone_is_found():
    """The contract is tried with these drives too, also where the simulator itself is set to ideal ones."""
    [violation] = violations([SERVO_CONTRACT, *SERVO_CHECKS], TouchesNothing(), ROBOT)
    assert violation.check == "sim-servo"
    assert "with drive=servo, sim-ground-contact: the arm was driven into the ground" in str(violation)


def test_every_check_has_a_mutant():
    """No check is without a simulator that fails it alone."""
    assert set(MUTANTS.values()) == set(SERVO_CHECKS)


@pytest.mark.parametrize("without", ["a field", "drives"])
def test_checks_are_left_out_where_there_are_no_such_drives(without: str, monkeypatch: pytest.MonkeyPatch):
    """A simulator without the field, or a robot without `[servo]`, opens nothing for them."""
    monkeypatch.setattr(Mujoco, "open", lambda *_: pytest.fail("it was opened"))
    simulator = IdealSimulator() if without == "a field" else Mujoco()
    robot = ROBOT if without == "a field" else replace(ROBOT, servo=None)
    assert list(violations([SERVO_CONTRACT, *SERVO_CHECKS], simulator, robot)) == []
