"""Where the end effector went in evaluation episodes."""

import numpy as np
import pytest

from harness import load_results
from harness.record import COLUMN, SCALARS, Manifest, TraceWriter
from harness.registry import Choice
from harness.results import Comparison, Group
from harness.results.replay import trajectories_of
from tests.stores import create_store

REACHED = [(0, 0, 0, 1, 0), (1, 0, 0, 1, 1)]


@pytest.fixture
def recorded(tmp_path, make_cell, make_plan):
    """Evaluations by reward and seed, each a list of episodes, and the comparison of arp with the baseline."""

    def record(**evaluations):
        cells = {
            make_cell(reward=Choice(label, (), label), seed=seed): episodes
            for label, runs in evaluations.items()
            for seed, episodes in runs.items()
        }
        store = create_store(tmp_path / "experiment", make_plan(*cells))
        for cell, episodes in cells.items():
            folder = store.cell_folder(cell)
            folder.mkdir(parents=True)
            with TraceWriter(folder / "evaluation.parquet", dof=1, action_size=1) as writer:
                for number, points in enumerate(episodes):
                    writer.append(_rows(number, np.array(points, float)))
            Manifest(cell, status="done").write(folder)
        seeds = tuple(sorted(set.intersection(*(set(runs) for runs in evaluations.values()))))
        group = Group.of(next(iter(cells)))
        proposed = list(evaluations)[-1]
        return load_results(store.folder), Comparison(group, "baseline", proposed, seeds)

    return record


def _rows(number, points):
    """An episode that goes along `points`, (rows, 5), and ends with the last one."""
    rows = np.zeros((len(points), len(SCALARS) + 2))
    rows[:, COLUMN["episode"]] = number
    for column, name in enumerate(("end_effector_x", "end_effector_y", "end_effector_z", "target_x", "reached")):
        rows[:, COLUMN[name]] = points[:, column]
    rows[-1, COLUMN["truncated"]] = 1.0
    return rows


def test_path_goes_from_the_start_to_the_target(recorded):
    """Every row of an episode that reaches it, in order, and the target."""
    found = trajectories_of(
        *recorded(baseline={0: [[(0, 0, 0, 3, 0), (1, 2, 3, 3, 0), (2.98, 0, 0, 3, 1)]]}, arp={0: [REACHED]})
    )
    (path,) = found.baseline
    np.testing.assert_array_equal(path.points, [[0, 0, 0], [1, 2, 3], [2.98, 0, 0]])
    np.testing.assert_array_equal(path.target, [3, 0, 0])
    assert path.reached


def test_path_of_a_miss_goes_to_the_end(recorded):
    """Also where it was near before."""
    miss = [(0, 0, 0, 3, 0), (2, 0, 0, 3, 0), (1, 0, 0, 3, 0)]
    (path,) = trajectories_of(*recorded(baseline={0: [REACHED]}, arp={0: [miss]})).proposed
    assert path.points[:, 0].tolist() == [0, 2, 1]
    assert not path.reached


def test_path_ends_where_the_target_is_reached_first(recorded):
    """Where the episode goes on with another target: the first one is kept."""
    on = [*REACHED, (2, 0, 0, 5, 0), (5, 0, 0, 5, 1)]
    (path,) = trajectories_of(*recorded(baseline={0: [on]}, arp={0: [REACHED]})).baseline
    assert (path.points[:, 0].tolist(), path.target.tolist()) == ([0, 1], [1, 0, 0])


def test_first_seed_of_both_is_read(recorded):
    """The first that was finished under both rewards; at most so many episodes of it."""
    other = [(7, 0, 0, 9, 0), (8, 0, 0, 9, 0)]
    rewards = {
        "baseline": {0: [REACHED], 1: [REACHED], 2: [REACHED]},
        "arp": {2: [REACHED], 1: [other] * 35},
    }
    found = trajectories_of(*recorded(**rewards))
    assert found.seed == 1
    assert len(found.proposed) == 30
    assert found.proposed[0].points[0, 0] == 7


def test_no_pair_no_paths(recorded):
    """Without a seed that both rewards finished."""
    assert trajectories_of(*recorded(baseline={0: [REACHED]}, arp={1: [REACHED]})) is None


def test_null_control_has_no_paths(recorded):
    """It has one reward, and asks nothing about its behaviour."""
    assert trajectories_of(*recorded(baseline={0: [REACHED]})) is None
