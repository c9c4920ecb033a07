"""Minari's files become logs of steps; what lies elsewhere or is newer is refused."""

import sys

import h5py
import numpy as np
import pytest

from harness.errors import NewerFormat, SchemaError, UsageError
from harness_plugins.datasets import dataset as sizes
from tests.record.dataset.written import episode, opened, write_minari


def read(text, **settings):
    """All columns of a data set."""
    return opened(text, **settings).rows()


def test_an_episode_is_what_was_written(tmp_path):
    """An episode is what was written; infos are those after each step."""
    one = episode(5, success=True)
    rows = read(f"minari:{write_minari(tmp_path / 'd', [one])}")
    assert np.array_equal(rows["before/observation"], one["observations"][:-1])
    assert np.array_equal(rows["observation"], one["observations"][1:])
    assert np.array_equal(rows["action"], one["actions"])
    assert np.array_equal(rows["reward/recorded"], one["rewards"])
    assert (rows["step"].tolist(), rows["terminated"].tolist()) == ([1, 2, 3, 4, 5], [False] * 5)
    assert rows["info/success"].tolist() == [False, False, False, False, True]
    assert rows["behaviour/success"].tolist() == [0.0, 0.0, 0.0, 0.0, 1.0]


def test_a_data_set_is_found_by_its_name(tmp_path, monkeypatch):
    """A data set is found by its name."""
    write_minari(tmp_path / "a" / "reach-v0", [episode(3)])
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    assert len(read("minari:a/reach-v0")) == 3


def test_long_episodes_come_in_parts(tmp_path, monkeypatch):
    """Long episodes come in parts, which hold what was written."""
    monkeypatch.setattr(sizes, "ROWS", 4)
    one = episode(9, success=True)
    log = opened(f"minari:{write_minari(tmp_path / 'd', [one])}")
    parts = list(log.tables(log.names))
    assert [part["step"].tolist() for part in parts] == [[1, 2, 3, 4], [5, 6, 7, 8], [9]]
    assert np.array_equal(np.concatenate([part["observation"] for part in parts]), one["observations"][1:])
    assert np.array_equal(np.concatenate([part["before/observation"] for part in parts]), one["observations"][:-1])
    assert [part["behaviour/success"].max() for part in parts] == [0.0, 0.0, 1.0]


def test_parts_of_an_observation_are_columns(tmp_path):
    """Those of a dict by their key, those of a tuple by their number."""
    one = {**episode(3), "observations": {"goal": np.ones((4, 3)), "both": (np.zeros((4, 2)), np.arange(4))}}
    rows = read(f"minari:{write_minari(tmp_path / 'd', [one])}")
    assert rows["observation/goal"].shape == (3, 3)
    assert rows["observation/both/_index_1"].tolist() == [1, 2, 3]
    assert rows["before/observation/both/_index_1"].tolist() == [0, 1, 2]


def test_pictures_are_left_out_and_told(tmp_path):
    """Pictures are left out and told."""
    one = {**episode(3), "observations": {"goal": np.ones((4, 3)), "camera": np.zeros((4, 9), np.uint8)}}
    space = (
        '{"type": "Dict", "subspaces": {"goal": {"dtype": "float64", "shape": [3]}, '
        '"camera": {"dtype": "uint8", "shape": [8, 8, 3]}}}'
    )
    found = opened(f"minari:{write_minari(tmp_path / 'd', [one], observation_space=space)}")
    assert [name for name in found.names if name.startswith("observation")] == ["observation/goal"]
    assert found.facts.notes == ("Pictures and texts are left out: observations/camera",)


def test_who_made_an_episode_is_told(tmp_path):
    """Who made an episode is told; the spec is text."""
    folder = write_minari(tmp_path / "d", [episode(2, operator="ann"), episode(2, operator="bob")])
    log = opened(f"minari:{folder}")
    assert log["operator"].tolist() == ["ann", "ann", "bob", "bob"]
    assert log.facts.env == '{"id": "Arm-v0"}'


@pytest.mark.parametrize(
    ("more", "attributes", "error", "told"),
    [
        ({}, {"minari_version": "0.6.0"}, NewerFormat, "written by Minari 0.6, and versions up to 0.5 are read"),
        ({}, {"data_format": "arrow"}, SchemaError, "'arrow'"),
        ({"observations": np.zeros((2, 6))}, {}, SchemaError, "one observation more than actions"),
    ],
    ids=["newer", "another storage", "without its last observation"],
)
def test_what_is_not_read_is_one_line(tmp_path, more, attributes, error, told):
    """What is not read is one line."""
    folder = write_minari(tmp_path / "d", [{**episode(2), **more}], **attributes)
    with pytest.raises(error, match=told):
        read(f"minari:{folder}")


def test_no_data_set_says_where_it_was_looked_for(tmp_path, monkeypatch):
    """No data set says where it was looked for."""
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    with pytest.raises(UsageError, match="minari download a/b-v0"):
        opened("minari:a/b-v0")


def test_a_missing_library_is_one_line(tmp_path, monkeypatch):
    """A missing library is one line."""
    folder = write_minari(tmp_path / "d", [episode(2)])
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(UsageError, match=r"pip install 'fd100-harness\[minari\]'"):
        opened(f"minari:{folder}")


@pytest.mark.parametrize("kind", ["external", "soft", "virtual"])
def test_numbers_in_other_files_are_not_read(tmp_path, kind):
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
        read(f"minari:{folder}")


def test_too_many_steps_are_refused(tmp_path, monkeypatch):
    """Too many steps are refused."""
    monkeypatch.setattr(sizes, "MOST_VALUES", 40)
    with pytest.raises(SchemaError, match="numbers, 40 are allowed"):
        read(f"minari:{write_minari(tmp_path / 'd', [episode(3), episode(3)])}")


def test_a_missing_key_of_success_names_those_there_are(tmp_path):
    """A missing key of success names those there are."""
    with pytest.raises(UsageError, match=r"--success won: .* It has: success"):
        opened(f"minari:{write_minari(tmp_path / 'd', [episode(3)])}", success="won")
