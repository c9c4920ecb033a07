"""The page's figures as files: accumulated reward, ruler x behaviour and learning of a combination; the race.

Each is an SVG file with all that tells what it shows. `missing` tells of cells that are not done.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import TypeAlias

import numpy as np

from harness.authoring.commands import Comparison, Learning, Split
from harness.authoring.pages import (
    MEAN,
    RACE_TITLE,
    CurvePanel,
    RaceTold,
    compared_text,
    describe_learning,
    describe_split,
    draw_both,
    draw_learning,
    draw_race,
    draw_split,
    flat_text,
    format_number,
    learning_heading,
    learning_names,
    percentage,
    reward_range,
    rewards_text,
    seeds_text,
    splits_of,
    text_of,
)

from .svg import INTERVALS, TitledChart, draw_svg

PANELS = 3
"""How many panels the figure of learning has at most."""
Panels: TypeAlias = tuple[CurvePanel, CurvePanel]
FLAT = 0.03
"""Curves that span less of the axis than this share look like a line."""
RUNS = (
    "Thin: one run per seed. Thick: their mean, which the indices are taken from. Shaded: Ω₁ below 0, which I_N sums, "
    "and Ω₂ above 0, which I_P sums."
)
LEARNING = "Lines: means over seeds. Bands: 95% intervals."


def runs_file(combination: Comparison, panels: Panels | None, missing: str = "", note: str = "") -> bytes | None:
    """The figure of accumulated reward: all runs and their mean, a panel per reward; None without a finished pair.

    Args:
        combination: What was compared.
        panels: Its curves; None if they are not known.
        missing: Which of its cells are not done.
        note: What else there is to say about the curves.
    """
    if panels is None:
        return None
    headings = (f"Baseline: {combination.baseline}", f"Proposed: {combination.proposed}")
    titled = [TitledChart(heading, chart) for heading, chart in zip(headings, draw_both(panels), strict=True)]
    return _file("Accumulated reward", combination, missing, titled, [RUNS, *_flat(panels), *filter(None, [note])])


def _flat(panels: Panels) -> Iterator[str]:
    """What is said of curves that are a line on the scale that both panels have."""
    low, high = reward_range(panels)
    for panel in panels:
        values = np.concatenate([run.values for run in panel.runs])
        if np.ptp(values) < FLAT * (high - low):
            yield f"On the scale of both panels the curves of {panel.reward} cannot be told from a line."


def split_file(combination: Comparison, missing: str = "") -> bytes | None:
    """The figure of every eta and its parts, each with its interval; None if no part of any can be drawn."""
    splits = splits_of(combination)
    drawn = {name: draw_split(name, split) for name, split in splits.items()}
    headings = {"eta": f"{MEAN} {combination.manner}: eta = ruler x behaviour"}
    panels = [
        TitledChart(headings.get(name, f"{name} = ruler x behaviour"), chart)
        for name, chart in drawn.items()
        if chart is not None
    ]
    if not panels:
        return None
    told = [describe_split(name, split) if drawn[name] else _not_drawn(name, split) for name, split in splits.items()]
    return _file("Ruler x behaviour", combination, missing, panels, [*told, INTERVALS])


def _not_drawn(name: str, split: Split) -> str:
    return f"{name} is not drawn: {split.eta.note or 'no part has a number'}."


def race_file(told: RaceTold) -> bytes:
    """The figure of a race: what decides over the seeds, a line for each reward."""
    return draw_svg(RACE_TITLE, [RACE_TITLE, told.sentence], [TitledChart("", draw_race(told))])


def measures_of(combination: Comparison, learning: Learning | None) -> dict[str, bool]:
    """The measures that the figure of learning shows, and whether each is written as a percentage."""
    names = learning_names(learning, combination)[:PANELS] if learning else []
    shares = [it.name for it in combination.changes_of(combination.manner) if text_of(it) is percentage]
    return {name: name in shares for name in names}


def learning_file(
    combination: Comparison, learning: Learning, measures: Mapping[str, bool], missing: str = ""
) -> bytes | None:
    """The figure of some measures over environment steps, under both rewards; None if nothing happens in any.

    Args:
        combination: What was compared.
        learning: How it learned.
        measures: See `measures_of`.
        missing: Which of its cells are not done.
    """
    flat = {name: flat_text(learning, name, text) for name, text in _texts(measures).items()}
    texts = {name: text for name, text in _texts(measures).items() if not flat[name]}
    if not texts:
        return None
    told = [f"{learning_heading(name)}: {describe_learning(learning, name, text)}" for name, text in texts.items()]
    panels = [TitledChart(learning_heading(name), draw_learning(learning, name, it)) for name, it in texts.items()]
    notes = [LEARNING, *told, *filter(None, flat.values())]
    return _file("Learning", combination, missing, panels, notes, compared_text(combination))


def flat_words(learning: Learning, measures: Mapping[str, bool]) -> str:
    """What is said in the place of a figure of learning in which nothing happens; empty where nothing is known."""
    return " ".join(filter(None, (flat_text(learning, name, text) for name, text in _texts(measures).items())))


def _texts(measures: Mapping[str, bool]) -> dict[str, Callable[[float | None], str]]:
    return {name: percentage if is_share else format_number for name, is_share in measures.items()}


def _file(
    what: str, combination: Comparison, missing: str, panels: list[TitledChart], notes: list[str], compared: str = ""
) -> bytes:
    """A figure as a file. Above its panels stands what was compared where, over how many seeds, and what is missing.

    Pay is compared on the seeds that both rewards have; `compared` says what is, where that is not so.
    """
    where, rewards = combination.group.title, rewards_text(combination)
    seeds = (compared or seeds_text(combination.seeds)) + (f"; {missing}" if missing else "")
    return draw_svg(f"{what}: {where}: {rewards}", (what, where, f"{rewards}, {seeds}"), panels, notes)
