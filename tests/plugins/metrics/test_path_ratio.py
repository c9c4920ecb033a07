"""How direct the way to the target is."""

import numpy as np
import pytest

from harness.errors import Unmeasured
from harness.log import trace_of
from harness.record import EpisodeFacts
from harness.record.trace import with_episode_facts
from harness_plugins.kit.metrics import recorded_trace
from harness_plugins.metrics.episodes import PathRatio, Spl


def walk(*paths, reached=True):
    """Episodes whose end effector goes along these points."""
    points = np.array([point for path in paths for point in path], float)
    last = np.cumsum([len(path) for path in paths]) - 1
    ended = np.isin(np.arange(len(points)), last)
    return trace_of(
        {
            "env": np.zeros(len(points), np.int32),
            "episode": np.repeat(np.arange(len(paths), dtype=np.int32), [len(path) for path in paths]),
            "reward": np.zeros(len(points)),
            "ground": np.zeros(len(points), bool),
            "reached": ended & reached,
            "terminated": ended & reached,
            "truncated": ended & (not reached),
            **{f"end_effector_{axis}": points[:, column] for column, axis in enumerate("xyz")},
        }
    )


STRAIGHT = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (3.0, 0.0, 0.0)]
CORNER = [(0.0, 0.0, 0.0), (3.0, 0.0, 0.0), (3.0, 4.0, 0.0)]
BACK = [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)]


@pytest.mark.parametrize(("path", "ratio"), [(STRAIGHT, 1.0), (CORNER, 7 / 5), (BACK, 5.0)])
def test_length_of_the_path_over_the_straight_line(path, ratio):
    """From where the episode starts to where it ends; 1 is straight, whatever the speed."""
    assert PathRatio()(walk(path)) == pytest.approx(ratio)


def test_mean_over_the_episodes():
    """Each episode counts once, however long it is."""
    assert PathRatio()(walk(STRAIGHT, BACK)) == pytest.approx(3.0)


def test_way_from_one_episode_to_the_next_is_none():
    """Where the next episode starts does not count."""
    far = [(100.0 + x, y, z) for x, y, z in STRAIGHT]
    assert PathRatio()(walk(STRAIGHT, far, STRAIGHT)) == pytest.approx(1.0)


def test_envs_are_told_apart():
    """The rows of two arms that move at once are two paths."""
    one, two = walk(STRAIGHT), walk(CORNER)
    both = {name: np.stack([one[name], two[name]], axis=1).ravel() for name in one.columns}
    both["env"] = np.tile(np.array([0, 1], np.int32), 3)
    assert PathRatio()(trace_of(both)) == pytest.approx(1.2)


def test_only_episodes_that_reach_the_target_count():
    """The end of another is anywhere."""
    trace = recorded_trace(0, ("reached", "ground", "truncated", ""))
    alone = recorded_trace(0, ("reached",))
    assert PathRatio()(trace) == PathRatio()(alone)


def test_way_back_to_the_start_has_no_ratio():
    """Its straight line has no length: it does not count, and alone it gives no value."""
    loop = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)]
    assert PathRatio()(walk(loop)) is None
    assert PathRatio()(walk(loop, CORNER)) == pytest.approx(1.4)


def test_path_ends_where_the_target_is_reached_first():
    """An episode that goes on to other targets counts up to its first."""
    trace = walk(CORNER + BACK, reached=False)
    trace["reached"][[1, 4]] = True
    assert PathRatio()(trace) == pytest.approx(1.0)
    trace["reached"][1] = False
    assert PathRatio()(trace) > 5.0


@pytest.mark.parametrize("seed", range(5))
def test_never_below_one(seed):
    """Nothing is shorter than a straight line."""
    assert PathRatio()(recorded_trace(seed, ("reached", "reached"))) >= 1.0 - 1e-12


def test_none_where_no_episode_reaches_it():
    """Where the target is never reached there is no value."""
    assert PathRatio()(recorded_trace(0, ("truncated", "ground"))) is None


@pytest.mark.parametrize("metric", [PathRatio(), Spl()])
def test_target_that_moves_has_no_straight_line(metric):
    """It says so."""
    trace = recorded_trace(0, ("reached",))
    with pytest.raises(Unmeasured, match="the target moves"):
        metric(with_episode_facts(trace, EpisodeFacts(target_moves=True)))
