"""Data sets as LeRobot lays them out, versions 2.0, 2.1 and 3.0, and what may become of them.

By https://huggingface.co/docs/lerobot/lerobot-dataset-v3 and the page of version 2.1: ``next.reward`` and
``next.success`` of a row say what came of that row's action, and no row holds what was seen after the last one.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from tests.oracles.recorded_runs import MATTERS, NO_MATTER, answer_of, draw_runs, other_task
from tests.oracles.trial import Trial, call_json

VERSIONS = ("v2.0", "v2.1", "v3.0")
LEFT_OUT = r"(?i)left out|left over|no label|unlabel|nothing says|not listed|lists|belong"
COPIES = r"(?i)cop(y|ies)|equal|same|twice|duplicate|distinct"


@dataclass
class Layout:
    """How it is written: all that must not matter."""

    version: str = "v3.0"
    compression: str = "snappy"
    rows_of_group: int = 1_000
    chunk: int = 1_000
    files: int = 1
    lists: str = "fixed"
    scalars_in_lists: bool = False
    pay_type: str = "float32"
    label_type: str = "bool"
    label: str = "next.success"
    indent: int | None = 4
    newline: str = "\n"
    columns: Callable[[list[str]], list[str]] = field(default=list)
    extra: bool = False


@dataclass
class Parts:
    """Everything that will be written; what a change changes.

    Attributes:
        columns: Of all rows.
        episodes: A line of metadata for each episode.
        info: ``meta/info.json``.
        place: By row, the number of the file that it is written into.
    """

    columns: dict[str, Any]
    episodes: list[dict[str, Any]]
    info: dict[str, Any]
    place: NDArray[np.int64]
    layout: Layout

    def keep(self, rows):
        """Only these rows, by number or as a mask."""
        self.columns = {name: values[rows] for name, values in self.columns.items()}
        self.place = self.place[rows]


def draw_layout(rng):
    """Any."""
    return Layout(
        version=rng.choice(VERSIONS),
        compression=rng.choice(("snappy", "zstd", "gzip", "none")),
        rows_of_group=rng.choice((1, 3, 7, 1_000)),
        chunk=rng.choice((3, 1_000)),
        files=rng.choice((1, 1, 2, 4)),
        lists=rng.choice(("fixed", "list", "large")),
        scalars_in_lists=rng.random() < 0.15,
        pay_type=rng.choice(("float32", "float64")),
        label_type=rng.choice(("bool", "int64", "float32", "float64")),
        indent=rng.choice((None, 1, 4)),
        newline=rng.choice(("\n", "\n", "\r\n")),
        columns=rng.choice((list, sorted, lambda names: sorted(names, reverse=True))),
        extra=rng.random() < 0.3,
    )


def parts_of(runs, layout):
    """What stands in the files."""
    lengths = np.array([len(run) for run in runs])
    number = np.repeat(np.arange(len(runs)), lengths)
    frame = np.concatenate([np.arange(length) for length in lengths])
    columns = {
        "observation.state": np.concatenate([run.states[:-1] for run in runs]),
        "action": np.concatenate([run.actions for run in runs]),
        "next.reward": np.concatenate([run.rewards for run in runs]).astype(layout.pay_type),
        "next.done": frame == np.repeat(lengths, lengths) - 1,
        layout.label: np.concatenate([run.success for run in runs]),
        "timestamp": (frame / 10).astype(np.float32),
        "frame_index": frame,
        "episode_index": number,
        "index": np.arange(len(frame)),
        "task_index": np.repeat([run.task for run in runs], lengths),
    }
    if not np.isin(columns[layout.label], (0, 1)).all() and layout.label_type in {"bool", "int64"}:
        layout.label_type = "float32"
    columns[layout.label] = columns[layout.label].astype(layout.label_type)
    if layout.extra:
        columns["observation.effort"] = np.ones((len(frame), 3), np.float32)
        columns["annotation"] = np.full(len(frame), 7)
    is_three = layout.version == "v3.0"
    files = np.minimum(np.arange(len(runs)) * layout.files // len(runs), layout.files - 1)
    file_of = files if is_three else np.arange(len(runs))
    ends = np.cumsum(lengths)
    episodes = [
        {
            "episode_index": place,
            "tasks": [f"task {run.task}"],
            "length": len(run),
            **(
                {
                    "data/chunk_index": int(file_of[place]) // layout.chunk,
                    "data/file_index": int(file_of[place]) % layout.chunk,
                    "dataset_from_index": int(ends[place]) - len(run),
                    "dataset_to_index": int(ends[place]),
                    "meta/episodes/chunk_index": 0,
                    "meta/episodes/file_index": 0,
                }
                if is_three
                else {}
            ),
        }
        for place, run in enumerate(runs)
    ]
    return Parts(columns, episodes, _info(runs, columns, layout), file_of[number], layout)


def _info(runs, columns, layout):
    tasks, is_three = 1 + max(run.task for run in runs), layout.version == "v3.0"
    features = {
        name: {"dtype": str(values.dtype), "shape": list(values.shape[1:]) or [1], "names": None}
        for name, values in columns.items()
    }
    path = (
        "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
        if is_three
        else "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet"
    )
    return {
        "codebase_version": layout.version,
        "robot_type": "arm",
        "total_episodes": len(runs),
        "total_frames": sum(map(len, runs)),
        "total_tasks": tasks,
        **({} if is_three else {"total_videos": 0, "total_chunks": -(-len(runs) // layout.chunk)}),
        "chunks_size": layout.chunk,
        "fps": 10,
        "splits": {"train": f"0:{len(runs)}"},
        "data_path": path,
        "video_path": None,
        "features": features,
    }


def write(parts, folder):
    """All files."""
    layout, meta = parts.layout, folder / "meta"
    meta.mkdir(parents=True)
    _write_text(meta / "info.json", json.dumps(parts.info, indent=layout.indent), layout)
    tasks = [f"task {number}" for number in range(parts.info["total_tasks"])]
    if layout.version == "v3.0":
        # as pandas writes a table whose index is the task
        pq.write_table(
            pa.table({"task_index": np.arange(len(tasks)), "__index_level_0__": tasks}), meta / "tasks.parquet"
        )
        (meta / "episodes" / "chunk-000").mkdir(parents=True)
        pq.write_table(pa.Table.from_pylist(parts.episodes), meta / "episodes" / "chunk-000" / "file-000.parquet")
    else:
        lines = [{"task_index": number, "task": task} for number, task in enumerate(tasks)]
        _write_text(meta / "tasks.jsonl", "\n".join(map(json.dumps, lines)) + "\n", layout)
        _write_text(meta / "episodes.jsonl", "\n".join(map(json.dumps, parts.episodes)) + "\n", layout)
    for number in np.unique(parts.place).tolist():
        name = f"chunk-{number // layout.chunk:03d}/"
        name += f"file-{number % layout.chunk:03d}" if layout.version == "v3.0" else f"episode_{number:06d}"
        path = folder / "data" / f"{name}.parquet"
        path.parent.mkdir(parents=True, exist_ok=True)
        rows = parts.place == number
        table = {name: _column(values[rows], layout) for name, values in parts.columns.items()}
        table = {name: table[name] for name in layout.columns(list(table))}
        pq.write_table(pa.table(table), path, compression=layout.compression, row_group_size=layout.rows_of_group)


def put(runs, layout, folder):
    """All files of these episodes."""
    write(parts_of(runs, layout), folder)


def _column(values, layout):
    if isinstance(values, pa.Array):
        return values
    if values.ndim == 1 and not layout.scalars_in_lists:
        return pa.array(values)
    size = values.shape[1] if values.ndim > 1 else 1
    flat = pa.array(values.ravel())
    if layout.lists == "fixed":
        return pa.FixedSizeListArray.from_arrays(flat, size)
    ends = np.arange(0, len(flat) + 1, size)
    return (
        pa.ListArray.from_arrays(ends.astype(np.int32), flat)
        if layout.lists == "list"
        else pa.LargeListArray.from_arrays(ends, flat)
    )


def _write_text(path, text, layout):
    path.write_text(text, newline=layout.newline)


def ask(folder, *flags):
    """What `harness audit` says of it."""
    told, said = call_json("audit", f"lerobot:{folder}", *flags)
    return reduced(told), said


def reduced(told):
    """What is compared of an audit."""
    found = next(reward for reward in told["rewards"] if reward["reward"] == "recorded")
    return {
        "auc": found["success"]["value"],
        "answer": found["success"]["answer"],
        "successes": told["successes"],
        "failures": told["failures"],
    }


def rewritten(rng, folder, runs, changes, how):
    """The same episodes in another way; `how` is what writes them, what draws a layout, and what asks."""
    put, draw, ask = how
    change, layout = rng.choice(changes), draw(rng)
    put(change(runs, rng), layout, folder)
    return Trial(f"{change.__name__}, {layout}", lambda: ask(folder), [answer_of(runs)])


def altered(rng, folder, runs, changes, how):
    """Other episodes, whose answer follows."""
    (put, draw, ask), change = how, rng.choice(changes)
    changed = change(runs, rng)
    put(changed, draw(rng), folder)
    tells = LEFT_OUT if change.__name__ == "unlabel" else ""
    return Trial(change.__name__, lambda: ask(folder), [answer_of(changed)], tells=tells)


def no_matter(rng, folder):
    """Written in another way, in another order."""
    return rewritten(rng, folder, draw_runs(rng, rng.choice((1, 1, 2, 3))), NO_MATTER, (put, draw_layout, ask))


def copied(rng, folder, put, layout, draw, ask):
    """Some episodes stand there several times, under numbers of their own."""
    runs = draw_runs(rng)
    more = [*runs, *(rng.choice(runs) for _ in range(rng.randrange(1, 40)))]
    put(runs, layout, folder / "once")
    put(rng.sample(more, len(more)), draw(rng), folder / "often")
    right = {"auc": answer_of(runs)["auc"], "answer": ask(folder / "once")[0]["answer"]}
    return Trial("copies", lambda: ask(folder / "often"), [right], tells=COPIES)


def matters(rng, folder):
    """Other episodes: the answer is another, and follows."""
    runs = draw_runs(rng, rng.choice((1, 2)))
    changes = (*MATTERS, *((other_task,) if max(run.task for run in runs) else ()))
    return altered(rng, folder, runs, changes, (put, draw_layout, ask))


ORACLES = {
    "lerobot, written otherwise": no_matter,
    "lerobot, copies": partial(copied, put=put, layout=Layout(), draw=draw_layout, ask=ask),
    "lerobot, other episodes": matters,
}
