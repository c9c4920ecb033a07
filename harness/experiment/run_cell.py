"""Train and evaluate one cell: the only place that does. It needs the cell and a folder, nothing else."""

import time
import traceback
from dataclasses import replace
from pathlib import Path

import numpy as np

from harness.algorithm import Algorithm
from harness.env.make import build_env
from harness.experiment.attempt import Attempt, begin_attempt
from harness.experiment.cell_evaluations import CellEvaluations
from harness.experiment.cell_progress import CellProgress, Report
from harness.experiment.event_log import EventLog
from harness.experiment.provenance import describe_environment
from harness.experiment.trace_parts import TraceParts, discard_parts
from harness.experiment.watch import UNWATCHED, Watch
from harness.policy import Policy
from harness.record.cell import Cell
from harness.record.folder import CHECKPOINT, LOG, POLICY, TENSORBOARD, TRACE, partial_folder, publish
from harness.record.manifest import Manifest, now
from harness.registry.registry import Registry, load_registry


def run_cell(
    cell: Cell,
    folder: Path,
    report: Report,
    checkpoint_every: int = 0,
    tensorboard: bool = False,
    watch: Watch = UNWATCHED,
) -> Manifest:
    """Do `cell` and leave its trace, policy, evaluation and manifest in `folder`.

    The folder is written beside its final name and renamed when complete. What a plugin raises ends up in the
    manifest, as the reason of a failed cell, and in the log.

    Args:
        cell: What to do.
        folder: Of the cell; replaced if it exists.
        report: Told the environment steps done so far.
        checkpoint_every: Environment steps from one checkpoint of the training to the next, at least; 0 for none. If
            this process is killed, the next call goes on from the last one.
        tensorboard: Whether to leave event files of scalars too.
        watch: Looks on.
    """
    started, clock = now(), time.perf_counter()
    partial = partial_folder(folder)
    partial.mkdir(parents=True, exist_ok=True)
    registry = load_registry()
    manifest = Manifest(cell, "done", started=started)
    try:
        manifest = replace(manifest, environment=describe_environment(cell, registry))
        attempt = begin_attempt(cell, partial, manifest.environment, checkpoint_every)
        manifest = replace(manifest, resumed_from=attempt.begun_from, note=attempt.note)
        events = partial / TENSORBOARD if tensorboard else None
        seconds = _train_and_evaluate(cell, attempt, registry, report, events, watch)
        manifest = replace(manifest, training_seconds=seconds)
    except (Exception, SystemExit) as error:  # a plugin may raise anything: it costs this cell alone
        with (partial / LOG).open("a") as log:
            traceback.print_exc(file=log)
        manifest = replace(manifest, status="failed", reason=f"{type(error).__name__}: {' '.join(str(error).split())}")
    manifest = replace(manifest, seconds=round(time.perf_counter() - clock, 3))
    (partial / CHECKPOINT).unlink(missing_ok=True)
    discard_parts(partial / TRACE)
    manifest.write(partial)
    publish(partial, folder)
    return manifest


def _train_and_evaluate(
    cell: Cell, attempt: Attempt, registry: Registry, report: Report, event_folder: Path | None, watch: Watch
) -> float:
    """Returns the seconds that the training took."""
    with EventLog(event_folder) as events:
        evaluations = CellEvaluations(cell, registry, attempt, events)
        policy = _train(cell, attempt, registry, report, evaluations, events, watch)
        seconds = round(attempt.seconds - evaluations.seconds, 3)
        policy.save(attempt.folder / POLICY, cell.to_json())
        watch.enter("evaluation")
        evaluations.finish(policy)
        watch.enter("saving")
    return seconds


def _train(
    cell: Cell,
    attempt: Attempt,
    registry: Registry,
    report: Report,
    evaluations: CellEvaluations,
    events: EventLog,
    watch: Watch,
) -> Policy:
    algorithm: Algorithm = cell.algorithm.build(registry, "algorithms")
    env_seed, algorithm_seed = (int(seed) for seed in np.random.SeedSequence(cell.seed).generate_state(2))
    env = build_env(registry, cell.simulator, cell.task, cell.reward, robot=cell.robot, num_envs=algorithm.num_envs)
    try:
        with TraceParts(attempt.folder / TRACE, env.robot.dof, env.episodes.action.shape[1], attempt.parts) as parts:
            env.recorder = parts.recorder
            env.reset(seed=env_seed)
            progress = CellProgress(report, attempt, env, parts, evaluations, events)
            watch.follow(env)
            policy = algorithm.train(env, cell.steps, algorithm_seed, progress)
            watch.enter("trace")
        return policy
    finally:
        watch.enter("saving")
        env.close()
