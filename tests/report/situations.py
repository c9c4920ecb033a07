"""Constructed situations, and every sentence that a reader meets in them, through the whole of the verdict.

``python -m tests.report.situations > tests/report/situations.txt`` writes the sentences down. A person reads what
changed there: none may be false, and none may have to be reconciled with the number beside it.
"""

import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.random import default_rng

from harness.eta import Quantity, change_of, swaps_of
from harness.record import Terms
from harness.registry import Choice
from harness.report.page.answer import card_of, pool_card
from harness.results import Comparison, Group
from harness.results.compare import with_verdicts
from harness.results.comparison import Behaviour
from harness.results.overview import decider_text
from tests.results.told import SPEED, SUCCESS

COST = Quantity("energy_balance", "J", "lower", "deterministic")
HORIZON = 5.0
"""The time that a failed episode counts, in seconds."""
TIME = Quantity("time_to_target", "s", "lower", "deterministic", bounds=(0.0, HORIZON))
WIDTH = 110
FIRST = Terms()

Trainings = Sequence[float | None]
Sides = tuple[Trainings, Trainings]
"""A value of each training of the baseline, and of the proposed reward; None of one that crashed."""


@dataclass(frozen=True)
class Situation:
    """What was measured, and under which terms.

    Attributes:
        title: What it is.
        places: By place, the measures and their values.
        terms: What was agreed on before the first training.
        look_of: In an experiment with looks: tells them.
        to_come: How many planned trainings are still to come.
        fields: Of what was measured, in every comparison.
    """

    title: str
    places: Mapping[str, Mapping[Quantity, Sides]]
    terms: Terms = FIRST
    look_of: Callable | None = None
    to_come: int = 0
    fields: Mapping[str, object] = field(default_factory=dict)


def around(mean, width, count, order=0):
    """Values about a mean, as many above it as below, in one of many orders."""
    return (mean + width * default_rng([order, count]).permutation(np.linspace(-1.0, 1.0, count))).round(4).tolist()


def timed(success, quick):
    """The time to the target where a success takes so long, and a failure counts the horizon."""
    return [it if it is None else round(it * quick + (1.0 - it) * HORIZON, 4) for it in success]


def arm(baseline, proposed, speed, quick=(1.0, 1.0)):
    """What is measured of an arm: success, the time to the target, success while training."""
    times = tuple(
        timed(side, of) if isinstance(of, float) else of for side, of in zip((baseline, proposed), quick, strict=True)
    )
    return {SUCCESS: (baseline, proposed), TIME: times, SPEED: speed}


def alone(*measured):
    """The same in one place."""
    return {"mujoco": arm(*measured)}


def alike(count, other=None):
    """Success while training that shows nothing."""
    return around(0.52, 0.08, count, 1), around(0.514, 0.07, other or count, 2)


def in_looks(complete, ends):
    """So many looks are complete, each with so many seeds."""

    def looks(comparison):
        return {seed: sum(seed >= end for end in ends) for seed in range(ends[-1])}, complete

    return looks


PERFECT = (1.0, 1.0, 1.0, 1.0, 1.0, 1.0)
LEARNED_ONE = (0.93, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
GOOD = (0.96, 0.99, 0.97, 1.0, 0.98, 0.95, 1.0, 0.99, 0.97, 0.98)
STEADY = (0.93, 0.88, 0.91, 0.86, 0.94, 0.90, 0.87, 0.92, 0.89, 0.93)
THREE_FAILED = (0.98, 0.21, 0.97, 0.99, 0.05, 0.96, 0.98, 1.0, 0.33, 0.97)
OTHERS = {
    COST._replace(name=f"column_{at}"): (around(0.0, 1.0, 8, at), around(0.0, 1.0, 8, at + 50)) for at in range(10)
}
"""Measures that show nothing."""
CRASHED = (None, None, None, None)
MIDDLE = (0.71, 0.62, 0.80, 0.55, 0.74, 0.68, 0.59, 0.77, 0.65, 0.70)

SITUATIONS = (
    Situation(
        "a clear help",
        alone(MIDDLE * 2, STEADY * 2, (around(0.45, 0.06, 20), around(0.6, 0.06, 20)), (1.2, 1.0)),
    ),
    Situation(
        "a help by little: the time falls from 2.01 to 1.90 s",
        alone(GOOD * 14, GOOD * 14, alike(140), (around(2.01, 0.03, 140), around(1.90, 0.03, 140))),
    ),
    Situation(
        "a hurt: more than half of the trainings fail",
        alone(GOOD, around(0.36, 0.3, 10), alike(10)),
    ),
    Situation(
        "behind so far: every training a little worse",
        {"mujoco": {SUCCESS: (around(0.995, 0.004, 6), around(0.965, 0.004, 6))}},
    ),
    Situation(
        "learns faster only",
        alone(GOOD, GOOD[::-1], (around(0.42, 0.06, 10), around(0.61, 0.06, 10))),
    ),
    Situation(
        "learns faster, but ends worse",
        alone(STEADY * 2, MIDDLE * 2, (around(0.42, 0.06, 20), around(0.61, 0.06, 20))),
    ),
    Situation(
        "two places, 30 points up and 30 points down",
        {
            "mujoco": arm(around(0.6, 0.06, 20), around(0.9, 0.06, 20), alike(20), (1.0, 0.8)),
            "pybullet": arm(around(0.9, 0.06, 20), around(0.6, 0.06, 20), alike(20), (2.0, 1.0)),
        },
    ),
    Situation(
        "eight places, better in three of them",
        {
            f"place {at}": arm(around(0.7, 0.08, 8), around(0.95 if at < 3 else 0.7, 0.05, 8)[::-1], alike(8))
            for at in range(8)
        },
    ),
    Situation(
        "no difference, with a spread",
        alone(
            around(0.93, 0.05, 140), around(0.934, 0.05, 140, 3), (around(0.5, 0.05, 140), around(0.503, 0.05, 140, 5))
        ),
    ),
    Situation("perfect trainings of both", alone(PERFECT, PERFECT, alike(6))),
    Situation(
        "neither learns, 60 seeds",
        alone((0.0, 0.02, 0.0) * 20, (0.01, 0.0, 0.02) * 20, ((0.0, 0.01, 0.0) * 20, (0.01, 0.0, 0.0) * 20)),
    ),
    Situation(
        "success from 1 to 5%",
        alone((0.0, 0.01, 0.02, 0.01), (0.05, 0.04, 0.06, 0.05), ((0.0, 0.01, 0.0, 0.0),) * 2),
    ),
    Situation("an unfinished plan", alone(MIDDLE[:7], STEADY[:7], alike(7), (1.2, 1.0)), to_come=12),
    Situation("3 of 10 trainings failed against 0 of 10", alone(THREE_FAILED, GOOD, alike(10))),
    Situation(
        "ahead so far: one reward is steady, and no training of the other failed yet",
        alone(around(0.84, 0.04, 6), PERFECT, alike(6)),
    ),
    Situation("3 seeds", alone((0.4, 0.5, 0.45), (0.9, 0.95, 1.0), alike(3))),
    Situation(
        "nothing differs, and nobody knows",
        alone(MIDDLE, (0.66, 0.75, 0.58, 0.72, 0.61, 0.81, 0.69, 0.57, 0.79, 0.73), alike(10)),
    ),
    Situation(
        "ahead so far: no share, lower is better, below 0, its ends not known",
        {"": {COST: (around(-3.2, 0.4, 8), around(-4.1, 0.5, 8))}},
        fields={"deciding": ("energy_balance",)},
    ),
    Situation(
        "the same steps, bit for bit",
        alone(GOOD[:3], GOOD[:3], (around(0.5, 0.05, 3),) * 2),
        fields={"same_steps": True},
    ),
    Situation(
        "until decided: the difference is small",
        alone(around(0.9, 0.05, 32), around(0.9, 0.05, 32, 4), alike(32)),
        terms=Terms((6, 8, 12, 16, 24, 32), margin=0.1),
        look_of=in_looks(6, (6, 8, 12, 16, 24, 32)),
    ),
    Situation(
        "until decided: five trainings crashed",
        alone((*MIDDLE, None, 0.72), (*GOOD[:8], *CRASHED), ([*alike(11)[0], None], [*alike(8)[1], *CRASHED])),
        terms=Terms((6, 8, 12, 16)),
        look_of=in_looks(3, (6, 8, 12, 16)),
    ),
    Situation("a folder that grew three times", alone(MIDDLE[:7], STEADY[:7], alike(7)), terms=Terms(grown=(4, 5, 6))),
    Situation(
        "one measure chosen from eleven, after the trainings",
        {"": {COST: (around(-3.2, 0.4, 8), around(-4.1, 0.5, 8)), **OTHERS}},
        fields={"deciding": ("energy_balance",), "offered": tuple(it.name for it in OTHERS)},
    ),
)


def judged(situation):
    """The comparisons of a situation, with their answers."""
    found = [_comparison(place, measures, situation) for place, measures in situation.places.items()]
    return with_verdicts(found, situation.terms, situation.look_of, situation.to_come)


def _comparison(place, measures, situation):
    changes = tuple(_change(measure, sides) for measure, sides in measures.items())
    trained = tuple(tuple(range(count)) for count in changes[0].counts)
    simulator = Choice(place, (), place) if place else None
    robot = "fd100" if place else "(environment)"
    group = Group(robot, Choice("reach", (), "reach"), Choice("sac", (), "sac"), 100_000, 100, simulator=simulator)
    shared = min(trained, key=len)
    measured = replace(Behaviour(changes, episodes={"deterministic": 100}), **situation.fields)
    return Comparison(group, "baseline", "dense", shared, trained, measured)


def _change(measure, sides):
    one, other = (dict(enumerate(side)) for side in sides)
    return change_of(measure, one, other, swaps_of(range(min(len(one), len(other)))))


def told(situation):
    """All sentences of a situation."""
    comparisons = judged(situation)
    pool, blocks = comparisons[0].answer.pool, []
    if pool is not None:
        blocks.append(_block("over all places", pool.headline.answer.value, "", pool.headline.robot, pool_card(pool)))
    shown = comparisons if len(comparisons) < 3 else (comparisons[0], comparisons[-1])
    for it in shown:
        title = it.group.place if pool is not None else ""
        blocks.append(
            _block(title, it.headline.answer.value, decider_text(it), it.headline.robot, card_of(it, "dense"))
        )
    return "\n".join([f"## {situation.title}", *blocks])


def _block(title, answer, decider, sentence, card):
    rows = "; ".join(f"{row.name}{row.note and f' [{row.note}]'} {row.value}" for row in card.rows)
    lines = [
        *([f"[{title}]"] if title else []),
        *_wrapped(
            "terminal", f"{answer.upper()} | {decider} | {sentence}" if decider else f"{answer.upper()}: {sentence}"
        ),
        *_wrapped("page", card.seen),
        *_wrapped("    ", f"({card.answer}) {card.lead}"),
        *_wrapped("rows", rows),
        *_wrapped("sure", card.sure),
        *(line for beside in card.beside for line in _wrapped("beside", beside)),
    ]
    return "\n".join([*lines, ""])


def _wrapped(name, text):
    return textwrap.wrap(text, WIDTH, initial_indent=f"{name:>8}: ", subsequent_indent=" " * 10) if text else []


def whole_text():
    """All situations, one below the other."""
    return "\n".join(_lines())


def _lines():
    yield "Constructed situations and every sentence of them; python -m tests.report.situations writes this file.\n"
    yield from map(told, SITUATIONS)


if __name__ == "__main__":
    print(whole_text())  # noqa: T201
