"""What an audit says, in plain words."""

from harness.audit.audit import OfScripts
from harness.audit.number import number
from harness.audit.questions import Finishing, Payoff, Temptation
from harness.audit.scripted import CREEP, FINISH, HOLD, HOVER


def verdict_of(found: OfScripts) -> list[str]:
    """One line on finishing, and one for whatever else needs a warning."""
    of = found.finishing
    payoffs = {payoff.policy: payoff for payoff in of.payoffs}
    lines = [on_finishing(of)]
    if of.holding_pays:
        lines.append(_on_holding(found, payoffs[HOLD]))
    if payoffs[FINISH].success < 1.0:
        lines.append(f"finish reached the target in only {payoffs[FINISH].success:.0%} of the episodes.")
    lines += [
        f"{name} could not stay outside epsilon: {payoffs[name].success:.0%} of its episodes ended at the target."
        for name in (HOVER, CREEP)
        if payoffs[name].success > 0.0
    ]
    return [*lines, *on_terms(of)]


def on_finishing(of: Finishing) -> str:
    """Whether finishing is what pays; rests on the discounted return, which is what a learner is after."""
    rate, plain, discounted = f"discounted by {of.gamma:g}", of.undiscounted, of.discounted
    if plain and discounted:
        told = f"{_compare(plain[0])}; {rate} {_compare(discounted[0])}"
        return f"Not finishing pays more than finishing: {told}."
    if discounted:
        return f"Not finishing pays more than finishing: {rate} {_compare(discounted[0])}; without discount less."
    if plain:
        return f"Finishing pays most {rate}; without discount it does not: {_compare(plain[0])}."
    finish = next(payoff for payoff in of.payoffs if payoff.policy == FINISH)
    others = [payoff for payoff in of.payoffs if payoff.success < finish.success]
    beside = f", {others[0].policy} {number(others[0].total)}" if others else ""
    return f"Finishing pays most: finish earns {number(finish.total)} per episode{beside}."


def on_terms(of: Finishing) -> list[str]:
    """A line for each term that paid nothing in all these steps of the scripted policies."""
    return [f"The term '{name}' never paid in {of.steps:,} steps." for name in of.never_paid]


def _on_holding(found: OfScripts, hold: Payoff) -> str:
    gamma = found.finishing.gamma
    earned = f"{number(hold.shaped)} of shaped reward per episode, {number(hold.shaped_discounted)}"
    line = f"Holding still pays: {earned} discounted by {gamma:g}."
    taken_back = any(answer.name == "potential-based" and answer.gamma == gamma for answer in found.properties)
    return f"{line} It is shaping by a potential, and the discount takes it back." if taken_back else line


def _compare(temptation: Temptation) -> str:
    return (
        f"{temptation.policy} earns {number(temptation.earns)} per episode, finish {number(temptation.finish_earns)}"
        f" (more in {temptation.share:.0%} of the episodes)"
    )
