"""Minari's files become pieces; what lies elsewhere or is newer is refused."""

import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from harness.errors import NewerFormat, SchemaError, UsageError
from harness.record.dataset import dataset as sizes
from harness.record.dataset import minari
from harness.record.dataset.dataset import RECORDED
from harness.record.dataset.labels import FAILURE, SUCCESS
from harness.record.dataset.open_dataset import open_dataset
from tests.record.dataset.written import episode, write_minari


def test_an_episode_is_what_was_written(tmp_path: Path) -> None:
    """An episode is what was written."""
    one = episode(5, success=True)
    (piece,) = open_dataset(f"minari:{write_minari(tmp_path / 'd', [one])}").pieces()
    assert np.array_equal(piece.observations, one["observations"])
    assert np.array_equal(piece.actions, one["actions"])
    assert np.array_equal(piece.rewards[RECORDED], one["rewards"])


def test_infos_are_those_after_each_step(tmp_path: Path) -> None:
    """Infos are those after each step."""
    (piece,) = open_dataset(f"minari:{write_minari(tmp_path / 'd', [episode(5, success=True)])}").pieces()
    assert piece.infos["success"].tolist() == [False, False, False, False, True]
    assert piece.told.tolist() == [FAILURE] * 4 + [SUCCESS]


def test_a_data_set_is_found_by_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A data set is found by its name."""
    write_minari(tmp_path / "a" / "reach-v0", [episode(3)])
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    assert sum(len(piece) for piece in open_dataset("minari:a/reach-v0").pieces()) == 3


def test_long_episodes_come_in_pieces(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Long episodes come in pieces."""
    monkeypatch.setattr(minari, "ROWS", 4)
    one = episode(9, success=True)
    pieces = list(open_dataset(f"minari:{write_minari(tmp_path / 'd', [one])}").pieces())
    assert [(piece.first, len(piece), piece.is_last) for piece in pieces] == [
        (0, 4, False),
        (4, 4, False),
        (8, 1, True),
    ]
    assert np.array_equal(np.concatenate([piece.observations[1:] for piece in pieces]), one["observations"][1:])
    assert [SUCCESS in piece.told for piece in pieces] == [False, False, True]


def test_dicts_and_tuples_stay_what_they_are(tmp_path: Path) -> None:
    """Dicts and tuples stay what they are."""
    one = {**episode(3), "observations": {"goal": np.ones((4, 3)), "both": (np.zeros((4, 2)), np.ones(4, np.int64))}}
    (piece,) = open_dataset(f"minari:{write_minari(tmp_path / 'd', [one])}").pieces()
    assert piece.observations["goal"].shape == (4, 3)
    assert piece.observations["both"][1].tolist() == [1, 1, 1, 1]


def test_pictures_are_left_out_and_told(tmp_path: Path) -> None:
    """Pictures are left out and told."""
    one = {**episode(3), "observations": {"goal": np.ones((4, 3)), "camera": np.zeros((4, 9), np.uint8)}}
    space = (
        '{"type": "Dict", "subspaces": {"goal": {"dtype": "float64", "shape": [3]}, '
        '"camera": {"dtype": "uint8", "shape": [8, 8, 3]}}}'
    )
    found = open_dataset(f"minari:{write_minari(tmp_path / 'd', [one], observation_space=space)}")
    (piece,) = found.pieces()
    assert set(piece.observations) == {"goal"}
    assert found.facts.notes == ("Pictures and texts are left out: observations/camera",)


def test_the_spec_is_text(tmp_path: Path) -> None:
    """The spec is text."""
    assert open_dataset(f"minari:{write_minari(tmp_path / 'd', [episode(2)])}").facts.env == '{"id": "Arm-v0"}'


def test_who_made_an_episode_is_told(tmp_path: Path) -> None:
    """Who made an episode is told."""
    folder = write_minari(tmp_path / "d", [episode(2, operator="ann"), episode(2, operator="bob")])
    assert [piece.operator for piece in open_dataset(f"minari:{folder}").pieces()] == ["ann", "bob"]


def test_a_newer_version_is_one_line(tmp_path: Path) -> None:
    """A newer version is one line."""
    folder = write_minari(tmp_path / "d", [episode(2)], minari_version="0.6.0")
    with pytest.raises(NewerFormat, match=r"written by Minari 0.6, and versions up to 0.5 are read"):
        open_dataset(f"minari:{folder}")


def test_another_storage_is_one_line(tmp_path: Path) -> None:
    """Another storage is one line."""
    with pytest.raises(SchemaError, match="'arrow'"):
        open_dataset(f"minari:{write_minari(tmp_path / 'd', [episode(2)], data_format='arrow')}")


def test_no_data_set_says_where_it_was_looked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No data set says where it was looked for."""
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    with pytest.raises(UsageError, match="minari download a/b-v0"):
        open_dataset("minari:a/b-v0")


def test_a_missing_library_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A missing library is one line."""
    folder = write_minari(tmp_path / "d", [episode(2)])
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(UsageError, match=r"pip install 'fd100-harness\[minari\]'"):
        open_dataset(f"minari:{folder}")


@pytest.mark.parametrize("kind", ["external", "soft", "virtual"])
def test_numbers_in_other_files_are_not_read(tmp_path: Path, kind: str) -> None:
    """Numbers in other files are not read."""
    folder = write_minari(tmp_path / "d", [episode(2)])
    with h5py.File(tmp_path / "other.hdf5", "w") as other:
        other["rewards"] = np.ones(2)
    with h5py.File(folder / "data" / "main_data.hdf5", "a") as file:
        group = file["episode_0"]
        del group["rewards"]
        if kind == "external":
            group["rewards"] = h5py.ExternalLink(str(tmp_path / "other.hdf5"), "/rewards")
        elif kind == "soft":
            group["rewards"] = h5py.SoftLink("/episode_0/actions")
        else:
            layout = h5py.VirtualLayout((2,), float)
            layout[:] = h5py.VirtualSource(str(tmp_path / "other.hdf5"), "rewards", (2,))
            group.create_virtual_dataset("rewards", layout)
    with pytest.raises(SchemaError, match="not followed"):
        list(open_dataset(f"minari:{folder}").pieces())


def test_an_episode_without_its_last_observation_is_refused(tmp_path: Path) -> None:
    """An episode without its last observation is refused."""
    one = {**episode(3), "observations": np.zeros((3, 6))}
    with pytest.raises(SchemaError, match="one observation more than actions"):
        list(open_dataset(f"minari:{write_minari(tmp_path / 'd', [one])}").pieces())


def test_a_number_that_is_not_finite_is_a_flaw_of_its_episode(tmp_path: Path) -> None:
    """A number that is not finite is a flaw of its episode."""
    one = {**episode(3), "rewards": np.array([0.0, np.nan, 0.0])}
    pieces = open_dataset(f"minari:{write_minari(tmp_path / 'd', [one, episode(3, 1)])}").pieces()
    assert ["not a finite number" in piece.flaw for piece in pieces] == [True, False]


def test_too_many_steps_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Too many steps are refused."""
    monkeypatch.setattr(sizes, "MOST_STEPS", 4)
    with pytest.raises(SchemaError, match="more than 4 steps"):
        list(open_dataset(f"minari:{write_minari(tmp_path / 'd', [episode(3), episode(3)])}").pieces())


def test_a_missing_key_of_success_names_those_there_are(tmp_path: Path) -> None:
    """A missing key of success names those there are."""
    with pytest.raises(UsageError, match=r"--success won: .* it has success"):
        open_dataset(f"minari:{write_minari(tmp_path / 'd', [episode(3)])}", success="won")
