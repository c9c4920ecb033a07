"""Trainings whose numbers a test knows, written as the programs of others write them: one function a kind of file."""

import csv
import gzip
import json
from pathlib import Path

import numpy as np
import pytest

REWARD, SUCCESS = "rollout/ep_rew_mean", "rollout/success_rate"
"""Names of stable-baselines3."""


def paid(success):
    """The mean return that goes with a share of successes."""
    return -50 + 45 * np.asarray(success)


def table(path, columns, separator=","):
    """A table of text; `.gz` behind the name compresses it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with gzip.open(path, "wt", newline="") if path.suffix == ".gz" else path.open("w", newline="") as file:
        rows = csv.writer(file, delimiter=separator, lineterminator="\n")
        rows.writerow(columns)
        rows.writerows(zip(*columns.values(), strict=True))


def monitor(path, returns, lengths, success, started, late=0.0):
    """As stable-baselines3's Monitor, whose clock is so many seconds late."""
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = zip(returns, lengths, np.cumsum(lengths) / 1e3 + late, success, strict=True)
    told = "".join(f"{pay:.3f},{int(length)},{at:.4f},{bool(is_so)}\n" for pay, length, at, is_so in rows)
    path.write_text(f"#{json.dumps({'t_start': started, 'env_id': 'Reach-v1'})}\nr,l,t,is_success\n{told}")


def progress(path, steps, success, **more):
    """As stable-baselines3's logger, ``progress.csv``."""
    table(path, {REWARD: paid(success).round(4), SUCCESS: success.round(4), "time/total_timesteps": steps, **more})


def evaluations(path, steps, success):
    """As stable-baselines3's EvalCallback, from successes (evaluations, episodes), whose returns differ a little."""
    path.parent.mkdir(parents=True, exist_ok=True)
    results = paid(success) - 0.1 * np.arange(success.shape[1])
    np.savez(path, timesteps=steps, results=results, ep_lengths=np.where(success, 20, 50), successes=success)


def events(folder, steps, success, reward=REWARD, share=SUCCESS, stamp=0, **parameters):
    """As TensorBoard, by its own writer of records; the parameters stand in the text that CleanRL writes."""
    pytest.importorskip("tensorboard", reason="needs the extra tensorboard")
    from tensorboard.compat.proto.event_pb2 import Event
    from tensorboard.compat.proto.summary_pb2 import Summary
    from tensorboard.compat.proto.tensor_pb2 import TensorProto
    from tensorboard.summary.writer.record_writer import RecordWriter

    folder.mkdir(parents=True, exist_ok=True)
    with (folder / f"events.out.tfevents.{1_700_000_000 + stamp}.host").open("wb") as file:
        writer = RecordWriter(file)

        def write(step, *values):
            writer.write(Event(step=step, summary=Summary(value=values)).SerializeToString())

        writer.write(Event(file_version="brain.Event:2").SerializeToString())
        if parameters:
            rows = "".join(f"\n|{name}|{value}|" for name, value in parameters.items())
            tensor = TensorProto(dtype="DT_STRING", string_val=[f"|param|value|\n|-|-|{rows}".encode()])
            plugin = {"plugin_data": {"plugin_name": "text"}}
            write(0, Summary.Value(tag="hyperparameters/text_summary", tensor=tensor, metadata=plugin))
        for step, value in zip(steps, success, strict=True):
            told = {reward: paid(value), share: value}
            write(int(step), *(Summary.Value(tag=tag, simple_value=float(it)) for tag, it in told.items()))
        writer.flush()


def chart(path, counter, runs):
    """As a chart that Weights & Biases exports: a column of success a run, rows by what the chart counts.

    Args:
        path: To write.
        counter: What it counts, ``Step``.
        runs: By name, what the counter says of its points, and their values.
    """
    rows = sorted({int(at) for of, _ in runs.values() for at in of})
    columns = {counter: rows}
    for name, (of, values) in runs.items():
        told = dict(zip(map(int, of), values, strict=True))
        for end in ("", "__MIN", "__MAX"):
            columns[f"{name} - {SUCCESS}{end}"] = [f"{told[at]:.4f}" if at in told else "" for at in rows]
    table(path, columns)


def lines(path, rows):
    """JSON, an object a line."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(f"{json.dumps(row)}\n" for row in rows))


def files(folder):
    """All files below a folder, by their names there."""
    return {path.relative_to(folder).as_posix(): path for path in sorted(Path(folder).rglob("*")) if path.is_file()}
