"""LeRobot's frames become pieces, whatever files and groups of rows they lie in."""

import json
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from harness.errors import NewerFormat, SchemaError, UsageError
from harness.record.dataset import lerobot
from harness.record.dataset.dataset import RECORDED
from harness.record.dataset.labels import FAILURE, SUCCESS
from harness.record.dataset.open_dataset import open_dataset
from tests.record.dataset.written import episode, write_lerobot


@pytest.mark.parametrize("version", ["v2.0", "v2.1", "v3.0"])
def test_every_known_version_is_read(tmp_path: Path, version: str) -> None:
    """Every known version is read."""
    episodes = [episode(4), episode(3, 1)]
    pieces = list(open_dataset(f"lerobot:{write_lerobot(tmp_path / 'd', episodes, version)}").pieces())
    counts = [
        tuple(sum(count(piece) for piece in pieces if piece.episode == number) for count in (len, lambda it: it.seen))
        for number in (0, 1)
    ]
    assert counts == [(4, 3), (3, 2)]


@pytest.mark.parametrize("rows", [2, 3, 5, 100])
def test_batches_do_not_change_the_steps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rows: int) -> None:
    """Batches do not change the steps."""
    monkeypatch.setattr(lerobot, "ROWS", rows)
    episodes = [episode(7), episode(1, 1), episode(4, 2)]
    pieces = list(open_dataset(f"lerobot:{write_lerobot(tmp_path / 'd', episodes)}").pieces())
    for number in (0, 2):
        actions = np.concatenate([piece.actions for piece in pieces if piece.episode == number])
        after = np.concatenate([piece.observations[1:] for piece in pieces if piece.episode == number])
        assert np.array_equal(actions, np.float32(episodes[number]["actions"]))
        assert np.array_equal(after, np.float32(episodes[number]["observations"][1:-1]))


@pytest.mark.parametrize("rows", [2, 3, 100])
def test_a_success_in_the_last_frame_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rows: int) -> None:
    """A success in the last frame counts."""
    monkeypatch.setattr(lerobot, "ROWS", rows)
    folder = write_lerobot(tmp_path / "d", [episode(4, success=True), episode(4, 1)])
    pieces = list(open_dataset(f"lerobot:{folder}").pieces())
    told = [np.concatenate([piece.told for piece in pieces if piece.episode == number]).tolist() for number in (0, 1)]
    assert told == [[FAILURE, FAILURE, FAILURE, SUCCESS], [FAILURE] * 4]


@pytest.mark.parametrize("rows", [2, 3, 100])
def test_every_episode_ends_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rows: int) -> None:
    """Every episode ends once."""
    monkeypatch.setattr(lerobot, "ROWS", rows)
    folder = write_lerobot(tmp_path / "d", [episode(4), episode(3, 1), episode(2, 2)])
    assert [piece.episode for piece in open_dataset(f"lerobot:{folder}").pieces() if piece.is_last] == [0, 1, 2]


def test_names_and_rewards_come_from_the_data_set(tmp_path: Path) -> None:
    """Names and rewards come from the data set."""
    facts = open_dataset(f"lerobot:{write_lerobot(tmp_path / 'd', [episode(3)])}").facts
    assert (facts.names["observation"], facts.rewards) == (tuple("abcdef"), (RECORDED,))
    assert (facts.success, facts.operator) == ("next.success", "operator")


def test_a_newer_version_is_one_line(tmp_path: Path) -> None:
    """A newer version is one line."""
    with pytest.raises(NewerFormat, match=r"version v4.0, and v2.0, v2.1, v3.0 are read: it is newer"):
        open_dataset(f"lerobot:{write_lerobot(tmp_path / 'd', [episode(3)], codebase_version='v4.0')}")


@pytest.mark.parametrize("column", ["action", "episode_index", "frame_index"])
def test_a_missing_column_is_one_line(tmp_path: Path, column: str) -> None:
    """A missing column is one line."""
    folder = write_lerobot(tmp_path / "d", [episode(3)], drop=[column])
    with pytest.raises(SchemaError, match=f"tells of no column {column}"):
        open_dataset(f"lerobot:{folder}")


def test_a_column_that_only_the_metadata_has_is_one_line(tmp_path: Path) -> None:
    """A column that only the metadata has is one line."""
    folder = write_lerobot(tmp_path / "d", [episode(3)])
    info = folder / "meta" / "info.json"
    told = json.loads(info.read_text())
    told["features"]["torque"] = {"dtype": "float32", "shape": [1], "names": None}
    info.write_text(json.dumps(told))
    with pytest.raises(SchemaError, match="has no column torque, of which"):
        list(open_dataset(f"lerobot:{folder}").pieces())


def test_frames_that_do_not_follow_are_refused(tmp_path: Path) -> None:
    """Frames that do not follow are refused."""
    folder = write_lerobot(tmp_path / "d", [episode(5)])
    (path,) = folder.glob("data/*/*.parquet")
    pq.write_table(pq.read_table(path).take([0, 1, 3, 4]), path)
    with pytest.raises(SchemaError, match="do not follow one another"):
        list(open_dataset(f"lerobot:{folder}").pieces())


def test_rows_of_another_width_are_refused(tmp_path: Path) -> None:
    """Rows of another width are refused."""
    folder = write_lerobot(tmp_path / "d", [episode(5)])
    info = folder / "meta" / "info.json"
    info.write_text(info.read_text().replace('"shape": [6]', '"shape": [7]'))
    with pytest.raises(SchemaError, match="other rows"):
        list(open_dataset(f"lerobot:{folder}").pieces())


def test_no_data_set_is_one_line(tmp_path: Path) -> None:
    """No data set is one line."""
    with pytest.raises(UsageError, match=r"meta/info\.json"):
        open_dataset(f"lerobot:{tmp_path}")
