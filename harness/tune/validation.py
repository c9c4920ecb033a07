"""Validation: episodes that policies of a search are judged by. ``python -m harness.tune.validation`` does them.

Their starts and targets are drawn from another seed than those of the evaluation after a training
(`harness.experiment.evaluate`), so that no comparison that follows is made on what the settings were chosen by.

The process reads one line of JSON from standard input, a list of orders, and does one after another. What a plugin
prints goes into the log. It ends when its parent does.
"""

import json
import os
import sys
import traceback
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from harness.errors import one_line
from harness.experiment.evaluate import evaluate
from harness.experiment.lifeline import end_with_parent
from harness.policy import Policy, load_policy
from harness.record.cell import Cell
from harness.record.folder import POLICY
from harness.record.manifest import read_manifest
from harness.registry.registry import Registry, load_registry

VALIDATION_SEED = 20_230_705
"""Of the starts and targets of every validation; not the evaluation's, and not a small number."""


class Order(NamedTuple):
    """One policy to validate."""

    cell_folder: str
    """Of the done cell that trained it."""
    path: str
    """The trace to leave; there only when it is complete."""
    episodes: int

    @property
    def failure(self) -> Path:
        """Where it says why there will be no trace."""
        return Path(self.path).with_suffix(".failed")

    @property
    def is_ended(self) -> bool:
        """Whether the trace is there, or the reason why it is not."""
        return Path(self.path).exists() or self.failure.exists()


def main() -> None:
    """Do what standard input orders."""
    orders = [Order(*order) for order in json.loads(sys.stdin.readline())]
    end_with_parent()
    registry = load_registry()
    for order in orders:
        validate(order, registry)


def validate(order: Order, registry: Registry) -> None:
    """Leave the order's trace, or the reason why there is none: a plugin may raise anything."""
    partial = Path(f"{order.path}.{os.getpid()}.partial")
    try:
        cell = read_manifest(Path(order.cell_folder)).cell
        record_validation(cell, registry, load_policy(Path(order.cell_folder) / POLICY), order.episodes, partial)
        partial.rename(order.path)
    except (Exception, SystemExit) as error:
        traceback.print_exc()
        order.failure.write_text(one_line(error))


def record_validation(cell: Cell, registry: Registry, policy: Policy, episodes: int, path: Path) -> None:
    """Let `policy` do so many episodes in the cell's simulator, one in each env of a batch, and record them."""
    evaluate(replace(cell, evaluation_episodes=episodes), registry, policy.act, path, VALIDATION_SEED)


if __name__ == "__main__":
    main()
