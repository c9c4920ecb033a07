"""An arm in a simulator, as a cell trains in it; see `harness.experiment.world.CellWorld`."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from harness.algorithm import Algorithm
from harness.arrays import Float
from harness.env.solid_probes import require_solids
from harness.env.vector_env import ReachVectorEnv, World, build_world
from harness.eta.manner import Acted
from harness.experiment.arm_evaluation import facts_of, record_evaluation
from harness.experiment.checkpoints.checkpoint import Attempt
from harness.experiment.trials.tried import Tried
from harness.experiment.workers.order import named_scalars
from harness.experiment.world import CellWorld, LastEpisodes
from harness.log import Log
from harness.policy import Policy
from harness.record.folder import SUFFIX, TRACE
from harness.record.progress import TERMS
from harness.record.scene import write_scene
from harness.record.trace import (
    COLUMN,
    INTEGERS,
    PAID,
    TERM,
    Recorder,
    Rows,
    TraceWriter,
    mean_over_episodes,
    mean_return,
    read_trace,
    terms_of,
)
from harness.registry.choice import Choice, Registry
from harness.reward.steps import ENDS
from harness.robot import Robot
from harness.robot.robot import load_robot
from harness.scene.scene import scene_of


class ArmWorld(CellWorld):
    """Leaves traces."""

    suffix = SUFFIX
    _env: ReachVectorEnv
    _learning: "LearningSoFar"
    _writer: TraceWriter

    @cached_property
    def _robot(self) -> Robot:  # type: ignore[override]
        return load_robot(self._cell.robot, self._registry)

    @cached_property
    def _world(self) -> World:
        return build_world(self._cell, self._robot, self._registry)

    def build(self, algorithm: Algorithm) -> Mapping[str, Any]:
        """See `CellWorld`: what the task measures, if that is no distance. The env is opened, to be restored."""
        require_solids(self._cell.simulator.label, self._world.simulator, self._robot, self._registry)
        self._algorithm = algorithm
        self._batch = self._open()
        goal = self._env.episodes.goal
        return {} if goal is None else {"error": goal.error, "unit": goal.unit}

    def _open(self) -> ReachVectorEnv:
        self._env = self._world.open(self._algorithm.num_envs, resumable=True)
        return self._env

    @contextmanager
    def _recorded(self, attempt: Attempt) -> Iterator[None]:
        env, path = self._env, attempt.folder / TRACE
        sizes, facts = (env.robot.dof, env.episodes.action.shape[1]), facts_of(env.task, env.robot)
        with TraceWriter(path, *sizes, facts, env.episodes.extras, after=attempt.rows) as self._writer:
            self._writer.keep()  # who looks finds it, and the next attempt too
            terms = [name.removeprefix(TERM) for name in env.episodes.extras if name.startswith(TERM)]
            env.recorder = self._learning = LearningSoFar(self._writer, terms)
            yield

    def _last_episodes(self) -> Mapping[str, float]:
        return self._learning.means()

    def _keep(self) -> int:
        return self._writer.keep()

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
    from harness.results.metrics import load_metrics, measure

    terms = {name: mean_over_episodes(values, trace) for name, values in terms_of(trace).items()}
    return named_scalars(mean_return(trace), measure(load_metrics(registry), trace), terms)


ADDED_UP = (*INTEGERS, "reached", *ENDS, *PAID)


class LearningSoFar(LastEpisodes):
    """A `Recorder` that hands every row on. A step costs a copy of its rows.

    Episodes that were under way when a killed training went on are left out.
    """

    def __init__(self, recorder: Recorder, terms: Sequence[str] = ()) -> None:
        """Start before any episode has ended.

        Args:
            recorder: Gets the rows.
            terms: Of the reward, whose columns end each row.
        """
        super().__init__(*(f"{TERMS}/{name}" for name in terms))
        self._recorder = recorder
        self._places = [*map(COLUMN.__getitem__, ADDED_UP), *range(-len(terms), 0)]

    def append(self, rows: Rows) -> None:
        self._recorder.append(rows)
        self.take(rows.take(self._places, axis=1))

    def _columns(self, steps: Float) -> Sequence[Float]:
        env, episode, step, reached, terminated, truncated, *paid = steps.T
        ends, pay = np.logical_or(terminated, truncated), np.sum(paid[: len(PAID)], axis=0)
        return env, episode, ends, step == 0, pay, reached, *paid[len(PAID) :]
