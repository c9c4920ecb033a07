"""A summary: the records and figures of an experiment, without its traces and policies.

::

    experiment.toml      what was run, resolved; reads as an experiment file
    results.json         what ``harness report --json`` prints
    cells.csv            one row per cell
    curves.parquet       the mean curves that the indices are read from, thinned
    figures/*.svg        what the report page draws
    summary.md           the combinations as a table, and what they took
"""

import os
import re
import shutil
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from harness.cli.records import Records
from harness.errors import UsageError
from harness.record import EXPERIMENT, PLAN
from harness.report import Report, report_text
from harness.results import Comparison, Results
from harness.text import file_stems

from .figures import draw_overview, flat_words, learning_file, measures_of, runs_file, split_file
from .markdown import SHOWN, Pictures, escape, missing_text, write_markdown
from .read import RECORD, SUMMARY, committed_table, committed_text, is_committed, refuse_committed
from .svg import CREATOR
from .tables import CURVES, write_cells, write_curves

CELLS = "cells.csv"


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
    drawn, report = draw_figures(results), Report(results)
    here = f'path = "{Path.cwd().as_posix()}/'  # files of plugins that lie below it are named from there
    files = {
        EXPERIMENT: results.experiment_text.replace(here, 'path = "').encode(),
        RECORD: f"{report_text(report)}\n".encode(),
        CELLS: write_cells(results).encode(),
        CURVES: write_curves(results.combinations),
        SUMMARY: write_markdown(report, drawn.overview, drawn.pictures).encode(),
    }
    put_files(folder, {**files, **drawn.files}, FIGURES)


FIGURES = "figures"
OVERVIEW = f"{FIGURES}/overview.svg"


class Drawn(NamedTuple):
    """The figures of a summary, and the lines of its page that show them."""

    files: dict[str, bytes]
    """By path within the folder."""
    overview: str
    """The line with all combinations; empty without that figure."""
    pictures: list[Pictures]
    """The lines of each combination, by what they show."""


def draw_figures(results: Results) -> Drawn:
    """Every figure."""
    combinations = results.combinations
    missing = [missing_text(results, it) for it in combinations]
    files = dict[str, bytes]()

    def keep(path: str, figure: bytes | None, title: str) -> str:
        if figure is None:
            return ""
        files[path] = figure
        return f"![{title}]({path})"

    overview = keep(
        OVERVIEW, draw_overview(combinations, missing), "eta of every combination, with ruler and behaviour"
    )
    pictures: list[Pictures] = []
    for combination, stem, lacking in zip(combinations, figure_stems(combinations), missing, strict=True):
        learning = results.learning(combination)
        measures = measures_of(combination, learning)
        drawn = {
            "runs": runs_file(combination, lacking),
            "split": split_file(combination, lacking),
            "learning": learning_file(combination, learning, measures, lacking) if learning else None,
        }
        lines = {what: keep(f"{FIGURES}/{stem}.{what}.svg", it, SHOWN[what]) for what, it in drawn.items()}
        if learning and not lines["learning"]:
            lines["learning"] = escape(flat_words(learning, measures))
        pictures.append({what: line for what, line in lines.items() if line})
    return Drawn(files, overview, pictures)


def figure_stems(combinations: Iterable[Comparison]) -> list[str]:
    """A name for each combination, of lower-case letters, digits, dots and hyphens; no two are alike."""
    return file_stems(map(_text, combinations))


def _text(combination: Comparison) -> str:
    labels = combination.group.labels
    labels |= {"robot": labels["robot"].rsplit("/")[-1]} if "robot" in labels else {}
    return " ".join([*labels.values(), combination.proposed, "against", combination.baseline])


PARTIAL = ".summary.partial"
FIGURE = re.compile(r"overview|.+\.(runs|split|learning)")
"""Names of our figures, without the ending."""


def put_files(folder: Path, files: Mapping[str, bytes], figures: str) -> None:
    """Write `files`, by their paths within `folder`, and remove our older figures that are not among them.

    All are written beside their final names before the first is renamed. So a killed process leaves whole files.

    Args:
        folder: Made if it is not there; what else is in it stays.
        files: What to write.
        figures: The folder of the figures, within `folder`.

    Raises:
        UsageError: `folder` cannot be written, or a link in it leads out of it.
    """
    for inner in (PARTIAL, figures):
        if (folder / inner).is_symlink():
            raise UsageError(f"'{folder / inner}' is a link; nothing is written through it: remove it")
    partial = folder / PARTIAL
    try:
        _write(partial, files)
        for name in files:
            (folder / name).parent.mkdir(exist_ok=True)
            os.replace(partial / name, folder / name)
        for path in (folder / figures).glob("*.svg"):
            is_old = f"{figures}/{path.name}" not in files and FIGURE.fullmatch(path.stem)
            if is_old and CREATOR.encode() in path.read_bytes():
                path.unlink()
    except OSError as error:
        raise UsageError(f"The summary '{folder}' cannot be written: {error.strerror}") from error
    finally:
        with suppress(OSError):  # not there if it could not be made
            shutil.rmtree(partial)


def _write(partial: Path, files: Mapping[str, bytes]) -> None:
    if partial.exists():  # left by a process that was killed
        shutil.rmtree(partial)
    partial.mkdir(parents=True)
    for name, content in files.items():
        (partial / name).parent.mkdir(exist_ok=True)
        (partial / name).write_bytes(content)


def records() -> Records:
    """What ``harness report`` gets of this plugin."""
    return Records(write_summary, is_committed, committed_text, committed_table, refuse_committed)
