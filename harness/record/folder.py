"""The folder that a cell leaves: names of its files, and how it comes to be there all at once."""

import shutil
from pathlib import Path

from harness.files.whole_file import sync

MANIFEST, LOG = "manifest.json", "log.txt"
TRACE, EVALUATION, RANDOM = "trace.parquet", "evaluation.parquet", "random.parquet"
STOCHASTIC, DETERMINISTIC = "stochastic.parquet", "deterministic.parquet"
"""The final evaluation in the other manner than that of `EVALUATION`; folders of version 0.1 have neither."""
EVALUATIONS = "evaluations"
"""Folder of what the policy did before its training ended, a trace per evaluation, named by the environment steps."""
SCENE = "scene.json"
"""What the arm looks like, see `harness.record.scene`; folders of version 0.1 have none."""
TRAINING_RECORDING, EVALUATION_RECORDING = "training", "evaluation"
"""Folders of recordings, see `harness.record.recording`, of a cell whose task is an environment."""
POLICY, WEIGHTS, CARD = "policy", "weights.safetensors", "card.json"
"""Folder of the trained policy, and the two files in it."""
SCORES = "scores.parquet"
"""What other rewards would have paid the rows of the trace, a column per reward."""
CHECKPOINT = "checkpoint.safetensors"
"""In a partial folder: where a training that was killed goes on."""
TENSORBOARD = "tensorboard"
"""Folder of event files, in cells that an earlier version left."""
DERIVED = "derived"
"""Folder of an experiment: what follows from its cells; see `harness.results.kept`."""
TRANSFER = "transfer"
"""Folder of an experiment: what policies did elsewhere; see `harness.transfer.record`."""


def partial_folder(folder: Path) -> Path:
    """Where a cell's folder grows until it is complete."""
    return folder.with_name(f".{folder.name}.partial")


def other_manner(deterministic: bool) -> str:
    """Name of the final evaluation in the other manner, of a cell that is evaluated in this one."""
    return STOCHASTIC if deterministic else DETERMINISTIC


def evaluation_files(folder: Path) -> dict[int, Path]:
    """The evaluations before the end of a cell's training, by the environment steps done, in order."""
    found = {int(path.stem): path for path in (folder / EVALUATIONS).glob("[0-9]*.parquet")}
    return dict(sorted(found.items()))


def publish(partial: Path, folder: Path) -> None:
    """Give a complete folder its final name, in place of an earlier one, once the disk has all of it.

    Raises:
        OSError: It cannot have it.
    """
    for path in [*partial.rglob("*"), partial]:
        if not path.is_symlink():
            sync(path)
    if folder.is_symlink() or folder.is_file():
        folder.unlink()
    elif folder.exists():
        shutil.rmtree(folder)
    partial.rename(folder)
    sync(folder.parent)
