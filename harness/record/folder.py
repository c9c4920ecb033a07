"""The folder that a cell leaves: names of its files, and how it comes to be there all at once."""

import shutil
from itertools import count, takewhile
from pathlib import Path

from harness.files.bounded import digest_of, sync

MANIFEST, LOG = "manifest.json", "log.txt"
TRACE, EVALUATION, RANDOM = "trace.parquet", "evaluation.parquet", "random.parquet"
SUFFIX = ".parquet"
"""Ends the names of traces. That of the final evaluation in the other manner than that of `EVALUATION` begins as
`harness.eta.manner.OWN_AND_OTHER` says; folders of version 0.1 have none."""
EVALUATIONS = "evaluations"
"""Folder of what the policy did before its training ended, a trace per evaluation, named by the environment steps."""
SCENE = "scene.json"
"""What the arm looks like, see `harness.record.scene`; folders of version 0.1 have none."""
TRAINING_RECORDING, EVALUATION_RECORDING, RANDOM_RECORDING = "training", "evaluation", "random"
"""Folders of recordings, see `harness.record.recording`, of a cell whose task is an environment. Its other evaluations
are folders too, named as the files of an arm's cell are without their ending: see `recording_of`."""
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


def partial_folder(folder: Path) -> Path:
    """Where a cell's folder grows until it is complete."""
    return folder.with_name(f".{folder.name}.partial")


def digests_in(folder: Path) -> dict[str, str]:
    """SHA-256 of every file in a folder but its manifest, by its path there; links are left out."""
    paths = [path for path in sorted(folder.rglob("*")) if path.is_file() and not path.is_symlink()]
    return {str(path.relative_to(folder).as_posix()): digest_of(path) for path in paths if path != folder / MANIFEST}


def part_path(first: Path, number: int) -> Path:
    """The file of a part of rows, by its number and the file of the first one, whose name may end with its number."""
    begin = first.stem.removesuffix("-00000")
    return first.with_name(f"{begin}-{number:05}{first.suffix}") if number else first


def parts_of(first: Path) -> list[Path]:
    """The files of rows, in order: the first one, and those after it that are there."""
    return [first, *takewhile(Path.exists, (part_path(first, number) for number in count(1)))]


def begun_by(part: str) -> str:
    """The trace that a file of this name would be a later part of."""
    return f"{part.rpartition('-')[0]}{SUFFIX}"


def recording_of(trace: str) -> str:
    """The folder of a recording, by the name that a trace has in its place in a cell of an arm."""
    return trace.removesuffix(SUFFIX)


def evaluation_files(folder: Path, suffix: str = SUFFIX) -> dict[int, Path]:
    """The evaluations before the end of a cell's training, by the environment steps done, in order.

    Args:
        folder: The folder of the cell.
        suffix: What their names end with: that of traces, or nothing if they are recordings.
    """
    found = (folder / EVALUATIONS).glob(f"[0-9]*{suffix}")
    return dict(sorted((int(it.stem), it) for it in found if it.stem.isdecimal() and it.suffix == suffix))


def publish(partial: Path, folder: Path, *, is_lasting: bool = True) -> None:
    """Give a complete folder its final name, in place of an earlier one.

    Args:
        partial: The folder.
        folder: Its final name.
        is_lasting: It also survives a machine that stops: the disk has all of it first.

    Raises:
        OSError: It cannot have it.
    """
    for path in [*partial.rglob("*"), partial] if is_lasting else ():
        if not path.is_symlink():
            sync(path)
    if folder.is_symlink() or folder.is_file():
        folder.unlink()
    elif folder.exists():
        shutil.rmtree(folder)
    partial.rename(folder)
    if is_lasting:
        sync(folder.parent)
