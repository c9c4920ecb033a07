"""The same calls give the same states, whatever was before."""

import numpy as np

from harness.arrays import Float
from harness.env.logged_simulation import LoggedSimulation
from harness.progress import TrainingState
from harness.robot import Robot
from harness.simulator import Simulator, State
from harness.testing.simulators.simulations import (
    NUM_ENVS,
    PERIOD,
    copied,
    dive_into_the_ground,
    drive_out_and_back,
    opened,
    poses_near_home,
    same,
    way_into_the_ground,
)
from harness.testing.violations import check, require

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
