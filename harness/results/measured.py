"""The values of every metric for one cell: its policy in both manners, random actions, and its training."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from harness.errors import SchemaError, Unmeasured, reason_of
from harness.eta.headline import SUCCESS
from harness.eta.laws import Span
from harness.files.plain import Plain
from harness.hookspecs import NOUNS
from harness.log import Log
from harness.measure import Measure
from harness.record.manifest import KERNEL, SHOWN_DIGITS, Manifest

Values: TypeAlias = dict[str, float | None]
"""Values by metric. A value is None if it is not defined, or if the metric fails."""

LAST_PART = 0.75
"""Evaluations after this part of the training count for the final policy."""
AREA, STEPS_TO_GOAL = "success_area", "steps_to_goal"
GOAL = 0.9
"""Sample efficiency is the number of steps until this share of the episodes succeeds."""


class Counted(NamedTuple):
    """What is counted of a training where it is no episodes of all steps that are asked about."""

    noun: str
    """``episode``, or ``point``, which is a mean over some."""
    over: Span | None = None
    """The steps of which it tells; None if it is all that are asked about."""

    @property
    def where(self) -> str:
        """The same in words; empty if it is all that are asked about."""
        if self.over is None:
            return ""
        begin, end = (f"{it:,.0f}" for it in self.over)
        return f"after {end} steps" if begin == end else f"from {begin} to {end} steps"


class Moment(NamedTuple):
    """One evaluation of one cell."""

    steps: int
    """Environment steps of training before it."""
    values: Mapping[str, float | None]


class Measured(NamedTuple):
    """All values of one cell."""

    manners: Mapping[str, Values]
    """Values of the trained policy by how it acted, and of the training itself; in the order in which they are
    shown."""
    episodes: Mapping[str, int]
    """How many finished episodes each manner rests on."""
    random: Values
    """The values of random actions."""
    reasons: Mapping[str, str] = {}
    """The reason for each metric that failed. Its values are None."""

    @property
    def own(self) -> Values:
        """The values of the trained policy in the manner that the cell names, which stands first."""
        return next(iter(self.manners.values()))


def measure(metrics: Mapping[str, Measure], trace: Log) -> Values:
    """Every metric of a trace; None if a metric fails."""
    values: Values = {}
    for name, metric in metrics.items():
        values[name] = None
        with suppress(Unmeasured):
            values[name] = value_of(metric, trace)
    return values


def value_of(metric: Measure, trace: Log) -> float | None:
    """The value of a metric for a trace.

    Raises:
        Unmeasured: It raises, or what it returns is no finite number.
    """
    with unmeasured():
        value = metric(trace)
        if value is not None and not math.isfinite(value):
            raise Unmeasured(f"it returned {value}")
        return None if value is None else float(value)


@contextmanager
def unmeasured() -> Iterator[None]:
    """Run a metric's code. An error that it raises becomes a reason, and stops nothing else.

    Raises:
        SchemaError: A file that it reads is damaged.
        Unmeasured: With the reason in one line.
    """
    try:
        yield
    except SchemaError:  # a column is damaged, whatever measures it
        raise
    except (Exception, SystemExit) as error:
        raise Unmeasured(reason_of(error)) from error


def moments_by_due(moments: Sequence[Moment], every: int, budget: int) -> list[tuple[int, Moment]]:
    """Evaluations, each with the multiple of `every` at which it was due. The last one was due at the budget.

    Algorithms that act for several steps at a time do not all hit a multiple.
    """
    return [(budget if moment.steps >= budget else moment.steps // every * every, moment) for moment in moments]


def last_values(moments: Sequence[Moment], budget: int, most: int) -> Values:
    """Means over the last evaluations, of which one alone is a checkpoint's luck; empty where there is one.

    Args:
        moments: All evaluations, the one after the training last.
        budget: Environment steps of the training.
        most: At most so many count, all of the last quarter of the training.
    """
    last = [moment for moment in moments if moment.steps >= LAST_PART * budget][-most:]
    if len(last) < 2:
        return {}
    names = last[-1].values
    means = {name: float(np.mean(np.array([it.values.get(name) for it in last], np.float64))) for name in names}
    return {name: None if math.isnan(mean) else mean for name, mean in means.items()}


def learning_values(moments: Sequence[Moment], budget: int, success: str = SUCCESS) -> Values:
    """How fast a cell learned: mean success over its evaluations, and the steps until `GOAL` of the episodes succeed.

    A training that never gets there counts with all of its steps. None where it was not evaluated while it learned.
    """
    known = [(moment.steps, value) for moment in moments if (value := moment.values.get(success)) is not None]
    if len(moments) < 2 or len(known) < len(moments):
        return {AREA: None, STEPS_TO_GOAL: None}
    reached = [steps for steps, share in known if share >= GOAL]
    return {AREA: float(np.mean([share for _, share in known])), STEPS_TO_GOAL: float(min([*reached, budget]))}


@dataclass(frozen=True)
class Mixture(Plain):
    """A plugin, a library or a kernel that was not the same for all cells of one comparison.

    Attributes:
        kind: Of the plugin; ``versions`` of a library, ``machine`` of a kernel.
        name: Of the plugin or the library, or the path of a robot's files.
        cells: How many cells each version made, by the SHA-256 of its files, the version's number or the kernel's
            name. The version that made most comes first.
    """

    kind: str
    name: str
    cells: Mapping[str, int]

    @property
    def text(self) -> str:
        """One sentence."""
        main, *others = (it[:SHOWN_DIGITS] if self.kind in NOUNS else it for it in self.cells)
        total = sum(self.cells.values())
        other = total - next(iter(self.cells.values()))
        return (
            f"{other} of {total} cells {'was' if other == 1 else 'were'} made by another {self.name} "
            f"({', '.join(others)}; the others {main}): they are not the same {NOUNS.get(self.kind, self.name)}"
        )


def mixtures_of(manifests: Iterable[Manifest]) -> tuple[Mixture, ...]:
    """The mixtures among done cells. A cell of which a version is not recorded is left out there."""
    started: dict[tuple[str, str], dict[str, list[str]]] = {}
    for manifest in manifests:
        told, made = manifest.environment, manifest.cell.plugins
        recorded = {
            **{(kind, made[kind]): it for kind, it in told.get("sources", {}).items() if kind in made},
            **{("versions", name): it for name, it in told.get("versions", {}).items()},
            ("machine", KERNEL): told.get("machine", {}).get("kernel"),
        }
        for which, version in recorded.items():
            if version:
                started.setdefault(which, {}).setdefault(version, []).append(manifest.started)
    found = list[Mixture]()
    for (kind, name), versions in started.items():
        # Of two versions that made as many, the newer one comes first.
        order = sorted(versions, key=lambda it: (len(versions[it]), max(versions[it])), reverse=True)
        found += [Mixture(kind, name, {it: len(versions[it]) for it in order})] if len(versions) > 1 else []
    return tuple(found)
