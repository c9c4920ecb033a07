"""A study of recorded trainings, as a terminal shows it."""

from rich.console import Group, RenderableType
from rich.text import Text

from harness.eta.scored_sums import BB, KK
from harness.report.rows.comparison import (
    SPLIT,
    Grid,
    advice,
    answer_text,
    claims_text,
    format_number,
    index_grid,
    ratio_grid,
    ratio_text,
    rewards_text,
    seeds_text,
    split_grid,
    sum_grid,
)
from harness.report.tables.grid import show_grid
from harness.report.tables.overview import STYLES
from harness.report.trainings.rows import (
    READING,
    RETURNS,
    SCALES,
    TABLE,
    TESTS,
    behaviour_grid,
    paid_grid,
    return_splits,
    returns_grid,
    study_text,
    text_of,
)
from harness.results import Results
from harness.results.comparison import Comparison
from harness.results.overview import NOTHING
from harness.results.recordings.study import Study, basis_text

HEADINGS = ("", "the agent", "return")
RATIO, DIFFERENCE = ("eta", "ruler", "behaviour"), ("difference", "ruler", "behaviour")
OVERVIEW = (
    "return: baseline > proposed, each training paid by its own reward. {whole}; the ruler is what comes from counting "
    "the same episodes differently."
)
RATIO_IS = "eta = ruler x behaviour is the ratio of both"
DIFFERENCE_IS = "difference = ruler + behaviour, because a ratio needs returns above 0"


def study_overview(study: Study, details: str, results: Results | None = None) -> RenderableType:
    """A line per comparison, and the full table of returns. A single comparison has its answers in sentences.

    Args:
        study: The study to show.
        details: The command that shows everything behind the overview.
        results: The experiment whose trainings these are; None if no experiment made them.
    """
    comparisons = study.comparisons
    parts: list[RenderableType] = [Text(study_text(study), style="bold"), *_notes(study)]
    parts += show_grid(paid_grid(study, _first_manner(study)))
    is_ratio = all(it.main is not None and it.main.ratio.eta.value is not None for it in comparisons if it.seeds)
    measures = (name.replace("_", " ") for name in study.runs.measures[:1])
    headings = (*HEADINGS, *(RATIO if is_ratio else DIFFERENCE), *measures)
    parts += show_grid(Grid(headings, [_line(it, is_ratio) for it in comparisons], []), STYLES)
    parts += [Text(), Text(OVERVIEW.format(whole=RATIO_IS if is_ratio else DIFFERENCE_IS), style="dim")]
    if len(comparisons) == 1:
        parts += [part for line in _sentences(comparisons[0], results) for part in (Text(), Text(line))]
    else:
        parts += [
            Text(),
            *(Text(line) for line in dict.fromkeys(basis_text(it) for it in comparisons if basis_text(it))),
        ]
    return Group(*parts, Text(), Text(f"All numbers behind this: {details}"))


def study_table(study: Study, results: Results | None = None) -> RenderableType:
    """Everything about each comparison: returns first, then how they split, then what the agent did."""
    parts: list[RenderableType] = [Text(study_text(study), style="bold"), *_notes(study), Text()]
    for comparison in study.comparisons:
        parts += _block(study, comparison, results)
    parts.append(Text(" ".join([SCALES, SPLIT, READING, TESTS])))
    for manner in study.tables:
        parts += show_grid(paid_grid(study, manner))
    return Group(*parts, Text(TABLE))


def _block(study: Study, comparison: Comparison, results: Results | None) -> list[RenderableType]:
    headline = comparison.headline
    parts: list[RenderableType] = [Text(rewards_text(comparison), style="bold")]
    if not comparison.seeds:
        return [*parts, Text(headline.robot), Text()]
    parts += [
        Text(f"{seeds_text(comparison.seeds)} compared"),
        *show_grid(returns_grid(comparison)._replace(title=RETURNS)),
    ]
    parts += [Text(), Text("The number", style="bold"), Text(comparison.number)]
    returns = return_splits(comparison)
    grids = [ratio_grid(returns), split_grid(returns)]
    splits = comparison.index_splits
    if splits and comparison.decomposition is not None:
        grids += [
            ratio_grid(splits)._replace(title="I_N and I_P of the summed reward: eta = proposed / baseline"),
            split_grid(splits),
            sum_grid(comparison.decomposition.total),
            index_grid(comparison.decomposition, study.kind),
        ]
    for grid in grids:
        parts += show_grid(grid)
    parts += [Text(), Text(f"The agent: {answer_text(headline)}", style="bold"), Text(headline.robot)]
    told = (basis_text(comparison), claims_text(comparison), _advice(comparison, results))
    parts += [Text(line) for line in told if line]
    for manner in comparison.episodes:
        parts += show_grid(behaviour_grid(comparison, manner))
    return [*parts, Text()]


def _notes(study: Study) -> list[RenderableType]:
    return [Text(f"{line}.") for line in study.runs.notes]


def _first_manner(study: Study) -> str:
    """The manner that verdicts use."""
    return next(iter(study.comparisons)).manner


def _line(comparison: Comparison, is_ratio: bool) -> tuple[str, ...]:
    """The values of a line, under the headings."""
    main, change = comparison.main, comparison.decisive
    measures = [] if not comparison.deciding else [NOTHING]
    if change is not None:
        text = text_of(change)
        measures = [f"{text(change.baseline)} > {text(change.proposed)}"]
    returns, whole = NOTHING, [NOTHING] * 3
    if main is not None:
        returns = f"{format_number(main.returns[BB].mean)} > {format_number(main.returns[KK].mean)}"
        ratio, total = main.ratio, main.total
        whole = [format_number(it.mean) for it in (total.change, total.ruler, total.behaviour)]
        whole = [ratio_text(it) for it in (ratio.eta, ratio.ruler, ratio.behaviour)] if is_ratio else whole
    return (rewards_text(comparison), answer_text(comparison.headline), returns, *whole, *measures)


def _sentences(comparison: Comparison, results: Results | None) -> list[str]:
    headline = comparison.headline
    told = (headline.robot, basis_text(comparison), headline.number, _advice(comparison, results))
    return [line for line in told if line]


def _advice(comparison: Comparison, results: Results | None) -> str:
    return advice(results, comparison) if results else ""
