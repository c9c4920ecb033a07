"""The committed records of an experiment whose task is an environment.

::

    experiment.toml      what was run, resolved; reads as an experiment file
    results.json         what ``harness report --json`` prints
    cells.csv            one row per cell: what every reward paid its episodes, and what it did in them
    figures/*.svg        of every comparison: how both learned, ruler x behaviour, the summed reward
    summary.md           every comparison as a table, with its figures; time, machine and versions
"""

import csv
from collections.abc import Iterator, Mapping, Sequence
from io import StringIO
from pathlib import Path
from typing import Any

from harness.errors import UsageError
from harness.eta.headline import count_seeds
from harness.record.manifest import Manifest
from harness.record.plan_file import EXPERIMENT, PLAN
from harness.report.environments.document import environments_text
from harness.report.environments.figures import Figure, figures_of
from harness.report.rows.comparison import (
    Grid,
    answer_text,
    claims_text,
    count_cells,
    ratio_grid,
    remarks_on_cells,
    rewards_text,
    split_grid,
)
from harness.report.summary.cells import plain_text
from harness.report.summary.files import put_files
from harness.report.summary.markdown import escape, markdown_table, what_it_took
from harness.report.summary.summary import CELLS, FIGURES, RECORD, SUMMARY
from harness.report.trainings.rows import (
    RETURNS,
    TABLE,
    TESTS,
    behaviour_grid,
    paid_grid,
    return_splits,
    returns_grid,
    study_text,
)
from harness.results import Results
from harness.results.comparison import Comparison
from harness.results.recordings.places import PlaceStudy
from harness.results.recordings.study import basis_text

OF_SUMS = "I_N and I_P of the summed reward: eta = proposed / baseline"
NAMES = ("id", "task", "algorithm", "reward", "seed", "steps", "status", "reason", "training_seconds", "seconds")


def write_environments_summary(results: Results, folder: Path) -> None:
    """Write the summary into `folder`; what else is in it stays as it is.

    Raises:
        UsageError: `folder` cannot be written, or is an experiment's own.
    """
    if (folder / PLAN).exists():
        raise UsageError(f"--summary '{folder}' is the folder of an experiment: name another")
    figures = figures_of(results.studies)
    files = {
        EXPERIMENT: results.experiment_text,
        RECORD: environments_text(results) + "\n",
        CELLS: _cells(results),
        SUMMARY: _markdown(results, figures),
    }
    drawn = {f"{FIGURES}/{it.name}": it.content for of in figures.values() for it in of}
    put_files(folder, {**{name: text.encode() for name, text in files.items()}, **drawn}, FIGURES)


def _cells(results: Results) -> str:
    """The cells in the order of the plan; numbers have as many digits as it takes to read them back exactly."""
    measured = dict(_measured(results.studies))
    names = dict.fromkeys(name for values in measured.values() for name in values)
    text = StringIO()
    writer = csv.DictWriter(text, [*NAMES, *names], lineterminator="\n")
    writer.writeheader()
    for manifest in results.manifests:
        row = {**_describe(manifest), **measured.get(manifest.cell.id, {})}
        writer.writerow({name: plain_text(value) for name, value in row.items()})
    return text.getvalue()


def _describe(manifest: Manifest) -> Mapping[str, Any]:
    cell = manifest.cell
    choices = (cell.task.label, cell.algorithm.label, cell.reward.label)
    times = (manifest.training_seconds or None, manifest.seconds or None)
    ended = (cell.seed, cell.steps, manifest.status, " ".join(manifest.reason.split()), *times)
    return dict(zip(NAMES, (cell.id, *choices, *ended), strict=True))


def _measured(studies: Sequence[PlaceStudy]) -> Iterator[tuple[str, dict[str, float | None]]]:
    """Mean returns and measures of each cell's episodes in every manner, by the cell's id."""
    for study in (told.study for told in studies if told.study is not None):
        for run in study.runs.members.values():
            values: dict[str, float | None] = {}
            for manner, part in run.parts(study.runs.steps).items():
                values |= {f"return {name}, {manner}": value for name, value in part.returns.items()}
                values |= {f"{name}, {manner}": value for name, value in part.behaviour.items()}
            yield run.path.parent.name, values


def _markdown(results: Results, figures: Mapping[Comparison, Sequence[Figure]]) -> str:
    labels = dict.fromkeys(told.group.task.label for told in results.studies)
    parts = [f"# {escape(', '.join(labels))}", escape(count_cells(results))]
    parts += [f"* {escape(line)}" for line in remarks_on_cells(results)]
    parts.append(f"Made from `{EXPERIMENT}`: `harness run {EXPERIMENT}` does it again.")
    for told in results.studies:
        parts.append(f"## {escape(told.title)}")
        if told.study is None:
            parts += [escape(f"{told.reason}."), *(f"* {escape(line)}" for line in told.notes)]
            continue
        study = told.study
        parts += [escape(study_text(study)), *(f"* {escape(line)}" for line in study.runs.notes)]
        for comparison in study.comparisons:
            parts += [*_comparison(comparison), *(_picture(it, comparison) for it in figures[comparison])]
        parts.append(escape(TABLE))
        for manner in study.tables:
            parts += _shown(paid_grid(study, manner))
        parts.append(escape(TESTS))
    parts += what_it_took(results)
    return "\n\n".join(part for part in parts if part) + "\n"


def _comparison(comparison: Comparison) -> list[str]:
    headline = comparison.headline
    parts = [
        f"### {escape(rewards_text(comparison))}",
        f"**The agent: {answer_text(headline)}.** {escape(headline.robot)}",
    ]
    if not comparison.seeds:
        return parts
    parts += [
        escape(f"{count_seeds(len(comparison.seeds))} compared. {basis_text(comparison)}"),
        escape(comparison.number),
    ]
    parts += _shown(returns_grid(comparison)._replace(title=RETURNS))
    parts += [part for grid in _ratios(comparison) for part in _shown(grid)]
    parts += [part for manner in comparison.episodes for part in _shown(behaviour_grid(comparison, manner))]
    return [*parts, escape(claims_text(comparison))]


def _picture(figure: Figure, comparison: Comparison) -> str:
    return f"![{figure.shows}: {escape(rewards_text(comparison))}]({FIGURES}/{figure.name})"


def _ratios(comparison: Comparison) -> tuple[Grid, ...]:
    returns, splits = return_splits(comparison), comparison.index_splits
    of_sums = (ratio_grid(splits)._replace(title=OF_SUMS), split_grid(splits)) if splits else ()
    return (ratio_grid(returns), split_grid(returns), *of_sums)


def _shown(grid: Grid) -> list[str]:
    if not grid.rows:
        return [f"* {escape(note)}" for note in grid.notes]
    return [grid.title, markdown_table(grid.headings, grid.rows), "\n".join(f"* {escape(note)}" for note in grid.notes)]
