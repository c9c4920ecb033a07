"""The trainings of an experiment as CSV files."""

from pathlib import Path

from harness.authoring.commands import (
    TRACE,
    TRAINING_RECORDING,
    Group,
    is_recording,
    recordings_in,
    write_csv,
    write_recording_csv,
)
from harness.results import Results
from harness.text import file_stems


def write_runs(results: Results, out: Path) -> dict[Path, int]:
    """Write a file for each done cell into `out`, in one folder for each group and reward.

    ::

        mujoco-sac-fd100-fd100-reach/arp/seed-0.csv
        mujoco-sac-fd100-fd100-reach/baseline-control/seed-6.csv    the baseline trained again for the null control
        ppo-gymnasium-id-pendulum-v1/own/seed-0.csv                 in an environment

    Returns:
        How many files were written into each folder.

    Raises:
        SchemaError: A trace or a recording is damaged or written by a newer version.
        OSError: `out` cannot be written.
    """
    written: dict[Path, int] = {}
    for name, cells in zip(file_stems(map(_text, results.groups)), results.groups.values(), strict=True):
        paid = {cell: f"{cell.reward.label}{' control' * results.is_control(cell)}" for cell in cells}
        kinds = list(dict.fromkeys(paid.values()))
        folders = {kind: out / name / stem for kind, stem in zip(kinds, file_stems(kinds), strict=True)}
        for cell in cells:
            folder = folders[paid[cell]]
            folder.mkdir(parents=True, exist_ok=True)
            _write(results.store.cell_folder(cell), folder / f"seed-{cell.seed}.csv")
            written[folder] = written.get(folder, 0) + 1
    return written


def write_recordings(folder: Path, out: Path) -> dict[Path, int]:
    """Write a file for each recorded training in a folder that is no experiment's, under its own path.

    Returns:
        How many files were written into each folder.

    Raises:
        SchemaError: A recording is damaged or written by a newer version.
        OSError: `out` cannot be written.
    """
    written: dict[Path, int] = {}
    for path in sorted(recordings_in(folder)):
        place = out / path.relative_to(folder)
        target = place.with_name(f"{place.name}.csv") if path != folder else out / "recording.csv"
        target.parent.mkdir(parents=True, exist_ok=True)
        write_recording_csv(path, target)
        written[target.parent] = written.get(target.parent, 0) + 1
    return written


def _write(cell: Path, path: Path) -> None:
    if is_recording(cell / TRAINING_RECORDING):
        write_recording_csv(cell / TRAINING_RECORDING, path)
    else:
        write_csv(cell / TRACE, path)


def _text(group: Group) -> str:
    return " ".join(label.rsplit("/")[-1] if kind == "robot" else label for kind, label in group.labels.items())
