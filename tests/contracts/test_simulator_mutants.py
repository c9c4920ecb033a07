"""Every simulator check has a broken simulator that fails it, and no other."""

from dataclasses import dataclass

import numpy as np
import pytest

import harness
from harness.env.ideal import IdealSimulation
from harness.robot import Robot
from harness.robot.ground_clearance import build_solids
from harness.robot.kinematics import link_frames
from harness.simulator import State
from harness_plugins.kit import SIMULATOR_CHECKS, IdealSimulator, violations
from harness_plugins.kit.simulators import checks as simulators, simulations
from harness_plugins.kit.simulators.servos import SERVO_CHECKS

ROBOT = harness.load_robot("fd100")


@dataclass
class Thawed:
    """Its settings can be changed while it runs."""

    def open(self, robot: Robot, num_envs: int, control_period: float) -> IdealSimulation:
        return IdealSimulation(robot, num_envs)


@dataclass(frozen=True)
class SetUpWithASet(IdealSimulator):
    """JSON knows no sets."""

    devices: frozenset[int] = frozenset({0})


class FlagsInAColumn(IdealSimulation):
    """Ground contact has an axis too many."""

    def state(self) -> State:
        state = super().state()
        return state._replace(ground_contact=state.ground_contact[:, None])


class SinglePrecision(IdealSimulation):
    """Velocities come as the engine has them."""

    def state(self) -> State:
        state = super().state()
        return state._replace(qvel=state.qvel.astype(np.float32))


class BreaksOnTheGround(IdealSimulation):
    """Contact forces are too much for the integrator."""

    def state(self) -> State:
        state = super().state()
        return state._replace(qvel=np.where(state.ground_contact[:, None], np.nan, state.qvel))


class ResetsRoughly(IdealSimulation):
    """Poses are rounded on the way into the engine."""

    def reset(self, qpos: np.ndarray, mask: np.ndarray) -> State:
        return super().reset(qpos.round(3), mask)

    def place(self, qpos: np.ndarray) -> State:
        return super().reset(qpos, np.ones(len(qpos), bool))


class PlacesInMotion(IdealSimulation):
    """Placing leaves a speed behind."""

    def place(self, qpos: np.ndarray) -> State:
        super().place(qpos)
        self.qvel += 0.1
        return self.state()


class IgnoresTheMask(IdealSimulation):
    """Every reset is one of all envs."""

    def reset(self, qpos: np.ndarray, mask: np.ndarray) -> State:
        return super().reset(qpos, np.ones_like(mask))


class LagsWithTheEndEffector(IdealSimulation):
    """The end effector is where it was before the drive."""

    def __init__(self, robot: Robot, num_envs: int) -> None:
        super().__init__(robot, num_envs)
        self.before = self.qpos.copy()

    def reset(self, qpos: np.ndarray, mask: np.ndarray) -> State:
        self.before[mask] = qpos[mask]
        return super().reset(qpos, mask)

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        self.before = self.qpos.copy()
        return super().drive(qpos, duration)

    def state(self) -> State:
        return super().state()._replace(end_effector=self.robot.end_effector(self.before))


class MeasuresBesideTheTip(IdealSimulation):
    """The end effector is another link's."""

    def state(self) -> State:
        state = super().state()
        return state._replace(end_effector=state.end_effector + 1e-4)


class DrivesSoftly(IdealSimulation):
    """A servo gets 95 % of the way."""

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        return super().drive(self.qpos + 0.95 * (qpos - self.qpos), duration)


class ReportsDegrees(IdealSimulation):
    """Velocities are in degrees per second."""

    def state(self) -> State:
        state = super().state()
        return state._replace(qvel=np.degrees(state.qvel))


class Sticks(IdealSimulation):
    """A joint does not move for less than 0.4 degrees."""

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        return super().drive(np.where(np.abs(qpos - self.qpos) < np.radians(0.4), self.qpos, qpos), duration)


class NeverTouches(IdealSimulation):
    """Ground contact is not wired up."""

    def state(self) -> State:
        return super().state()._replace(ground_contact=np.zeros(len(self.qpos), bool))


class AlwaysTouches(IdealSimulation):
    """The base, which stands on the ground, counts."""

    def state(self) -> State:
        return super().state()._replace(ground_contact=np.ones(len(self.qpos), bool))


class ReadsTheOpening(IdealSimulation):
    """Reading tells how it was in the beginning."""

    def read(self) -> State:
        return IdealSimulation(self.robot, len(self.qpos)).state()


class KeepsTheArray(IdealSimulation):
    """What it is placed at stays the caller's array."""

    def place(self, qpos: np.ndarray) -> State:
        state = super().place(qpos)
        self.qpos = qpos
        return state


class WritesIntoTheArray(IdealSimulation):
    """It brings the caller's targets into the range from -pi to pi."""

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        qpos -= 1e-12
        return super().drive(qpos, duration)


class ShakesOnTheGround(IdealSimulation):
    """Contacts are solved in an order that changes from run to run."""

    def state(self) -> State:
        state = super().state()
        noise = np.random.default_rng().uniform(-1e-9, 1e-9, state.qvel.shape)
        return state._replace(qvel=state.qvel + np.where(state.ground_contact[:, None], noise, 0.0))


class StaysOnTheGround(IdealSimulation):
    """A contact is never forgotten."""

    touched = False

    def state(self) -> State:
        state = super().state()
        self.touched = self.touched | state.ground_contact
        return state._replace(ground_contact=self.touched)


class WearsOut(IdealSimulation):
    """A little is left over from every drive."""

    drives = 0

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        self.drives += 1
        return super().drive(qpos + 1e-12 * self.drives, duration)


class CountsItsEnvs(IdealSimulation):
    """The last digits depend on how many envs there are."""

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        return super().drive(qpos + 1e-12 * len(qpos), duration)


class PrefersTheFirst(IdealSimulation):
    """The last digits depend on the env's number."""

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        return super().drive(qpos + 1e-12 * np.arange(len(qpos))[:, None], duration)


class PushesItsNeighbour(IdealSimulation):
    """An arm feels what the next one does."""

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        return super().drive(qpos + 1e-9 * (qpos - np.roll(qpos, 1, axis=0)), duration)


class SleepsOn(IdealSimulation):
    """An arm that has rested stays where it is, whatever is reset."""

    def __init__(self, robot: Robot, num_envs: int) -> None:
        super().__init__(robot, num_envs)
        self.asleep = np.zeros(num_envs, bool)

    def rest(self, mask: np.ndarray) -> None:
        self.asleep = mask.copy()

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        return super().drive(np.where(self.asleep[:, None], self.qpos, qpos), duration)


class Renders(IdealSimulation):
    """It renders frames of one colour, which depends on where the target is: nothing is wrong with it."""

    def render(self, env: int, target: np.ndarray, width: int, height: int) -> np.ndarray:
        return np.full((height, width, 3), target.sum() * 50.0).astype(np.uint8)


class RendersSideways(Renders):
    """Width and height are swapped."""

    def render(self, env: int, target: np.ndarray, width: int, height: int) -> np.ndarray:
        return super().render(env, target, height, width)


class RendersFloats(Renders):
    """Colours go from 0 to 1."""

    def render(self, env: int, target: np.ndarray, width: int, height: int) -> np.ndarray:
        return super().render(env, target, width, height) / 255.0


class KeepsTheFirstSize(Renders):
    """The renderer is made once, of the size of the first frame."""

    size = None

    def render(self, env: int, target: np.ndarray, width: int, height: int) -> np.ndarray:
        self.size = self.size or (width, height)
        return super().render(env, target, *self.size)


class MovesToRender(Renders):
    """Rendering steps the engine."""

    def render(self, env: int, target: np.ndarray, width: int, height: int) -> np.ndarray:
        self.qvel += 1e-3
        return super().render(env, target, width, height)


class HidesTheTarget(Renders):
    """The marker is not drawn."""

    def render(self, env: int, target: np.ndarray, width: int, height: int) -> np.ndarray:
        return super().render(env, np.zeros(3), width, height)


class HasNoRenderer(IdealSimulation):
    """Rendering what is asked for needs a library that is not there."""

    def render(self, env: int, target: np.ndarray, width: int, height: int) -> np.ndarray:
        raise ImportError("no GL")


class ClosesOnce(IdealSimulation):
    """The engine is released a second time."""

    closed = False

    def close(self) -> None:
        if self.closed:
            raise RuntimeError("there is no engine")
        self.closed = True


class SharesOneArm(IdealSimulation):
    """All envs tell what the first one does."""

    def state(self) -> State:
        return State._make(np.repeat(array[:1], len(array), axis=0) for array in super().state())


class SwapsEnvs(IdealSimulation):
    """The envs are told in reverse order."""

    def state(self) -> State:
        return State._make(array[::-1] for array in super().state())


class SwapsJoints(IdealSimulation):
    """The engine has the joints in another order, and is told so, but the end effector is not."""

    def state(self) -> State:
        return super().state()._replace(end_effector=self.robot.end_effector(self.qpos[:, ::-1]))


class StandsStill(IdealSimulation):
    """Driving does nothing."""

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        return self.state()


class CountsItsResets(IdealSimulation):
    """Where an arm gets depends, by a bit, on how often others were reset on their own."""

    count = 0

    def reset(self, qpos: np.ndarray, mask: np.ndarray) -> State:
        self.count = 0 if mask.all() else self.count + 1
        return super().reset(qpos, mask)

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        return super().drive(qpos + 1e-12 * self.count, duration)


class LacksRead(IdealSimulation):
    """Nobody has read the interface to its end."""

    read = None  # type: ignore[assignment]


class NamesItsArguments(IdealSimulation):
    """Arguments have names of its own."""

    def render(self, number: int, marker: np.ndarray, width: int, height: int) -> np.ndarray:
        return super().render(number, marker, width, height)


class KnowsOnePeriod(IdealSimulation):
    """The speed is that of a whole period, however long the drive lasts."""

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        return super().drive(qpos, simulations.PERIOD)


class GoesAShareOfTheWay(IdealSimulation):
    """Half a period leads half-way to the target, which was given for the end of that half."""

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        share = duration / simulations.PERIOD
        return super().drive(self.qpos + share * (qpos - self.qpos), duration)


class LastsAWholePeriod(IdealSimulation):
    """Half a period is simulated as a whole one at the speed that was asked for: it goes twice as far."""

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        return super().drive(self.qpos + (qpos - self.qpos) * simulations.PERIOD / duration, duration)


class OwesTheRest(IdealSimulation):
    """A part of a period is rounded down to whole physics steps, of which there are three."""

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        done = np.floor(3.0 * duration / simulations.PERIOD + 1e-9) / (3.0 * duration / simulations.PERIOD)
        return super().drive(self.qpos + done * (qpos - self.qpos), duration)


class ReversesTheBatch(IdealSimulation):
    """The last env is driven to the first one's target."""

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        return super().drive(qpos[::-1], duration)


class ReversesTheSpeeds(IdealSimulation):
    """The velocities come in the order of the engine."""

    def state(self) -> State:
        state = super().state()
        return state._replace(qvel=state.qvel[::-1])


class DropsASolid(IdealSimulation):
    """The engine could not read the shape of the tool, and went on without it."""

    def __init__(self, robot: Robot, num_envs: int) -> None:
        super().__init__(robot, num_envs)
        self.solids = build_solids([*robot.joint_shapes[:-1], robot.joint_shapes[-1][:-1]])

    def state(self) -> State:
        frames = link_frames(self.robot.chain, self.qpos)
        contact = self.solids.touch_ground(frames) | (self.robot.end_effector(self.qpos)[:, 2] < -0.05)
        return super().state()._replace(ground_contact=contact)


class TouchesTogether(IdealSimulation):
    """One arm on the ground is all arms on the ground."""

    def state(self) -> State:
        state = super().state()
        return state._replace(ground_contact=np.full(len(self.qpos), state.ground_contact.any()))


class TouchesElsewhere(IdealSimulation):
    """Contacts are told of the next env."""

    def state(self) -> State:
        state = super().state()
        return state._replace(ground_contact=np.roll(state.ground_contact, 1))


class TellsWhatItWasTold(IdealSimulation):
    """The positions of a state are the targets, as the caller gave them."""

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        return super().drive(qpos, duration)._replace(qpos=qpos)


class DivergesInTime(IdealSimulation):
    """What it adds up overflows at the 37th period of an episode."""

    periods = 0

    def reset(self, qpos: np.ndarray, mask: np.ndarray) -> State:
        self.periods = 0
        return super().reset(qpos, mask)

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        self.periods += 1
        state = super().drive(qpos, duration)
        return state._replace(qvel=np.full_like(state.qvel, np.nan)) if self.periods >= 37 else state


class KeepsEveryState(IdealSimulation):
    """A history that nobody reads."""

    def __init__(self, robot: Robot, num_envs: int) -> None:
        super().__init__(robot, num_envs)
        self.history: list[State] = []

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        self.history.append(super().drive(qpos, duration))
        return self.state()


MUTANTS = {
    DivergesInTime: simulators.states_are_finite,
    KeepsEveryState: simulators.nothing_is_kept_of_a_period,
    NamesItsArguments: simulators.a_simulation_has_its_methods,
    KnowsOnePeriod: simulators.parts_of_a_period_add_up,
    GoesAShareOfTheWay: simulators.parts_of_a_period_add_up,
    LastsAWholePeriod: simulators.parts_of_a_period_add_up,
    OwesTheRest: simulators.parts_of_a_period_add_up,
    ReversesTheBatch: simulators.every_env_does_what_it_was_told,
    DropsASolid: simulators.every_solid_touches_the_ground,
    TouchesTogether: simulators.ground_contact_is_the_envs_own,
    TouchesElsewhere: simulators.ground_contact_is_the_envs_own,
    TellsWhatItWasTold: simulators.states_are_not_the_callers_arrays,
    CountsItsResets: simulators.the_same_way_leads_to_the_same_place,
    Thawed: simulators.settings_are_frozen,
    SetUpWithASet: simulators.settings_survive_json,
    FlagsInAColumn: simulators.states_have_the_declared_shapes,
    SinglePrecision: simulators.states_are_float64_and_bool,
    BreaksOnTheGround: simulators.states_are_finite,
    ResetsRoughly: simulators.reset_puts_the_arm_there_at_rest,
    PlacesInMotion: simulators.place_puts_the_arm_there_at_rest,
    IgnoresTheMask: simulators.reset_leaves_the_other_envs_alone,
    LagsWithTheEndEffector: simulators.end_effector_is_that_of_the_robot,
    MeasuresBesideTheTip: simulators.end_effector_is_that_of_the_robot,
    SwapsJoints: simulators.end_effector_is_that_of_the_robot,
    DrivesSoftly: simulators.drive_tracks_a_joint_ramp,
    ReportsDegrees: simulators.qvel_is_the_speed_of_a_steady_motion,
    Sticks: simulators.small_moves_move_every_joint,
    NeverTouches: simulators.ground_contact_is_seen,
    AlwaysTouches: simulators.no_ground_contact_in_the_air,
    ReadsTheOpening: simulators.read_returns_the_state_of_the_last_call,
    KeepsTheArray: simulators.arguments_are_copied,
    WritesIntoTheArray: simulators.arguments_are_copied,
    ShakesOnTheGround: simulators.same_calls_give_same_states,
    StaysOnTheGround: simulators.reset_forgets_what_was_before,
    WearsOut: simulators.reset_forgets_what_was_before,
    CountsItsEnvs: simulators.an_env_in_a_batch_is_as_one_alone,
    PrefersTheFirst: simulators.an_env_in_a_batch_is_as_one_alone,
    PushesItsNeighbour: simulators.envs_do_not_touch_one_another,
    SleepsOn: simulators.resting_arms_change_nothing,
    RendersSideways: simulators.render_gives_a_frame_or_says_why_not,
    RendersFloats: simulators.render_gives_a_frame_or_says_why_not,
    MovesToRender: simulators.render_gives_a_frame_or_says_why_not,
    KeepsTheFirstSize: simulators.render_gives_a_frame_or_says_why_not,
    HidesTheTarget: simulators.frames_show_the_target,
    ClosesOnce: simulators.close_can_be_called_twice,
}

COARSE_MUTANTS = {
    LacksRead: simulators.a_simulation_has_its_methods,
    ReversesTheSpeeds: simulators.every_env_does_what_it_was_told,
    HasNoRenderer: simulators.render_gives_a_frame_or_says_why_not,
    SharesOneArm: simulators.envs_do_not_touch_one_another,
    SwapsEnvs: simulators.reset_leaves_the_other_envs_alone,
    StandsStill: simulators.small_moves_move_every_joint,
}


def failing(mutant: type) -> list[str]:
    """Names of the checks that a mutant fails."""
    return [violation.check for violation in violations(SIMULATOR_CHECKS, simulator_of(mutant), ROBOT)]


def simulator_of(mutant: type) -> object:
    """The simulator that opens a broken simulation; a broken simulator itself."""
    if not issubclass(mutant, IdealSimulation):
        return mutant()

    @dataclass(frozen=True)
    class Mutant(IdealSimulator):
        def open(self, robot: Robot, num_envs: int, control_period: float) -> IdealSimulation:
            return mutant(robot, num_envs)

    return Mutant()


def test_mutant_fails_one_check(subtests: pytest.Subtests):
    """A simulator that is broken in one way fails the check of that fact, and no other."""
    for mutant, check in MUTANTS.items():
        with subtests.test(mutant=mutant, check=check):
            assert failing(mutant) == [check.name]


def test_coarse_mutant_fails_its_check(subtests: pytest.Subtests):
    """A simulator that is broken in many ways fails, among others, the check that is nearest."""
    for mutant, check in COARSE_MUTANTS.items():
        with subtests.test(mutant=mutant, check=check):
            assert check.name in failing(mutant)


def test_the_mutants_that_render_are_made_of_a_sound_simulation():
    """What the mutants of rendering are made of fails nothing."""
    assert failing(Renders) == []


def test_every_check_has_a_mutant():
    """No check is without a simulator that fails it alone; those of drives have theirs in test_servo_mutants.py."""
    assert set(MUTANTS.values()) == set(SIMULATOR_CHECKS) - {simulators.SERVO_CONTRACT, *SERVO_CHECKS}
