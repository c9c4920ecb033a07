"""All figures of a summary, drawn from its own files: so they can be drawn again where the trainings are gone."""

import json
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from harness.authoring.pages import RACE_TITLE, Grid, RaceTold
from harness.results import Results
from harness.text import file_stems

from .figures import flat_words, learning_file, measures_of, race_file, runs_file, split_file
from .markdown import SHOWN, Pictures, escape
from .missing import missing_text
from .names import figure_stems
from .overview_figure import draw_overview
from .runs import Runs, panels_in
from .stored import comparison_of, learning_in, stored_comparisons

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
