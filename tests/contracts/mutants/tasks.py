"""Broken tasks."""

import time

import numpy as np
from pydantic.dataclasses import dataclass

from harness.motion.motion import Move, MoveJ
from harness.task import Goal, ReachTask, Targets
from tests.registered import FD100 as ROBOT, REGISTRY

from . import mutant

MOVING = REGISTRY.get("tasks", "fd100-moving").load()
Seen, MovingGoal = type(ReachTask().observation(ROBOT)), type(MOVING().goal(ROBOT))


@dataclass(frozen=True)
class SetUpWithASet(ReachTask):
    """JSON knows no sets."""

    zones: frozenset[int] = frozenset({1})


def of_another_arm(self, robot):
    """The task's own robot does not pass."""
    assert robot.name == "fd100"


def remembers(self, robot, rng):
    """Every second start is home."""
    object.__setattr__(self, "odd", not getattr(self, "odd", False))
    start = ReachTask.draw_start(self, robot, rng)
    return start if self.odd else robot.home.copy()


def starts(draw):
    """A task of other starts."""
    return mutant(
        ReachTask, draw_start=lambda self, robot, rng: draw(ReachTask.draw_start(self, robot, rng), robot, rng)
    )


def targets(change):
    """A task whose targets are changed after they were drawn."""
    return draws(lambda self, rng, count: Targets(*change(*ReachTask.draw_targets(self, ROBOT, rng, count))))


def draws(draw):
    """A task that draws its targets otherwise."""
    return mutant(ReachTask, draw_targets=lambda self, robot, rng, count: draw(self, rng, count))


def spread(self, rng, count):
    """Over a line: one alone is at its beginning."""
    rng.random(count)
    position = np.stack([np.full(count, 0.8), np.linspace(-0.2, 0.2, count), np.full(count, 0.7)], axis=1)
    return Targets(position, np.zeros(count, bool))


def hurried(self, rng, count):
    """The more targets there are to draw, the nearer they are."""
    position, relative = ReachTask.draw_targets(self, ROBOT, rng, count)
    return Targets(position - [0.1 / count, 0.0, 0.0], relative)


def below(self, rng, count):
    """It counts from the end effector what was drawn from the origin, downwards."""
    return Targets(np.array([[0.0, 0.0, -3.0]]) * rng.uniform(0.9, 1.0, (count, 1)), np.ones(count, bool))


class TooFar(MoveJ):
    """Full speed leads out of the joint ranges; it stays in them where nobody looks."""

    def advance(self, qpos, qvel, action):
        full = np.abs(action).max() == 1.0
        return Move((qpos + 10.0,), qvel) if full else super().advance(qpos, qvel, action)


def sees(**changed):
    """A task with another observation."""
    return mutant(
        ReachTask, observation=lambda self, robot: type("Mutant", (Seen,), changed)(robot, self.control_period)
    )


def one_more(array):
    """With a number that is always 0."""
    return np.concatenate([array, np.zeros_like(array[..., :1])], axis=-1)


def beyond(self, episodes):
    """The first number is the step."""
    seen = Seen.observe(self, episodes)
    seen[:, 0] = episodes.step
    return seen


def in_one_array(self, episodes):
    """Written over each time."""
    seen = Seen.observe(self, episodes)
    if self.kept is None:
        self.kept = seen
    self.kept[...] = seen
    return self.kept


def turning(self, episodes):
    """Each look is a price paid."""
    episodes.step_price -= 1.0
    return Seen.observe(self, episodes)


class Near(Goal):
    """The end effector at the target."""

    error = "distance"
    aim = "position"

    def errors(self, now):
        return np.linalg.norm(now.target - now.end_effector, axis=1)


def asks(**changed):
    """A task with another goal."""
    return mutant(ReachTask, goal=lambda self, robot: mutant(Near, **changed))


def errs(change, **changed):
    """A task whose errors are changed."""
    return asks(errors=lambda self, now: change(Near.errors(self, now)), **changed)


class Jumping(MovingGoal):
    """The target is elsewhere than where it was set: it counts from 1."""

    def displacement(self, numbers, step):
        return super().displacement(numbers, step + 1.0)


def jumping(self, robot):
    """The goal of a task whose target jumps away."""
    return Jumping(self, robot, self.target_speed, self.control_period, self.steps_within)


SOUND = (mutant(ReachTask), asks())
MUTANTS = {
    "set up with a set": ("settings-json", SetUpWithASet()),
    "names no error": ("task-goal-words", asks(error="")),
    "shows and does not say": (
        "task-goal-words",
        asks(bounds=lambda self: (-np.ones(1), np.ones(1)), observe=lambda self, now: np.zeros((len(now.step), 1))),
    ),
    "an error below zero": ("task-error", errs(lambda it: np.where(it > 0.5, -it, it), aim=None)),
    "an error of the batch": ("task-error", errs(lambda it: 0.99 * it + 0.01 * it.mean(), aim=None)),
    "never there": ("task-error-zero", errs(lambda it: it + 1e-3)),
    "forgives the far": ("task-error-zero", errs(lambda it: np.where(it > 0.5, 0.0, it))),
    "targets that jump away": ("task-goal-motion", mutant(MOVING, goal=jumping)),
    "targets that move in secret": (
        "task-goal-motion",
        asks(displacement=lambda self, numbers, step: 0.001 * np.repeat(step[:, None], 3, axis=1)),
    ),
    "shows the step": (
        "task-goal-observed",
        asks(
            observed="the step (1)",
            bounds=lambda self: (np.zeros(1), np.ones(1)),
            observe=lambda self, now: now.step[:, None].copy(),
        ),
    ),
    "targets out of reach": ("task-targets-in-reach", targets(lambda at, relative: (at * [3.0, 1.0, 1.0], relative))),
    "targets underground": ("task-targets-in-reach", targets(lambda at, relative: (at - [0.0, 0.0, 0.7], relative))),
    "targets that nobody reaches": (
        "task-all-targets-in-reach",
        targets(lambda at, relative: (at * [3.0, 1.0, 1.0], relative)),
    ),
    "slow": (
        "task-slow",
        starts(lambda start, *_: time.sleep(0.003) or start),
        "the start and the target of an episode take ",
    ),
    "relative targets underground": ("task-targets-in-reach", draws(below)),
    "spreads its targets": ("task-targets-count", draws(spread)),
    "hurries its targets": ("task-targets-count", draws(hurried)),
    "ends in a number": ("task-numbers", mutant(ReachTask, ends_at_target=1)),
    "never says where": ("task-words", mutant(ReachTask, start_in_words=lambda self, robot: "")),
    "needs another arm": ("task-own-robot", mutant(ReachTask, robot="unity-arm", check=of_another_arm)),
    "starts anywhere": (
        "task-starts",
        starts(lambda _, arm, rng: arm.home + (rng.random() > 0.9) * (arm.upper - arm.home + 0.1) * np.eye(arm.dof)[5]),
    ),
    "starts in single": ("task-starts", starts(lambda start, robot, rng: start.astype(np.float32))),
    "flags in numbers": ("task-targets", targets(lambda at, relative: (at, relative.astype(int)))),
    "forgets the stream": (
        "task-draws",
        starts(lambda start, robot, rng: robot.home + 0.01 * np.random.random(robot.dof)),
    ),
    "remembers on itself": ("task-draws", mutant(ReachTask, draw_start=remembers)),
    "says it is fixed": ("task-varies", mutant(ReachTask, varies=False)),
    "one reward for all": (
        "task-target-rewards",
        mutant(ReachTask, target_rewards=lambda self, *_: np.full(1, self.target_reward)),
    ),
    "goes too far": (
        "task-motion",
        mutant(ReachTask, motion=lambda self, robot: TooFar(ReachTask.motion(self, robot).limits)),
    ),
    "sees nothing new": (
        "task-bounds",
        sees(
            low=property(lambda self: one_more(Seen.low.fget(self))),
            high=property(lambda self: one_more(Seen.high.fget(self))),
            observe=lambda self, episodes: one_more(Seen.observe(self, episodes)),
        ),
    ),
    "sees beyond": ("task-observations", sees(observe=beyond)),
    "sees in one array": ("task-observing", sees(observe=in_one_array, kept=None)),
    "counts looks": ("task-observing", sees(observe=turning)),
}
