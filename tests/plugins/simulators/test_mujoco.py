"""MuJoCo: the threads of a batch do not show; what it cannot load is named."""

from tests.plugins.simulators.conftest import assert_same, home, wander


def test_number_of_threads_does_not_show(open_arms):
    """One thread and two give the same states, bit for bit."""
    assert_same(*(wander(open_arms(7, threads=threads), 7, 60)[0] for threads in (1, 2)))


def test_more_threads_than_arms(open_arms):
    """Threads without an arm are no error."""
    assert open_arms(2, threads=4).drive(home(2), 0.1).qpos.shape == (2, 6)
