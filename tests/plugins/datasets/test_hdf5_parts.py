"""An HDF5 file has no end that a reader would have to wait for."""

from itertools import pairwise

import h5py
import pytest

from harness.errors import SchemaError
from harness_plugins.datasets.dataset import MOST_KEYS
from tests.record.dataset.written import episode, opened, write_minari


def _changed(folder):
    return h5py.File(write_minari(folder / "d", [episode(3)]) / "data/main_data.hdf5", "a")


def _read(folder):
    opened(f"minari:{folder / 'd'}").rows()


@pytest.mark.parametrize("part", ["infos", "observations"])
def test_groups_that_are_reached_in_many_ways_are_refused(tmp_path, part):
    """Groups that are reached in many ways are refused: 30 names at each of 7 depths would be 22 billion."""
    with _changed(tmp_path) as file:
        if part == "observations":
            del file["episode_0/observations"]
            file.create_group("episode_0/observations")
        levels = [file[f"episode_0/{part}"], *(file.create_group(f"level_{depth}") for depth in range(7))]
        for level, below in pairwise(levels):
            for number in range(30):
                level[f"k{number}"] = below
    with pytest.raises(SchemaError, match="another name for a group"):
        _read(tmp_path)


def test_a_group_in_itself_is_refused(tmp_path):
    """A group in itself is refused."""
    with _changed(tmp_path) as file:
        file["episode_0/infos/again"] = file["episode_0/infos"]
    with pytest.raises(SchemaError, match="another name for a group"):
        _read(tmp_path)


def test_the_parts_of_an_episode_are_counted_together(tmp_path):
    """The parts of an episode are counted together, not by group."""
    with _changed(tmp_path) as file:
        for number in range(3):
            for key in range(MOST_KEYS // 2):
                file.create_dataset(f"episode_0/infos/{number}/{key}", data=[0.0])
    with pytest.raises(SchemaError, match=f"more than {MOST_KEYS:,} parts"):
        _read(tmp_path)


def test_rows_times_columns_are_bounded(tmp_path):
    """Rows times columns are bounded, before any is read: a file of some kilobytes may declare them."""
    steps = 10_000_000
    with _changed(tmp_path) as file:
        group = file["episode_0"]
        for key, shape in (("observations", (steps + 1, 16_000)), ("actions", (steps, 2)), ("rewards", (steps,))):
            del group[key]
            group.create_dataset(key, shape=shape, dtype="f4")
        group.attrs["total_steps"] = steps
    with pytest.raises(SchemaError, match=r"160,0.* numbers, 20,000,000,000 are allowed"):
        _read(tmp_path)
