"""What `harness.run` takes, for editors and type checkers; what each means stands where it is checked."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Required, TypeAlias, TypedDict

from harness.algorithm import Algorithm
from harness.eta.curve import Kind
from harness.experiment.changed import Changed
from harness.reward import Reward
from harness.simulator import Simulator
from harness.task import Task

Name: TypeAlias = str | Mapping[str, Any]
"""``"arp:k2=2"``, or a table ``{"name": "arp", "k2": 2}``."""
Names: TypeAlias = Name | Sequence[Name]
"""One, text with commas, or a list."""
Thing: TypeAlias = Name | Simulator | Algorithm | Reward | Task
"""A name, or an object whose class workers can import."""
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
    retry_failed: int
    fail_fast: bool
    stall_after: float
    cell_time: float
    cell_memory: float
    fresh: bool
    metrics: str | Sequence[str] | None
