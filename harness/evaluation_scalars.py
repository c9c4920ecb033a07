"""What an evaluation says, by names for TensorBoard."""

from harness.mean_return import mean_return
from harness.metric import Metric
from harness.plugins import Registry
from harness.trace import Trace

SECTION = "Evaluation"


def evaluation_scalars(trace: Trace, registry: Registry) -> dict[str, float]:
    """The return and every registered metric, those that are not defined left out: ``Evaluation/Success Rate``."""
    metrics: dict[str, Metric] = {name: registry.get("metrics", name).load()() for name in registry.names("metrics")}
    values = {"Cumulative Reward": mean_return(trace)}
    values |= {name.replace("_", " ").title(): metric(trace) for name, metric in metrics.items()}
    return {f"{SECTION}/{name}": float(value) for name, value in values.items() if value is not None}
