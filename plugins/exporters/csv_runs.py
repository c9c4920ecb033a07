"""The trainings of an experiment as CSV files."""

from pathlib import Path

from harness.record.folder import TRACE
from harness.results import Results
from harness.results.comparison import Group
from harness.score.csv_writing import write_csv
from harness.text import file_stems


def write_runs(results: Results, out: Path) -> dict[Path, int]:
    """Write a file for each done cell into `out`, in one folder for each group and reward.

    ::

        mujoco-sac-fd100-fd100-reach/arp/seed-0.csv
        mujoco-sac-fd100-fd100-reach/baseline-control/seed-6.csv    the baseline trained again for the null control

    Returns:
        How many files were written into each folder.

    Raises:
        SchemaError: A trace is damaged or written by a newer version.
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
            write_csv(results.store.cell_folder(cell) / TRACE, folder / f"seed-{cell.seed}.csv")
            written[folder] = written.get(folder, 0) + 1
    return written


def _text(group: Group) -> str:
    return " ".join({**group.labels, "robot": group.robot.rsplit("/")[-1]}.values())
