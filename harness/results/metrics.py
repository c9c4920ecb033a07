"""The metrics of results, what takes the place of one that cannot be used, and the values of all for one cell.

They are those of its policy in both manners, of random actions, and of its training.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import chdir, contextmanager, suppress
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from harness.errors import SchemaError, Unmeasured, UsageError, reason_of
from harness.eta.behaviour_change import Quantity
from harness.eta.headline import DECIDING, SUCCESS
from harness.eta.interval import are_bounds
from harness.eta.laws import Span
from harness.files.plain import Plain
from harness.hookspecs import NOUNS
from harness.log import Log
from harness.log.measure import Measure, bounds_of, is_error, is_share, is_time, needs_of
from harness.record.cell import SHOWN_DIGITS, Manifest
from harness.registry.choice import Choice, Registry, choose, split_list
from harness.registry.spec import unknown_name

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
        with chdir("."):  # the metric may change it
            yield
    except SchemaError:  # a column is damaged, whatever measures it
        raise
    except (Exception, SystemExit) as error:
        raise Unmeasured(reason_of(error)) from error


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


BETTER = ("higher", "lower", "")


@dataclass(frozen=True)
class Unmeasurable:
    """Takes the place of a metric that cannot be used, and says why for every trace. So the rest of a report works."""

    reason: str
    unit: str = ""
    better: str = "higher"

    def __call__(self, trace: Log) -> float | None:
        """Raises Unmeasured."""
        raise Unmeasured(self.reason)


def named_measures(experiment: Mapping[str, Any]) -> tuple[str, ...]:
    """The measures that an experiment names, the one that decides first. It may be anybody's: whatever stands there."""
    told = experiment.get("measure")
    return tuple(name for name in told if isinstance(name, str)) if isinstance(told, list) else ()


def load_metrics(
    registry: Registry, names: Iterable[str] | None = None, named: Sequence[str] = ()
) -> dict[str, Measure]:
    """Metrics by name. A metric that cannot be used is `Unmeasurable`, unless it was named.

    Args:
        registry: The plugins.
        names: Those to load, ``"work"`` or with parameters, several with commas, by their labels; what decides about
            the robot always stands before them. All that are registered if None.
        named: The measures that the experiment names: those of them that nobody registered are `Unmeasurable`.

    Raises:
        UsageError: A named one is not registered, or not installed.
        PluginError: A named one is broken.
    """
    there = registry.names("metrics")
    untold = Unmeasurable("the experiment names it, and nobody registered it: give its file, --measure FILE")
    missing: dict[str, Measure] = dict.fromkeys((name for name in named if name not in there), untold)
    if names is None:
        return {**{name: _usable(registry, name) for name in there}, **missing}
    deciding = [name for name in named or DECIDING if name in there]
    chosen = dict.fromkeys(choose(registry, "metrics", name) for name in [*deciding, *split_list(names)])
    return {**missing, **{choice.label: choice.build(registry, "metrics") for choice in chosen}}


def fields_needed(registry: Registry) -> frozenset[str]:
    """What metrics read of a step that others brought, by names of `harness.reward.steps.ARM`; ours read what is there.

    Raises:
        UsageError: A function of a step or of an episode fails on made-up steps, or reads what no step has.
    """
    for it in registry.functions_of("measure").values():
        if it.spec is not None:
            it.spec.load()
    others = [name for name in registry.names("metrics") if not registry.is_built_in("metrics", name)]
    return frozenset(field for name in others for field in needs_of(_usable(registry, name)))


def require_measures(names: Iterable[str], there: Iterable[str]) -> None:
    """See that an environment has these measures of behaviour.

    Raises:
        UsageError: It lacks one; says which there are.
    """
    known = list(there)
    for name in names:
        if name not in known:
            raise UsageError(unknown_name("measure", name, known))


def measure_of(
    name: str,
    metric: Measure,
    manner: str,
    episodes: int,
    manifest: Manifest,
    longest: tuple[float, float] = (math.inf, math.inf),
) -> Quantity:
    """What a metric measures. A metric of the task's error gets the name and the unit of that error.

    A time in an episode is at most as long as an episode can be.

    Args:
        name: The name of the metric.
        metric: The metric.
        manner: See `Quantity`.
        episodes: How many episodes it is a share of, if it is a share.
        manifest: The manifest of one of the cells, which all do one task.
        longest: How long an episode of theirs can be, in steps and in seconds.
    """
    share = episodes if is_share(metric) else None
    low, high = bounds_of(metric)
    if is_time(metric):
        high = min(high, longest[metric.unit == "s"])
    found = Quantity(name, metric.unit, metric.better, manner, share, bounds=(low, high))
    if not (manifest.error and is_error(metric)):
        return found
    return found._replace(unit=manifest.unit, title=name.replace("_", " ").replace("distance", manifest.error))


def _usable(registry: Registry, name: str) -> Measure:
    try:
        with unmeasured():
            metric: Measure = Choice(name).build(registry, "metrics")
            if metric.better not in BETTER:
                raise Unmeasured(f"its 'better' is {metric.better!r}: allowed are higher and lower, or an empty text")
            if not are_bounds(bounds_of(metric)):
                raise Unmeasured(
                    f"its 'bounds' are {bounds_of(metric)!r}: allowed are two numbers, the lower one first"
                )
            return metric
    except Unmeasured as error:
        return Unmeasurable(str(error))
