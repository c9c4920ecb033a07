"""What evaluations before the end of the trainings say of two rewards."""

from collections.abc import Callable, Sequence

from harness.eta.behaviour_change import Change, Quantity
from harness.eta.interval import SHARE
from harness.results.comparison import Group, StepChange
from harness.results.measured import AREA, LEARNING, STEPS_TO_GOAL, Moment, learning_values, moments_by_due

Moments = tuple[Sequence[Sequence[Moment]], Sequence[Sequence[Moment]]]
"""The evaluations of each compared training by the baseline, then of each by the proposed reward."""


def changes_along(
    group: Group, moments: Moments, names: Sequence[str], change: Callable[..., Change]
) -> tuple[StepChange, ...]:
    """The measures that decide, at each evaluation before the end that all trainings have.

    Args:
        group: What the trainings share.
        moments: Their evaluations.
        names: The names of the measures.
        change: A function of a measure's name, its manner, and the values of both sides by seed.
    """
    one, other = ([dict(moments_by_due(its, group.evaluate_every, group.steps)) for its in side] for side in moments)
    in_all = set.intersection(*(set(its) for its in (*one, *other)))

    def at(due: int) -> tuple[Change, ...]:
        return tuple(
            change(
                name, f"after {due:,} steps", *([its[due].values.get(name) for its in side] for side in (one, other))
            )
            for name in names
        )

    return tuple(StepChange(due, at(due)) for due in sorted(in_all) if due < group.steps)


def learning_changes(group: Group, moments: Moments, success: str, change: Callable[..., Change]) -> list[Change]:
    """How fast the trainings learned, by the share of episodes that end in success.

    Args:
        group: What the trainings share.
        moments: Their evaluations.
        success: The name of that measure.
        change: A function of a measure, and the values of both sides by seed.
    """
    one, other = ([learning_values(its, group.steps, success) for its in side] for side in moments)
    measures = (
        Quantity(AREA, "", "higher", LEARNING, bounds=SHARE),
        Quantity(STEPS_TO_GOAL, "steps", "lower", LEARNING, bounds=(0.0, float(group.steps))),
    )
    return [change(it, *([values[it.name] for values in side] for side in (one, other))) for it in measures]
