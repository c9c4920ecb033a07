"""Whether each env of a simulation is its own: in its own place of the arrays, with its own ground contact."""

import inspect
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.robot import Robot
from harness.simulator import Simulator, State
from harness.testing.simulators.simulations import (
    NUM_ENVS,
    PERIOD,
    copied,
    opened,
    poses_near_home,
    start_at_home,
    turns,
    way_into_the_ground,
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
"""Of a simulation, with the names of their arguments."""
SHARES = np.array([1.0, 0.4, 0.7])
"""How far each env goes, as a share of the first one's way."""
MOVE = 0.2
"""The first env's way, as a share of what its joints can do in a period."""
TOLERANCE = 0.1
"""Of a way, as a share of it."""


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


@check("sim-batch-order")
def every_env_does_what_it_was_told(simulator: Simulator, robot: Robot) -> None:
    """Row k of the commands moves env k, and row k of the state belongs to env k: rows are not mixed up."""
    with opened(simulator, robot) as simulation:
        home = start_at_home(simulation, robot).qpos
        way = SHARES[:, None] * MOVE * robot.max_speed * PERIOD * turns(robot, 1)
        state = copied(simulation.drive(home + way, PERIOD))
    for name, told, wanted in (("goes by", state.qpos - home, way), ("has the speed", state.qvel, way / PERIOD)):
        for env in range(NUM_ENVS):
            if _is_near(told[env], wanted[env]):
                continue
            others = [other for other in range(NUM_ENVS) if other != env and _is_near(told[env], wanted[other])]
            # Where it is nobody's way, the arm does not track at all: another check says so.
            require(
                not others,
                f"joint 1 of env {env} {name} {told[env][0]:.3g}, it was told {wanted[env][0]:.3g}; the other is what "
                f"env {others[0] if others else 0} was told: the envs come in another order",
            )


@check("sim-contact-per-env")
def ground_contact_is_the_envs_own(simulator: Simulator, robot: Robot) -> None:
    """If one arm is in the ground, only its own env reports contact: the envs that stay at home touch nothing."""
    with opened(simulator, robot) as simulation:
        home = start_at_home(simulation, robot)
        targets = home.qpos.copy()
        for qpos in way_into_the_ground(robot):
            targets[0] = qpos
            state = copied(simulation.drive(targets, PERIOD))
            contact, stays = state.ground_contact, (np.abs(state.qpos - home.qpos) < TOLERANCE).all(axis=1)
            new = contact & ~home.ground_contact & stays  # who left home was told so: another check says it
            told = f"env 0 alone goes into the ground, and ground_contact goes from {home.ground_contact.tolist()} to "
            require(not new[1:].any(), f"{told}{contact.tolist()}: the others stand at home")


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


def _is_near(told: Float, wanted: Float) -> bool:
    return bool((np.abs(told - wanted) <= TOLERANCE * np.abs(wanted)).all())
