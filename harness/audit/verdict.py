"""What an audit says, in plain words."""

from collections.abc import Iterable, Sequence

from harness.audit.audit import Audit
from harness.audit.number import number
from harness.audit.payoff import Payoff, Temptation
from harness.audit.scripted import CREEP, FINISH, HOLD, HOVER


def verdict_of(audit: Audit) -> list[str]:
    """One line on finishing, and one for whatever else needs a warning."""
    payoffs = {payoff.policy: payoff for payoff in audit.payoffs}
    lines = [on_finishing(audit.gamma, audit.payoffs, audit.undiscounted, audit.discounted)]
    if audit.holding_pays:
        lines.append(_on_holding(audit, payoffs[HOLD]))
    if payoffs[FINISH].success < 1.0:
        lines.append(f"finish reached the target in only {payoffs[FINISH].success:.0%} of the episodes.")
    lines += [
        f"{name} could not stay outside epsilon: {payoffs[name].success:.0%} of its episodes ended at the target."
        for name in (HOVER, CREEP)
        if payoffs[name].success > 0.0
    ]
    return [*lines, *on_terms(audit.never_paid, audit.steps)]


def on_finishing(
    gamma: float, payoffs: Sequence[Payoff], undiscounted: Sequence[Temptation], discounted: Sequence[Temptation]
) -> str:
    """Whether finishing is what pays; rests on the discounted return, which is what a learner is after.

    Args:
        gamma: Discount per step.
        payoffs: One of each scripted policy, the best return first.
        undiscounted: What pays more than finishing, without discount.
        discounted: The same with it.
    """
    rate = f"discounted by {gamma:g}"
    if undiscounted and discounted:
        told = f"{_compare(undiscounted[0])}; {rate} {_compare(discounted[0])}"
        return f"Not finishing pays more than finishing: {told}."
    if discounted:
        return f"Not finishing pays more than finishing: {rate} {_compare(discounted[0])}; without discount less."
    if undiscounted:
        return f"Finishing pays most {rate}; without discount it does not: {_compare(undiscounted[0])}."
    finish = next(payoff for payoff in payoffs if payoff.policy == FINISH)
    others = [payoff for payoff in payoffs if payoff.success < finish.success]
    beside = f", {others[0].policy} {number(others[0].total)}" if others else ""
    return f"Finishing pays most: finish earns {number(finish.total)} per episode{beside}."


def on_terms(never_paid: Iterable[str], steps: int) -> list[str]:
    """A line for each term that paid nothing in all these steps of the scripted policies."""
    return [f"The term '{name}' never paid in {steps:,} steps." for name in never_paid]


def _on_holding(audit: Audit, hold: Payoff) -> str:
    earned = f"{number(hold.shaped)} of shaped reward per episode, {number(hold.shaped_discounted)}"
    line = f"Holding still pays: {earned} discounted by {audit.gamma:g}."
    taken_back = any(answer.name == "potential-based" and answer.gamma == audit.gamma for answer in audit.properties)
    return f"{line} It is shaping by a potential, and the discount takes it back." if taken_back else line


def _compare(temptation: Temptation) -> str:
    return (
        f"{temptation.policy} earns {number(temptation.earns)} per episode, finish {number(temptation.finish_earns)}"
        f" (more in {temptation.share:.0%} of the episodes)"
    )
