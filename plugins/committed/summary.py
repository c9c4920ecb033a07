"""A summary: the records and figures of an experiment, without its traces and policies.

::

    experiment.toml      what was run, resolved; reads as an experiment file
    results.json         what ``harness report --json`` prints
    cells.csv            one row per cell
    curves.parquet       the mean curves that the indices are read from, thinned
    runs.parquet         the curves of single runs, as the figures show them
    figures.json         what the figures tell besides
    figures/*.svg        what the report page draws, without a script; `redraw.py` draws them again
    summary.md           the combinations as a table, and what they took
"""

import json
from pathlib import Path

from harness.authoring.commands import EXPERIMENT, PLAN
from harness.authoring.pages import race_told, report_text
from harness.errors import UsageError
from harness.results import Results

from .cells import write_cells
from .curves import CURVES, write_curves
from .drawing import DRAWN, FIGURES, draw_figures, figures_text
from .files import put_files
from .markdown import write_markdown
from .runs import RUNS, read_runs, write_runs

RECORD, CELLS, SUMMARY = "results.json", "cells.csv", "summary.md"


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
    record, race, runs = report_text(results) + "\n", race_told(results), write_runs(results.combinations)
    told = figures_text(results, race)
    drawn = draw_figures(json.loads(record), json.loads(told), read_runs(runs))
    files = {
        EXPERIMENT: _portable(results).encode(),
        RECORD: record.encode(),
        CELLS: write_cells(results).encode(),
        CURVES: write_curves(results.combinations),
        RUNS: runs,
        DRAWN: told.encode(),
        SUMMARY: write_markdown(results, drawn.overview, drawn.pictures, drawn.race).encode(),
    }
    put_files(folder, {**files, **drawn.files}, FIGURES)


def _portable(results: Results) -> str:
    """The experiment's file. Files of plugins that lie below the current folder are named from there."""
    text, here = results.experiment_text, f"{Path.cwd().as_posix()}/"
    return text.replace(f'path = "{here}', 'path = "')
