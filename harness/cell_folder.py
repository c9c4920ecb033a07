"""The folder that a cell leaves: names of its files, and how it comes to be there all at once."""

import shutil
from pathlib import Path

TRACE, EVALUATION, RANDOM, POLICY, LOG = "trace.parquet", "evaluation.parquet", "random.parquet", "policy", "log.txt"


def partial_folder(folder: Path) -> Path:
    """Where a cell's folder grows until it is complete."""
    return folder.with_name(f".{folder.name}.partial")


def publish(partial: Path, folder: Path) -> None:
    """Give a complete folder its final name, in place of an earlier one."""
    if folder.exists():
        shutil.rmtree(folder)
    partial.rename(folder)
