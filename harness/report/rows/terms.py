"""What each term of a reward paid, as text: what the terminal and the page share."""

from collections.abc import Iterator

from harness.eta.seed_mean import SeedMean
from harness.registry.choice import parse
from harness.report.rows.ratios import Grid, format_number
from harness.report.rows.returns import interval_of_mean
from harness.results import Results
from harness.results.comparison import Comparison
from harness.results.terms_paid import TermPaid, TermsPaid

TITLE = "What each term paid"
EXPLANATION = (
    "What a term paid an episode, as a mean over trainings. Start and end are the first and the last tenth of the "
    "episodes of the reward's own trainings, evaluation those of the final policies. No word of better or worse "
    "belongs to a term: that one pays more, or all, is what its author asked for."
)


def terms_of(results: Results, comparison: Comparison, *, is_first: bool = True) -> list[TermsPaid]:
    """What the terms of the compared rewards paid: of the proposed one, and in the first comparison of the baseline."""
    names = [comparison.proposed, *([comparison.baseline] if is_first else [])]
    there = [it for it in results.terms if it.group == comparison.group and it.reward in names]
    return sorted(there, key=lambda it: names.index(it.reward))


def terms_grid(found: TermsPaid) -> Grid:
    """A row for each term, its interval below it; below the table what to say of them."""
    has = {
        "start": True,
        "end": True,
        "evaluation": any(it.evaluation.mean is not None for it in found.terms),
        f"with {found.baseline}": any(it.others.mean is not None for it in found.terms),
        "random": any(it.random is not None for it in found.terms),
        "behaviour": found.is_compared,
        "ruler": any(it.ruler.mean is not None for it in found.terms),
    }
    shown = [heading for heading, is_there in has.items() if is_there]
    rows: list[tuple[str, ...]] = []
    for term in found.terms:
        values = dict(zip(has, _values(term), strict=True))
        rows.append((term.name, *(_text(values[heading]) for heading in shown)))
        intervals = [_interval(values[heading]) for heading in shown]
        rows += [("  95% interval", *intervals)] if any(intervals) else []
    return Grid(("an episode", *shown), rows, list(_notes(found)), f"{TITLE}: {found.reward}")


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


def _values(term: TermPaid) -> tuple[SeedMean | float | None, ...]:
    return (term.start, term.end, term.evaluation, term.others, term.random, term.behaviour, term.ruler)


def _text(value: SeedMean | float | None) -> str:
    return format_number(value.mean if isinstance(value, SeedMean) else value)


def _interval(value: SeedMean | float | None) -> str:
    if not isinstance(value, SeedMean) or value.low == value.high:  # one without a width would be taken for certainty
        return ""
    return interval_of_mean(value)
