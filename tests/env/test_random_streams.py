"""The random streams of a batch."""

import numpy as np
from numpy.random import default_rng
from numpy.testing import assert_array_equal

from harness.env.random_streams import AHEAD, Streams
from harness.task import ReachTask, Targets
from tests.refusals import refused
from tests.registered import FD100 as ROBOT

TIP = np.array([0.5, 0.0, 0.5])


class Ladder(ReachTask):
    """Targets one after the other, every second one counted from the end effector."""

    def draw_targets(self, robot, rng, count):
        """0, 1, 2, ... [m] on the x axis."""
        return Targets(np.arange(count)[:, None] * [1.0, 0.0, 0.0], np.arange(count) % 2 == 1)


def test_relative_targets_count_from_the_end_effector():
    """The others from the world's origin, in the order in which they were drawn."""
    streams = Streams(Ladder(), ROBOT, 1, 0)
    drawn = [streams.target(0, TIP)[0] for _ in range(4)]
    assert_array_equal(drawn, [[0.0, 0.0, 0.0], [1.5, 0.0, 0.5], [2.0, 0.0, 0.0], [3.5, 0.0, 0.5]])


def test_targets_come_in_the_order_of_the_stream():
    """Drawing ahead does not show."""
    streams, rng = Streams(ReachTask(), ROBOT, 1, [7]), np.random.SeedSequence(7).spawn(2)[1]
    generator = default_rng(rng)
    expected = [ReachTask().draw_targets(ROBOT, generator, AHEAD).position for _ in range(2)]
    assert_array_equal([streams.target(0, TIP)[0] for _ in range(2 * AHEAD)], np.concatenate(expected))


def test_target_apart_skips_those_that_one_is_in():
    """The first target of an episode is farther than epsilon from the end effector."""
    streams = Streams(Ladder(epsilon=0.6), ROBOT, 1, 0)
    assert_array_equal(streams.target_apart(0, np.zeros(3), ROBOT.home)[0], [1.0, 0.0, 0.0])


def test_targets_that_all_cover_the_start_are_refused():
    """Rather than to search for ever."""
    with refused("epsilon=100"):
        Streams(Ladder(epsilon=100.0), ROBOT, 1, 0).target_apart(0, np.zeros(3), ROBOT.home)


def test_envs_do_not_share_a_stream():
    """What one draws changes nothing for the other, starts or targets."""
    one, other = (Streams(ReachTask(), ROBOT, 2, 3) for _ in range(2))
    for _ in range(40):
        one.target(0, TIP)
        one.start(0)
    assert_array_equal(one.target(1, TIP)[0], other.target(1, TIP)[0])
    assert_array_equal(one.start(1), other.start(1))


def test_starts_and_targets_do_not_share_a_stream():
    """However many targets an episode took, the next start is the same."""
    one, other = (Streams(ReachTask(), ROBOT, 1, 3) for _ in range(2))
    for _ in range(40):
        one.target(0, TIP)
    assert_array_equal(one.start(0), other.start(0))


def test_equal_seeds_meet_the_same():
    """What each meets alone: the first 40 targets, whatever the envs beside it drew before."""
    many, alone = Streams(ReachTask(), ROBOT, 3, [7, 8, 7]), Streams(ReachTask(), ROBOT, 1, [7])
    first = [many.target(0, TIP)[0] for _ in range(40)]
    third = [many.target(2, TIP)[0] for _ in range(40)]
    assert_array_equal(first, [alone.target(0, TIP)[0] for _ in range(40)])
    assert_array_equal(first, third)


def test_equal_seeds_are_drawn_once():
    """To see which targets an arm reaches is what takes the time of a start."""
    drawn = []

    class Counted(ReachTask):
        def draw_targets(self, robot, rng, count):
            drawn.append(count)
            return super().draw_targets(robot, rng, count)

    streams = Streams(Counted(), ROBOT, 256, [k % 4 for k in range(256)])
    for env in range(256):
        streams.target(env, TIP)
    assert len(drawn) == 4
