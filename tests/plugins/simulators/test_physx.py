"""PhysX: contact of the end of a period, worlds that are given back, joints that turn without end."""

import resource

import numpy as np

from tests.plugins.simulators.conftest import home


def test_worlds_are_given_back(open_arms):
    """A reset makes a new world; a thousand of them take no more memory than the first hundred, to 20 MB."""
    simulation, everyone = open_arms(1), np.ones(1, bool)

    def peak_after(resets):
        for _ in range(resets):
            simulation.reset(home(1), everyone)
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024

    before = peak_after(100)
    assert peak_after(1000) - before < 20
