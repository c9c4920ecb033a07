"""Evaluation apart from training: fixed starts and targets, the same in every cell."""

from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float32
from harness.conditions.conditions import conditions_of
from harness.conditions.varied_robot import Factors, draw_factors
from harness.env.arm_observation import kinematics_policy, why_not_kinematics
from harness.env.vector_env import ReachVectorEnv, World
from harness.errors import SimulationDiverged
from harness.eta.manner import ACTED_AT_RANDOM, DETERMINISTIC, Acted
from harness.policy import Policy
from harness.record.trace import COLUMN, SCALARS, EpisodeFacts, Recorder, Rows, TraceWriter
from harness.registry.sources import description
from harness.robot import Robot
from harness.robot.energy import least_work, read_bodies
from harness.task import Task, goal_of, varies

EVALUATION_SEED = 20_211_118
"""Seed of the starts and targets of every evaluation. It is not one of the small numbers that people train with."""

Act = Callable[[Float32], NDArray[Any]]


def evaluate(
    world: World,
    act: Callable[[], Act],
    episodes: int,
    path: Path,
    seed: int = EVALUATION_SEED,
    ik_steps: Sequence[int | None] | None = None,
    on_step: Callable[[], None] = lambda: None,
) -> None:
    """Let a policy do `episodes` episodes, one in each env, and record them.

    Args:
        world: Where.
        act: Makes what acts: observations (episodes, observation_size) to actions (episodes, action_size), or choices
            (episodes,). Each batch of envs has one of its own, so that all of them draw the same.
        episodes: How many.
        path: The trace to write: one episode of each env.
        seed: Of the starts and targets.
        ik_steps: What `ik_steps` says of them, or of more episodes; None where it is not asked.
        on_step: Called after every step of a batch.
    """
    facts, kept = facts_of(world.task, world.robot), KeptRows()
    facts = replace(facts, ik_steps=None if ik_steps is None else tuple(ik_steps[:episodes]))
    with ExitStack() as written:
        for batch in world.batches(episodes):
            with closing(world.open_part(batch, kept)) as env:
                if not batch.start:
                    sizes, extras = (env.robot.dof, env.episodes.action.shape[1]), env.episodes.extras
                    most = episodes * (1 + env.task.horizon)  # one file, since its facts are known at its end
                    writer = written.enter_context(TraceWriter(path, *sizes, facts, extras, part_rows=most))
                    written.callback(kept.hand_to, writer)
                play(env, act(), batch, episodes, seed, on_step)
        writer.facts = replace(facts, work=work_of(world, kept))


def play(
    env: ReachVectorEnv,
    act: Act,
    batch: slice,
    episodes: int,
    seed: int,
    on_step: Callable[[], None] = lambda: None,
    *,
    until_reached: bool = False,
) -> None:
    """Let a policy do the episodes of a batch.

    It acts for all episodes, so that it computes and draws the same, bit for bit, whatever the batches are.

    Args:
        env: The envs of the batch.
        act: See `evaluate`.
        batch: Which of the episodes they have.
        episodes: How many there are in all batches.
        seed: Of the starts and targets.
        on_step: Called after every step.
        until_reached: Whether an episode is over when it has reached its first target.
    """
    seen, _ = env.reset(seed=seed)
    running = np.ones(env.num_envs, bool)
    while running.any():
        if env.num_envs < episodes:
            all_seen = np.resize(seen, (episodes, *seen.shape[1:]))
            all_seen[batch], seen = seen, all_seen
        seen, _, terminated, truncated, infos = env.step(act(seen)[batch])
        running &= ~(terminated | truncated | (infos["is_success"] & until_reached))
        env.rest(~running)
        on_step()


def facts_of(task: Task, robot: Robot) -> EpisodeFacts:
    """The facts about a task's episodes that are known before any episode."""
    goal, facts = goal_of(task, robot), EpisodeFacts(task.horizon, task.control_period, arms=_arms(task, robot))
    return facts if goal is None else replace(facts, error=goal.error, unit=goal.unit, target_moves=goal.moves)


def _arms(task: Task, robot: Robot) -> tuple[Factors, ...] | None:
    conditions = conditions_of(task)
    if not conditions.is_varied:
        return None
    return tuple(draw_factors(conditions, robot, number) for number in range(conditions.variants))


def act_of(policy: Policy, acted: Acted) -> Act:
    """How `policy` acts in an evaluation. What it draws there does not depend on earlier draws."""
    if acted == DETERMINISTIC:
        return policy.act
    return partial(policy.act, rng=np.random.default_rng([EVALUATION_SEED, 1 if acted == ACTED_AT_RANDOM else 2]))


def record_evaluation(
    world: World,
    policy: Policy,
    acted: Acted,
    episodes: int,
    path: Path,
    seed: int | None = None,
    on_step: Callable[[], None] = lambda: None,
) -> None:
    """Write the trace of what `policy` does in a world, and how many steps the arm's own kinematics take there.

    Args:
        world: Where.
        policy: The policy that acts.
        acted: How; see `harness.experiment.world.CellWorld.evaluate`.
        episodes: How many. Where start and targets are always the same, the episodes of a deterministic policy are
            alike, and it does one.
        path: The trace to write.
        seed: Of the starts and targets; None for those of every evaluation.
        on_step: Called after every step of the batch.
    """
    act = partial(act_of, policy, acted)
    if seed is not None:
        evaluate(world, act, episodes, path, seed)
        return
    count = episodes if varies(world.task) or acted != DETERMINISTIC else 1
    steps = ik_steps(world, episodes, EVALUATION_SEED)
    evaluate(world, act, count, path, ik_steps=steps, on_step=on_step)


class KeptRows(list[Rows]):
    """A `Recorder` of the episodes of all batches, one after the other."""

    def append(self, rows: Rows) -> None:
        super().append(rows.copy())

    def hand_to(self, recorder: Recorder) -> None:
        """Tell another one all rows as if all envs were side by side: one step after the other, each by env."""
        for rows in sorted(self, key=lambda rows: float(rows[0, COLUMN["step"]])):
            recorder.append(rows)


def work_of(world: World, kept: Sequence[Rows]) -> tuple[float, ...] | None:
    """The work by env, [J]; None if the arm jumps from pose to pose, or if its links have no mass."""
    chain, jumps = world.robot.chain, world.task.motion(world.robot).jumps
    if jumps or (bodies := read_bodies(world.robot)) is None:
        return None
    columns = [COLUMN["env"], *range(len(SCALARS), len(SCALARS) + world.robot.dof)]
    rows = np.concatenate([rows[:, columns] for rows in kept])
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    episodes = np.split(rows[:, 1:], np.flatnonzero(np.diff(rows[:, 0])) + 1)
    return tuple(least_work(chain, bodies, qpos, world.task.control_period) for qpos in episodes)


def ik_steps(world: World, episodes: int, seed: int) -> tuple[int | None, ...] | None:
    """The environment steps to the first target, by env; None of an env where it is not reached.

    `harness.policy.inverse_kinematics` acts, in the same world and from the same starts. It does not look out for the
    ground: an episode that ends there has not reached its target.

    Args:
        world: Where.
        episodes: How many, one in each env of a batch.
        seed: Of the starts and targets.

    Returns:
        None where the kinematics cannot act, or the simulation diverges under them: that costs no cell.
    """
    if why_not_kinematics(world.task, world.robot):
        return None
    parts = (description(world.simulator), description(world.task), world.robot.driven_digest)
    return _answer(_Question(parts, episodes, seed, world))


@dataclass(frozen=True)
class _Question:
    """Everything that the answer depends on, and the world in which it is found, which adds nothing to that."""

    parts: tuple[str, ...]
    episodes: int
    seed: int
    world: World = field(compare=False)


@lru_cache(maxsize=16)
def _answer(question: _Question) -> tuple[int | None, ...] | None:
    """The answer. A process that does several cells computes it once."""
    world, episodes, seed = question.world, question.episodes, question.seed
    count = episodes if varies(world.task) else 1
    try:
        return _play(world, count, seed) * (episodes // count)
    except SimulationDiverged:
        return None


def _play(world: World, episodes: int, seed: int) -> tuple[int | None, ...]:
    policy, kept = kinematics_policy(world.task, world.robot), KeptRows()
    for batch in world.batches(episodes):
        with closing(world.open_part(batch, kept)) as env:
            play(env, policy.act, batch, episodes, seed, until_reached=True)
    at = [COLUMN["env"], COLUMN["step"]]
    reached = [rows[rows[:, COLUMN["reached"]] > 0.0][:, at].astype(int) for rows in kept]
    first = dict(np.concatenate(reached)[::-1].tolist())  # a decision may go on behind its first target
    return tuple(map(first.get, range(episodes)))
