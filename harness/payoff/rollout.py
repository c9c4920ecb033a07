"""What scripted movements do, what a reward pays them, and whether reaching the target pays best."""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import chdir, closing
from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import islice
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Float32, Mask, read_only
from harness.env.vector_env import ReachVectorEnv, World
from harness.errors import SimulationDiverged, UsageError, sentence
from harness.experiment.arm_evaluation import EVALUATION_SEED
from harness.files.plain import tells
from harness.log.log import is_countable, sums_from, uncountable_text
from harness.motion.motion import JointLimits, MoveJ
from harness.reward import (
    Carry,
    Paid,
    Reward,
    Steps,
    pay,
)
from harness.reward.steps import ARM_BEFORE, DISTANCE, ENDS, step_between
from harness.reward.terms import Unpaid, paid_twice, paid_twice_text, require_one_each, require_same
from harness.robot import Robot
from harness.robot.kinematics import reach_position
from harness.simulator import Simulator
from harness.task import Task, goal_of
from harness.text import number

FINISH, HOVER, CREEP, OSCILLATE, HOLD, RANDOM = SCRIPTS = ("finish", "hover", "creep", "oscillate", "hold", "random")

STOPS = MappingProxyType(
    {FINISH: (0.0, 0.0), HOVER: (1.2, 1.2), CREEP: (1.2, 1.1), OSCILLATE: (1.2, 2.4), HOLD: (math.inf, math.inf)}
)
"""Where a script goes first and where then, as distances to the target in units of epsilon.

``oscillate`` goes back and forth between the two; ``creep`` takes all the time there is from one to the other, so that
it comes nearer at every step and never arrives.
"""


class NoScriptsError(UsageError):
    """The scripted policies cannot do a task; the message says why, and what to ask instead."""


@dataclass(frozen=True, eq=False)
class JointPath:
    """Straight in joint space from a start (0) to a goal (1), for n arms at once.

    Attributes:
        robot: The arm.
        start: Joint positions at 0, (n, dof), [rad].
        change: From there to the goal, (n, dof), [rad].
        target: World frame, (n, 3), [m].
    """

    robot: Robot
    start: Float
    change: Float
    target: Float

    def distance(self, along: Float) -> Float:
        """End effector to target at the places `along`, (..., n), each in [0, 1]; [m]."""
        tip = self.robot.end_effector(self.start + along[..., None] * self.change)
        return np.asarray(np.linalg.norm(self.target - tip, axis=-1))

    def first_within(self, radius: float) -> Float:
        """The last place before the path first comes within `radius` [m] of the target, (n,); 1 where it never does."""
        grid = np.linspace(0.0, 1.0, 201)
        within = self.distance(np.repeat(grid[:, None], len(self.start), axis=1)) <= radius
        first = np.where(within.any(axis=0), within.argmax(axis=0), len(grid) - 1)
        low, high = grid[np.maximum(first - 1, 0)], grid[first]
        for _ in range(30):
            middle = (low + high) / 2.0
            inside = self.distance(middle) <= radius
            low, high = np.where(inside, low, middle), np.where(inside, middle, high)
        return np.where(within.any(axis=0), low, 1.0)


def plan_actions(
    script: str, robot: Robot, task: Task, start: Float, target: Float, rng: np.random.Generator
) -> Float32:
    """Actions of a whole episode.

    Args:
        script: One of `SCRIPTS`.
        robot: The arm.
        task: Its motion turns actions into joint targets; its horizon is the length.
        start: Joint positions at rest, (n, dof), [rad].
        target: World frame, (n, 3), [m].
        rng: What ``random`` draws from.

    Returns:
        Joint speeds as fractions of their maxima, (horizon, n, dof), in [-1, 1].

    Raises:
        NoScriptsError: The task's actions are no joint speeds.
    """
    motion = task.motion(robot)
    if not isinstance(motion, MoveJ):
        raise NoScriptsError("The scripted policies of an audit move joints: name a task with action=movej")
    if script == RANDOM:
        return rng.uniform(-1.0, 1.0, (task.horizon, *start.shape)).astype(np.float32)
    path = JointPath(robot, start, _pose_at(robot, target, start) - start, target)
    places = {stop: path.first_within(stop * task.epsilon) for stop in {*STOPS[script]}}
    first, second = map(places.__getitem__, STOPS[script])
    speeds = _speeds_along(path, motion.limits, first, second, task.horizon)
    actions: Float32 = (speeds[:, :, None] * path.change / motion.limits.max_speed).astype(np.float32)
    return actions


def _pose_at(robot: Robot, target: Float, start: Float) -> Float:
    """Joint positions at the target, (n, dof): near the start's where the search from there succeeds."""
    near, found = reach_position(robot, target, start)
    other, _ = reach_position(robot, target, np.tile(robot.home, (len(start), 1)))
    return np.where(found[:, None], near, other)


def _speeds_along(path: JointPath, limits: JointLimits, first: Float, second: Float, steps: int) -> Float:
    """Speeds along the path, (steps, n), [1/s]: at full speed to the place `first`, on to `second`, and back again.

    Where `second` is behind, at full speed too; where it is ahead, so slowly that it is not reached.
    """
    there = _limits_along(path, limits, np.zeros_like(first), first)
    on = _limits_along(path, limits, np.minimum(first, second), np.maximum(first, second))
    creep = (second - first) / ((steps + 1) * limits.period)
    wanted = np.where(second > first, np.minimum(creep, on.max_speed), -on.max_speed)
    place = speed = np.zeros((1, len(first)))
    going_there = np.ones(place.shape, bool)
    speeds = np.empty((steps, len(first)))
    for step in range(steps):
        legs = there.advance(place, speed, there.max_speed[None]), on.advance(place, speed, wanted[None])
        place, speed = (np.where(going_there, one, other) for one, other in zip(*legs, strict=True))
        speeds[step] = speed
        going_there ^= np.abs(speed) <= 1e-9 * there.max_speed  # it has stopped: at an end
    return speeds


def _limits_along(path: JointPath, limits: JointLimits, lower: Float, upper: Float) -> JointLimits:
    """The arm's limits as those of one number, the place on the path; the n arms take the place of joints.

    On the path all joints keep step, so the one that is nearest to a limit sets the pace.
    """
    size = np.maximum(np.abs(path.change), 1e-9)
    speed, change = (limits.max_speed / size).min(axis=1), (limits.max_change / size).min(axis=1)
    return JointLimits(lower, upper, speed, change, limits.period)


States: TypeAlias = Mapping[str, NDArray[Any]]
"""What n arms were like before the first step and after each one, by the names of `harness.reward.steps.ARM`, (steps +
1, n, ...); ``distance`` is always there."""


@dataclass(frozen=True, eq=False)
class Rollout:
    """What one script did in n episodes; no reward enters.

    Attributes:
        script: Its name.
        states: What the arms were like, row 0 at the start; the action is that of the step before. An arm whose
            episode has ended goes on until the last one's has.
        events: What the task pays at each step, (steps, n); 0 after an episode's end.
        running: Whether the step belongs to the episode, (steps, n).
        reached: Whether the episode ended at the target, (n,).
    """

    script: str
    states: States
    events: Float
    running: Mask
    reached: Mask

    @property
    def distances(self) -> Float:
        """End effector to target, (steps + 1, n), [m]; row 0 is the begin distance."""
        return self.states["distance"]

    @property
    def steps(self) -> Float:
        """How long each episode was, (n,)."""
        return np.asarray(self.running.sum(axis=0), np.float64)


def record_rollouts(
    simulator: Simulator, robot: Robot, task: Task, episodes: int, noise: float = 0.0
) -> tuple[Rollout, ...]:
    """One rollout of each of `SCRIPTS`; see `rollouts_by_noise`."""
    return rollouts_by_noise(simulator, robot, task, episodes, (noise,))[0]


def rollouts_by_noise(
    simulator: Simulator, robot: Robot, task: Task, episodes: int, noises: Sequence[float]
) -> list[tuple[Rollout, ...]]:
    """For each noise, one rollout of each of `SCRIPTS`, in their order, which are planned once.

    Starts and targets are those of every evaluation.

    Args:
        simulator: Moves the arms.
        robot: The arm.
        task: What it has to do.
        episodes: Of each script.
        noises: Standard deviations of what is added to every action, before it is clipped to [-1, 1].

    Raises:
        UsageError: The robot cannot do the task; a `NoScriptsError` if only the scripts cannot.
        SimulationDiverged: The engine left the finite numbers.
    """
    task.check(robot)
    goal = goal_of(task, robot)
    if goal is not None:
        raise NoScriptsError(
            "The scripted policies of an audit go to points that do not move, and this task asks for more (its error: "
            f"{goal.error}). Audit the reward on fd100-reach, whose steps have the same fields"
        )
    world = World(simulator, robot, task, Unpaid())
    parts = world.batches(episodes)
    begun = list[tuple[Float, Float]]()
    for batch in parts:
        with closing(world.open_part(batch)) as env:
            env.reset(seed=EVALUATION_SEED)
            begun.append((env.simulation.read().qpos.copy(), env.episodes.target.copy()))
    start, target = map(np.concatenate, zip(*begun, strict=True))
    planned = list[tuple[Float32, Float32]]()
    for script in SCRIPTS:
        rng = np.random.default_rng([EVALUATION_SEED, 2])
        actions = plan_actions(script, robot, task, start, target, rng)
        planned.append((actions, rng.standard_normal(actions.shape, np.float32)))
    disturbed = [np.clip(of + noise * by, -1.0, 1.0) if noise else of for noise in noises for of, by in planned]
    found = list[list[States]]()
    for batch in parts:
        with closing(world.open_part(batch)) as env:
            found.append([_record(env, actions[:, batch], parts[1:]) for actions in disturbed])
    each = map(_joined, SCRIPTS * len(noises), zip(*found, strict=True))
    return [tuple(islice(each, len(SCRIPTS))) for _ in noises]


def _record(env: ReachVectorEnv, actions: Float32, others: Sequence[slice]) -> States:
    """What envs do and are paid; to the horizon where episodes of `others` may be longer."""
    env.reset(seed=EVALUATION_SEED)
    running, nothing = np.ones(env.num_envs, bool), np.zeros(env.num_envs)
    steps = [
        {**_state(env), "events": nothing, "running": running, **dict.fromkeys(("reached", *ENDS), ~running)},
    ]
    for action in actions:
        _, paid, *ended, infos = env.step(action)
        target = env.episodes.steps.before.target.copy()  # that of the step; a task that goes on has set the next one
        told = {"target": target, "distance": infos["distance"], "events": np.where(running, paid, 0.0)}
        told |= zip(ENDS, ended, strict=True)
        steps.append({**_state(env), **told, "running": running, "reached": running & infos["is_success"]})
        running = running & ~np.logical_or(*ended)
        if not (others or running.any()):
            break
    return {name: np.stack([of[name] for of in steps]) for name in steps[0]}


def _joined(script: str, parts: Sequence[States]) -> Rollout:
    """The episodes of all batches, until the last one's has ended."""
    states = {name: np.concatenate([of[name] for of in parts], axis=1) for name in parts[0]}
    last = int(states["running"].any(axis=1).sum())
    events, running, reached = (states.pop(name)[1:last] for name in ("events", "running", "reached"))
    return Rollout(
        script, {name: it[:last] for name, it in states.items()}, events, running, np.asarray(reached.any(axis=0))
    )


def _state(env: ReachVectorEnv) -> dict[str, NDArray[Any]]:
    """What the arms are like now; copies."""
    return {name: getattr(env.episodes, name).copy() for name in ARM_BEFORE}


def steps_along(states: States) -> Iterator[Steps]:
    """The steps of episodes that go through these states; as the env tracks them."""
    distances = states[DISTANCE]
    best = np.minimum.accumulate(distances, axis=0)
    rows = [{name: values[row] for name, values in states.items()} for row in range(len(distances))]
    for step in range(1, len(distances)):
        count = np.full(distances.shape[1], float(step))
        yield step_between(rows[step - 1], rows[step], distances[0], best[step - 1], count)


def paid_along(reward: Reward, states: States) -> Iterator[tuple[Carry, Paid]]:
    """What is remembered before each step of episodes that go through these states, and what it is paid.

    Raises:
        UsageError: The reward reads what the states do not have, pays no number an arm, or its terms change.
    """
    states = {name: read_only(values) for name, values in states.items()}  # other rewards are paid by them too
    carry, names = reward.initial_carry(states[DISTANCE][0]), None
    for step in steps_along(states):
        with np.errstate(all="ignore"):  # a reward may divide by anything where it then takes another value
            remembered, paid = pay(reward, carry, step)
        require_one_each(paid, len(step.begin_distance))
        names = tuple(paid.terms) if names is None else names
        require_same(names, paid.terms)
        yield carry, paid
        carry = remembered


def pay_along(reward: Reward, states: States) -> Paid:
    """Shaped reward of every step and its terms, (steps, n); may hold NaN and infinities. See `paid_along`."""
    with chdir("."):  # the reward may change it
        totals, terms = zip(*(paid for _, paid in paid_along(reward, states)), strict=True)
    return Paid(_stacked(totals), {name: _stacked([of[name] for of in terms]) for name in terms[0]})


def pay_distances(reward: Reward, distances: Float) -> Float:
    """What a reward pays for made-up distances, (steps + 1, n), [m]; as `pay_along`."""
    total: Float = pay_along(reward, {DISTANCE: distances}).total
    return total


def discounted_sum(values: Float, gamma: float) -> Float:
    """Sum over steps of gamma^t values(t), t from 0; (steps, n) to (n,)."""
    steps, count = values.shape
    return sums_from(np.arange(count) * steps, values.T.ravel(), gamma)


@dataclass(frozen=True, eq=False)
class Score:
    """A rollout as one reward pays it.

    Attributes:
        rollout: What was done.
        values: Shaped reward, (steps, n); 0 after an episode's end.
        terms: What each of its terms paid, the same.
    """

    rollout: Rollout
    values: Float
    terms: Mapping[str, Float]

    @cached_property
    def paid(self) -> Float:
        """Shaped reward and event terms, (steps, n)."""
        return self.values + self.rollout.events


def score_rollout(reward: Reward, rollout: Rollout) -> Score:
    """What the reward would have paid during the rollout.

    Raises:
        SimulationDiverged: It pays something that is not finite, or so much that nothing can be counted with it.
        UsageError: It reads what no step of an arm has, or its terms are none.
    """
    paid = pay_along(reward, rollout.states)
    *terms, values = (np.where(rollout.running, of, 0.0) for of in (*paid.terms.values(), paid.total))
    for name, of in zip((*(f"the term '{name}'" for name in paid.terms), "the reward"), (*terms, values), strict=True):
        wrong = ~is_countable(of)
        if wrong.any():
            step, episode = np.argwhere(wrong)[0]
            told = uncountable_text(of[step, episode])
            raise SimulationDiverged(f"{name} pays '{rollout.script}' {told}, at step {step + 1}")
    return Score(rollout, values, dict(zip(paid.terms, terms, strict=True)))


def _stacked(values: Any) -> Float:
    return np.stack([np.asarray(value, np.float64) for value in values])


SLACK = 1e-9
"""Returns that differ by no more than this share of the largest are equal."""


NOISE, MARGIN = 0.05, 0.05
"""With noise of this standard deviation on every action, something else has to earn more than finishing by this share
of all that is earned."""
ROBUST, FRAGILE = "ROBUST", "FRAGILE"
"""Whether what pays more than doing the task still does with noise on the actions."""


@dataclass(frozen=True)
class Payoff:
    """Means over the episodes of one script.

    Attributes:
        policy: The script.
        success: Share of episodes that ended at the target.
        steps: Length of an episode.
        shaped: Sum of the shaped reward of an episode.
        total: The same with the event terms.
        shaped_discounted: The sum of gamma^t times the shaped reward.
        total_discounted: The same with the event terms.
        terms: The sum of what each term of the reward paid in an episode, in their order; none if it has none.
    """

    policy: str
    success: float
    steps: float
    shaped: float
    total: float
    shaped_discounted: float
    total_discounted: float
    terms: Mapping[str, float]

    def to_json(self) -> dict[str, Any]:
        """Plain data; a reward without terms has none there."""
        return {name: value for name, value in asdict(self).items() if name != "terms" or value}


@tells("policy", "gamma", "earns", "finish_earns", "share", "margin")
@dataclass(frozen=True)
class Temptation:
    """A policy that does not finish and earns more than the one that does, event terms included.

    Attributes:
        policy: The script.
        gamma: Discount per step.
        earns: Its mean return.
        finish_earns: That of ``finish``.
        share: Of the episodes in which it earns more.
    """

    policy: str
    gamma: float
    earns: float
    finish_earns: float
    share: float

    @property
    def margin(self) -> float:
        """By how much it earns more."""
        return self.earns - self.finish_earns


@dataclass(frozen=True)
class Finishing:
    """What a reward pays the scripted policies, and whether finishing is what pays.

    Attributes:
        gamma: Discount of the discounted figures.
        payoffs: One of each scripted policy, the best return first.
        undiscounted: What pays more than finishing, without discount.
        discounted: The same with it.
        holding_pays: Whether standing still at the start does, by more than nothing, discounted or not.
        steps: How many steps the policies took in all.
        never_paid: The terms that paid nothing in any of them.
        paid_twice: The term that is the sum of all others in all of them; empty if there is none.
    """

    gamma: float
    payoffs: tuple[Payoff, ...]
    undiscounted: tuple[Temptation, ...]
    discounted: tuple[Temptation, ...]
    holding_pays: bool
    steps: int
    never_paid: tuple[str, ...]
    paid_twice: str


def finishing_of(scores: Sequence[Score], gamma: float) -> Finishing:
    """What a reward pays for.

    Args:
        scores: What it paid in one rollout of each script.
        gamma: The learner's discount per step, in (0, 1].
    """
    payoffs = [payoff_of(score, gamma) for score in scores]
    hold = next(payoff for payoff in payoffs if payoff.policy == HOLD)
    largest = max(max(abs(payoff.shaped), abs(payoff.shaped_discounted)) for payoff in payoffs)
    return Finishing(
        gamma,
        tuple(sorted(payoffs, key=lambda payoff: -payoff.total)),
        tuple(temptations(scores, 1.0)),
        tuple(temptations(scores, gamma)),
        max(hold.shaped, hold.shaped_discounted) > 1e-3 * largest,
        sum(int(score.rollout.running.sum()) for score in scores),
        tuple(name for name in scores[0].terms if not any(it.terms[name].any() for it in scores)),
        paid_twice({name: np.concatenate([it.terms[name].ravel() for it in scores]) for name in scores[0].terms}),
    )


def payoff_of(score: Score, gamma: float) -> Payoff:
    """The means of a scored rollout."""
    rollout = score.rollout
    return Payoff(
        rollout.script,
        float(rollout.reached.mean()),
        float(rollout.steps.mean()),
        shaped=_mean_return(score.values, 1.0),
        total=_mean_return(score.paid, 1.0),
        shaped_discounted=_mean_return(score.values, gamma),
        total_discounted=_mean_return(score.paid, gamma),
        terms={name: _mean_return(values, 1.0) for name, values in score.terms.items()},
    )


def temptations(scores: Sequence[Score], gamma: float) -> list[Temptation]:
    """The scripts that reach the target less often than ``finish`` and earn more, the best first."""
    returns = {score.rollout.script: discounted_sum(score.paid, gamma) for score in scores}
    success = {score.rollout.script: score.rollout.reached.mean() for score in scores}
    finish = returns[FINISH]
    slack = SLACK * max(np.abs(values).mean() for values in returns.values())
    found = [
        Temptation(name, gamma, float(earned.mean()), float(finish.mean()), float((earned > finish + slack).mean()))
        for name, earned in returns.items()
        if success[name] < success[FINISH] and earned.mean() > finish.mean() + slack
    ]
    return sorted(found, key=lambda temptation: -temptation.margin)


def _mean_return(values: Float, gamma: float) -> float:
    return float(discounted_sum(values, gamma).mean())


def on_finishing(of: Finishing) -> str:
    """Whether finishing is what pays; rests on the discounted return, which is what a learner is after."""
    rate, plain, discounted = f"discounted by {of.gamma:g}", of.undiscounted, of.discounted
    if plain and discounted:
        told = f"{_compare(plain[0])}; {rate} {_compare(discounted[0])}"
        return f"Not finishing pays more than finishing: {told}."
    if discounted:
        return f"Not finishing pays more than finishing: {rate} {_compare(discounted[0])}; without discount less."
    if plain:
        return f"Finishing pays most {rate}; without discount it does not: {_compare(plain[0])}."
    finish = next(payoff for payoff in of.payoffs if payoff.policy == FINISH)
    others = [payoff for payoff in of.payoffs if payoff.success < finish.success]
    beside = f", {others[0].policy} {number(others[0].total)}" if others else ""
    return f"Finishing pays most: finish earns {number(finish.total)} per episode{beside}."


def on_noise(of: Finishing, disturbed: Finishing) -> str:
    """Whether what pays more than finishing still does while actions are disturbed; asked only if something does.

    Args:
        of: What the scripts earn.
        disturbed: What they earn with noise of `NOISE` on their actions.
    """
    plain, noisy = (
        {it.policy: it.total if of.undiscounted else it.total_discounted for it in found.payoffs}
        for found in (of, disturbed)
    )
    margin = MARGIN * (max(plain.values()) - min(plain.values()))
    best = max((it.policy for it in of.undiscounted or of.discounted), key=noisy.__getitem__)
    rate = "" if of.undiscounted else f", discounted by {of.gamma:g}"
    told = f"{best} earns {number(noisy[best])} per episode{rate}, finish {number(noisy[FINISH])}"
    if noisy[best] > noisy[FINISH] + margin:
        return f"{ROBUST}: with action noise {NOISE:g} {told}. A learner may well find that."
    return f"{FRAGILE}: with action noise {NOISE:g}, as while it explores, {told}. A learner may finish all the same."


def on_terms(of: Finishing) -> list[str]:
    """A line for each term that paid nothing in all these steps of the scripted policies, and for one that is a sum."""
    told = [f"The term '{name}' never paid in {of.steps:,} steps." for name in of.never_paid]
    return [*told, *([f"{sentence(paid_twice_text(of.paid_twice, of.steps))}."] if of.paid_twice else [])]


def _compare(temptation: Temptation) -> str:
    return (
        f"{temptation.policy} earns {number(temptation.earns)} per episode, finish {number(temptation.finish_earns)}"
        f" (more in {temptation.share:.0%} of the episodes)"
    )
