"""The interface that a metric fills: a pure function of a trace that uses no reward."""

from collections.abc import Iterable
from typing import Protocol

from harness.record.trace import Trace
from harness.registry.choice import Choice
from harness.registry.registry import Registry


class Metric(Protocol):
    """A frozen dataclass: how well a robot behaves, whatever it was paid."""

    @property
    def unit(self) -> str:
        """Of the value; empty where it has none."""

    @property
    def better(self) -> str:
        """``higher`` or ``lower``."""

    def __call__(self, trace: Trace) -> float | None:
        """The value over all finished episodes of a trace; None where it is not defined."""


def build_metrics(registry: Registry, names: Iterable[str] | None = None) -> dict[str, Metric]:
    """Metrics with their default parameters, by name: those of `names`, by default every registered one.

    Raises:
        UsageError: A metric is not registered, or a library that it requires is missing.
        PluginError: A metric cannot be imported.
    """
    chosen = registry.names("metrics") if names is None else names
    return {name: Choice(name).build(registry, "metrics") for name in chosen}
