"""Long runs find what grows and what drifts."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

import harness
from harness.env.ideal import IdealSimulation
from harness.registry.registry import load_registry
from harness.robot import Robot
from harness.simulator import State
from harness_plugins.kit import IdealSimulator, violations
from harness_plugins.kit.simulators import calls as long_runs

REGISTRY = load_registry()
ROBOT = harness.load_robot("fd100", REGISTRY)
STEPS = 1_500
KEPT = 40_000
"""Numbers that a leaking mutant keeps of each step."""


@pytest.fixture
def shorter(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take fewer steps."""
    monkeypatch.setattr(long_runs, "STEPS", STEPS)


class KeepsEveryState(IdealSimulation):
    """A history that nobody reads."""

    history: ClassVar[list[np.ndarray]] = []

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        self.history.append(np.ones(KEPT))
        return super().drive(qpos, duration)


class Drifts(IdealSimulation):
    """After a thousand drives a joint is a little beside its target, and stays there."""

    drives = 0

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        self.drives += 1
        return super().drive(qpos + 1e-9 * (self.drives > 1000), duration)


@dataclass(frozen=True)
class Opens(IdealSimulator):
    """Opens a mutant."""

    kind: type[IdealSimulation]

    def open(self, robot: Robot, num_envs: int, control_period: float) -> IdealSimulation:
        return self.kind(robot, num_envs)


FOUND: dict[str, tuple[Any, str]] = {
    "simulator leaks": (Opens(KeepsEveryState), "the process grew by"),
    "simulator drifts": (Opens(Drifts), "the same episode goes another way, by up to 1e-09"),
}


@pytest.fixture
def forget() -> Any:
    """Give back what the mutants keep."""
    yield
    KeepsEveryState.history.clear()


@pytest.mark.usefixtures("shorter", "forget")
@pytest.mark.parametrize("name", FOUND)
def test_what_shows_after_a_while_is_found(name: str):
    """In fewer steps than the kit takes."""
    mutant, words = FOUND[name]
    (violation,) = violations([long_runs.a_long_simulation_neither_drifts_nor_leaks], mutant, ROBOT)
    assert words in violation.sentence


@pytest.mark.usefixtures("shorter")
def test_nothing_is_found_where_nothing_is_wrong():
    """The kit's own simulator."""
    assert not list(violations([long_runs.a_long_simulation_neither_drifts_nor_leaks], IdealSimulator(), ROBOT))


@pytest.mark.slow
@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize("simulator", REGISTRY.names("simulators"))
def test_simulators_last(simulator: str):
    """10,000 periods of every installed simulator."""
    built = REGISTRY.get("simulators", simulator).load()()
    assert not list(violations([long_runs.a_long_simulation_neither_drifts_nor_leaks], built, ROBOT))
