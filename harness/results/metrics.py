"""The metrics of results, and what takes the place of a metric that cannot be used."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from harness.errors import Unmeasured, UsageError, one_line
from harness.eta.behaviour_change import Quantity
from harness.eta.headline import DECIDING
from harness.eta.interval import are_bounds
from harness.log import Log
from harness.measure import Measure, bounds_of, is_error, is_share, is_time, needs_of
from harness.record.manifest import Manifest
from harness.registry.choice import Choice, choose, split_list
from harness.registry.registry import Registry
from harness.registry.sources import fingerprint
from harness.registry.spec import unknown_name
from harness.results.measured import unmeasured

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
    others = [name for name in registry.names("metrics") if not registry.get("metrics", name).is_built_in]
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


def with_fingerprints(metrics: Mapping[str, Measure]) -> dict[str, tuple[Measure, str]]:
    """Each metric with its fingerprint. A metric whose sources cannot be read becomes `Unmeasurable`."""
    found = dict[str, tuple[Measure, str]]()
    for name, metric in metrics.items():
        try:
            found[name] = metric, fingerprint(metric)
        except Exception as error:  # a plugin may be of any make
            instead = Unmeasurable(f"its sources cannot be read: {one_line(error)}")
            found[name] = instead, fingerprint(instead)
    return found


def _usable(registry: Registry, name: str) -> Measure:
    try:
        with unmeasured():
            metric: Measure = Choice(name).build(registry, "metrics")
            if metric.better not in BETTER:
                raise Unmeasured(f"its 'better' is {metric.better!r}: allowed are higher and lower, or an empty text")
            if not are_bounds(bounds_of(metric)):
                told = bounds_of(metric)
                raise Unmeasured(f"its 'bounds' are {told!r}: allowed are two numbers, the lower one first")
            return metric
    except Unmeasured as error:
        return Unmeasurable(str(error))
