"""What one simulator makes of its orders."""

from contextlib import closing
from typing import NamedTuple

from harness.parity.orders import Orders, Setting
from harness.parity.placement import place_at
from harness.parity.track import Track, follow
from harness.simulator import Simulator


class Performance(NamedTuple):
    """A track of each order."""

    placed: Track
    driven: Track
    dived: Track | None


def perform(simulator: Simulator, setting: Setting, orders: Orders) -> Performance:
    """Open the simulator and do all that is ordered.

    Raises:
        SimulationDiverged: A number is not finite.
    """
    with closing(simulator.open(setting.robot, setting.episodes, setting.period)) as simulation:
        placed = place_at(simulation, orders.poses)
        driven = follow(simulation, orders.motion, setting.period)
        dived = None if orders.dives is None else follow(simulation, orders.dives, setting.period)
    return Performance(placed, driven, dived)
