"""A study of recorded trainings as text: sentences and small grids that the terminal and the page share."""

from harness.eta.behaviour_change import Change
from harness.eta.headline import count_seeds
from harness.eta.scored_sums import BB, KK
from harness.eta.seed_mean import SeedMean
from harness.eta.splits import Split
from harness.report.rows.behaviour import Text, behaviour_row, percentage
from harness.report.rows.comparison import Grid, format_number, mean_interval_text
from harness.results.comparison import Comparison
from harness.results.overview import NOTHING
from harness.results.recordings.runs import TRAINING
from harness.results.recordings.study import Study, Table

RETURNS = "Mean return of an episode"
SCALES = "eta compares two rewards, each on its own scale: it does not yet say how the agent behaves."
READING = (
    "Returns are means over episodes, then over seeds. Baseline and proposed: each training paid by its own reward. Of "
    "their difference, ruler is what comes from counting the same episodes by the other reward, behaviour what comes "
    "from the episodes."
)
TABLE = (
    "What each reward (a row) pays the policies that each reward taught (a column). Compare within a row: down a "
    "column the scale changes, not the behaviour."
)
TESTS = (
    "p: how often chance alone gives a difference as large, corrected for all claims of the folder together. A result "
    "stands only where p is at most 0.05. Intervals are over seeds, 95% each by itself."
)
HEADINGS = ("", "baseline", "proposed", "difference", "better", "p", "result")


def study_title(study: Study) -> str:
    """The question that a study answers."""
    proposed = study.runs.trained[1:]
    asked = f"Does the reward {proposed[0]}"
    if len(proposed) > 1:
        asked = f"Do the rewards {', '.join(proposed[:-1])} and {proposed[-1]}"
    return f"{asked} make the agent behave better, or only the numbers bigger?"


def study_text(study: Study) -> str:
    """What the study recorded."""
    runs = study.runs
    told = ", ".join(f"{count_seeds(len(runs.of(reward)))} by {reward}" for reward in runs.trained)
    return f"{runs.env}: {len(runs.members)} trainings of {runs.steps:,} steps; {told}."


def returns_grid(comparison: Comparison) -> Grid:
    """The mean return of either training, and what their difference is made of."""
    rows: list[tuple[str, ...]] = []
    for manner, split in comparison.returns.items():
        parts = (split.total.change, split.total.ruler, split.total.behaviour)
        amounts = (split.returns[BB], split.returns[KK], *parts)
        rows.append((manner, *(format_number(it.mean) for it in amounts)))
        if any(it.low is not None for it in amounts):
            rows.append(("  95% interval", *map(_interval, amounts)))
    notes = [f"{manner}: {NOTHING}: {reason}" for manner, reason in comparison.missing.items()]
    reasons = dict.fromkeys(
        note
        for split in comparison.returns.values()
        for it in (split.returns[BB], split.total.ruler)
        for note in it.notes
    )
    headings = ("", "baseline", "proposed", "difference", "of it ruler", "of it behaviour")
    return Grid(headings, rows, [*notes, *reasons])


def return_splits(comparison: Comparison) -> dict[str, Split]:
    """The ratios of mean returns by name, one for each manner. A ratio without a value has the reason."""
    return {f"eta {manner}": split.ratio for manner, split in comparison.returns.items()}


def paid_grid(study: Study, manner: str) -> Grid:
    """The full table: a row for each reward that pays, a column for each that taught."""
    table, runs = study.tables[manner], study.runs
    rows: list[tuple[str, ...]] = []
    for payer in runs.rewards:
        means = [table[payer, trained] for trained in runs.trained]
        rows.append((payer, *(format_number(mean.mean) for mean in means)))
        if any(mean.low is not None for mean in means):
            rows.append(("  95% interval", *map(_interval, means)))
    headings = ("paid by", *(f"trained by {trained}" for trained in runs.trained))
    return Grid(headings, rows, _notes(table), f"{RETURNS}, {manner}")


def behaviour_grid(comparison: Comparison, manner: str) -> Grid:
    """Every measure of one manner, the one that decides first."""
    rows = [_behaviour_texts(change) for change in comparison.changes_of(manner)]
    count = comparison.episodes[manner]
    title = f"Behaviour {manner}, {count:,} episode{'s' * (count != 1)} or more per seed"
    notes = dict.fromkeys(change.reason for change in comparison.changes_of(manner) if change.reason and change.seeds)
    return Grid(HEADINGS, rows, list(notes), title)


def text_of(change: Change) -> Text:
    """The function that writes a measure's values: shares as percentages, all others as they are."""
    return format_number if change.measure.episodes is None else percentage


def _behaviour_texts(change: Change) -> tuple[str, ...]:
    told = behaviour_row(change, text_of(change))
    return tuple(value for name, value in told._asdict().items() if name != "random")


def _notes(table: Table) -> list[str]:
    """One line for each remark, with the places that it holds for if not for all."""
    where: dict[str, list[str]] = {}
    for (payer, trained), mean in table.items():
        for note in mean.notes:
            where.setdefault(note, []).append(f"{payer} of {trained}")
    return [note if len(at) == len(table) else f"{', '.join(at)}: {note}" for note, at in where.items()]


def _interval(mean: SeedMean) -> str:
    return "" if mean.low is None else mean_interval_text(mean)


def recordings_grid(study: Study) -> Grid:
    """The result of every training by its own reward."""
    runs = study.runs
    rows: list[tuple[str, ...]] = []
    for run in runs.members.values():
        parts = run.parts(runs.steps)
        known = {manner: format_number(part.returns.get(run.reward)) for manner, part in parts.items()}
        values = [known.get(manner, NOTHING) for manner in study.tables]
        path = run.path.relative_to(study.folder).as_posix()
        counts = (str(run.seed), f"{run.steps:,}", f"{parts[TRAINING].episodes:,}")
        rows.append((path, run.reward, *counts, *values))
    headings = [f"return {manner}" for manner in study.tables]
    return Grid(("recording", "trained by", "seed", "steps", "episodes", *headings), rows, [])
