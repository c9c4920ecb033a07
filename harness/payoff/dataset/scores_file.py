"""What rewards pay each step of a data set, as a Parquet file beside it."""

from pathlib import Path

import numpy as np
import pyarrow as pa

from harness.errors import UsageError
from harness.payoff.dataset.paid_dataset import PaidDataset
from harness.record.folder import SCORES
from harness.score.rescore import write_scores


def scores_place(folder: Path, out: Path | None) -> Path:
    """The file: beside the data set's folder, which stays as it is, or in another folder."""
    return (folder.resolve().parent if out is None else out) / f"{folder.resolve().name}.{SCORES}"


def write_dataset_scores(paid: PaidDataset, path: Path) -> None:
    """Write a row for each step: ``episode``, ``step``, and a column for each reward, empty where it could not pay.

    Each term of a reward has a column too, ``gentle/effort``.

    Raises:
        UsageError: No reward could pay, or the file cannot be written.
    """
    if not paid.paid:
        told = "; ".join(f"{name}: {reason}" for name, reason in paid.failed.items())
        raise UsageError(f"Nothing is written, since no reward pays {paid.facts.name}: {told}")
    lengths = np.diff(paid.begins)
    steps = np.arange(paid.steps) - np.repeat(paid.begins[:-1], lengths)
    columns = {"episode": np.repeat(paid.each("number"), lengths), "step": steps}
    terms = {f"{name}/{term}": values for name, of in paid.terms.items() for term, values in of.items()}
    columns |= {name: pa.array(values, from_pandas=True) for name, values in {**paid.paid, **terms}.items()}
    write_scores(path, columns)
