"""What each term of a reward paid, as text: what the terminal and the page share."""

from collections.abc import Iterator

from harness.eta.seed_mean import SeedMean
from harness.registry.choice import parse
from harness.report.rows.ratios import Grid, format_number, value_rows
from harness.results import Results
from harness.results.comparison import Comparison
from harness.results.terms_paid import TermsPaid

TITLE = "What each term paid"
EXPLANATION = (
    "What a term paid an episode, as a mean over trainings. Start and end are the first and the last tenth of the "
    "episodes of the reward's own trainings, evaluation those of the final policies. No word of better or worse "
    "belongs to a term: that one pays more, or all, is what its author asked for."
)


COLUMNS = ("start", "end", "evaluation", "others", "random", "behaviour", "ruler")
ALWAYS = COLUMNS[:2]
"""Columns that stand there without a value too."""


def terms_of(results: Results, comparison: Comparison) -> list[TermsPaid]:
    """What the terms of the compared rewards paid: of the proposed one, and in the first comparison of the baseline."""
    names = [comparison.proposed, *([comparison.baseline] if comparison is results.combinations[0] else [])]
    there = [it for it in results.terms if it.group == comparison.group and it.reward in names]
    return sorted(there, key=lambda it: names.index(it.reward))


def terms_grid(found: TermsPaid) -> Grid:
    """A row for each term, its interval below it; below the table what to say of them."""
    terms = found.terms
    shown = [name for name in COLUMNS if name in ALWAYS or any(_is_known(getattr(term, name)) for term in terms)]
    rows = [row for term in terms for row in value_rows(term.name, [getattr(term, name) for name in shown])]
    headings = (f"with {found.baseline}" if name == "others" else name for name in shown)
    return Grid(("an episode", *headings), rows, list(_notes(found)), f"{TITLE}: {found.reward}")


def never_texts(results: Results) -> list[str]:
    """A sentence for each term that never paid; where there are several places, each says its own."""
    several = len({it.group for it in results.terms}) > 1
    return [
        f"{f'{it.group.title}, ' if several else ''}{it.reward}: {text}" for it in results.terms for text in _never(it)
    ]


def changed_text(found: TermsPaid) -> str:
    """Which term changed most; empty where there is one term, or none changed."""
    most = found.most_changed
    if most is None or len(found.terms) < 2:
        return ""
    if not found.is_compared:
        start, end = format_number(most.start.mean), format_number(most.end.mean)
        return f"`{most.name}` changed most: {start} an episode at the start of the trainings, {end} at their end."
    own, others = format_number(most.final.mean), format_number(most.others.mean)
    where = "of the evaluations" if most.evaluation.mean is not None else "at the end of the trainings"
    return f"`{most.name}` differs most: it pays {own} an episode {where}, and {others} with {found.baseline}."


def _is_known(value: SeedMean | float | None) -> bool:
    return (value.mean if isinstance(value, SeedMean) else value) is not None


def _notes(found: TermsPaid) -> Iterator[str]:
    yield from filter(None, [changed_text(found)])
    yield from _never(found)
    if found.is_compared:
        yield (
            f"Behaviour is what the term pays in the end minus what it pays the trainings with {found.baseline}. Over "
            f"all terms it adds up to the behaviour part on one of the two paths: {found.path}."
        )
    if any(it.ruler.mean is not None for it in found.terms):
        yield f"Ruler is what the term pays the episodes of {found.baseline} minus what its own term of that name pays."
    if found.missing:
        yield f"With {found.baseline} n/a: {found.missing}"


def _never(found: TermsPaid) -> Iterator[str]:
    weights = parse(found.reward)[1]
    for term in found.terms:
        if term.never:
            off = ": its weight is 0" if weights.get(term.name) in ("0", "-0") else ""
            later = " of training, only in the evaluations" if term.evaluation.mean else ""
            yield f"`{term.name}` never paid in {found.steps:,} steps{later}{off}."
