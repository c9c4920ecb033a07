"""What an audit says, in plain words."""

from harness.authoring.commands import CREEP, FINISH, HOLD, HOVER, Payoff, on_finishing, on_terms
from harness.text import number

from .audit import OfScripts


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


def _on_holding(found: OfScripts, hold: Payoff) -> str:
    gamma = found.finishing.gamma
    earned = f"{number(hold.shaped)} of shaped reward per episode, {number(hold.shaped_discounted)}"
    line = f"Holding still pays: {earned} discounted by {gamma:g}."
    taken_back = any(answer.name == "potential-based" and answer.gamma == gamma for answer in found.properties)
    return f"{line} It is shaping by a potential, and the discount takes it back." if taken_back else line
