"""Fixtures for tests of plugins. If the harness is installed, pytest loads them by itself. See docs/authoring.md.

Nothing is imported before a test asks for a fixture, since every pytest on the machine loads this module.
"""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from pathlib import Path

    from harness.env.vector_env import ReachVectorEnv
    from harness.record import Manifest
    from harness.simulator import Simulation


MARK = "harness"
DEFAULTS = {"sim": "kinematic", "task": "fd100-reach", "reward": "baseline", "robot": None, "num_envs": 1}
CELL_DEFAULTS = {"algo": "random", "steps": 64, "evaluation_episodes": 2}


def pytest_configure(config: pytest.Config) -> None:
    """Make the marker known."""
    config.addinivalue_line(
        "markers",
        f"{MARK}(sim=, task=, reward=, robot=, num_envs=, algo=, steps=, evaluation_episodes=): what the fixtures "
        "reach_env, simulation and cell of a test consist of",
    )


@pytest.fixture
def reach_env(request: pytest.FixtureRequest) -> "Iterator[ReachVectorEnv]":
    """A vector env with what the test's marker names. It is closed when the test ends."""
    from harness import make_env

    given = _given(request, DEFAULTS)
    env = make_env(given["sim"], given["task"], given["reward"], given["robot"], given["num_envs"])
    yield env
    env.close()


@pytest.fixture
def simulation(request: pytest.FixtureRequest) -> "Iterator[Simulation]":
    """The simulator that the marker names, open with its robot and number of envs; closed at the test's end."""
    from .opened import open_simulation

    given = _given(request, DEFAULTS)
    opened = open_simulation(given["sim"], given["robot"], given["num_envs"], task=given["task"])
    yield opened.simulation
    opened.simulation.close()


@pytest.fixture
def cell(request: pytest.FixtureRequest, tmp_path: "Path") -> "tuple[Path, Manifest]":
    """The folder and the manifest of a cell, trained and evaluated in this process with what the marker names."""
    from .opened import train_cell

    given = _given(request, {**DEFAULTS, **CELL_DEFAULTS})
    del given["num_envs"]  # an algorithm says itself how many
    return train_cell(tmp_path / "cell", **given)


@pytest.fixture
def stepping() -> Iterator[Callable[..., Callable[[], object]]]:
    """A function: ``stepping(simulator, num_envs=1, period=0.1, robot="fd100")`` opens a simulator.

    The function that it returns drives all arms for one control period: ``benchmark(stepping("my_sim", 64))``.
    """
    from contextlib import ExitStack, closing

    from .opened import driven, open_simulation

    with ExitStack() as stack:

        def step(
            simulator: str, num_envs: int = 1, period: float = 0.1, robot: str | None = None
        ) -> Callable[[], object]:
            opened = open_simulation(simulator, robot, num_envs, period=period)
            stack.enter_context(closing(opened.simulation))
            return driven(opened)

        yield step


def _given(request: pytest.FixtureRequest, defaults: dict[str, Any]) -> dict[str, Any]:
    """The marker's settings. If several markers name the same one, the nearest to the test decides.

    Raises:
        pytest.UsageError: It has an argument that no fixture takes.
    """
    found = dict(defaults)
    for mark in reversed(list(request.node.iter_markers(MARK))):
        unknown = [*map(repr, mark.args), *(set(mark.kwargs) - {*DEFAULTS, *CELL_DEFAULTS})]
        if unknown:
            allowed = ", ".join([*DEFAULTS, *CELL_DEFAULTS])
            raise pytest.UsageError(f"pytest.mark.{MARK} does not take {', '.join(unknown)}; by name: {allowed}")
        found |= {key: value for key, value in mark.kwargs.items() if key in found}
    return found
