"""What `harness.run` takes, for editors and type checkers; what each means stands where it is checked."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Required, TypeAlias, TypedDict

from harness.eta.curve import Kind
from harness.experiment.changed import Changed

Name: TypeAlias = str | Mapping[str, Any]
"""``"arp:k2=2"``, or a table ``{"name": "arp", "k2": 2}``."""
Names: TypeAlias = Name | Sequence[Name]
"""One, text with commas, or a list."""


class RunArguments(TypedDict, total=False):
    """The fields of `harness.experiment.plan.Experiment`, then those of `harness.experiment.experiment.RunOptions`."""

    sim: Required[Names]
    algo: Required[Names]
    reward: Names
    baseline: Name
    task: Name
    robot: str | None
    seeds: int | Sequence[int]
    steps: int
    evaluation_episodes: int
    evaluate_every: int
    deterministic: bool
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
