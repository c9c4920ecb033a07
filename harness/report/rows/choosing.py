"""Which of several rewards went furthest, as the terminal and the page show it."""

from typing import NamedTuple

from harness.eta.headline import Answer, count_trainings
from harness.eta.index import NOTHING
from harness.report.answers import word_of
from harness.report.rows.ratios import Grid, format_number
from harness.results import Results
from harness.results.choosing import Choosing

CHOOSING_TITLE = "How far the candidates went"
CHOOSING = (
    "The worse half of the candidates leaves at each stage, by the mean of their trainings so far. That promises "
    "nothing: one that left may be as good. So the one that went furthest and the baseline train anew, and only these "
    "new trainings are compared."
)
SAID = {
    Answer.CANNOT_TELL: "whether it beats {baseline} cannot be told yet",
    Answer.HELPS: "{name} helps",
    Answer.HURTS: "{name} hurts",
    Answer.AHEAD: "{name} is ahead so far",
    Answer.BEHIND: "{name} is behind so far",
    Answer.NO_DIFFERENCE: "{name} makes no difference",
}


class ChoosingTold(NamedTuple):
    """How far candidates went, in words."""

    sentence: str
    grid: Grid
    """By candidate, the mean of what decides at each stage at which it was there."""


def choosing_told(results: Results) -> ChoosingTold | None:
    """How far candidates went; None where none is chosen, or before the first stage is over."""
    found = results.choosing
    if found is None or found.schedule is None or not found.halving.means:
        return None
    measure, is_share, sign = _measure(results)
    means = found.halving.means
    went = dict.fromkeys(name for of in reversed(means) for name in of)
    rungs = found.schedule.rungs[: len(means)]
    headings = ("", *(f"{measure} of {count_trainings(rung.seeds)}" for rung in rungs))

    def shown(value: float | None) -> str:
        return NOTHING if value is None else f"{sign * value:.1%}" if is_share else format_number(sign * value)

    rows = [(name, *(shown(of[name]) if name in of else "" for of in means)) for name in went]
    return ChoosingTold(choosing_sentence(results, found), Grid(headings, rows, []))


def choosing_sentence(results: Results, found: Choosing) -> str:
    """Who went furthest, and what is said of it."""
    winner, count = found.halving.furthest, len(found.candidates)
    if winner is None:
        return f"{found.text[:1].upper()}{found.text[1:]}."
    told, fresh = f"{winner} went furthest of {count} ({count_trainings(found.spent)}).", len(found.fresh) // 2
    answers = [it.headline for it in results.pools] or [it.headline for it in results.combinations]
    if not found.is_over or not answers:
        return f"{told} New trainings of it and of {found.baseline} are to tell whether it helps: {fresh} of each."
    answer = answers[0].answer
    said = SAID.get(answer, f"the answer is {word_of(answer)}").format(name=winner, baseline=found.baseline)
    return f"{told} On {fresh} new trainings of each, {said}."


def _measure(results: Results) -> tuple[str, bool, float]:
    """What decides, whether it is a share, and -1 where less of it is better."""
    for of in results.trainings:
        for name in of.deciding[:1]:
            measure = of.quantity(name, "", 1)
            return name.replace("_", " "), measure.is_share, -1.0 if measure.better == "lower" else 1.0
    return "behaviour", False, 1.0
