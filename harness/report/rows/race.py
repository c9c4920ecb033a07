"""A race for the best reward, as the terminal and the page show it."""

from typing import NamedTuple

import numpy as np

from harness.eta.index import NOTHING
from harness.eta.verdict.race import CLOSE, Race
from harness.report.rows.ratios import Grid, format_number
from harness.results import Results
from harness.results.comparison import Comparison
from harness.results.overview import pay_texts
from harness.results.standing import Standing, standing_of, values_of

RACE_TITLE = "The race for the best reward"
RACE = (
    "Clearly worse candidates are dropped and trained no further. The test that drops them allows for all looks "
    "together, at 5 %. Pay is that of an episode, each training by its own reward: x 2 is twice the baseline's. The "
    "ruler is the part of the change that is rescaling alone. Pay does not affect the race."
)
HEADINGS = ("", "in the race", "{measure}", "seeds", "pay", "ruler")


class RaceTold(NamedTuple):
    """A race in words."""

    sentence: str
    grid: Grid
    points: dict[str, list[tuple[int, float]]]
    """By reward, the mean of what decides at each look at which it was in the race: seeds and value."""
    living: tuple[str, ...]
    """Who can still be the best."""
    measure: str
    is_share: bool
    beside: tuple[str, ...] = ()
    """What has to be known at once of the rewards, a sentence or two each."""


def race_told(results: Results) -> RaceTold | None:
    """The race in an experiment's folder; None if there is none, or nothing to show yet."""
    standing = standing_of(results)
    race = None if standing is None else standing.race
    if standing is None or race is None or not race.looks:
        return None
    first = next(iter(results.combinations))
    measure = (first.measured.deciding[0] if first.measured.deciding else "behaviour").replace("_", " ")
    change = first.decisive
    is_share = change is not None and change.measure.episodes is not None
    sign = -1.0 if change is not None and change.measure.better == "lower" else 1.0
    points = {name: _points(results, standing, name, sign) for name in standing.rewards}
    order = sorted(standing.rewards, key=lambda name: _rank(race, name, points[name], sign))
    paid = {it.proposed: it for it in results.combinations}
    rows = [_row(standing, name, points[name], is_share, paid.get(name)) for name in order]
    headings = tuple(it.format(measure=measure) for it in HEADINGS)
    beside = tuple(dict.fromkeys(line for it in results.combinations for line in it.not_maximised))
    return RaceTold(race_sentence(standing), Grid(headings, rows, []), points, race.living, measure, is_share, beside)


def race_sentence(standing: Standing) -> str:
    """Who is the best, as far as it is known."""
    race, looks = standing.race, standing.terms.looks
    assert race is not None
    if not race.living:
        return "CANNOT TELL: no reward left a number in its trainings."
    seeds = looks[race.looks - 1] if race.looks else 0
    worse = "worse" if all(it.by for it in race.beaten.values()) else "worse or failed"
    others = f"{next(iter(race.beaten))} is {worse}." if len(race.beaten) == 1 else f"All others are {worse}."
    others = others if race.beaten else ""
    if race.best is not None:
        return f"BEST: {race.best}. {others} The test is made to err in at most 5 % of such races."
    if race.is_close:
        return f"WITHIN {100 * CLOSE:g} POINTS OF THE BEST: {', '.join(race.living)}. {others}".rstrip()
    if race.is_over:
        return f"CANNOT TELL after {seeds} seeds which is best: {', '.join(race.living)}. {others}".rstrip()
    living = ", ".join(race.living)
    return (
        f"After {seeds} seeds, these can still be the best: {living}. At most {standing.most_left} trainings are left."
    )


def _row(
    standing: Standing, name: str, points: list[tuple[int, float]], is_share: bool, comparison: Comparison | None
) -> tuple[str, ...]:
    seeds, value = points[-1] if points else (0, None)
    told = NOTHING if value is None else f"{value:.1%}" if is_share else format_number(value)
    return (
        name,
        _end(standing, name),
        told,
        str(seeds),
        *(("", "") if comparison is None else pay_texts(comparison.number.pay)[1:3]),
    )


def _points(results: Results, standing: Standing, name: str, sign: float) -> list[tuple[int, float]]:
    """The mean at each look, up to the one at which it left, or the last one that is complete."""
    race = standing.race
    assert race is not None
    values = sign * values_of(results, standing.seen, name)
    last = race.beaten[name].look + 1 if name in race.beaten else race.looks
    ends = standing.terms.looks[:last]
    return [
        (end, float(np.nanmean(values[:, :end], axis=1).mean())) for end in ends if np.isfinite(values[:, :end]).any()
    ]


def _rank(race: Race, name: str, points: list[tuple[int, float]], sign: float) -> tuple[int, float]:
    left = race.beaten[name].look if name in race.beaten else race.looks
    return -left, -sign * (points[-1][1] if points else 0.0)


def _end(standing: Standing, name: str) -> str:
    race = standing.race
    assert race is not None
    if name in race.beaten:
        it = race.beaten[name]
        return f"worse than {it.by}" if it.by else "too few numbers"
    if race.best == name:
        return "BEST"
    return f"within {100 * CLOSE:g} points of the best" if race.is_close else "can be the best"
