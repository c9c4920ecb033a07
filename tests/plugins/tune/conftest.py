"""Searches that take a moment: an ideal arm whose success grows with the setting `effort`, all in this process."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from harness.experiment.workers.order import Order
from harness.registry.registry import Registry
from harness_plugins.tune.trial import Tuned
from harness_plugins.tune.tune import tune
from harness_plugins.tune.tuning import Setup, check_tuning, resolve

QUICK: dict[str, Any] = {
    "sim": "ideal",
    "algo": "sweep",
    "reward": "arp",
    "task": "fd100-reach:epsilon=0.2,horizon=5",
    "search": {"effort": "0..1"},
    "trials": 3,
    "seeds": 1,
    "steps": 2,
    "validation_episodes": 10,
}


@pytest.fixture
def make_setup(toys: Registry) -> Callable[..., Setup]:
    """A search resolved; some keys may be said otherwise."""
    return lambda **keys: resolve(check_tuning({**QUICK, **keys}), toys)


@pytest.fixture
def tune_here(toys: Registry, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Tuned]:
    """Tune without a process for anything; some keys may be said otherwise."""

    def validate_all(orders: Sequence[Order], at_once: int) -> None:
        for order in orders:
            if not order.folder.exists():
                order.work.do(order.folder, lambda steps: None)

    monkeypatch.setattr("harness_plugins.tune.outcomes.validate_all", validate_all)
    return lambda **keys: tune(**{"out": tmp_path / "tuning", "executor": "here", "jobs": 1, **QUICK, **keys})
