"""Every task check has a broken task that fails it, and no other."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest
from pydantic.dataclasses import dataclass as checked_dataclass

import harness
from harness.env.arm_observation import ArmObservation
from harness.env.episodes import Episodes
from harness.goal import Goal, Situation
from harness.motion import Move, MoveJ
from harness.reach import ReachTask
from harness.robot import Robot
from harness.task import Targets
from harness_plugins.kit import TASK_CHECKS, tasks, violations
from harness_plugins.tasks.moving import Moving, MovingGoal

ROBOT = harness.load_robot("fd100")
SOUND = ReachTask()


@dataclass
class Thawed:
    """Its parameters can be changed while it runs."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(SOUND, name)


class Sound(ReachTask):
    """Nothing is wrong with it."""


@checked_dataclass(frozen=True)
class SetUpWithASet(ReachTask):
    """JSON knows no sets."""

    zones: frozenset[int] = frozenset({1})


class EndsInANumber(ReachTask):
    """1 is as good as True until somebody compares."""

    ends_at_target: ClassVar[Any] = 1


class NeverSaysWhere(ReachTask):
    """Nobody learns where episodes start."""

    def start_in_words(self, robot: Robot) -> str:
        return ""


class NeedsAnotherArm(ReachTask):
    """It was made for an arm that does not pass."""

    robot: ClassVar[str] = "unity-arm"

    def check(self, robot: Robot) -> None:
        assert robot.name == "fd100"


class StartsAnywhere(ReachTask):
    """Now and then a joint starts a whole turn too far."""

    def draw_start(self, robot: Robot, rng: np.random.Generator) -> Any:
        return robot.home + (rng.random() > 0.9) * (robot.upper - robot.home + 0.1) * (np.arange(robot.dof) == 5)


class StartsInSingle(ReachTask):
    """Half of the digits are lost."""

    def draw_start(self, robot: Robot, rng: np.random.Generator) -> Any:
        return super().draw_start(robot, rng).astype(np.float32)


class FlagsInNumbers(ReachTask):
    """0 and 1 pick rows, where False and True choose them."""

    def draw_targets(self, robot: Robot, rng: np.random.Generator, count: int) -> Targets:
        position, relative = super().draw_targets(robot, rng, count)
        return Targets(position, relative.astype(int))


class ForgetsTheStream(ReachTask):
    """It draws from the stream that all share."""

    def draw_start(self, robot: Robot, rng: np.random.Generator) -> Any:
        return robot.home + 0.01 * np.random.random(robot.dof)


class RemembersOnSelf(ReachTask):
    """Every second start is home."""

    def draw_start(self, robot: Robot, rng: np.random.Generator) -> Any:
        object.__setattr__(self, "odd", not getattr(self, "odd", False))
        start = super().draw_start(robot, rng)
        return start if self.odd else robot.home.copy()


class SaysItIsFixed(ReachTask):
    """One episode is evaluated, and stands for all."""

    varies: ClassVar[bool] = False


class PaysAll(ReachTask):
    """One reward for all arms, which numpy would spread."""

    def target_rewards(self, robot: Robot, qpos: Any) -> Any:
        return np.full(1, self.target_reward)


class GoesTooFar(ReachTask):
    """Full speed leads out of the joint ranges."""

    def motion(self, robot: Robot) -> Any:
        return TooFar(super().motion(robot).limits)


class TooFar(MoveJ):
    """The motion of `GoesTooFar`, which stays in range where nobody looks."""

    def advance(self, qpos: Any, qvel: Any, action: Any) -> Move:
        full = np.abs(action).max() == 1.0
        return Move((qpos + 10.0,), qvel) if full else super().advance(qpos, qvel, action)


class Seen(ArmObservation):
    """What the mutants below see; each changes a thing."""

    @classmethod
    def of(cls, task: ReachTask, robot: Robot) -> Any:
        return cls(robot, task.control_period)


class SeesNothingNew(ReachTask):
    """The last number has a range of nothing."""

    def observation(self, robot: Robot) -> Any:
        return OneMore.of(self, robot)


class OneMore(Seen):
    """A number that is always 0."""

    @property
    def low(self) -> Any:
        return np.append(super().low, np.float32(0.0))

    @property
    def high(self) -> Any:
        return np.append(super().high, np.float32(0.0))

    def observe(self, episodes: Episodes) -> Any:
        seen = super().observe(episodes)
        return np.concatenate([seen, np.zeros_like(seen[:, :1])], axis=1)


class SeesBeyond(ReachTask):
    """The steps that it counts leave their bounds."""

    def observation(self, robot: Robot) -> Any:
        return Beyond.of(self, robot)


class Beyond(Seen):
    """The first number is the step."""

    def observe(self, episodes: Episodes) -> Any:
        seen = super().observe(episodes)
        seen[:, 0] = episodes.step
        return seen


class SeesInOneArray(ReachTask):
    """Every observation is the same array."""

    def observation(self, robot: Robot) -> Any:
        return OneArray.of(self, robot)


class OneArray(Seen):
    """Written over each time."""

    kept: Any = None

    def observe(self, episodes: Episodes) -> Any:
        seen = super().observe(episodes)
        if self.kept is None:
            self.kept = seen
        self.kept[...] = seen
        return self.kept


class CountsLooks(ReachTask):
    """Looking at the episodes turns their clock."""

    def observation(self, robot: Robot) -> Any:
        return Turning.of(self, robot)


class Turning(Seen):
    """Each look is a price paid."""

    def observe(self, episodes: Episodes) -> Any:
        episodes.step_price -= 1.0
        return super().observe(episodes)


class TargetsOutOfReach(ReachTask):
    """Metres and millimetres are mixed up."""

    def draw_targets(self, robot: Robot, rng: np.random.Generator, count: int) -> Targets:
        position, relative = super().draw_targets(robot, rng, count)
        return Targets(position * [3.0, 1.0, 1.0], relative)


class TargetsUnderground(ReachTask):
    """The box of targets has its zero at the arm's shoulder."""

    def draw_targets(self, robot: Robot, rng: np.random.Generator, count: int) -> Targets:
        position, relative = super().draw_targets(robot, rng, count)
        return Targets(position - [0.0, 0.0, 0.7], relative)


class RelativeTargetsUnderground(ReachTask):
    """It counts from the end effector what was drawn from the origin, downwards."""

    def draw_targets(self, robot: Robot, rng: np.random.Generator, count: int) -> Targets:
        position = np.array([[0.0, 0.0, -3.0]]) * rng.uniform(0.9, 1.0, (count, 1))
        return Targets(position, np.ones(count, bool))


class SpreadsItsTargets(ReachTask):
    """The targets of a batch are spread over a line: one alone is at its beginning."""

    def draw_targets(self, robot: Robot, rng: np.random.Generator, count: int) -> Targets:
        rng.random(count)
        position = np.stack([np.full(count, 0.8), np.linspace(-0.2, 0.2, count), np.full(count, 0.7)], axis=1)
        return Targets(position, np.zeros(count, bool))


class HurriesItsTargets(ReachTask):
    """The more targets there are to draw, the nearer they are."""

    def draw_targets(self, robot: Robot, rng: np.random.Generator, count: int) -> Targets:
        position, relative = super().draw_targets(robot, rng, count)
        return Targets(position - [0.1 / count, 0.0, 0.0], relative)


class Asks(ReachTask):
    """What the mutants below ask for; each changes a thing."""

    asked: ClassVar[type[Goal]]

    def goal(self, robot: Robot) -> Goal:
        return self.asked()


class Near(Goal):
    """Nothing is wrong with it: the end effector at the target."""

    error = "distance"
    aim = "position"

    def errors(self, now: Situation) -> Any:
        return np.linalg.norm(now.target - now.end_effector, axis=1)


class SoundGoal(Asks):
    """Nothing is wrong with it."""

    asked = Near


class NamesNoError(Asks):
    """Nobody learns what the numbers are."""

    class asked(Near):  # noqa: N801 (it stands for a field)
        """Without a name."""

        error = ""


class ShowsAndDoesNotSay(Asks):
    """The learner sees a number of which nobody knows what it is."""

    class asked(Near):  # noqa: N801
        """With one that is always 0."""

        def bounds(self) -> Any:
            return -np.ones(1), np.ones(1)

        def observe(self, now: Situation) -> Any:
            return np.zeros((len(now.step), 1))


class GoesBelowZero(Asks):
    """Beyond half a metre the sign is wrong."""

    class asked(Near):  # noqa: N801
        """As of a potential."""

        aim = None

        def errors(self, now: Situation) -> Any:
            errors = super().errors(now)
            return np.where(errors > 0.5, -errors, errors)


class MeasuresTheBatch(Asks):
    """An arm is a little farther where the others are far."""

    class asked(Near):  # noqa: N801
        """By a share of the mean."""

        aim = None

        def errors(self, now: Situation) -> Any:
            errors = super().errors(now)
            return 0.99 * errors + 0.01 * errors.mean()


class NeverThere(Asks):
    """A millimetre is left at the target."""

    class asked(Near):  # noqa: N801
        """Within epsilon nobody notices."""

        def errors(self, now: Situation) -> Any:
            return super().errors(now) + 1e-3


class ForgivesTheFar(Asks):
    """Who is too far away to come back is asked for nothing."""

    class asked(Near):  # noqa: N801
        """Beyond half a metre."""

        def errors(self, now: Situation) -> Any:
            errors = super().errors(now)
            return np.where(errors > 0.5, 0.0, errors)


class JumpsAway(Moving):
    """The target is elsewhere than where it was set."""

    def goal(self, robot: Robot) -> Any:
        return Jumping(self, robot, self.target_speed, self.control_period, self.steps_within)


class Jumping(MovingGoal):
    """By a step: it counts from 1."""

    def displacement(self, numbers: Any, step: Any) -> Any:
        return super().displacement(numbers, step + 1.0)


class MovesInSecret(Asks):
    """It says that its targets stay."""

    class asked(Near):  # noqa: N801
        """And would move them."""

        def displacement(self, numbers: Any, step: Any) -> Any:
            return 0.001 * np.repeat(step[:, None], 3, axis=1)


class ShowsMore(Asks):
    """What it shows is not cut off by itself."""

    class asked(Near):  # noqa: N801
        """The step, in [0, 1]."""

        observed = "the step (1)"

        def bounds(self) -> Any:
            return np.zeros(1), np.ones(1)

        def observe(self, now: Situation) -> Any:
            return now.step[:, None].copy()


MUTANTS = {
    NamesNoError: tasks.goals_are_described,
    ShowsAndDoesNotSay: tasks.goals_are_described,
    GoesBelowZero: tasks.errors_are_numbers,
    MeasuresTheBatch: tasks.errors_are_numbers,
    NeverThere: tasks.errors_are_zero_at_the_goal,
    ForgivesTheFar: tasks.errors_are_zero_at_the_goal,
    JumpsAway: tasks.targets_move_from_where_they_are_set,
    MovesInSecret: tasks.targets_move_from_where_they_are_set,
    ShowsMore: tasks.goals_show_numbers_in_their_bounds,
    TargetsOutOfReach: tasks.targets_can_be_reached,
    TargetsUnderground: tasks.targets_can_be_reached,
    RelativeTargetsUnderground: tasks.targets_can_be_reached,
    SpreadsItsTargets: tasks.targets_do_not_depend_on_the_count,
    HurriesItsTargets: tasks.targets_do_not_depend_on_the_count,
    Thawed: tasks.settings_are_frozen,
    SetUpWithASet: tasks.settings_survive_json,
    EndsInANumber: tasks.numbers_are_in_their_ranges,
    NeverSaysWhere: tasks.words_are_lines,
    NeedsAnotherArm: tasks.the_own_robot_passes,
    StartsAnywhere: tasks.starts_are_in_the_joint_ranges,
    StartsInSingle: tasks.starts_are_in_the_joint_ranges,
    FlagsInNumbers: tasks.targets_are_points,
    ForgetsTheStream: tasks.draws_depend_on_the_stream_alone,
    RemembersOnSelf: tasks.draws_depend_on_the_stream_alone,
    SaysItIsFixed: tasks.episodes_are_alike_where_it_says_so,
    PaysAll: tasks.target_rewards_are_one_per_pose,
    GoesTooFar: tasks.the_motion_takes_its_actions,
    SeesNothingNew: tasks.bounds_are_a_space,
    SeesBeyond: tasks.observations_are_in_their_bounds,
    SeesInOneArray: tasks.observing_changes_nothing,
    CountsLooks: tasks.observing_changes_nothing,
}


def failing(mutant: Callable[[], Any]) -> list[str]:
    """Names of the checks that a mutant fails."""
    return [violation.check for violation in violations(TASK_CHECKS, mutant(), ROBOT)]


def test_mutant_fails_one_check(subtests: pytest.Subtests):
    """A task that is broken in one way fails the check of that fact, and no other."""
    for mutant, check in MUTANTS.items():
        with subtests.test(mutant=mutant, check=check):
            assert failing(mutant) == [check.name]


def test_every_check_has_a_mutant():
    """No check is without a task that fails it alone."""
    assert set(MUTANTS.values()) == set(TASK_CHECKS)


@pytest.mark.parametrize("sound", [Sound, SoundGoal])
def test_the_mutants_are_made_of_a_sound_task(sound: type):
    """What the mutants are made of fails nothing."""
    assert failing(sound) == []
