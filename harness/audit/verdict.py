"""What an audit says, in plain words."""

from harness.audit.audit import Audit
from harness.audit.number import number
from harness.audit.payoff import Payoff, Temptation
from harness.audit.scripted import CREEP, FINISH, HOLD, HOVER


def verdict_of(audit: Audit) -> list[str]:
    """One line on finishing, and one for whatever else needs a warning."""
    payoffs = {payoff.policy: payoff for payoff in audit.payoffs}
    lines = [_on_finishing(audit, payoffs)]
    if audit.holding_pays:
        lines.append(_on_holding(audit, payoffs[HOLD]))
    if payoffs[FINISH].success < 1.0:
        lines.append(f"finish reached the target in {payoffs[FINISH].success:.0%} of the episodes only.")
    lines += [
        f"{name} could not keep outside epsilon: {payoffs[name].success:.0%} of its episodes ended at the target."
        for name in (HOVER, CREEP)
        if payoffs[name].success > 0.0
    ]
    return lines


def _on_finishing(audit: Audit, payoffs: dict[str, Payoff]) -> str:
    """Rests on the discounted return, which is what a learner is after."""
    rate = f"discounted by {audit.gamma:g}"
    if audit.undiscounted and audit.discounted:
        plain, discounted = audit.undiscounted[0], audit.discounted[0]
        return f"Not finishing pays more than finishing: {_compare(plain)}; {rate} {_compare(discounted)}."
    if audit.discounted:
        return f"Not finishing pays more than finishing: {rate} {_compare(audit.discounted[0])}; without discount less."
    if audit.undiscounted:
        return f"Finishing pays most {rate}; without discount it does not: {_compare(audit.undiscounted[0])}."
    finish = payoffs[FINISH]
    others = [payoff for payoff in audit.payoffs if payoff.success < finish.success]
    beside = f", {others[0].policy} {number(others[0].total)}" if others else ""
    return f"Finishing pays most: finish earns {number(finish.total)} per episode{beside}."


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
