"""Real runs: the same code raises no alarm, and a simulator that was made slower is found."""

import importlib
import os
from pathlib import Path

import pytest

from harness.registry.registry import load_registry
from harness_plugins.bench.contests import Entry, Setting
from harness_plugins.bench.measure import measure_speeds
from harness_plugins.bench.speeds import compare_speeds

pytestmark = pytest.mark.slow
RUNS, ROUNDS = 7, 5
"""Every two of seven runs are compared: 21 comparisons."""
HOOKS = """
import harness
@harness.hookimpl
def register_simulators(register):
    register("brakes", __name__ + "_arm:Brakes", summary="as kinematic, slower where the environment says so")
"""
ARM = """
import os, time
from dataclasses import dataclass
from harness_plugins.simulators.kinematic import Kinematic

SLOWER = float(os.environ.get("BRAKES_SLOWER", "0"))

@dataclass(frozen=True)
class Brakes(Kinematic):
    def open(self, robot, num_envs, control_period):
        opened = super().open(robot, num_envs, control_period)
        drive, clock = opened.drive, time.thread_time
        def slow(qpos, duration):
            begin = clock()
            state = drive(qpos, duration)
            end = clock() + SLOWER * (clock() - begin)
            while clock() < end:
                pass
            return state
        opened.drive = slow
        return opened
"""


@pytest.fixture
def measured(install, monkeypatch):
    """A run of 1 and 64 arms."""
    folder = str(Path(importlib.import_module(install("brakes", HOOKS, arm=ARM)).__file__ or "").parent)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [folder, os.environ.get("PYTHONPATH")])))
    entries = [Entry("simulators", "simulators", "brakes", size) for size in (1, 64)]
    return lambda: measure_speeds(load_registry(), entries, (), Setting(budget=1.0), ROUNDS, lambda *news: None)


def test_no_false_alarm_in_twenty_and_a_slowdown_is_found(measured, monkeypatch):
    """21 comparisons of the same code; then the simulator takes 1.5 times as long, and every line of it is named."""
    runs = [measured() for _ in range(RUNS)]
    pairs = [(old, new) for place, old in enumerate(runs) for new in runs[place + 1 :]]
    assert len(pairs) == 21
    assert not any(compare_speeds(old, new).slower for old, new in pairs)
    monkeypatch.setenv("BRAKES_SLOWER", "0.5")
    slower = compare_speeds(runs[-1], measured()).slower
    assert {"simulator"} <= {change.contender for change in slower}
    assert {change.title for change in slower} == {"brakes, 1 env", "brakes, 64 envs"}
