"""The metrics of results, and what takes the place of a metric that cannot be used."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial

from harness.errors import Unmeasured, UsageError, one_line
from harness.eta.behaviour_change import Quantity
from harness.eta.headline import DECIDING
from harness.eta.interval import are_bounds
from harness.measure import Measure, bounds_of, is_error, is_share
from harness.record.manifest import Manifest
from harness.record.trace import Trace
from harness.registry.choice import Choice, choose, split_list
from harness.registry.names import unknown_name
from harness.registry.registry import Registry
from harness.registry.sources import fingerprint
from harness.results.measured import unmeasured_if_it_raises

BETTER = ("higher", "lower")


@dataclass(frozen=True)
class Unmeasurable:
    """Takes the place of a metric that cannot be used, and says why for every trace. So the rest of a report works."""

    reason: str
    unit: str = ""
    better: str = "higher"

    def __call__(self, trace: Trace) -> float | None:
        """Raises Unmeasured."""
        raise Unmeasured(self.reason)


def load_metrics(registry: Registry, names: Iterable[str] | None = None) -> dict[str, Measure]:
    """Metrics by name. A metric that cannot be used is `Unmeasurable`, unless it was named.

    Args:
        registry: The plugins.
        names: Those to load, ``"work"`` or with parameters, several with commas, by their labels; what decides about
            the robot always stands before them. All that are registered if None.

    Raises:
        UsageError: A named one is not registered, or not installed.
        PluginError: A named one is broken.
    """
    if names is None:
        return {name: _usable(registry, name) for name in registry.names("metrics")}
    deciding = [name for name in DECIDING if name in registry.names("metrics")]
    chosen = dict.fromkeys(choose(registry, "metrics", name) for name in [*deciding, *split_list(names)])
    return {choice.label: choice.build(registry, "metrics") for choice in chosen}


def require_measures(names: Iterable[str], there: Iterable[str]) -> None:
    """See that an environment has these measures of behaviour.

    Raises:
        UsageError: It lacks one; says which there are.
    """
    known = list(there)
    for name in names:
        if name not in known:
            raise UsageError(unknown_name("measure", name, known))


def measure_of(name: str, metric: Measure, manner: str, episodes: int, manifest: Manifest) -> Quantity:
    """What a metric measures. A metric of the task's error gets the name and the unit of that error.

    Args:
        name: The name of the metric.
        metric: The metric.
        manner: See `Quantity`.
        episodes: How many episodes it is a share of, if it is a share.
        manifest: The manifest of one of the cells, which all do one task.
    """
    share, bounds = episodes if is_share(metric) else None, bounds_of(metric)
    if manifest.error and is_error(metric):
        title = name.replace("_", " ").replace("distance", manifest.error)
        return Quantity(name, manifest.unit, metric.better, manner, share, title, bounds)
    return Quantity(name, metric.unit, metric.better, manner, share, bounds=bounds)


def with_fingerprints(metrics: Mapping[str, Measure]) -> dict[str, tuple[Measure, str]]:
    """Each metric with its fingerprint. A metric whose sources cannot be read becomes `Unmeasurable`."""
    return {name: _fingerprinted(metric) for name, metric in metrics.items()}


def _fingerprinted(metric: Measure) -> tuple[Measure, str]:
    try:
        return metric, fingerprint(metric)
    except Exception as error:  # a plugin may be of any make
        instead = Unmeasurable(f"its sources cannot be read: {one_line(error)}")
        return instead, fingerprint(instead)


def _usable(registry: Registry, name: str) -> Measure:
    try:
        return unmeasured_if_it_raises(partial(_build, registry, name))
    except Unmeasured as error:
        return Unmeasurable(str(error))


def _build(registry: Registry, name: str) -> Measure:
    metric: Measure = Choice(name).build(registry, "metrics")
    if metric.better not in BETTER:
        raise Unmeasured(f"its 'better' is {metric.better!r}: allowed are {' and '.join(BETTER)}")
    if not are_bounds(bounds_of(metric)):
        raise Unmeasured(f"its 'bounds' are {bounds_of(metric)!r}: allowed are two numbers, the lower one first")
    return metric
