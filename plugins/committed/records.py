"""A summary: the records and figures of an experiment, without its traces and policies.

::

    experiment.toml      what was run, resolved; reads as an experiment file
    results.json         what ``harness report --json`` prints
    cells.csv            one row per cell
    curves.parquet       the mean curves that the indices are read from, thinned
    runs.parquet         the curves of single runs, as the figures show them
    figures.json         what the figures tell besides
    figures/*.svg        what the report page draws; `harness_plugins.committed.redraw` draws them again
    summary.md           the combinations as a table, and what they took
"""

import json
import os
import re
import shutil
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from harness.authoring.commands import EXPERIMENT, PLAN, Comparison, Records
from harness.authoring.pages import RACE_TITLE, Grid, RaceTold, race_told, report_text
from harness.errors import UsageError
from harness.results import Results
from harness.text import file_stems

from .figures import draw_overview, flat_words, learning_file, measures_of, race_file, runs_file, split_file
from .markdown import SHOWN, Pictures, escape, missing_text, write_markdown
from .read import RECORD, SUMMARY, committed_table, committed_text, is_committed, refuse_committed
from .stored import comparison_of, learning_in, stored_comparisons
from .svg import CREATOR
from .tables import CURVES, RUNS, Runs, panels_in, read_runs, write_cells, write_curves, write_runs

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


DRAWN = "figures.json"
FORMAT = 1
FIGURES = "figures"
NOT_DRAWN = ("grid", "beside")
"""What no figure shows of a race."""
OVERVIEW, RACE = f"{FIGURES}/overview.svg", f"{FIGURES}/race.svg"
READ_BACK = "The curves were read back from the figure of an earlier version, to a tenth of a pixel."


class Drawn(NamedTuple):
    """The figures of a summary, and the lines of its page that show them."""

    files: dict[str, bytes]
    """By path within the folder."""
    overview: str
    """The line with all combinations; empty without that figure."""
    race: str
    """The line with the race for the best reward; empty without that figure."""
    pictures: list[Pictures]
    """The lines of each combination, by what they show."""
    words: dict[str, str]
    """What is said in the place of a figure in which nothing happens, by the figure's path."""


def figures_text(results: Results, race: RaceTold | None) -> str:
    """``figures.json``: what the figures tell besides ``results.json`` and the curves."""
    combinations = [
        {
            "missing": missing_text(results, it),
            "manner": it.manner,
            "learning": measures_of(it, results.learning(it)),
        }
        for it in results.combinations
    ]
    told = race and {name: value for name, value in race._asdict().items() if name not in NOT_DRAWN}
    data = {"format": FORMAT, "read_back": False, "combinations": combinations, "race": told}
    return json.dumps(data, indent=1, allow_nan=False) + "\n"


def draw_figures(record: Mapping[str, Any], told: Mapping[str, Any], runs: Runs) -> Drawn:
    """Every figure.

    Args:
        record: ``results.json``.
        told: ``figures.json``.
        runs: ``runs.parquet``.
    """
    stored = list(stored_comparisons(record))
    combinations = [
        comparison_of(it, beside["manner"]) for it, beside in zip(stored, told["combinations"], strict=True)
    ]
    missing = [it["missing"] for it in told["combinations"]]
    files, words = dict[str, bytes](), dict[str, str]()

    def keep(path: str, figure: bytes | None, title: str) -> str:
        if figure is None:
            return ""
        files[path] = figure
        return f"![{title}]({path})"

    title = "eta of every combination, with ruler and behaviour"
    overview = keep(OVERVIEW, draw_overview(combinations, missing), title) if "combinations" in record else ""
    race = keep(RACE, race_file(_race(told["race"])), RACE_TITLE) if told["race"] else ""
    stems = figure_stems(combinations) if "combinations" in record else _older_stems(stored)
    pictures: list[Pictures] = []
    for of, combination, stem, beside in zip(stored, combinations, stems, told["combinations"], strict=True):
        learning, measures = learning_in(of), beside["learning"]
        note = READ_BACK if told["read_back"] else ""
        panels = panels_in(runs, combination, record["curve"])
        drawn = {
            "runs": runs_file(combination, panels, beside["missing"], note),
            "split": split_file(combination, beside["missing"]),
            "learning": learning_file(combination, learning, measures, beside["missing"]) if learning else None,
        }
        lines = {what: keep(f"{FIGURES}/{stem}.{what}.svg", it, SHOWN[what]) for what, it in drawn.items()}
        if learning and not lines["learning"]:
            lines["learning"] = escape(flat_words(learning, measures))
            words[f"{FIGURES}/{stem}.learning.svg"] = lines["learning"]
        pictures.append({what: line for what, line in lines.items() if line})
    return Drawn(files, overview, race, pictures, words)


def _race(told: Mapping[str, Any]) -> RaceTold:
    """A race, without its table, which no figure shows."""
    return RaceTold(**{**told, "grid": Grid((), [], []), "living": tuple(told["living"])})


def _older_stems(stored: Sequence[Mapping[str, Any]]) -> list[str]:
    """The names of figures in records of version 0.1, of environments."""
    return file_stems(f"{it['task']} {it['algorithm']} {it['proposed']} against {it['baseline']}" for it in stored)


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
            if f"{figures}/{path.name}" not in files and _is_ours(path):
                path.unlink()
    except OSError as error:
        raise UsageError(f"The summary '{folder}' cannot be written: {error.strerror}") from error
    finally:
        with suppress(OSError):  # not there if it could not be made
            shutil.rmtree(partial)


def _is_ours(path: Path) -> bool:
    """Whether a figure is ours, by its name and by its creator."""
    return bool(FIGURE.fullmatch(path.stem)) and CREATOR.encode() in path.read_bytes()


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
