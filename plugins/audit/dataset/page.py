"""What was found on a data set as one HTML file: the answers, and the curves of the pairs that are ranked wrongly."""

from pathlib import Path

import numpy as np

from harness.eta import AGAINST, CANNOT_TELL, RANKS
from harness.eta.auc import Auc
from harness.report import Chart, Grid, Line, draw_chart
from harness.report.figures.accumulated import select_points
from harness.report.page.page import render_page, write_page
from harness.text import number

from ..chart import chart_of
from ..recorded.pair_grid import MISSING, distance_text, share_text
from .dataset_audit import (
    PROMISE,
    SCALE,
    DatasetAudit,
    RewardAnswer,
    WrongPair,
    answers_of,
    auc_text,
    notes_of,
    setting_of,
    title_of,
)

TEMPLATE = Path(__file__).parent / "dataset.html.j2"


def write_dataset_page(audit: DatasetAudit, path: Path) -> None:
    """Write the page to `path`.

    Raises:
        UsageError: A library of the extra ``report`` is missing, or `path` cannot be written.
    """
    page = render_page(
        TEMPLATE,
        "--html",
        title=title_of(audit),
        setting=setting_of(audit),
        lines=notes_of(audit),
        overview=_overview(audit),
        rewards=[_reward(place, reward, audit) for place, reward in enumerate(audit.rewards)],
        distances=_distances(audit),
        promise=f"{SCALE}. {PROMISE}.",
    )
    write_page(page, path, "The page")


BADGES = {RANKS: "helps", AGAINST: "hurts", CANNOT_TELL: "cannot-tell"}
"""The colour of each answer."""


def _overview(audit: DatasetAudit) -> Grid:
    headings: tuple[str, ...] = ("reward", "answer", "success above failure", "pay while standing still")
    rows: list[tuple[str, ...]] = [
        (reward.name, reward.by_success.answer, auc_text(reward.by_success), share_text(reward.still))
        for reward in audit.rewards
    ]
    if any(reward.by_level for reward in audit.rewards) and audit.beginner is not None:
        headings = (*headings, f"above {audit.beginner}")
        rows = [
            (*row, MISSING if reward.by_level is None else f"{auc_text(reward.by_level)} {reward.by_level.answer}")
            for row, reward in zip(rows, audit.rewards, strict=True)
        ]
    return Grid(headings, rows, [])


def _reward(place: int, reward: RewardAnswer, audit: DatasetAudit) -> dict[str, object]:
    return {
        "name": reward.name,
        "answer": reward.by_success.answer,
        "badge": BADGES[reward.by_success.answer],
        "lead": _lead(reward.by_success),
        "told": [(question.capitalize(), answer) for question, answer in answers_of(reward, audit)],
        "pairs": [
            (f"pair-{place}-{rank}", _words(pair), draw_chart(_curves(pair), _words(pair)))
            for rank, pair in enumerate(reward.pairs)
        ],
    }


def _lead(auc: Auc) -> str:
    """The answer in a sentence; the table above has the interval."""
    if auc.value is None:
        return f"{auc.reason[:1].upper()}{auc.reason[1:]}."
    told = f"A success is paid more than a failure with a chance of {100 * auc.value:.0f} %"
    return f"{told}: {auc.reason}." if auc.reason else f"{told}."


def _words(pair: WrongPair) -> str:
    paid = (number(value) for value in pair.paid)
    return "failure {1} is paid {3}, success {0} only {2}".format(pair.success, pair.failure, *paid)


def _curves(pair: WrongPair) -> Chart:
    named = (f"success {pair.success}", "proposed"), (f"failure {pair.failure}", "baseline")
    marks = []
    for curve, (name, colour) in zip(pair.curves, named, strict=True):
        paid = np.concatenate([[0.0], curve])  # what had been paid after so many steps, 0 before the first
        steps = select_points(paid)
        marks.append(Line(steps.tolist(), paid[steps].tolist(), colour, name, in_legend=True))
    return chart_of(marks, "step", "paid so far")


def _distances(audit: DatasetAudit) -> Grid:
    """Every two rewards."""
    rows: list[tuple[str, ...]] = [
        (
            f"{pair.one} and {pair.other}",
            distance_text(pair.steps),
            distance_text(pair.returns),
            share_text(pair.discordant),
        )
        for pair in audit.pairs
    ]
    note = (
        "Distances: 0 the same but for scale and offset, 0.71 unrelated, 1 opposite. The last column is the share of "
        "the pairs of episodes that both tell apart and put in opposite orders. Means over parts of the data set."
    )
    return Grid(
        ("two rewards", "distance by steps", "distance by episodes", "opposite order"), rows, [note] if rows else []
    )
