"""What a report says, in its order: the facts that the terminal, the page, the summary and its records show."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Literal

from harness.eta.index import NOTHING
from harness.report.rows import Fact, Grid
from harness.report.rows.comparison import (
    ALONE,
    CHOOSING,
    CHOOSING_TITLE,
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
    choosing_told,
    claims_text,
    compared_text,
    count_cells,
    interim_text,
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
from harness.report.rows.ranking import AGREEMENT, CHOICE, EXPLANATION as RANKED, TITLE as RANKING, task_rows
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
from harness.results.ranking import ranking_of
from harness.results.results import ReturnMatrix
from harness.results.score_matrix import ScoreMatrix
from harness.results.trainings import Alone
from harness.section import shown_sections
from harness.text import shortened

FEW = 3
"""Measures that are shown at a glance."""
ETAS = ("", "eta_N", "its parts", "eta_P", "its parts")


def paragraphs(*texts: str, kind: Literal["", "command"] = "") -> list[Fact]:
    """A fact for each text, without the empty ones; each text once."""
    return [Fact(lines=(text,), kind=kind) for text in dict.fromkeys(filter(None, texts))]


def first_facts(results: Results) -> list[Fact]:
    """What is read first: what is the same in all comparisons, then a line for each. A single one is told in sentences.

    Where one of several rewards is chosen, a line for each of them stands before that.
    """
    combinations, chosen = results.combinations, choosing_facts(results)
    facts = [*said_facts(results), *chosen]
    if combinations:
        facts += [*paragraphs(interim_text(results)), *overview_facts(combinations), *_in_sentences(results)]
        facts += advice_facts(results) if len(combinations) == 1 else []
    elif not chosen:
        facts += [*alone_facts(results, with_all=False), *beside_facts(results)]
    mixtures = (mixture.text for it in combinations for mixture in it.measured.mixtures)
    facts += paragraphs(*mixtures, *_not_split(combinations), *never_texts(results))
    facts += return_facts(_with_others(results))
    return [*facts, *_cells(results), *ranking_facts(results, with_all=False), *_of_sections(results)]


def all_facts(results: Results) -> list[Fact]:
    """Everything that the first facts rest on: a part for each comparison, what the rewards pay, then the cells."""
    combinations = results.combinations
    facts = [*said_facts(results), *paragraphs(interim_text(results)), *pooled_facts(combinations)]
    facts += [*alone_facts(results, with_all=True), *beside_facts(results)]
    facts += [fact for it in combinations for fact in comparison_facts(results, it)]
    facts += advice_facts(results)
    facts += [how_to_read(results)] if any(it.has_trainings for it in combinations) else []
    facts += return_facts(results.returns)
    facts += [Fact(lines=(EXPLANATION,), kind="reading")] if results.returns else []
    return [*facts, *_cells(results), *ranking_facts(results, with_all=True), *_of_sections(results)]


def comparison_facts(results: Results, comparison: Comparison) -> list[Fact]:
    """Everything that is said of one comparison: which it is, both answers, then what they rest on."""
    headline, group = comparison.headline, comparison.group
    compared = f"{compared_text(comparison)} compared, {group.steps:,} training steps per run"
    mixtures = [mixture.text for mixture in comparison.measured.mixtures]
    facts = [
        Fact(f"{group.title}: {rewards_text(comparison)}", (compared, *mixtures)),
        Fact(f"The {group.subject}: {word_of(headline.answer)}", (headline.robot,)),
        *paragraphs(*beside_answer(comparison), basis_text(comparison)),
    ]
    told = {PAY: comparison.pay_sentence, INDICES: comparison.index_sentence}
    facts += [Fact(title, (text,)) for title, text in told.items() if text]
    grids = [grid for of in comparison_grids(results, comparison).values() for grid in of]
    return [*facts, *paragraphs(claims_text(comparison)), Fact(grids=tuple(grids))]


def comparison_grids(results: Results, comparison: Comparison) -> dict[str, list[Grid]]:
    """Every table of one comparison that has something to show, by what it is about."""
    behaviour = behaviour_grids(comparison)
    found = {
        "behaviour": behaviour[:1],
        "other behaviour": [along_grid(comparison), *behaviour[1:], seeds_grid(comparison)],
        "pay": [returns_grid(comparison)],
        "numbers": number_grids(comparison, results.kind),
        "terms": list(map(terms_grid, terms_of(results, comparison))),
    }
    return {name: [grid for grid in grids if grid.rows or grid.notes] for name, grids in found.items()}


def how_to_read(results: Results) -> Fact:
    """What the numbers of comparisons mean, and what decides."""
    combinations = results.combinations
    split = [SPLIT] * any(it.number.is_split for it in combinations)
    paid = [READING] * any(bool(it.number.pay) for it in combinations)
    told = (scales_text(results.subject), *split, *paid, NO_REWARD, what_decides(results))
    return Fact(lines=(" ".join(told),), kind="reading")


def overview_facts(combinations: Sequence[Comparison]) -> list[Fact]:
    """What is the same in all comparisons, the answers over all places, a line for each, and how to read them."""
    wide, middle = (overview_grids(combinations, with_intervals=it) for it in (True, False))
    narrower = (tuple(middle), tuple(map(_narrow, middle)))
    reading = Fact(lines=(overview_of(combinations).reading,), kind="reading")
    return [
        Fact(shared_text(combinations)),
        *pooled_facts(combinations),
        Fact(grids=tuple(wide), narrower=narrower),
        reading,
        *_etas(combinations),
    ]


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


def _in_sentences(results: Results) -> list[Fact]:
    """What to know of the lines above; of one comparison both answers."""
    combinations = results.combinations
    lines = [*(line for it in combinations for line in beside_answer(it)), *map(basis_text, combinations)]
    if len(combinations) == 1:
        only = combinations[0]
        lines = [only.headline.robot, *lines, only.pay_sentence]
    return paragraphs(*lines)


def advice_facts(results: Results) -> list[Fact]:
    """How to get an answer where there is none."""
    return paragraphs(*(advice(results, it) for it in results.combinations), kind="command")


def beside_facts(results: Results) -> list[Fact]:
    """How to compare a reward that stands alone."""
    told = beside(results, results.alone)
    return paragraphs(told and f"To compare it with another reward: {told}", kind="command")


def pooled_facts(combinations: Sequence[Comparison]) -> list[Fact]:
    """The answers over all places; none where there is one place."""
    lines = tuple(f"{answer}: {told}" for answer, told in pooled_answers(combinations))
    return [Fact(POOLED_TITLE, lines)] if lines else []


def choosing_facts(results: Results) -> list[Fact]:
    """Who went furthest, and a line for each candidate; none where none is chosen, or nobody has left yet."""
    told = choosing_told(results)
    if told is None:
        return []
    table = Fact(CHOOSING_TITLE, grids=(told.grid,))
    return [Fact(told.sentence), table, Fact(lines=(CHOOSING,), kind="reading")]


def alone_facts(results: Results, *, with_all: bool) -> list[Fact]:
    """What each reward paid for; none where each has another beside it.

    Args:
        results: The experiment, or the recordings.
        with_all: Whether every measure, every interval and every term is shown.
    """
    facts = [fact for it in results.alone for fact in _alone(results, it, with_all)]
    return [*facts, Fact(lines=(ALONE,), kind="reading")] if facts else []


def _alone(results: Results, alone: Alone, with_all: bool) -> Iterator[Fact]:
    grid = alone_grid(alone, None if with_all else FEW)
    title, where = f"{question(results)} {size_text(alone)}.", alone.group.title
    yield Fact(title, (where,), (grid,))
    yield from paragraphs(story(alone))
    for terms in results.terms:
        if (terms.group, terms.reward) == (alone.group, alone.reward):
            yield from [Fact(grids=(terms_grid(terms),))] if with_all else paragraphs(changed_text(terms))


def ranking_facts(results: Results, *, with_all: bool) -> list[Fact]:
    """Whether another reward would have been chosen elsewhere, and on request what that rests on."""
    tasks = list(map(task_rows, ranking_of(results).tasks))
    facts = [Fact(RANKING)] if tasks else []
    for rows in tasks:
        grids = (*(table.grid for table in rows.ranks), rows.choices, rows.agreements) if with_all else ()
        facts.append(Fact(rows.title, tuple(rows.lines), grids))
    return [*facts, Fact(lines=(f"{RANKED} {CHOICE} {AGREEMENT}",), kind="reading")] if tasks and with_all else facts


def said_facts(results: Results) -> list[Fact]:
    """How what was found was sorted and read; none of an experiment, which knows what it trained."""
    return [Fact(lines=tuple(f"{line}." for line in results.said))] if results.said else []


def _of_sections(results: Results) -> list[Fact]:
    """What commands of plugins add."""
    return [fact for section in shown_sections(results).values() for fact in section.facts]


def _cells(results: Results) -> list[Fact]:
    return [Fact(count_cells(results), tuple(remarks_on_cells(results)))]


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
