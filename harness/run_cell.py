"""Train and evaluate one cell: the only place that does. It needs the cell and a folder, nothing else."""

import time
import traceback
from dataclasses import replace
from pathlib import Path

import numpy as np

from harness.algorithm import Algorithm, Progress
from harness.cell import Cell
from harness.cell_folder import EVALUATION, LOG, POLICY, RANDOM, TRACE, partial_folder, publish
from harness.evaluate import evaluate, random_actions
from harness.make import build_env
from harness.manifest import Manifest, describe_environment, now
from harness.plugins import Registry, load_registry
from harness.policy import Policy
from harness.trace import TraceWriter


def run_cell(cell: Cell, folder: Path, progress: Progress) -> Manifest:
    """Do `cell` and leave its trace, policy, evaluation and manifest in `folder`.

    The folder is written beside its final name and renamed when complete. What a plugin raises ends up in the
    manifest, as the reason of a failed cell, and in the log.

    Args:
        cell: What to do.
        folder: Of the cell; replaced if it exists.
        progress: Told the environment steps done so far.
    """
    started, clock = now(), time.perf_counter()
    partial = partial_folder(folder)
    partial.mkdir(parents=True, exist_ok=True)
    registry = load_registry()
    manifest = Manifest(cell, "done", started=started)
    try:
        manifest = replace(manifest, environment=describe_environment(cell, registry))
        manifest = replace(manifest, training_seconds=_train_and_evaluate(cell, partial, registry, progress))
    except (Exception, SystemExit) as error:  # a plugin may raise anything: it costs this cell alone
        with (partial / LOG).open("a") as log:
            traceback.print_exc(file=log)
        manifest = replace(manifest, status="failed", reason=f"{type(error).__name__}: {' '.join(str(error).split())}")
    manifest = replace(manifest, seconds=round(time.perf_counter() - clock, 3))
    manifest.write(partial)
    publish(partial, folder)
    return manifest


def _train_and_evaluate(cell: Cell, folder: Path, registry: Registry, progress: Progress) -> float:
    """Returns the seconds that the training took."""
    clock = time.perf_counter()
    policy = _train(cell, folder, registry, progress)
    seconds = round(time.perf_counter() - clock, 3)
    policy.save(folder / POLICY)
    evaluate(cell, registry, policy.act, folder / EVALUATION)
    evaluate(cell, registry, random_actions(len(policy.action_low)), folder / RANDOM)
    return seconds


def _train(cell: Cell, folder: Path, registry: Registry, progress: Progress) -> Policy:
    algorithm: Algorithm = cell.algorithm.build(registry, "algorithms")
    env_seed, algorithm_seed = (int(seed) for seed in np.random.SeedSequence(cell.seed).generate_state(2))
    env = build_env(registry, cell.simulator, cell.task, cell.reward, robot=cell.robot, num_envs=algorithm.num_envs)
    try:
        with TraceWriter(folder / TRACE, dof=env.robot.dof, action_size=env.robot.dof) as recorder:
            env.recorder = recorder
            env.reset(seed=env_seed)
            return algorithm.train(env, cell.steps, algorithm_seed, progress)
    finally:
        env.close()
