"""What calls mean, what repeats itself, what the envs of a batch have in common, and what shows after a long time."""

import inspect
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from harness import Float
from harness.algorithm import TrainingState
from harness.env.ideal import LoggedSimulation
from harness.robot import Robot
from harness.simulator import Simulator, State

from ..contract import check, require
from ..memory import require_no_growth, require_nothing_kept, resident
from .simulations import (
    NUM_ENVS,
    PERIOD,
    copied,
    dive_into_the_ground,
    drive_out_and_back,
    opened,
    part,
    poses_near_home,
    ramps,
    same,
    start_at_home,
    turns,
    way_into_the_ground,
)

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


RESETS = {1: (0,), 3: (1,), 4: (0,)}
"""Which envs are reset again, after so many periods, while the others go on."""
BACK = 5
"""Periods that they move on for, later."""


@check("sim-determinism")
def same_calls_give_same_states(simulator: Simulator, robot: Robot) -> None:
    """Two simulations that get the same calls return the same states, bit for bit."""
    runs = []
    for _ in range(2):
        with opened(simulator, robot) as simulation:
            driven = drive_out_and_back(simulation, robot)
            placed = copied(simulation.place(poses_near_home(robot, NUM_ENVS)))
            runs.append([*driven, placed, *dive_into_the_ground(simulation, robot)])
    require(same(*runs), "the same calls gave other states the second time")


@check("sim-reset-forgets")
def reset_forgets_what_was_before(simulator: Simulator, robot: Robot) -> None:
    """What an arm does after a reset does not depend, not by a bit, on what was before, not even on ground contact."""
    with opened(simulator, robot) as simulation:
        fresh = drive_out_and_back(simulation, robot)
        dive_into_the_ground(simulation, robot)
        again = drive_out_and_back(simulation, robot)
    require(same(fresh, again), "after a reset the arm moves differently than when it was new")


@check("sim-resume")
def the_same_way_leads_to_the_same_place(simulator: Simulator, robot: Robot) -> None:
    """An arm that gets all calls since its last reset again stands where it stood, bit for bit, and goes on alike.

    Whatever came before that reset, and whenever other envs were reset; touching the ground, too. Trainings that were
    killed go on from checkpoints that hold no more of the physics.
    """
    stood, went_on = _goes_on(simulator, robot, None)
    if not same(went_on, _goes_on(simulator, robot, None)[1]):
        return  # it does not even do the same in the same run: another check says so
    require(same(went_on, _goes_on(simulator, robot, stood)[1]), "an arm that stands where it stood moves differently")


def _goes_on(simulator: Simulator, robot: Robot, stood: TrainingState | None) -> tuple[TrainingState, list[State]]:
    """Where the arms stand when one has got into the ground, or where they `stood`; and their states from then on."""
    home, targets = np.tile(robot.home, (NUM_ENVS, 1)), _into_the_ground_and_back(robot)
    with opened(simulator, robot) as simulation:
        log = LoggedSimulation(simulation, robot, NUM_ENVS)
        if stood is None:
            log.reset(home, np.ones(NUM_ENVS, bool))
            for period, qpos in enumerate(targets[:-BACK]):
                log.drive(qpos, PERIOD)
                for env in RESETS.get(period, ()):
                    log.reset(home, np.arange(NUM_ENVS) == env)
            stood = log.state()
        else:
            log.restore(stood)
        return stood, [copied(log.drive(qpos, PERIOD)) for qpos in targets[-BACK:]]


def _into_the_ground_and_back(robot: Robot) -> list[Float]:
    """Joint targets of envs some of which are at home again after some periods, see `RESETS`."""
    way, done, targets = way_into_the_ground(robot), np.zeros(NUM_ENVS, int), []
    for period in range(len(way)):
        targets.append(way[done])
        done += 1
        done[list(RESETS.get(period, ()))] = 0
    for _ in range(BACK):
        done = np.maximum(done - 1, 0)
        targets.append(way[done])
    return targets


SHARES = np.array([1.0, 0.4, 0.7])
"""How far each env goes, as a share of the first one's way."""
MOVE = 0.2
"""The first env's way, as a share of what its joints can do in a period."""
TOLERANCE = 0.1
"""The tolerance of a way, as a share of it."""


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


@check("sim-batch-as-alone")
def an_env_in_a_batch_is_as_one_alone(simulator: Simulator, robot: Robot) -> None:
    """Each env of a batch has the same states, bit for bit, as an env alone that gets the same calls."""
    batch, alone = _driven_alike(simulator, robot, NUM_ENVS), _driven_alike(simulator, robot, 1)
    for env in range(NUM_ENVS):
        one = [part(state, np.array([env])) for state in batch]
        require(same(one, alone), f"env {env} of {NUM_ENVS} moves differently than one env alone")


@check("sim-env-isolation")
def envs_do_not_touch_one_another(simulator: Simulator, robot: Robot) -> None:
    """What an env does is the same, bit for bit, whatever commands the other envs get."""
    runs = [_driven_beside(simulator, robot, share) for share in (1.0, 0.5)]
    require(same(*runs), "env 1 moves differently when the others do")


@check("sim-rest")
def resting_arms_change_nothing(simulator: Simulator, robot: Robot) -> None:
    """If the simulation has `rest`, the other arms move as they do without it, and a reset wakes an arm."""
    with opened(simulator, robot) as simulation:
        if getattr(simulation, "rest", None) is None:
            return
    alone, beside = (_driven_with_rest(simulator, robot, rests) for rests in (False, True))
    require(same(alone[0], beside[0]), "an arm moves in another way while others rest")
    require(same(alone[1], beside[1]), "an arm that has rested and is reset does not move as one that has not")


def _is_near(told: Float, wanted: Float) -> bool:
    return bool((np.abs(told - wanted) <= TOLERANCE * np.abs(wanted)).all())


def _driven_alike(simulator: Simulator, robot: Robot, num_envs: int) -> list[State]:
    """The states of envs that are all told the same."""
    with opened(simulator, robot, num_envs) as simulation:
        start_at_home(simulation, robot, num_envs)
        targets = [np.repeat(target, num_envs, axis=0) for target in ramps(robot, 1)]
        return [copied(simulation.drive(target, PERIOD)) for target in targets]


def _driven_beside(simulator: Simulator, robot: Robot, share: float) -> list[State]:
    """The states of env 1 while the others go only a share of their way."""
    shares = np.where(np.arange(NUM_ENVS) == 1, 1.0, share)[:, None]
    with opened(simulator, robot) as simulation:
        home = start_at_home(simulation, robot).qpos
        targets = [home + shares * (target - home) for target in ramps(robot, NUM_ENVS)]
        return [part(copied(simulation.drive(target, PERIOD)), np.array([1])) for target in targets]


def _driven_with_rest(simulator: Simulator, robot: Robot, rests: bool) -> tuple[list[State], list[State]]:
    """The states of env 1 while the others may rest, then of all envs after a reset of those others."""
    one = np.arange(NUM_ENVS) == 1
    with opened(simulator, robot) as simulation:
        home = start_at_home(simulation, robot).qpos.copy()
        if rests:
            simulation.rest(~one)  # type: ignore[attr-defined]
        targets = ramps(robot, NUM_ENVS)
        beside = [part(copied(simulation.drive(target, PERIOD)), np.array([1])) for target in targets]
        simulation.reset(home, ~one)
        return beside, [part(copied(simulation.drive(target, PERIOD)), ~one) for target in targets]


STEPS = 10_000
WARM_UP = 0.2
"""The share of the steps in which a plugin may fill its caches."""
EPISODES = 5
"""Out and back, in which nothing may be kept."""


@check("sim-leak")
def nothing_is_kept_of_a_period(simulator: Simulator, robot: Robot) -> None:
    """The memory that Python's objects of a simulation take does not grow from episode to episode."""
    with opened(simulator, robot) as simulation:

        def play_episodes() -> None:
            for _ in range(EPISODES):
                drive_out_and_back(simulation, robot)

        require_nothing_kept(play_episodes, EPISODES * len(ramps(robot, NUM_ENVS)), "control periods")


@check("sim-long-run")
def a_long_simulation_neither_drifts_nor_leaks(simulator: Simulator, robot: Robot) -> None:
    """After 10,000 periods an episode is the same as at the beginning, bit for bit, and the process has not grown."""
    with opened(simulator, robot) as simulation:
        first = drive_out_and_back(simulation, robot)
        targets = ramps(robot, NUM_ENVS)
        warm_up = int(WARM_UP * STEPS)
        before = 0
        for step in range(STEPS):
            if step % len(targets) == 0:
                start_at_home(simulation, robot)
            simulation.drive(targets[step % len(targets)], PERIOD)
            if step == warm_up:
                before = resident()
        require_no_growth(before, STEPS - warm_up, "control periods")
        last = drive_out_and_back(simulation, robot)
    drift = max(np.abs(old.qpos - new.qpos).max() for old, new in zip(first, last, strict=True))
    told = f"after {STEPS:,} periods the same episode goes another way, by up to {drift:.2g} [rad or m] of a joint"
    require(same(first, last), told)
