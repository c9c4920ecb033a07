"""What one simulator makes of its orders."""

from contextlib import closing
from typing import NamedTuple

from harness.env.solid_probes import Probe, find_missing
from harness.simulator import Simulator

from .classes import CONTACT, SMOOTH
from .orders import Orders, Setting
from .placement import place_at
from .track import Track, follow


class Performance(NamedTuple):
    """A track of each order."""

    placed: Track
    driven: Track
    dived: Track | None
    others: dict[str, Track]
    """The tracks of the other classes of motions."""
    missing: tuple[Probe, ...]
    """The solids that it lacks."""

    @property
    def classes(self) -> dict[str, Track]:
        """The tracks of every class of motions."""
        dived = {} if self.dived is None else {CONTACT: self.dived}
        return {SMOOTH: self.driven, **dived, **self.others}


def perform(simulator: Simulator, setting: Setting, orders: Orders) -> Performance:
    """Open the simulator and do all that is ordered.

    Raises:
        SimulationDiverged: A number is not finite.
    """
    with closing(simulator.open(setting.robot, setting.episodes, setting.period)) as simulation:
        placed = place_at(simulation, orders.poses)
        driven = follow(simulation, orders.motion, setting.period)
        dived = None if orders.dives is None else follow(simulation, orders.dives, setting.period)
        others = {name: follow(simulation, motion, setting.period) for name, motion in orders.others.items()}
        missing = find_missing(simulation, orders.probes, setting.episodes)
    return Performance(placed, driven, dived, others, missing)
