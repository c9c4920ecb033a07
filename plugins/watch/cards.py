"""Trainings as small figures: behaviour, and what the reward paid beside it. A reward has its own axis of pay."""

import math
from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from harness.report import Axis, Chart, Dots, Line, draw_chart, linear_axis

from .trainings import Training

WIDTH, HEIGHT = 190.0, 76.0
"""The width of a figure and the height of its panel, [px]."""
POINTS, EPISODES = 20, 8
"""The most points of a curve, and the fewest episodes of one: a single episode has no share of successes."""
COLOURS = ("pair-3", "pair-4", "pair-5", "baseline", "proposed", "ink")
"""The colours of terms; those that pay least are left out where there are more."""
Range = tuple[float, float]


class Figure(NamedTuple):
    """One figure of a card."""

    title: str
    now: str
    """Its last value."""
    svg: str


class Card(NamedTuple):
    """What is shown of one training."""

    training: Training
    progress: str
    share: float
    """The share of its steps that are done, in percent; NaN where nobody said how many there will be."""
    figures: tuple[Figure, ...]
    words: str
    """In the place of figures."""


class Row(NamedTuple):
    """The trainings of one reward in one place."""

    place: str
    reward: str
    cards: tuple[Card, ...]


def rows_of(trainings: Sequence[Training]) -> list[Row]:
    """The cards of all trainings, by place and reward, in the order in which they first stand."""
    places: dict[str, dict[str, list[Training]]] = {}
    for training in trainings:
        places.setdefault(training.place, {}).setdefault(training.reward, []).append(training)
    rows = []
    for place, rewards in places.items():
        everywhere = [training for of in rewards.values() for training in of]
        last = max(max(training.asked, training.steps) for training in everywhere)
        did = _range(value for training in everywhere for value in curves_of(training).behaviour)
        for reward, of in rewards.items():
            paid = _range(value for training in of for value in curves_of(training).pay)
            terms = _range(value for training in of for _, values in curves_of(training).terms for value in values)
            rows.append(Row(place, reward, tuple(card_of(it, last, did, paid, terms) for it in of)))
    return rows


class Curves(NamedTuple):
    """What is drawn of a training's blocks: means of some episodes each."""

    steps: tuple[float, ...]
    """Environment steps when the last of these episodes had ended, (points,); so long are all of them."""
    behaviour: tuple[float, ...]
    pay: tuple[float, ...]
    terms: tuple[tuple[str, tuple[float, ...]], ...]
    """The means of each term, by its name."""


@lru_cache(maxsize=1024)
def curves_of(training: Training) -> Curves:
    """The curves of a training: at most `POINTS` points, each of `EPISODES` episodes at least if there are so many."""
    blocks = training.blocks
    if not blocks:
        return Curves((), (), (), ())
    points = _points(blocks.episodes.tolist())
    means = np.array([np.average(blocks.means[it], axis=0, weights=blocks.episodes[it]) for it in points])
    pay, behaviour, *terms = (tuple(it) for it in means.T.tolist())
    steps = tuple(float(blocks.steps[point.stop - 1]) for point in points)
    return Curves(steps, behaviour, pay, tuple(zip(blocks.terms, terms, strict=True)))


@lru_cache(maxsize=1024)
def card_of(training: Training, last: int, did: Range, paid: Range, terms: Range) -> Card:
    """The card of a training.

    Args:
        training: Which.
        last: The steps at which the figures end.
        did: The range of the behaviour, of all trainings in its place.
        paid: The range of the pay, of all trainings by its reward.
        terms: The same of the reward's terms.
    """
    measure = training.measure.replace("_", " ")
    progress = f"{training.steps:,} steps"
    if training.asked and training.state != "done":
        progress = f"{training.steps:,} of {training.asked:,} steps"
    share = 100.0 * min(1.0, training.steps / training.asked) if training.asked else math.nan
    if not training.blocks:
        words = training.note or ("" if training.state == "failed" else "No episode has ended yet.")
        return Card(training, progress, share, (), words)
    curves = curves_of(training)
    steps, figures = curves.steps, list[Figure]()
    if measure:
        values = curves.behaviour
        axis = Axis(-0.03, 1.03, "", ((0.0, "0 %"), (0.5, "50 %"), (1.0, "100 %"))) if training.is_share else _axis(did)
        shown = f"{100 * values[-1]:.0f} %" if training.is_share else _number(values[-1])
        lower = ", less is better" if training.better == "lower" else ""
        figures.append(_figure(f"{measure}{lower}", shown, steps, values, "behaviour", axis, last))
    pay = curves.pay
    figures.append(_figure(f"pay by {training.reward}", _number(pay[-1]), steps, pay, "ruler", _axis(paid), last))
    if len(curves.terms) > 1:
        figures.append(_terms(training.reward, curves.terms, steps, _axis(terms), last))
    return Card(training, progress, share, tuple(figures), training.note)


def _figure(
    title: str, now: str, steps: Sequence[float], values: Sequence[float], colour: str, axis: Axis, last: int
) -> Figure:
    marks = (Line(steps, values, colour), Dots(steps[-1:], values[-1:], colour, size=2.5))
    known = marks if math.isfinite(values[-1]) else marks[:1]
    label = f"{title}: {now} after {steps[-1]:,.0f} steps"
    return Figure(title, now, draw_chart(Chart(_steps(last), axis, known, HEIGHT, width=WIDTH), label))


def _points(episodes: Sequence[int]) -> list[slice]:
    """Which blocks make a point of a curve each: equally many, the last one some more."""
    size = max(math.ceil(len(episodes) / POINTS), math.ceil(EPISODES / episodes[0]))
    begins = [*range(0, len(episodes) - size + 1, size)] or [0]
    return [slice(begin, end) for begin, end in pairwise([*begins, len(episodes)])]


def _terms(
    reward: str, terms: Sequence[tuple[str, Sequence[float]]], steps: Sequence[float], axis: Axis, last: int
) -> Figure:
    """What each term paid an episode, those that pay most."""
    most = sorted(terms, key=lambda it: -max(map(abs, it[1])))[: len(COLOURS)]
    shown = [it for it in terms if it in most]
    lines = tuple(
        Line(steps, means, colour, name, in_legend=True) for (name, means), colour in zip(shown, COLOURS, strict=False)
    )
    told = ", ".join(f"{name} {_number(means[-1])}" for name, means in shown)
    others = len(terms) - len(shown)
    title = f"terms of {reward}" + (f", {others} smaller ones left out" if others else "")
    chart = Chart(_steps(last), axis, lines, HEIGHT, width=WIDTH)
    return Figure(title, "", draw_chart(chart, f"{title}: {told}"))


def _steps(last: int) -> Axis:
    end = float(max(last, 1))
    return Axis(0.0, end, "steps", ((0.0, "0"), (end, _short(end))), has_grid=False)


def _short(steps: float) -> str:
    for size, unit in ((1e6, "M"), (1e3, "k")):
        if steps >= 10 * size:
            return f"{steps / size:.3g}{unit}"
    return f"{steps:,.0f}"


def _axis(ends: Range) -> Axis:
    low, high = ends
    air = 0.06 * (high - low) or 0.5 * abs(low) or 1.0
    plain = linear_axis(low - air, high + air, "", 3)
    return plain._replace(ticks=tuple((tick, _number(tick)) for tick, _ in plain.ticks))


def _range(values: Iterable[float]) -> Range:
    known = [value for value in values if math.isfinite(value)]
    return (min(known), max(known)) if known else (0.0, 1.0)


def _number(value: float) -> str:
    """A number in few characters."""
    if math.isnan(value):
        return "unknown"
    return f"{value:,.0f}" if 1e3 <= abs(value) < 1e5 else f"{value:.3g}"
