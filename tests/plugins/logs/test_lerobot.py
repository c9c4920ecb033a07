"""LeRobot's frames become logs of steps, whatever files and groups of rows they lie in."""

import numpy as np
import pyarrow.parquet as pq
import pytest

from harness.errors import NewerFormat, SchemaError, UsageError
from harness_plugins.audit import audit_dataset
from harness_plugins.datasets import dataset as sizes
from tests.record.dataset.frames import write_frames
from tests.record.dataset.written import episode, opened, write_lerobot


@pytest.mark.parametrize("version", ["v2.0", "v2.1", "v3.0"])
def test_every_known_version_is_read(tmp_path, version):
    """Every known version is read."""
    rows = opened(f"lerobot:{write_lerobot(tmp_path / 'd', [episode(4), episode(3, 1)], version)}").rows()
    assert rows["episode"].tolist() == [0, 0, 0, 0, 1, 1, 1]
    assert rows["step"].tolist() == [1, 2, 3, 4, 1, 2, 3]
    assert rows["seen"].tolist() == [True, True, True, False, True, True, False]


@pytest.mark.parametrize("rows", [2, 3, 5, 100])
def test_batches_do_not_change_the_steps(tmp_path, monkeypatch, rows):
    """Batches do not change the steps; what was seen after the last one of an episode is not known."""
    monkeypatch.setattr(sizes, "ROWS", rows)
    episodes = [episode(7), episode(1, 1), episode(4, 2)]
    found = opened(f"lerobot:{write_lerobot(tmp_path / 'd', episodes)}").rows()
    for number, one in enumerate(episodes):
        mine = found.part(found["episode"] == number)
        assert np.array_equal(mine["action"], np.float32(one["actions"]))
        assert np.array_equal(mine["before/observation"], np.float32(one["observations"][:-1]))
        assert np.array_equal(mine["observation"][:-1], np.float32(one["observations"][1:-1]))
        assert np.isnan(mine["observation"][-1]).all()
        assert mine["seen"].tolist() == [True] * (len(mine) - 1) + [False]


@pytest.mark.parametrize("rows", [2, 3, 100])
def test_a_success_in_the_last_frame_counts(tmp_path, monkeypatch, rows):
    """A success in the last frame counts."""
    monkeypatch.setattr(sizes, "ROWS", rows)
    folder = write_lerobot(tmp_path / "d", [episode(4, success=True), episode(4, 1)])
    assert opened(f"lerobot:{folder}")["behaviour/success"].tolist() == [0.0, 0.0, 0.0, 1.0] + [0.0] * 4


def test_names_and_rewards_come_from_the_data_set(tmp_path):
    """Names and rewards come from the data set."""
    log = opened(f"lerobot:{write_lerobot(tmp_path / 'd', [episode(3)])}")
    assert (log.facts.names["observation"], log.rewards) == (tuple("abcdef"), ("recorded",))
    assert (log.facts.success, log.facts.operator) == ("next.success", "operator")


def _frames(steps, **columns):
    return {"observation.state": np.ones((steps, 3)), "action": np.ones((steps, 2)), **columns}


def test_several_episodes_that_are_stored_as_one_are_refused(tmp_path):
    """Twenty rollouts in one episode, as a recorder wrote that was not told of their ends: strands robots 708."""
    done = np.tile(np.arange(5) == 4, 20)
    folder = write_frames(tmp_path / "d", [_frames(100, **{"next.done": done})])
    with pytest.raises(SchemaError, match=r"episode 0: next.done ends it with frame 4, .* are stored as one"):
        opened(f"lerobot:{folder}").rows()


def test_frames_after_the_end_that_say_so_belong_to_the_episode(tmp_path):
    """A recorder goes on for some frames after a success, and each of them is done."""
    folder = write_frames(tmp_path / "d", [_frames(9, **{"next.done": np.arange(9) > 4}) for _ in range(2)])
    assert len(opened(f"lerobot:{folder}").rows(["episode"])) == 18


def test_a_newer_version_is_one_line(tmp_path):
    """A newer version is one line."""
    with pytest.raises(NewerFormat, match=r"version v4.0, and v2.0, v2.1, v3.0 are read: it is newer"):
        opened(f"lerobot:{write_lerobot(tmp_path / 'd', [episode(3)], codebase_version='v4.0')}")


@pytest.mark.parametrize("column", ["action", "episode_index", "frame_index"])
def test_a_missing_column_is_one_line(tmp_path, column):
    """A missing column is one line."""
    folder = write_lerobot(tmp_path / "d", [episode(3)], drop=[column])
    with pytest.raises(SchemaError, match=f"tells of no column {column}"):
        opened(f"lerobot:{folder}")


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            '"features": {',
            '"features": {"torque": {"dtype": "float32", "shape": [1], "names": null}, ',
            "has no column torque",
        ),
        ('"shape": [6]', '"shape": [7]', "other rows"),
    ],
)
def test_metadata_that_do_not_fit_are_one_line(tmp_path, old, new, told):
    """A column that they alone have, and rows of another width."""
    folder = write_lerobot(tmp_path / "d", [episode(5)])
    info = folder / "meta" / "info.json"
    info.write_text(info.read_text().replace(old, new))
    with pytest.raises(SchemaError, match=told):
        opened(f"lerobot:{folder}").rows()


def test_frames_that_do_not_follow_are_refused(tmp_path):
    """Frames that do not follow are refused."""
    folder = write_lerobot(tmp_path / "d", [episode(5)])
    (path,) = folder.glob("data/*/*.parquet")
    pq.write_table(pq.read_table(path).take([0, 1, 3, 4]), path)
    with pytest.raises(SchemaError, match="do not follow one another"):
        opened(f"lerobot:{folder}").rows()


def test_no_data_set_is_one_line(tmp_path):
    """No data set is one line."""
    with pytest.raises(UsageError, match=r"meta/info\.json"):
        opened(f"lerobot:{tmp_path}")


def test_a_folder_without_success_answers_as_far_as_it_can(tmp_path):
    """Recorded pay and functions are told apart, labels from a file rank them, and what is missing is said."""
    pay = np.random.default_rng(0).normal(size=(10, 6))
    episodes = [_frames(6, **{"next.reward": row, "observation.state": np.outer(row, np.ones(3))}) for row in pay]
    text = f"lerobot:{write_frames(tmp_path / 'd', episodes)}"
    opposite = {
        "recorded": lambda step: float(step.info["next.reward"]),
        "less": lambda step: -step.info["next.reward"],
    }
    found = audit_dataset(text, opposite)
    assert (found.successes, found.failures, found.pairs[0].steps.value) == (0, 0, pytest.approx(1.0))
    assert any("--success KEY, or give --labels episodes.csv or --success-above RETURN" in note for note in found.notes)
    labels = tmp_path / "labels.csv"
    labels.write_text("episode,success\n" + "".join(f"{number},{number % 2}\n" for number in range(10)))
    (ranked,) = audit_dataset(text, labels=labels).rewards
    returns = np.float32(pay).sum(axis=1, dtype=float)
    assert ranked.by_success.value == pytest.approx(np.mean(returns[1::2][:, None] > returns[::2]))
