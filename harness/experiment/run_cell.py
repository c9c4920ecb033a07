"""Train and evaluate one cell: the only place that does. It needs the cell and a folder, nothing else."""

from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from harness.algorithm import Algorithm
from harness.env import ReachVectorEnv
from harness.env.make import build_world
from harness.executor import CellOptions, Word
from harness.experiment.checkpoints.attempt import Attempt, begin_attempt
from harness.experiment.checkpoints.stored_rings import discard_rings
from harness.experiment.checkpoints.trace_parts import TraceParts, discard_parts
from harness.experiment.draft import Draft, draft_of
from harness.experiment.evaluation.cell import CellEvaluations
from harness.experiment.evaluation.evaluate import facts_of
from harness.experiment.peak_memory import forget_peak, peak_memory
from harness.experiment.progress.cell import CellProgress
from harness.experiment.progress.learning_so_far import LearningSoFar
from harness.experiment.provenance import describe_environment
from harness.experiment.watch import UNWATCHED, Watch
from harness.experiment.workers.order import Report
from harness.policy import Policy
from harness.record.cell import Cell
from harness.record.folder import CHECKPOINT, POLICY, TRACE
from harness.record.manifest import Manifest
from harness.record.scene import write_scene
from harness.registry.registry import Registry, load_registry
from harness.robot.load import load_robot
from harness.scene.scene import scene_of

if TYPE_CHECKING:
    from harness.experiment.environments.training import EnvironmentTraining

DEFAULTS = CellOptions()


def run_cell(
    cell: Cell, folder: Path, report: Report, options: CellOptions = DEFAULTS, watch: Watch = UNWATCHED
) -> Manifest:
    """Do `cell` and leave its trace, policy, evaluation and manifest in `folder`.

    The folder is written beside its final name and renamed when complete. What a plugin raises ends up in the
    manifest, as the reason of a failed cell, and in the log. If this process is killed, the next call goes on from the
    last checkpoint, if it left one.

    Args:
        cell: What to do.
        folder: Of the cell; replaced if it exists.
        report: Told how far it is.
        options: How to do it.
        watch: Looks on.
    """
    with draft_of(folder, Manifest(cell, status="done")) as draft:
        forget_peak()
        try:
            kind = _environment_training() if cell.is_in_environment else _Run
            kind(cell, load_registry(given=options.plugins), report, options, watch).leave(draft)
        finally:
            draft.note(peak_memory=peak_memory())
            (draft.partial / CHECKPOINT).unlink(missing_ok=True)
            discard_rings(draft.partial)
            discard_parts(draft.partial / TRACE)
    return draft.record


def _environment_training() -> "type[EnvironmentTraining]":
    """Import the training in environments, which only cells whose task is an environment need."""
    from harness.experiment.environments.training import EnvironmentTraining

    return EnvironmentTraining


@dataclass(frozen=True)
class TrainCell:
    """`run_cell`, as a worker is told to do it."""

    cell: Cell
    options: CellOptions = DEFAULTS

    noun: ClassVar[str] = "cell"

    def to_json(self) -> dict[str, Any]:
        """See `harness.experiment.workers.order.Work`."""
        return {"cell": self.cell.to_json(), "options": self.options.to_json()}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """See `harness.experiment.workers.order.Work`."""
        return cls(Cell.from_json(data["cell"]), CellOptions.from_json(data["options"]))

    def do(self, folder: Path, report: Report) -> bool:
        """See `harness.experiment.workers.order.Work`."""
        return run_cell(self.cell, folder, report, self.options).status == "done"


@dataclass(frozen=True)
class _Run:
    """The run of one cell: what all its steps need."""

    cell: Cell
    registry: Registry
    report: Report
    options: CellOptions
    watch: Watch

    def leave(self, draft: Draft[Manifest]) -> None:
        """Train and evaluate; leave everything but the manifest, and put into that what there is to say."""
        cell, registry = self.cell, self.registry
        robot = load_robot(cell.robot, registry)
        environment = describe_environment(cell, robot, registry)
        draft.note(environment=environment)
        world = build_world(cell, robot, registry)
        algorithm: Algorithm = cell.algorithm.build(registry, "algorithms")
        with closing(world.open(algorithm.num_envs, resumable=True)) as env:
            attempt = begin_attempt(cell, draft.partial, environment, self.options.checkpoint_every, env.restore)
            goal = env.episodes.goal
            if goal is not None:
                draft.note(error=goal.error, unit=goal.unit)
            draft.note(resumed_from=attempt.begun_from, note=attempt.note)
            self.report(Word(attempt.begun_from))
            evaluations = CellEvaluations(cell, world, registry, attempt, self.options.tracked, self.report)
            policy = self._train(algorithm, env, attempt, evaluations)
            draft.note(training_seconds=round(attempt.seconds - evaluations.seconds, 3))
            policy.save(draft.partial / POLICY, cell.to_json())
            write_scene(scene_of(robot), draft.partial)
            self.watch.enter("evaluation")
            evaluations.finish(policy, self.options.floor)
            self.watch.enter("saving")

    def _train(
        self, algorithm: Algorithm, env: ReachVectorEnv, attempt: Attempt, evaluations: CellEvaluations
    ) -> Policy:
        """Train on `env`, which stands where the attempt begins, and close it."""
        cell, watch = self.cell, self.watch
        env_seed, algorithm_seed = (int(seed) for seed in np.random.SeedSequence(cell.seed).generate_state(2))
        try:
            sizes, facts = (env.robot.dof, env.episodes.action.shape[1]), facts_of(env.task, env.robot)
            with TraceParts(attempt.folder / TRACE, *sizes, facts, attempt.parts, env.episodes.extras) as parts:
                env.recorder = learning = LearningSoFar(parts, attempt.begun_from)
                if attempt.checkpoint is None:
                    env.reset(seed=env_seed)
                tracked = self.options.tracked
                progress = CellProgress(self.report, attempt, env, parts, evaluations, learning, tracked)
                watch.follow(env)
                policy = algorithm.train(env, cell.steps, algorithm_seed, progress)
                steps = min(env.environment_steps, cell.steps)
                self.report(Word(steps, learning.scalars(steps)))
                watch.enter("trace")
            return policy
        finally:
            watch.enter("saving")
            env.close()
