"""Data sets as their own libraries lay them out, written by the fewest calls."""

import json
from collections.abc import Mapping

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from harness.record.dataset.open_dataset import open_dataset
from tests.registered import REGISTRY

# An episode: ``observations`` (steps + 1, n), ``actions``, ``rewards``, ``infos``; ``attrs`` of the episode.


def episode(steps, seed=0, success=False, **attrs):
    """Numbers that are drawn, and a success in the last step or none."""
    rng = np.random.default_rng(seed)
    return {
        "observations": rng.normal(size=(steps + 1, 6)),
        "actions": rng.normal(size=(steps, 2)),
        "rewards": rng.normal(size=steps),
        "infos": {"success": np.array([False] * steps + [success])},
        "attrs": attrs,
    }


def opened(text, **settings):
    """The data set that a user's text names, with the installed formats."""
    return open_dataset(text, REGISTRY, **settings)


def write_minari(folder, episodes, **metadata):
    """A Minari data set."""
    (folder / "data").mkdir(parents=True)
    told = {"data_format": "hdf5", "minari_version": "0.5.4", "env_spec": '{"id": "Arm-v0"}', **metadata}
    (folder / "data" / "metadata.json").write_text(json.dumps(told))
    with h5py.File(folder / "data" / "main_data.hdf5", "w") as file:
        for number, one in enumerate(episodes):
            group = file.create_group(f"episode_{number}")
            group.attrs.update({"id": number, "total_steps": len(one["rewards"]), **one["attrs"]})
            for key in ("observations", "actions", "rewards", "infos"):
                _put(group, key, one[key])
            group["terminations"] = np.zeros(len(one["rewards"]), bool)
            group["truncations"] = np.zeros(len(one["rewards"]), bool)
    return folder


def _put(group, key, value):
    if isinstance(value, tuple):
        value = {f"_index_{number}": part for number, part in enumerate(value)}
    if isinstance(value, Mapping):
        inner = group.create_group(key)
        for name, part in value.items():
            _put(inner, name, part)
    else:
        group.create_dataset(key, data=value, chunks=True, maxshape=(None, *np.shape(value)[1:]))


def write_lerobot(
    folder,
    episodes,
    version="v3.0",
    row_group_size=1_000,
    drop=(),
    **info,
):
    """A LeRobot data set; frames do not have what was seen after the last one."""
    tables = [_frames(number, one, drop) for number, one in enumerate(episodes)]
    if version == "v3.0":
        files = {"data/chunk-000/file-000.parquet": pa.concat_tables(tables)}
    else:
        files = {f"data/chunk-000/episode_{number:06d}.parquet": table for number, table in enumerate(tables)}
    for name, table in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        pq.write_table(table, folder / name, row_group_size=row_group_size)
    (folder / "meta").mkdir()
    features = {
        "observation.state": {"dtype": "float32", "shape": [6], "names": {"motors": list("abcdef")}},
        "action": {"dtype": "float32", "shape": [2], "names": None},
        "observation.images.top": {"dtype": "video", "shape": [4, 4, 3], "names": None},
        **{
            name: {"dtype": "int64", "shape": [1], "names": None}
            for name in ("episode_index", "frame_index", "operator")
        },
        "next.reward": {"dtype": "float32", "shape": [1], "names": None},
        "next.success": {"dtype": "bool", "shape": [1], "names": None},
    }
    features = {name: feature for name, feature in features.items() if name not in drop}
    told = {"codebase_version": version, "robot_type": "arm", "fps": 10, "features": features, **info}
    (folder / "meta" / "info.json").write_text(json.dumps(told))
    return folder


def _frames(number, one, drop):
    steps = len(one["rewards"])
    columns = {
        "observation.state": pa.array(list(np.float32(one["observations"][:-1])), pa.list_(pa.float32())),
        "action": pa.FixedSizeListArray.from_arrays(np.float32(one["actions"]).ravel(), 2),
        "episode_index": np.full(steps, number),
        "frame_index": np.arange(steps),
        "operator": np.full(steps, number % 2),
        "next.reward": np.float32(one["rewards"]),
        "next.success": one["infos"]["success"][1:],
    }
    return pa.table({name: column for name, column in columns.items() if name not in drop})
