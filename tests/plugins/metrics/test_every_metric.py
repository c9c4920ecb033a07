"""What is the same question for every metric of the project; the contract asks the rest."""

import pytest

from harness.registry.choice import build_defaults
from harness_plugins.kit.metrics import recorded_trace
from tests.registered import REGISTRY

METRICS = build_defaults(REGISTRY, "metrics")


@pytest.mark.parametrize("name", METRICS)
def test_none_without_a_finished_episode(name):
    """Where every episode is cut off by the end of the trace there is no value."""
    assert METRICS[name](recorded_trace(0, ("",))) is None


def test_units_and_directions():
    """What the report says beside the values."""
    assert {name: f"{metric.unit} {metric.better}" for name, metric in METRICS.items()} == {
        "closest_distance": "m lower",
        "final_distance": "m lower",
        "ground_hits": " lower",
        "obstacle_hits": " lower",
        "optimality": " higher",
        "path_ratio": " lower",
        "smoothness": "rad/step^2 lower",
        "sparc": " higher",
        "spl": " higher",
        "steps_to_target": "steps lower",
        "success_rate": " higher",
        "time_to_target": "s lower",
        "timeouts": " lower",
        "work": "J lower",
    }
