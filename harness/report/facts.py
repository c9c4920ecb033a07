"""What a report says, as facts: each is made once, and terminal, page, summary and records arrange them."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

from harness.eta.index import NOTHING
from harness.report.rows import Fact, Grid
from harness.report.rows.comparison import (
    ALONE,
    NO_REWARD,
    POOLED_TITLE,
    SHOWN,
    advice,
    alone_grid,
    along_grid,
    basis_text,
    behaviour_grids,
    beside,
    beside_answer,
    choosing_facts,
    claims_text,
    compared_text,
    count_cells,
    grown_text,
    interim_text,
    joined_text,
    pooled_answers,
    question,
    remarks_on_cells,
    rewards_text,
    seeds_grid,
    size_text,
    story,
    what_decides,
    word_of,
)
from harness.report.rows.ranking import ranking_facts
from harness.report.rows.ratios import SPLIT, scales_text, split_grid
from harness.report.rows.returns import (
    EXPLANATION,
    INDICES,
    PAY,
    READING,
    changed_text,
    matrix_title,
    never_texts,
    number_grids,
    return_grid,
    returns_grid,
    terms_grid,
    terms_of,
)
from harness.report.section import Shown, shown_sections
from harness.results import Results
from harness.results.comparison import Comparison
from harness.results.overview import (
    PAY as PAY_TITLE,
    group_name,
    index_rows,
    line_names,
    overview_of,
    overview_row,
    reward_names,
    shared_text,
    varying_kinds,
)
from harness.results.ranking import Ranking, ranking_of
from harness.results.results import ReturnMatrix
from harness.results.score_matrix import ScoreMatrix
from harness.results.trainings import Alone
from harness.text import shortened

FEW = 3
"""Measures that are shown at a glance."""
ETAS = ("", "eta_N", "its parts", "eta_P", "its parts")


def paragraphs(*texts: str, kind: Literal["", "command", "warning"] = "") -> list[Fact]:
    """A fact for each text, without the empty ones; each text once."""
    return [Fact(lines=(text,), kind=kind) for text in dict.fromkeys(filter(None, texts))]


@dataclass(frozen=True)
class Compared:
    """What is said of one comparison: which it is, both answers, what to know of them; then every table there is."""

    facts: Sequence[Fact]
    behaviour: Sequence[Grid] = ()
    """In the manner that decides."""
    otherwise: Sequence[Grid] = ()
    """Behaviour of the same trainings, measured otherwise."""
    pay: Sequence[Grid] = ()
    numbers: Sequence[Grid] = ()
    terms: Sequence[Grid] = ()

    @property
    def all(self) -> list[Fact]:
        """The facts, then all tables."""
        grids = (*self.behaviour, *self.otherwise, *self.pay, *self.numbers, *self.terms)
        return [*self.facts, Fact(grids=grids)]


class Report:
    """What a report says. A part is made when it is first asked for; who asks again gets the same."""

    def __init__(self, results: Results) -> None:
        """Make nothing yet."""
        self.results = results

    @property
    def short(self) -> list[Fact]:
        """What is read first: what is the same in all comparisons, then a line for each. A single one has sentences.

        Where one of several rewards is chosen, a line for each of them stands before that.
        """
        combinations = self.results.combinations
        facts = [*self.said, *self.warnings, *self.chosen]
        if combinations:
            facts += [*self.overview, *_in_sentences(combinations), *(self.advice if len(combinations) == 1 else [])]
        elif not self.chosen:
            facts += [*alone_facts(self.results, with_all=False), *self.beside]
        mixtures = (mixture.text for it in combinations for mixture in it.measured.mixtures)
        facts += [*paragraphs(*mixtures, *_not_split(combinations)), *self.never]
        facts += return_facts(_with_others(self.results))
        ranking = [replace(it, grids=()) for it in self.ranking if it.kind != "reading"]
        return [*facts, self.cells, *ranking, *self._of_sections]

    @property
    def full(self) -> list[Fact]:
        """Everything that the first facts rest on: a part for each comparison, what the rewards pay, then the cells."""
        facts = [*self.said, *self.warnings, *self.pooled, *self.alone, *self.beside]
        facts += [fact for it in self.compared for fact in it.all]
        facts += [*self.advice, *self.reading, *self.returns, self.cells, *self.ranking]
        return [*facts, *self._of_sections]

    @cached_property
    def question(self) -> str:
        """What it answers."""
        return question(self.results)

    @cached_property
    def setting(self) -> str:
        """What is the same in all comparisons; empty without one."""
        return shared_text(self.results.combinations) if self.results.combinations else ""

    @cached_property
    def said(self) -> list[Fact]:
        """How what was found was sorted and read; none of an experiment, which knows what it trained."""
        return [Fact(lines=tuple(f"{line}." for line in self.results.said))] if self.results.said else []

    @cached_property
    def warnings(self) -> list[Fact]:
        """What a reader must know before the answers."""
        of = self.results
        return paragraphs(interim_text(of), joined_text(of), grown_text(of), kind="warning")

    @cached_property
    def chosen(self) -> list[Fact]:
        """Who went furthest, and a line for each candidate; none where none is chosen, or nobody has left yet."""
        return choosing_facts(self.results)

    @cached_property
    def pooled(self) -> list[Fact]:
        """The answers over all places; none where there is one place."""
        lines = tuple(f"{answer}: {told}" for answer, told in pooled_answers(self.results.combinations))
        return [Fact(POOLED_TITLE, lines)] if lines else []

    @cached_property
    def overview(self) -> list[Fact]:
        """What is the same in all comparisons, the answers over all places, a line for each, and how to read them."""
        combinations = self.results.combinations
        wide, middle = (overview_grids(combinations, with_intervals=it) for it in (True, False))
        narrower = (tuple(middle), tuple(map(_narrow, middle)))
        reading = Fact(lines=(overview_of(combinations).reading,), kind="reading")
        lines = Fact(grids=tuple(wide), narrower=narrower)
        return [Fact(self.setting), *self.pooled, lines, reading, *_etas(combinations)]

    @cached_property
    def compared(self) -> list[Compared]:
        """What is said of each comparison."""
        return [_compared(self.results, it) for it in self.results.combinations]

    @cached_property
    def alone(self) -> list[Fact]:
        """What each reward paid for; none where each has another beside it."""
        return alone_facts(self.results, with_all=True)

    @cached_property
    def advice(self) -> list[Fact]:
        """How to get an answer where there is none."""
        return paragraphs(*(advice(self.results, it) for it in self.results.combinations), kind="command")

    @cached_property
    def beside(self) -> list[Fact]:
        """How to compare a reward that stands alone."""
        told = beside(self.results, self.results.alone)
        return paragraphs(told and f"To compare it with another reward: {told}", kind="command")

    @cached_property
    def numbers_mean(self) -> str:
        """What the numbers of comparisons mean."""
        numbers = [it.number for it in self.results.combinations]
        split, paid = any(it.is_split for it in numbers), any(it.pay for it in numbers)
        return " ".join((scales_text(self.results.subject), *[SPLIT] * split, *[READING] * paid))

    @cached_property
    def decides(self) -> str:
        """What decides."""
        return f"{NO_REWARD} {what_decides(self.results)}"

    @property
    def reading(self) -> list[Fact]:
        """How to read comparisons; none where nothing is compared."""
        is_compared = any(it.has_trainings for it in self.results.combinations)
        return [Fact(lines=(it,), kind="reading") for it in (self.numbers_mean, self.decides)] if is_compared else []

    @cached_property
    def never(self) -> list[Fact]:
        """Which terms never paid."""
        return paragraphs(*never_texts(self.results))

    @cached_property
    def returns(self) -> list[Fact]:
        """What each reward pays the policies that each reward taught."""
        found = return_facts(self.results.returns)
        return [*found, Fact(lines=(EXPLANATION,), kind="reading")] if found else []

    @cached_property
    def cells(self) -> Fact:
        """How many cells there are, how they ended, and what to keep in mind of them."""
        return Fact(count_cells(self.results), tuple(remarks_on_cells(self.results)))

    @cached_property
    def ranked(self) -> Ranking:
        """The rankings themselves."""
        return ranking_of(self.results)

    @cached_property
    def ranking(self) -> list[Fact]:
        """Whether another reward would have been chosen elsewhere, and what that rests on; none in one place."""
        return ranking_facts(self.ranked.tasks) if self.ranked.tasks else []

    @cached_property
    def sections(self) -> Mapping[str, Shown]:
        """What commands of plugins add."""
        return shown_sections(self.results)

    @property
    def _of_sections(self) -> list[Fact]:
        return [fact for section in self.sections.values() for fact in section.facts]


def _sentences(comparison: Comparison) -> list[Fact]:
    """Which comparison it is, both answers, and what to know of them."""
    headline, group = comparison.headline, comparison.group
    compared = f"{compared_text(comparison)} compared, {group.steps:,} training steps per run"
    told = {PAY: comparison.pay_sentence, INDICES: comparison.index_sentence}
    return [
        Fact(f"{group.title}: {rewards_text(comparison)}", (compared,)),
        *paragraphs(*(f"{it.text}." for it in comparison.measured.mixtures), kind="warning"),
        Fact(f"The {group.subject}: {word_of(headline.answer)}", (headline.robot,)),
        *paragraphs(*beside_answer(comparison), basis_text(comparison)),
        *(Fact(title, (text,)) for title, text in told.items() if text),
        *paragraphs(claims_text(comparison)),
    ]


def _compared(results: Results, comparison: Comparison) -> Compared:
    behaviour = behaviour_grids(comparison)
    return Compared(
        _sentences(comparison),
        behaviour[:1],
        _told([along_grid(comparison), *behaviour[1:], seeds_grid(comparison)]),
        _told([returns_grid(comparison)]),
        _told(number_grids(comparison, results.kind)),
        list(map(terms_grid, terms_of(results, comparison))),
    )


def _told(grids: Iterable[Grid]) -> list[Grid]:
    """Those that have something to show."""
    return [grid for grid in grids if grid.rows or grid.notes]


def _etas(combinations: Sequence[Comparison]) -> Iterator[Fact]:
    """The note's answer of each comparison, where the lines above tell the pay of an episode; why one is not known."""
    title = f"{INDICES}, each = ruler x behaviour"
    wide, middle = (
        tuple(Grid(ETAS, rows, [], title) for rows in [index_rows(combinations, with_intervals)] if rows)
        for with_intervals in (True, False)
    )
    if wide:
        etas = [(name, split.eta) for it in combinations for name, split in it.number.splits.items()]
        missing = (f"{name} {NOTHING}: {'; '.join(eta.notes)}." for name, eta in etas if eta.value is None)
        yield Fact(grids=wide, narrower=(middle, middle))
        yield from paragraphs(*missing)


def overview_grids(combinations: Sequence[Comparison], *, with_intervals: bool) -> list[Grid]:
    """A line per comparison. If both groups and rewards vary, there is a grid for each group."""
    varying, overview = varying_kinds(combinations), overview_of(combinations)
    is_one = not varying or len({it.proposed for it in combinations}) == 1
    names = line_names(combinations) if is_one else reward_names(combinations)
    blocks: dict[str, list[tuple[str, ...]]] = {}
    for name, it in zip(names, combinations, strict=True):
        row = overview_row(name, it, with_intervals, overview)
        blocks.setdefault("" if is_one else group_name(it, varying), []).append(row)
    return [Grid(overview.headings, rows, [], name) for name, rows in blocks.items()]


def _narrow(grid: Grid) -> Grid:
    """The same lines with the change of pay and its ruler alone."""
    if PAY_TITLE not in grid.headings:
        return grid
    at = grid.headings.index(PAY_TITLE)
    rows: list[tuple[str, ...]] = [(*row[:at], *row[at + 1 : at + 3]) for row in grid.rows]
    return replace(grid, headings=(*grid.headings[:at], "pay", "ruler"), rows=rows)


def _in_sentences(combinations: Sequence[Comparison]) -> list[Fact]:
    """What to know of the lines above; of one comparison both answers."""
    lines = [*(line for it in combinations for line in beside_answer(it)), *map(basis_text, combinations)]
    if len(combinations) == 1:
        only = combinations[0]
        lines = [only.headline.robot, *lines, only.pay_sentence]
    return paragraphs(*lines)


def alone_facts(results: Results, *, with_all: bool) -> list[Fact]:
    """What each reward paid for that nothing is compared with, a fact for each; none where each has another beside it.

    Args:
        results: The experiment, or the recordings.
        with_all: Whether every measure, every interval and every term is shown.
    """
    facts = [_alone(results, it, with_all) for it in results.alone]
    return [*facts, Fact(lines=(ALONE,), kind="reading")] if facts else []


def _alone(results: Results, alone: Alone, with_all: bool) -> Fact:
    terms = [it for it in results.terms if (it.group, it.reward) == (alone.group, alone.reward)]
    told = (alone.group.title, story(alone), *([] if with_all else map(changed_text, terms)))
    grids = (alone_grid(alone, None if with_all else FEW), *(map(terms_grid, terms) if with_all else ()))
    return Fact(f"What did {alone.reward} pay for? {size_text(alone)}.", tuple(filter(None, told)), grids)


def _not_split(combinations: Sequence[Comparison]) -> list[str]:
    """Why a reward could not pay the runs of another one: it explains why an eta was not split."""
    numbers = (it.number for it in combinations if it.seeds)
    told = (it.index_splits for it in numbers if it.pay is None and not it.is_split)
    return [note for splits in told for note in split_grid(splits).notes]


def return_facts(matrices: Iterable[ReturnMatrix]) -> list[Fact]:
    """What each reward pays the policies that each reward taught, a table for each group of trainings."""
    return [Fact(matrix_title(it), grids=(return_grid(it),)) for it in matrices]


def _with_others(results: Results) -> list[ReturnMatrix]:
    """The first table of returns of each group that has rewards which taught nobody: the lines above leave them out."""
    first = {matrix.group: matrix for matrix in reversed(results.returns)}
    return [it for it in first.values() if set(it.returns) - set(it.trained_with)]


def score_facts(matrices: Sequence[ScoreMatrix]) -> list[Fact]:
    """I_N and I_P of each group of cells, of every training under every reward."""
    return [Fact(it.group.title, grids=tuple(_score_grid(name, it) for name in ("I_N", "I_P"))) for it in matrices]


def _score_grid(name: str, matrix: ScoreMatrix) -> Grid:
    """A row per scoring reward and a column per training."""
    rows = [
        (scoring, *(f"{getattr(row[it], name):,.1f}" if it in row else NOTHING for it in matrix.seeds))
        for scoring, row in matrix.indices.items()
    ]
    failed = {it: f"n/a ({shortened(why, SHOWN)})" for it, why in matrix.failed.items() if it not in matrix.indices}
    rows += [(scoring, told, *[NOTHING] * (len(matrix.seeds) - 1)) for scoring, told in failed.items()]
    return Grid((f"{name}, scored by \\ trained on", *matrix.seeds), rows, [])
