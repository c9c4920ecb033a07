"""Evaluate one cell's policy in another simulator: the cell's own evaluation, the simulator apart."""

import time
import traceback
from dataclasses import replace
from pathlib import Path

from harness.experiment.evaluate import act_of, evaluate
from harness.experiment.provenance import describe_environment
from harness.policy import load_policy
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, LOG, POLICY, partial_folder, publish
from harness.record.manifest import now, read_manifest
from harness.registry.choice import Choice
from harness.registry.registry import Registry, load_registry
from harness.transfer.record import TransferRecord, policy_digest

KINDS = ("simulators", "tasks", "rewards")
"""What makes the result; the library that trained the policy is not needed, and need not be there."""


def evaluate_elsewhere(cell_folder: Path, simulator: Choice, folder: Path) -> TransferRecord:
    """Let the policy of a done cell do the cell's evaluation episodes in `simulator`.

    The folder is written beside its final name and renamed when complete. What a plugin raises ends up in the record,
    as the reason of a failed evaluation, and in the log.

    Args:
        cell_folder: Of the cell that trained the policy.
        simulator: Where to evaluate it.
        folder: To leave; replaced if it exists.
    """
    started, clock = now(), time.perf_counter()
    partial = partial_folder(folder)
    partial.mkdir(parents=True, exist_ok=True)
    trained = read_manifest(cell_folder).cell
    registry, cell = load_registry(), replace(trained, simulator=simulator)
    record = TransferRecord(trained.id, simulator, policy_digest(cell_folder), "done", started=started)
    try:
        record = replace(record, environment=describe_environment(cell, registry, KINDS))
        _evaluate(cell, registry, cell_folder, partial)
    except (Exception, SystemExit) as error:  # a plugin may raise anything: it costs this evaluation alone
        with (partial / LOG).open("a") as log:
            traceback.print_exc(file=log)
        record = replace(record, status="failed", reason=f"{type(error).__name__}: {' '.join(str(error).split())}")
    record = replace(record, seconds=round(time.perf_counter() - clock, 3))
    record.write(partial)
    publish(partial, folder)
    return record


def _evaluate(cell: Cell, registry: Registry, cell_folder: Path, partial: Path) -> None:
    policy = load_policy(cell_folder / POLICY)
    evaluate(cell, registry, act_of(policy, cell), partial / EVALUATION)
