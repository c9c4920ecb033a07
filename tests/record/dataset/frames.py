"""LeRobot's folders as its own library lays them out: frames, totals and the list of episodes."""

import json
from collections.abc import Mapping

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

# Frames of an episode: by column, its values, (frames, ...).


def write_frames(
    folder,
    episodes,
    version="v3.0",
    listed: Mapping = {},  # only read
    **how,
):
    """A data set of such episodes; `listed` says more of each, and None leaves out the list of episodes."""
    tables, begin = [], 0
    for number, one in enumerate(episodes):
        steps = len(one["action"])
        index = {"episode_index": np.full(steps, number), "frame_index": np.arange(steps)}
        index |= {"index": begin + np.arange(steps), "timestamp": np.arange(steps) / 10.0}
        tables.append(pa.table({key: _column(np.asarray(value)) for key, value in {**one, **index}.items()}))
        begin += steps
    if version == "v3.0":
        files = {"file-000.parquet": pa.concat_tables(tables)}
    else:
        files = {f"episode_{number:06d}.parquet": table for number, table in enumerate(tables)}
    (folder / "data/chunk-000").mkdir(parents=True)
    (folder / "meta").mkdir()
    for name, table in files.items():
        pq.write_table(table, folder / "data/chunk-000" / name, **how)
    features = {key: _feature(np.asarray(value)) for key, value in {**episodes[0], **index}.items()}
    told = {"codebase_version": version, "total_episodes": len(episodes), "total_frames": begin, "features": features}
    (folder / "meta/info.json").write_text(json.dumps(told))
    if listed is not None:
        _list(folder, [len(one["action"]) for one in episodes], version, listed)
    return folder


def info_of(folder):
    """What ``meta/info.json`` says."""
    told = json.loads((folder / "meta/info.json").read_text())
    return told


def _column(values):
    if values.ndim == 1:
        return np.float32(values) if values.dtype == np.float64 else values
    return pa.FixedSizeListArray.from_arrays(np.float32(values).ravel(), values.shape[1])


def _feature(values):
    kind = "float32" if values.dtype == np.float64 else str(values.dtype)
    return {"dtype": kind, "shape": list(values.shape[1:]) or [1], "names": None}


def _list(folder, lengths, version, listed):
    rows = [
        {
            "episode_index": number,
            "tasks": ["reach"],
            "length": length,
            **{key: it[number] for key, it in listed.items()},
        }
        for number, length in enumerate(lengths)
    ]
    if version == "v3.0":
        place = folder / "meta/episodes/chunk-000"
        place.mkdir(parents=True)
        rows = [{**row, "data/chunk_index": 0, "data/file_index": 0, "stats/action/max": [1.0, 2.0]} for row in rows]
        pq.write_table(pa.Table.from_pylist(rows), place / "file-000.parquet")
    else:
        (folder / "meta/episodes.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
