"""An audit as a terminal shows it."""

from collections.abc import Iterable

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from harness.audit.audit import Audit
from harness.audit.distance import Distance
from harness.audit.number import number
from harness.audit.payoff import Payoff
from harness.audit.probe import why_not_asked
from harness.audit.transitions.form_distances import DARD, EPIC, STARC
from harness.audit.verdict import verdict_of
from harness.audit.workspace import FACTOR

SAME = "0: the same up to scale, offset and shaping by a potential; 0.71: unrelated; 1: opposite"
MADE_UP = {EPIC: SAME, DARD: "as EPIC, but each step is compared only with steps that the arm can do from there"}
MEANING = {
    EPIC: SAME,
    DARD: "as EPIC, but each step is compared only with recorded steps that are near in time",
    STARC: "as EPIC, but less the value of a state, by recorded steps that are near in time",
}
"""What the distances say that rest on recorded transitions, by form; `MADE_UP` is that of made-up distances."""
RECORDED = (
    "These distances were computed from recorded transitions, because a reward reads {}, and not distances alone: each "
    "was asked what a recorded action pays between two recorded states."
)


def audit_table(audit: Audit, title: str, setting: str, against: str) -> RenderableType:
    """What ``harness audit`` prints.

    Args:
        audit: What was found.
        title: The reward.
        setting: Where the scripted policies were recorded.
        against: The reward that it was compared with.
    """
    first, *others = verdict_of(audit)
    return Group(
        Text(title, style="bold"),
        Text(f"{setting}\n"),
        _payoff_grid(audit),
        *_terms(audit),
        Text(f"\n{first}", style="bold"),
        *map(Text, others),
        Text(),
        _answer_grid(audit, against),
        *_recorded(audit),
        *_rescaling(audit, title, against),
    )


def _terms(audit: Audit) -> list[RenderableType]:
    """What each term paid each policy; nothing for a reward without terms. Policies stand in the order of the table."""
    terms = audit.payoffs[0].terms
    if not terms:
        return []
    grid = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
    grid.add_column("term", overflow="fold")
    for payoff in audit.payoffs:
        grid.add_column(Text(payoff.policy), justify="right", no_wrap=True)
    for name in terms:
        grid.add_row(Text(name), *(Text(number(payoff.terms[name])) for payoff in audit.payoffs))
    return [Text("\nWhat each term paid in an episode, without discount:\n"), grid]


def _rescaling(audit: Audit, title: str, against: str) -> list[Text]:
    """A sentence that says that the reward is the other one but for its scale; empty if it is not."""
    if audit.rescaling is None:
        return []
    return [
        Text(f"\n{audit.rescaling.sentence(title, against)}. Event terms are the task's, and stay as they are.", "bold")
    ]


def _payoff_grid(audit: Audit) -> Table:
    """In two lines of headings, so that names and values are whole in 60 columns."""
    grid = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
    grid.add_column("policy", no_wrap=True)
    for heading in ("return", "shaped\nalone", f"return\ngamma {audit.gamma:g}", "steps", "success"):
        grid.add_column(Text(heading), justify="right", no_wrap=True)
    for place, payoff in enumerate(audit.payoffs):
        name = f"{payoff.policy} (best)" if place == 0 else payoff.policy
        grid.add_row(Text(name), *map(Text, _cells(payoff)), style="bold" if place == 0 else "")
    return grid


def _cells(payoff: Payoff) -> Iterable[str]:
    yield from map(number, (payoff.total, payoff.shaped, payoff.total_discounted))
    yield f"{payoff.steps:.1f}"
    yield f"{payoff.success:.0%}"


def _answer_grid(audit: Audit, against: str) -> Table:
    """What is asked, the answer, and what that rests on."""
    grid = Table(box=None, show_header=False, pad_edge=False)
    grid.add_column(overflow="fold")
    grid.add_column(no_wrap=True)
    grid.add_column(overflow="fold")
    asked, larger = [answer.name for answer in audit.properties], f"all distances times {FACTOR:g}"
    if audit.needed:
        grid.add_row(Text("\n".join((*asked, larger))), "n/a", Text(why_not_asked(audit.needed)))
    else:
        for answer in audit.properties:
            grid.add_row(Text(answer.name), "yes" if answer.holds else "no", Text(answer.evidence))
        grid.add_row(Text(larger), "", Text(_workspace(audit)))
    for name, distance in ((EPIC, audit.distance), (DARD, audit.reachable_distance), (STARC, audit.starc_distance)):
        if distance is not None:
            meaning = (MEANING if audit.recorded_because else MADE_UP)[name]
            grid.add_row(
                Text(f"{name} distance to {against}"), _distance_value(distance), Text(_note(distance, meaning))
            )
    return grid


def _workspace(audit: Audit) -> str:
    ratios = [f"{policy} {'n/a' if ratio is None else number(ratio)}" for policy, ratio in audit.workspace.items()]
    return f"the shaped return grows by a factor: {', '.join(ratios)}; the event terms stay the same"


def _recorded(audit: Audit) -> list[Text]:
    """Why the distances were computed in another way than those of rewards of distances."""
    fields = ", ".join(audit.recorded_because)
    return [Text(f"\n{RECORDED.format(fields)}")] if fields else []


def _distance_value(distance: Distance) -> str:
    return "n/a" if distance.value is None else f"{distance.value:.3f}"


def _note(distance: Distance, meaning: str) -> str:
    if distance.value is None:
        return (
            f"not defined: {distance.reason or 'one of the two rewards is only an offset and shaping by a potential'}"
        )
    return f"{meaning}; {distance.transitions:,} recorded steps"
