"""Episodes to be shown."""

from dataclasses import replace

import numpy as np
import pytest

from harness.errors import SchemaError, UsageError
from harness.log import trace_of
from harness.record import read_trace
from harness.results import replay
from harness.results.replay import ShownCells, choose, first_show, show_cells, shows_of
from harness_plugins.kit.metrics import recorded_trace

R, G, T = "reached", "ground", "time-out"


def test_every_way_to_end_is_chosen_first():
    """Of both sides, however late it comes first; then the others in order."""
    baseline = [R] * 90 + [T, R, G]
    proposed = [R, T] * 46 + [G]
    chosen = choose([baseline, proposed])
    assert (chosen[:5], chosen[5:7], len(chosen)) == ([0, 90, 92, 1, 2], [3, 4], 93)


def test_the_evaluation_that_decides_is_shown(recorded):
    """The one in the other manner, where that has more episodes."""
    (combination,) = recorded.combinations
    cells = tuple((cell,) for cell in recorded.done_cells)
    assert ShownCells(cells, "", (), combination).files == ["evaluation.parquet"] * 2
    more = replace(
        combination, measured=replace(combination.measured, episodes={"deterministic": 1, "stochastic": 100})
    )
    assert ShownCells(cells, "", (), more).files == ["stochastic.parquet"] * 2


def test_an_episode_alone_has_the_metrics_of_the_whole(recorded):
    """The mean over all episodes is that of the evaluation, where every episode has a value."""
    (show,) = shows_of(recorded)
    for side in show.sides:
        own = recorded.measured(recorded.done[0].cell if side is show.sides[0] else recorded.done[1].cell).own
        for name in ("success_rate", "time_to_target", "final_distance", "timeouts"):
            assert np.mean([it.values[name] for it in side.episodes]) == pytest.approx(own[name]), name


def test_both_sides_of_a_show_begin_alike(recorded):
    """The same poses, the same targets, under both rewards."""
    (show,) = shows_of(recorded)
    baseline, proposed = show.sides
    assert (baseline.title, proposed.title) == ("Baseline: baseline", "Proposed: arp")
    assert len(show.numbers) == len(baseline.episodes) == 4
    for one, other in zip(baseline.episodes, proposed.episodes, strict=True):
        np.testing.assert_array_equal(one.qpos[0], other.qpos[0])
        np.testing.assert_array_equal(one.target[0], other.target[0])


def test_an_episode_is_what_was_recorded(recorded):
    """Joint positions, distances and what was paid are those of the trace; the arm is where these say."""
    (show,) = shows_of(recorded)
    side = show.sides[1]
    trace = read_trace(recorded.store.cell_folder(recorded.done_cells[1]) / "evaluation.parquet")
    rows, episode = trace.episodes[0], side.episodes[0]
    kept = rows[episode.steps]
    np.testing.assert_array_equal(episode.qpos, trace["qpos"][kept])
    np.testing.assert_array_equal(episode.distance, trace["distance"][kept])
    events = sum(trace[f"reward_{event}"][rows].sum() for event in ("ground", "target", "step"))
    assert episode.paid[-1] == pytest.approx(trace["reward"][rows].sum() + events)
    assert episode.steps[-1] == len(rows) - 1


def test_cells_are_shown_by_the_beginnings_of_their_ids(recorded):
    """In the order in which they are named."""
    one, other = (manifest.cell for manifest in recorded.manifests)
    show = show_cells(recorded, [other.id[:8], one.id], 2)
    assert [side.title for side in show.sides] == [f"{it.reward.label} · seed {it.seed}" for it in (other, one)]
    assert show.numbers == (1, 2)


def test_an_id_that_no_cell_has_is_refused(recorded):
    """The message says where ids stand."""
    with pytest.raises(UsageError, match=r"results\.parquet"):
        show_cells(recorded, ["zz"])


def test_cells_of_an_earlier_version_are_not_shown(recorded):
    """Without a scene there is nothing to draw; a film of nothing is refused."""
    for path in recorded.folder.glob("cells/*/scene.json"):
        path.unlink()
    assert shows_of(recorded) == ()
    with pytest.raises(UsageError, match="earlier version"):
        first_show(recorded, 3)


def test_an_arm_of_other_joints_is_refused(recorded):
    """A scene that does not belong to the recording is damaged."""
    for path in recorded.folder.glob("cells/*/scene.json"):
        path.write_text(
            path.read_text().replace(
                '"joints":[{', '"joints":[{"frame":[1,0,0,0,0,1,0,0,0,0,1,0],"axis":[0,0,1],"slides":false},{'
            )
        )
    with pytest.raises(SchemaError, match="7 joints"):
        shows_of(recorded)


def test_an_obstacle_is_a_way_to_end_and_is_shown():
    """Those that a trace does not have are none; seven zeros are none either."""
    trace = recorded_trace(0, ("obstacle", "ground"))
    first, second = trace.episodes
    assert [replay.Way(trace, rows).outcome for rows in (first, second)] == ["obstacle", "ground"]
    assert replay._obstacles(trace, first).shape == (0, 7)
    sphere = [0.5, 0.1, 0.6, 0.0, 0.0, 0.0, 0.08]
    cluttered = trace_of({**trace.rows().columns, "obstacles": np.tile([*sphere, *[0.0] * 7], (len(trace), 1))})
    np.testing.assert_array_equal(replay._obstacles(cluttered, first), [sphere])
