"""A summary: the records and figures of an experiment, without its traces and policies.

::

    experiment.toml      what was run, resolved; reads as an experiment file
    results.json         what ``harness report --json`` prints
    cells.csv            one row per cell
    curves.parquet       the mean curves that the indices are read from, thinned
    figures/*.svg        what the report page draws, without a script
    summary.md           the combinations as a table, and what they took
"""

from pathlib import Path

from harness.errors import UsageError
from harness.record.plan_file import EXPERIMENT, PLAN
from harness.report.document import report_text
from harness.report.rows.race import race_told
from harness.report.summary.cells import write_cells
from harness.report.summary.curves import CURVES, write_curves
from harness.report.summary.figures import learning_file, race_file, runs_file, split_file
from harness.report.summary.files import put_files
from harness.report.summary.markdown import Pictures, write_markdown
from harness.report.summary.missing import missing_text
from harness.report.summary.names import figure_stems
from harness.report.summary.overview_figure import draw_overview
from harness.results import Results

RECORD, CELLS, SUMMARY = "results.json", "cells.csv", "summary.md"
FIGURES = "figures"
RACE = f"{FIGURES}/race.svg"


def write_summary(results: Results, folder: Path) -> None:
    """Write the summary into `folder`; what else is in it stays as it is.

    Everything is made before anything is written: an error leaves the old files.

    Raises:
        UsageError: `folder` cannot be written, or is an experiment's own.
        SchemaError: A file of the experiment is damaged or written by a newer version.
    """
    if (folder / PLAN).exists():
        raise UsageError(f"--summary '{folder}' is the folder of an experiment: name another")
    if not results.is_experiment:
        raise UsageError("--summary does not go with a folder of recorded trainings: leave it out")
    figures, overview, pictures = _draw(results)
    race = race_told(results)
    if race is not None:
        figures[RACE] = race_file(race)
    files = {
        EXPERIMENT: _portable(results).encode(),
        RECORD: (report_text(results) + "\n").encode(),
        CELLS: write_cells(results).encode(),
        CURVES: write_curves(results.combinations),
        SUMMARY: write_markdown(results, overview, pictures, RACE if race else "").encode(),
    }
    put_files(folder, {**files, **figures}, FIGURES)


def _portable(results: Results) -> str:
    """The experiment's file. Files of plugins that lie below the current folder are named from there."""
    text, here = results.experiment_text, f"{Path.cwd().as_posix()}/"
    return text.replace(f'path = "{here}', 'path = "')


def _draw(results: Results) -> tuple[dict[str, bytes], str, list[Pictures]]:
    """Every figure by its path, the path of the overview, and the paths of each combination's own by what they show."""
    combinations = results.combinations
    missing = [missing_text(results, combination) for combination in combinations]
    figures: dict[str, bytes] = {}

    def keep(name: str, figure: bytes | None) -> str:
        path = f"{FIGURES}/{name}.svg"
        if figure is None:
            return ""
        figures[path] = figure
        return path

    overview = keep("overview", draw_overview(combinations, missing))
    pictures: list[Pictures] = []
    for combination, stem, told in zip(combinations, figure_stems(combinations), missing, strict=True):
        learning = results.learning(combination)
        drawn = {
            "runs": runs_file(combination, told),
            "split": split_file(combination, told),
            "learning": learning_file(combination, learning, told) if learning else None,
        }
        paths = {what: keep(f"{stem}.{what}", figure) for what, figure in drawn.items()}
        pictures.append({what: path for what, path in paths.items() if path})
    return figures, overview, pictures
