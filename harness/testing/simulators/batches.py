"""Whether each env of a simulation is its own: in its own place of the arrays, whatever the others do."""

import numpy as np

from harness.arrays import Float
from harness.robot import Robot
from harness.simulator import Simulator, State
from harness.testing.simulators.simulations import (
    NUM_ENVS,
    PERIOD,
    copied,
    opened,
    part,
    ramps,
    same,
    start_at_home,
    turns,
)
from harness.testing.violations import check, require

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
