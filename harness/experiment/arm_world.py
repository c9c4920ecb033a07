"""An arm in a simulator, as a cell trains in it; see `harness.experiment.world.CellWorld`."""

import time
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from harness.algorithm import Algorithm, TrainingEnv
from harness.arrays import Float
from harness.env import ReachVectorEnv
from harness.env.solid_probes import require_solids
from harness.env.vector_env import World, build_world
from harness.eta.manner import Acted
from harness.executor import NO_SCALARS
from harness.experiment.arm_evaluation import facts_of, record_evaluation
from harness.experiment.checkpoints.checkpoint import Attempt
from harness.experiment.checkpoints.trace_parts import TraceParts
from harness.experiment.provenance import describe_environment
from harness.experiment.trials.tried import Tried
from harness.experiment.workers.order import TELL_EVERY, Beat, Report, named_scalars
from harness.log import Log
from harness.log.log import OpenEpisodes
from harness.policy import Policy
from harness.progress import LAST_EPISODES, RETURN, SPEED, SUCCESS, TERMS, TrainingState
from harness.record.blocks import BEHAVIOUR, OWN, Blocks, read_blocks
from harness.record.cell import Cell
from harness.record.folder import SUFFIX, TRACE
from harness.record.returns import PAID, mean_over_episodes, mean_return
from harness.record.scene import write_scene
from harness.record.trace import COLUMN, SCALARS, TERM, Recorder, Rows, read_trace, terms_of
from harness.registry.choice import Choice
from harness.registry.registry import Registry
from harness.robot import Robot
from harness.robot.robot import load_robot
from harness.scene.scene import scene_of


class ArmWorld:
    """Leaves traces."""

    suffix = SUFFIX

    def __init__(self, cell: Cell, registry: Registry, report: Report) -> None:
        """Build nothing yet; see `harness.experiment.world.world_of`."""
        self._cell, self._registry, self._beat = cell, registry, Beat(report)
        self._env: ReachVectorEnv
        self._learning: LearningSoFar | None = None
        self._parts: TraceParts | None = None
        self._folder: Path | None = None

    @cached_property
    def runs_on(self) -> Mapping[str, Any]:
        return describe_environment(self._cell, self._robot, self._registry)

    @cached_property
    def _robot(self) -> Robot:
        return load_robot(self._cell.robot, self._registry)

    @cached_property
    def _world(self) -> World:
        return build_world(self._cell, self._robot, self._registry)

    def build(self, algorithm: Algorithm) -> Mapping[str, Any]:
        """See `CellWorld`: what the task measures, if that is no distance. The env is opened, to be restored."""
        require_solids(self._cell.simulator.label, self._world.simulator, self._robot, self._registry)
        self._env = self._world.open(algorithm.num_envs, resumable=True)
        goal = self._env.episodes.goal
        return {} if goal is None else {"error": goal.error, "unit": goal.unit}

    def restore(self, state: TrainingState) -> None:
        self._env.restore(state)

    @contextmanager
    def training(self, attempt: Attempt) -> Iterator[TrainingEnv]:
        env, path = self._env, attempt.folder / TRACE
        try:
            sizes, facts = (env.robot.dof, env.episodes.action.shape[1]), facts_of(env.task, env.robot)
            with TraceParts(path, *sizes, facts, attempt.parts, env.episodes.extras) as self._parts:
                terms = [name.removeprefix(TERM) for name in env.episodes.extras if name.startswith(TERM)]
                before = read_blocks(attempt.folder) if attempt.begun_from else None
                self._folder = attempt.folder
                env.recorder = self._learning = LearningSoFar(self._parts, attempt.begun_from, before, terms=terms)
                yield env
        finally:
            env.close()

    def learned(self, steps: int, *, if_due: bool = False) -> Mapping[str, float]:
        if self._learning is None or self._folder is None:
            return NO_SCALARS
        told = self._learning.scalars_if_due(steps) if if_due else self._learning.scalars(steps)
        if told:
            self._learning.blocks.write(self._folder)
        return told

    def kept(self) -> tuple[TrainingState, Sequence[str]] | None:
        """See `CellWorld`: the trace so far is finished, as a part."""
        if self._parts is None:
            return None
        self._parts.cut()
        return self._env.state(), self._parts.digests

    def evaluate(
        self, policy: Policy, acted: Acted, episodes: int, path: Path, *, after: int = 0, seed: int | None = None
    ) -> None:
        """See `CellWorld`: all episodes side by side."""
        now = after or self._cell.steps
        record_evaluation(self._world, policy, acted, episodes, path, seed, lambda: self._beat(now))

    def try_out(self, rewards: Sequence[Choice], without: Collection[str], tell: Callable[[str], None]) -> Tried:
        """See `CellWorld`: by an arm whose joints are where they are told to be."""
        from harness.experiment.trials.arm_trial import try_arm

        return try_arm(self._cell, rewards, self._registry, without, tell)

    def scalars(self, path: Path) -> dict[str, float]:
        return evaluation_scalars(read_trace(path), self._registry)

    def finish(self, folder: Path) -> Sequence[str]:
        """See `CellWorld`: what the arm looks like."""
        write_scene(scene_of(self._robot), folder)
        return ()


def evaluation_scalars(trace: Log, registry: Registry) -> dict[str, float]:
    """The return and its terms, and all metrics, such as ``Evaluation/Success Rate``; what is not known is left out."""
    # Most runs have no tracker: their processes start without what reads results.
    from harness.results.measured import measure
    from harness.results.metrics import load_metrics

    terms = {name: mean_over_episodes(values, trace) for name, values in terms_of(trace).items()}
    return named_scalars(mean_return(trace), measure(load_metrics(registry), trace), terms)


ENV, EPISODE, STEP = (COLUMN[name] for name in ("env", "episode", "step"))
PAYMENTS = [COLUMN[name] for name in PAID]
REACHED, ENDS = COLUMN["reached"], [COLUMN["terminated"], COLUMN["truncated"]]


class LearningSoFar:
    """A `Recorder` that hands every row on, and knows what the last `LAST_EPISODES` episodes came to.

    A step costs a copy of its rows. They are added up when somebody asks, or when there are `BLOCK` of them.
    Episodes that were under way when a killed training went on are left out.

    Attributes:
        blocks: What all episodes came to, as far as rows were added up.
    """

    BLOCK = 4096

    def __init__(
        self,
        recorder: Recorder,
        begun_from: int = 0,
        before: Blocks | None = None,
        now: Callable[[], float] = time.monotonic,
        terms: Sequence[str] = (),
    ) -> None:
        """Start before any episode has ended.

        Args:
            recorder: Gets the rows.
            begun_from: Environment steps that were done before.
            before: What the episodes of these steps came to.
            now: The time, [s].
            terms: Of the reward, whose columns end each row.
        """
        self._recorder, self._now, self._terms = recorder, now, [f"{TERMS}/{name}" for name in terms]
        self._block, self._filled = np.empty((self.BLOCK, len(SCALARS) + len(terms))), 0
        # Of each episode that goes on: its numbers as `Blocks` has them, and whether its start was seen.
        self._open = OpenEpisodes.none(OWN + len(terms) + 1)
        self._ended: deque[Float] = deque(maxlen=LAST_EPISODES)
        self._steps, self._told, self._taken = begun_from, now(), begun_from
        self.blocks = before.until(begun_from) if before and before.terms == tuple(terms) else Blocks.none(terms)

    def append(self, rows: Rows) -> None:
        self._recorder.append(rows)
        for first in range(0, len(rows), self.BLOCK):
            part = rows[first : first + self.BLOCK]
            if self._filled + len(part) > self.BLOCK:
                self._add_up()
            place = self._block[self._filled : self._filled + len(part)]
            place[:, : len(SCALARS)] = part[:, : len(SCALARS)]
            if self._terms:
                place[:, len(SCALARS) :] = part[:, -len(self._terms) :]
            self._filled += len(part)

    def scalars_if_due(self, steps: int) -> Mapping[str, float]:
        """`scalars`, once in `TELL_EVERY` seconds; else nothing."""
        return self.scalars(steps) if self._now() >= self._told + TELL_EVERY else NO_SCALARS

    def scalars(self, steps: int) -> dict[str, float]:
        """The scalars after `steps`, by the names of `harness.progress`; empty if they were reported before."""
        if steps == self._steps:
            return {}
        self._add_up()
        now = self._now()
        found = {}
        if now > self._told:
            found[SPEED] = (steps - self._steps) / (now - self._told)
        self._steps, self._told = steps, now
        if self._ended:
            found |= zip([RETURN, SUCCESS, *self._terms], np.mean(self._ended, axis=0).tolist(), strict=True)
        return found

    def _add_up(self) -> None:
        rows = self._block[: self._filled]
        self._filled = 0
        paid, terms = rows[:, PAYMENTS].sum(axis=1), rows[:, len(SCALARS) :].T
        summed = [paid, rows[:, REACHED], *terms, rows[:, STEP] == 0]
        self._open, ends, sums = self._open.after(
            rows[:, ENV], rows[:, EPISODE], np.logical_or.reduce(rows[:, ENDS].T), summed
        )
        steps = self._taken + np.cumsum(rows[:, STEP] > 0)  # a start is no step
        self._taken = int(steps[-1]) if len(steps) else self._taken
        sums[BEHAVIOUR] = sums[BEHAVIOUR] > 0
        *numbers, is_whole = sums
        ended = np.array(numbers).T[is_whole > 0]
        self._ended.extend(ended)
        self.blocks = self.blocks.followed_by(steps[ends[is_whole > 0]], ended)
