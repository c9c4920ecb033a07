"""An arm in a simulator, as a cell trains in it; see `harness.experiment.world.CellWorld`."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from harness.algorithm import Algorithm, TrainingEnv
from harness.env import ReachVectorEnv
from harness.env.make import build_world
from harness.env.solid_probes import require_solids
from harness.executor import NO_SCALARS
from harness.experiment.checkpoints.attempt import Attempt
from harness.experiment.checkpoints.trace_parts import TraceParts
from harness.experiment.evaluation.evaluate import evaluate, facts_of
from harness.experiment.evaluation.evaluator import Evaluator
from harness.experiment.evaluation.scalars import named_scalars
from harness.experiment.progress.beat import Beat
from harness.experiment.progress.learning_so_far import LearningSoFar
from harness.experiment.provenance import describe_environment
from harness.experiment.watch import Watch
from harness.experiment.workers.order import Report
from harness.log import Log
from harness.policy import Policy
from harness.progress import TrainingState
from harness.record.cell import Cell
from harness.record.folder import SUFFIX, TRACE
from harness.record.returns import mean_over_episodes, mean_return
from harness.record.scene import write_scene
from harness.record.trace import TERM, read_trace, terms_of
from harness.registry.registry import Registry
from harness.robot.load import load_robot
from harness.scene.scene import scene_of


class ArmWorld:
    """Leaves traces."""

    suffix = SUFFIX

    def __init__(self, cell: Cell, registry: Registry, report: Report, watch: Watch) -> None:
        """Load the robot; see `harness.experiment.world.world_of`."""
        self._cell, self._registry, self._watch, self._report = cell, registry, watch, report
        self._robot = load_robot(cell.robot, registry)
        self.runs_on: Mapping[str, Any] = describe_environment(cell, self._robot, registry)
        self._env: ReachVectorEnv
        self._evaluator: Evaluator
        self._learning: LearningSoFar | None = None
        self._parts: TraceParts | None = None
        self._now = cell.steps

    def build(self, algorithm: Algorithm) -> None:
        """See `CellWorld`. The env of the training is opened, so that it can be restored."""
        world, beat = build_world(self._cell, self._robot, self._registry), Beat(self._report)
        require_solids(self._cell.simulator.label, world.simulator, self._robot, self._registry)
        self._evaluator = Evaluator(world, self._cell.evaluation_episodes, lambda: beat(self._now))
        self._env = world.open(algorithm.num_envs, resumable=True)

    def restore(self, state: TrainingState) -> None:
        """See `CellWorld`."""
        self._env.restore(state)

    @contextmanager
    def training(self, attempt: Attempt) -> Iterator[TrainingEnv]:
        """See `CellWorld`."""
        env, path = self._env, attempt.folder / TRACE
        try:
            sizes, facts = (env.robot.dof, env.episodes.action.shape[1]), facts_of(env.task, env.robot)
            with TraceParts(path, *sizes, facts, attempt.parts, env.episodes.extras) as self._parts:
                terms = [name.removeprefix(TERM) for name in env.episodes.extras if name.startswith(TERM)]
                env.recorder = self._learning = LearningSoFar(self._parts, attempt.begun_from, terms=terms)
                self._watch.follow(env)
                yield env
                self._watch.enter("trace")
        finally:
            self._watch.enter("saving")
            env.close()

    def facts(self) -> Mapping[str, Any]:
        """See `CellWorld`: what the task measures, if that is no distance."""
        goal = self._env.episodes.goal
        return {} if goal is None else {"error": goal.error, "unit": goal.unit}

    def learned(self, steps: int, *, if_due: bool = False) -> Mapping[str, float]:
        """See `CellWorld`."""
        if self._learning is None:
            return NO_SCALARS
        return self._learning.scalars_if_due(steps) if if_due else self._learning.scalars(steps)

    def kept(self) -> tuple[TrainingState, Sequence[str]] | None:
        """See `CellWorld`: the trace so far is finished, as a part."""
        if self._parts is None:
            return None
        self._parts.cut()
        return self._env.state(), self._parts.digests

    def record(self, policy: Policy, deterministic: bool, path: Path, after: int) -> None:
        """See `CellWorld`."""
        self._now = after or self._cell.steps
        self._evaluator.record(policy, deterministic, path)

    def record_random(self, policy: Policy, path: Path) -> None:
        """See `CellWorld`."""
        self._evaluator.record_random(policy, path)

    def validate(self, policy: Policy, episodes: int, path: Path, seed: int) -> None:
        """See `CellWorld`."""
        evaluate(build_world(self._cell, self._robot, self._registry), policy.act, episodes, path, seed)

    def scalars(self, path: Path) -> dict[str, float]:
        """See `CellWorld`."""
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
