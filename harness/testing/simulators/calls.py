"""The calls of a simulation: what they are named, whose arrays they take and give, and that it can be closed."""

import inspect
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.robot import Robot
from harness.simulator import Simulator, State
from harness.testing.simulators.simulations import (
    NUM_ENVS,
    PERIOD,
    copied,
    drive_out_and_back,
    opened,
    poses_near_home,
    same,
    start_at_home,
)
from harness.testing.violations import check, require

METHODS: Mapping[str, tuple[str, ...]] = {
    "reset": ("qpos", "mask"),
    "drive": ("qpos", "duration"),
    "place": ("qpos",),
    "read": (),
    "render": ("env", "target", "width", "height"),
    "close": (),
}
"""The methods of a simulation, with the names of their arguments."""


@check("sim-methods")
def a_simulation_has_its_methods(simulator: Simulator, robot: Robot) -> None:
    """What `open` returns has `reset`, `drive`, `place`, `read`, `render` and `close`, with the right arguments."""
    with opened(simulator, robot, 1) as simulation:
        for name, arguments in METHODS.items():
            method = getattr(simulation, name, None)
            require(callable(method), f"{type(simulation).__name__} has no method {name}()")
            taken = list(inspect.signature(method).parameters) if method else []
            fits = _takes(method, arguments)
            require(fits, f"{name}({', '.join(taken)}) cannot be called as {name}({', '.join(arguments)}): rename them")


@check("sim-read")
def read_returns_the_state_of_the_last_call(simulator: Simulator, robot: Robot) -> None:
    """`read` returns, each time, the state that the last `reset` or `drive` returned."""
    with opened(simulator, robot) as simulation:
        for call in (start_at_home, lambda *given: drive_out_and_back(*given)[-1]):
            state = call(simulation, robot)
            for _ in range(2):
                require(same([simulation.read()], [state]), "read() tells another state")


@check("sim-arguments")
def arguments_are_copied(simulator: Simulator, robot: Robot) -> None:
    """The caller's arrays are neither changed nor kept: what the caller does to them later changes nothing."""
    runs = [_called_with_changing_arrays(simulator, robot, change) for change in (0.0, 1.0)]
    require(same(*runs), "an array that the caller changed after the call is part of the state")


@check("sim-state-owned")
def states_are_not_the_callers_arrays(simulator: Simulator, robot: Robot) -> None:
    """A state holds the engine's own values: none of its arrays is one that the caller passed in."""
    with opened(simulator, robot) as simulation:
        qpos = poses_near_home(robot, NUM_ENVS)
        calls: dict[str, Callable[[Float], State]] = {
            "reset": lambda given: simulation.reset(given, np.ones(NUM_ENVS, bool)),
            "place": simulation.place,
            "drive": lambda given: simulation.drive(given, PERIOD),
        }
        for name, call in calls.items():
            given = qpos.copy()
            state = call(given)
            for field, array in state._asdict().items():
                require(not np.shares_memory(array, given), f"{name}(qpos) returns the caller's own qpos as {field}")


@check("sim-close")
def close_can_be_called_twice(simulator: Simulator, robot: Robot) -> None:
    """`close` releases the engine, and a second call does nothing."""
    simulation = simulator.open(robot, NUM_ENVS, PERIOD)
    simulation.close()
    simulation.close()


def _takes(method: Any, arguments: tuple[str, ...]) -> bool:
    """Whether a method can be called with these arguments, by position and by name."""
    if not callable(method):
        return False
    signature = inspect.signature(method)
    try:
        signature.bind(*arguments)
        signature.bind(**dict.fromkeys(arguments))
    except TypeError:
        return False
    return True


def _called_with_changing_arrays(simulator: Simulator, robot: Robot, change: float) -> list[State]:
    """The states of calls with the same joint positions, in arrays that are changed after the call."""
    mask, states = np.ones(NUM_ENVS, bool), []
    with opened(simulator, robot) as simulation:
        reset = partial(simulation.reset, mask=mask)
        drive = partial(simulation.drive, duration=PERIOD)
        for call in (reset, drive, drive, simulation.place, drive):
            qpos = np.tile(robot.home, (NUM_ENVS, 1))
            states.append(copied(call(qpos)))
            require((qpos == robot.home).all() and mask.all(), "the caller's array was changed")
            qpos += change
    return states
