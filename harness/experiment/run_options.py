"""The options of a run, which change no result, and all arguments of `harness.run`.

A new option is a field here, in both classes, and a flag in `harness.cli.run`.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Required, TypeAlias, TypedDict

from harness.algorithm import Algorithm
from harness.errors import UsageError
from harness.eta.curve import KINDS, Kind
from harness.executor import CellOptions, Executor, Limits
from harness.experiment.changed import CHANGED, Changed
from harness.experiment.followed import Given
from harness.experiment.workers.workers import worker_count
from harness.registry.choice import Registry, choose
from harness.reward import Reward

if TYPE_CHECKING:
    from harness.simulator import Simulator
    from harness.task import Task

STALL_AFTER = 1800.0
"""Seconds without progress after which a cell is ended. Algorithms report every 100 steps, evaluations every step."""
ZERO_FOR = {
    "checkpoint_every": "none",
    "budget": "no limit",
    "retry_failed": "never",
    "stall_after": "never",
    "cell_time": "no limit",
    "cell_memory": "no limit",
}
"""What 0 means, of the options that are numbers."""


@dataclass(frozen=True)
class RunOptions:
    """How an experiment is run; nothing here changes a result.

    Attributes:
        out: The experiment's folder; by default one under ``results/runs/`` named for the plan, so that the same
            experiment goes on where an earlier run stopped.
        jobs: How many cells at once; by default as many as there are cores.
        executor: What runs the cells, with its settings: ``"processes"``, ``"mine:nodes=2"`` or a table.
        checkpoint_every: Environment steps from one checkpoint of a training to the next, at least; 0 for none; by
            default one every ten minutes.
        tracker: What shows the trainings elsewhere: ``"tensorboard"``, ``"tensorboard,wandb:mode=offline"``, a table,
            or a list of such.
        curve: Which curves the indices are read from afterwards; see `harness.eta.curve.GroupCurve`.
        wait: Whether to wait while another run is using the folder; else that is an error.
        changed: What becomes of done cells that other plugins made than those installed now: ``"refuse"`` to run,
            ``"keep"`` them beside the new ones, or do them ``"again"``.
        only: Do only the cells that this names; see `harness.experiment.experiment.select`. The others stay pending.
        limit: Do at most so many cells; the others stay pending.
        budget: Seconds after which the run ends, once a cell has ended; the others stay pending. 0 for any number.
        retry_failed: How often a failed cell is tried again, after all others.
        fail_fast: Whether to end with the first cell that fails.
        stall_after: Seconds without progress after which a cell counts as hung, and fails; 0 for never.
        cell_time: Seconds that a cell may take; 0 for any number.
        cell_memory: GiB of memory that a cell may use; 0 for any number.
        fresh: Whether each cell gets a process of its own, instead of one that does several cells.
        metrics: Which metrics the results tell, ``"work"``, several with commas; every registered one if None. In an
            environment: which of its measures.

    Raises:
        UsageError: A number is out of range, or there is no such curve or choice.
    """

    out: str | Path | None = None
    jobs: int | None = None
    executor: str | Mapping[str, Any] = "processes"
    checkpoint_every: int | None = None
    tracker: Given | Sequence[Given] = ()
    curve: Kind = "accumulated"
    wait: bool = True
    changed: Changed = "refuse"
    only: str | None = None
    limit: int | None = None
    budget: float = 0.0
    retry_failed: int = 0
    fail_fast: bool = False
    stall_after: float = STALL_AFTER
    cell_time: float = 0.0
    cell_memory: float = 0.0
    fresh: bool = False
    metrics: str | Sequence[str] | None = None

    def __post_init__(self) -> None:
        worker_count(self.jobs)
        for name, none in ZERO_FOR.items():
            given = getattr(self, name)
            if given is not None and not 0 <= given < math.inf:
                raise UsageError(f"{name}={given}: must be a number above 0, or 0 for {none}")
        if self.limit is not None and self.limit < 1:
            raise UsageError(f"limit={self.limit}: must be at least 1")
        if self.curve not in KINDS:
            raise UsageError(f"curve='{self.curve}': allowed are {' and '.join(KINDS)}")
        if self.changed not in CHANGED:
            raise UsageError(f"changed='{self.changed}': allowed are {', '.join(CHANGED)}")

    @property
    def at_once(self) -> int:
        """How many cells run at once."""
        return worker_count(self.jobs)

    @property
    def of_cells(self) -> CellOptions:
        """The options that each cell gets."""
        limits = Limits(self.stall_after, self.cell_time, self.cell_memory)
        return CellOptions(self.checkpoint_every, bool(self.tracker), limits, self.fresh)

    def build_executor(self, registry: Registry) -> Executor:
        """The executor that runs the cells.

        Raises:
            UsageError: The executor or a setting of it is not known, or a library for it is missing.
        """
        executor: Executor = choose(registry, "executors", self.executor).build(registry, "executors")
        return executor


DEFAULTS = RunOptions()


Name: TypeAlias = str | Mapping[str, Any]
"""``"arp:k2=2"``, or a table ``{"name": "arp", "k2": 2}``."""
Names: TypeAlias = Name | Sequence[Name]
"""One, text with commas, or a list."""
if TYPE_CHECKING:
    Thing: TypeAlias = Name | Simulator | Algorithm | Reward | Task
    """A name, or an object whose class workers can import."""
else:
    Thing = object  # what type checkers alone look at loads no arms
Things: TypeAlias = Thing | Sequence[Thing]
"""One, text with commas, or a list."""


class RunArguments(TypedDict, total=False):
    """The fields of `harness.experiment.plan.Experiment`, then those of `harness.experiment.experiment.RunOptions`."""

    sim: Things
    algo: Required[Things]
    reward: Things
    baseline: Thing
    task: Thing
    robot: str | None
    seeds: int | Sequence[int]
    until: Literal["decided", "best"]
    looks: Sequence[int]
    margin: float
    trainings: int
    minutes: float
    steps: int
    evaluation_episodes: int
    evaluate_every: int
    deterministic: bool
    measure: str | Sequence[str | Path]
    evaluation_horizon: int | None
    plugins: Sequence[str | Path | type]
    out: str | Path | None
    jobs: int | None
    executor: str | Mapping[str, Any]
    checkpoint_every: int | None
    tracker: Names
    curve: Kind
    wait: bool
    changed: Changed
    only: str | None
    limit: int | None
    budget: float
    retry_failed: int
    fail_fast: bool
    stall_after: float
    cell_time: float
    cell_memory: float
    fresh: bool
    metrics: str | Sequence[str] | None
