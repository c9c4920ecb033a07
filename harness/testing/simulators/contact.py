"""Contact with the ground: seen where it is, in the env where it is, and nowhere else."""

import numpy as np

from harness.env.solid_probes import find_missing, missing_in_words, probes_of
from harness.robot import Robot
from harness.simulator import Simulator
from harness.testing.simulators.simulations import (
    PERIOD,
    copied,
    dive_into_the_ground,
    drive_out_and_back,
    opened,
    start_at_home,
    way_into_the_ground,
)
from harness.testing.violations import check, require

STAYS = 0.1
"""So far from home, [rad] or a slide's share of it, is an arm at most that stays there; see `Robot.per_radian`."""


@check("sim-ground-contact")
def ground_contact_is_seen(simulator: Simulator, robot: Robot) -> None:
    """An arm that is driven into the ground touches it."""
    with opened(simulator, robot) as simulation:
        contacts = [state.ground_contact for state in dive_into_the_ground(simulation, robot)]
        require(np.any(contacts, axis=0).all(), "the arm was driven into the ground and touched nothing")


@check("sim-solids")
def every_solid_touches_the_ground(simulator: Simulator, robot: Robot) -> None:
    """Where one collision shape alone is in the ground, and all others above it, the arm touches: none was dropped."""
    with opened(simulator, robot, 1) as simulation:
        probes = probes_of(robot)
        missing = find_missing(simulation, probes)
    touches_nothing = len(missing) == len(probes) > 1  # another check says it
    require(
        not missing or touches_nothing,
        f"{missing_in_words(missing)}: where it alone is in the ground, the arm touches nothing",
    )


@check("sim-no-false-contact")
def no_ground_contact_in_the_air(simulator: Simulator, robot: Robot) -> None:
    """An arm at home, or moving about it, does not touch the ground."""
    with opened(simulator, robot) as simulation:
        for state in drive_out_and_back(simulation, robot):
            require(not state.ground_contact.any(), "the arm touches the ground in the air")


@check("sim-contact-per-env")
def ground_contact_is_the_envs_own(simulator: Simulator, robot: Robot) -> None:
    """If one arm is in the ground, only its own env reports contact: the envs that stay at home touch nothing."""
    with opened(simulator, robot) as simulation:
        home = start_at_home(simulation, robot)
        targets = home.qpos.copy()
        for qpos in way_into_the_ground(robot):
            targets[0] = qpos
            state = copied(simulation.drive(targets, PERIOD))
            contact, stays = (
                state.ground_contact,
                (np.abs(state.qpos - home.qpos) < STAYS * robot.per_radian).all(axis=1),
            )
            new = contact & ~home.ground_contact & stays  # who left home was told so: another check says it
            told = f"env 0 alone goes into the ground, and ground_contact goes from {home.ground_contact.tolist()} to "
            require(not new[1:].any(), f"{told}{contact.tolist()}: the others stand at home")
