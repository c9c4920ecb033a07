"""The answer to a search: whether a reward pays for failing, or for loitering, by three numbers of each start.

Of one start, F is the pay of the best-paid failure, S that of the best-paid success, and Q that of the fastest success.
F > S is not all there is: "loop, then finish in the last step" is the best-paid success of a loophole, so S stands for
doing the task only where it is not far slower than Q, and paid for it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from harness.errors import sentence
from harness.text import number

from .behaviour import Behaviour, Role, Searched, Three
from .finding import CANNOT_TELL, FAILING, LOITERING, NAMES, NOTHING
from .held_out import share_interval
from .table import TABLE
from .world import Shown, World, since

MARGIN = 0.05
"""An alarm needs so much more pay, as a share of what the best behaviour earns above random actions."""
COSTLY = 5.0
"""Random actions may cost so much that the margin is more than so many times `MARGIN` of the pay itself. Where failing
is then paid more, by less than the margin, a search cannot tell. A table takes the smaller one of the two."""
SLACK = 1e-6
"""Numbers that differ by no more than this share of the largest are equal."""
LATER, SPARE = 1.5, 0.25
"""A success loiters that takes so many times as long as the fastest, and so large a part of the time that is left."""
REACH = 3.0
"""A learner that discounts by gamma counts almost nothing after so many times 1 / (1 - gamma) steps: exp(-3) is 5 %."""
WORSE = 0.75
"""A failure is clearly worse that is in success for less than this share of the steps that a success is."""
NEAR, SLIGHT = 0.05, 3.0
"""A near miss: all measures within this share of a success's, and no more margins above its pay."""
FEW = 8
"""So many different successes of a start are too few to know what success can earn."""
LATEST, LATE = 0.9, (0.8, 0.95)
"""A success that comes and goes, and came last after the first share of an episode, does not tell what holding it pays.
Nor does one that comes within the other two, whether it lasts or not, where failing is paid as much; what comes later
still, such as having survived, could not come sooner."""


Walks: TypeAlias = Callable[[Behaviour], Sequence[Shown]]
"""The episodes of a behaviour that succeeded: one where nothing is left to chance, else some of them."""


@dataclass(frozen=True, eq=False)
class Case:
    """One start by one sum of pay.

    Attributes:
        three: Its behaviours.
        word: What it says by itself, one of the four answers.
        tempting: What would be an alarm.
        against: What it is compared with: the success that does the task.
        lead: By how many margins the tempting one is paid more.
        margin: In units of pay.
        discount: The factor per step of the sum that this is by; 1 of the plain sum.
        is_close: Whether failing is paid more, by less than the margin, and random actions are `COSTLY`.
        is_late: Whether even the fastest success tells little of what doing the task pays: it comes and goes, and came
            again near the end, or it begins late where failing is paid as much.
    """

    three: Three
    word: str
    tempting: Role
    against: Role
    lead: float
    margin: float
    discount: float
    is_late: bool = False
    is_close: bool = False

    @property
    def is_alarm(self) -> bool:
        """Whether failing or loitering pays here."""
        return self.word in (FAILING, LOITERING)


@dataclass(frozen=True, eq=False)
class Judged:
    """The answer.

    Attributes:
        word: One of the four.
        lines: In sentences; the first one says the three numbers.
        alarmed: The cases of the starts where an alarm holds.
        shown: The case that tells most.
    """

    word: str
    lines: tuple[str, ...]
    alarmed: tuple[Case, ...]
    shown: Case


def judge(searched: Searched, facts: World, walks: Walks) -> Judged:
    """What a search says of a reward.

    Args:
        searched: What was found.
        facts: Of the world; it is played by nothing here.
        walks: Asked of few behaviours, where one may loiter.
    """
    is_exact = TABLE in searched.how
    case_of = partial(_case_of, facts=facts, walks=walks, is_exact=is_exact)
    plain = list(map(partial(case_of, discount=1.0), searched.plain, searched.typical))
    discounted = list(map(partial(case_of, discount=facts.gamma), searched.discounted, searched.typical_discounted))
    if not is_exact:
        climbing = [of / case.margin for of, case in zip(searched.climbing, plain, strict=True)]
        plain, discounted = (list(map(_trusted, of, searched.successes, climbing)) for of in (plain, discounted))
    decided = list(map(_decided, plain, discounted))
    alarmed = tuple(case for case in decided if case.is_alarm)
    words = [case.word for case in decided]
    failing, loitering, unsure = map(words.count, (FAILING, LOITERING, CANNOT_TELL))
    if 2 * len(alarmed) >= len(words):
        word = FAILING if failing >= loitering else LOITERING
    else:
        word = CANNOT_TELL if 2 * (len(alarmed) + unsure) >= len(words) else NOTHING
    told = [case for case in decided if word in (CANNOT_TELL, case.word)]
    shown = max(told, key=lambda case: ("failure" in case.three or case.is_alarm, case.lead))
    if not facts.success:
        return Judged(CANNOT_TELL, _on_paid_most(shown), (), shown)
    lines = _lines(word, shown, list(zip(plain, discounted, decided, strict=True)), searched, facts)
    return Judged(word, tuple(map(sentence, lines)), alarmed, shown)


def paid_by(behaviour: Behaviour, discount: float) -> float:
    """The sum of what it was paid, plain for a discount of 1."""
    return behaviour.paid if discount == 1.0 else behaviour.discounted


def _case_of(three: Three, typical: float, *, discount: float, facts: World, walks: Walks, is_exact: bool) -> Case:
    """One start by one sum.

    Args:
        three: Its behaviours.
        typical: What random actions earn there.
        discount: Of the sum.
        facts: Of the world; it is played by nothing here.
        walks: See `judge`.
        is_exact: Whether nothing pays more than these.
    """
    paid = {role: paid_by(of, discount) for role, of in three.items()}
    known = [paid[role] for role in paid if role != "fastest"]
    best = max(known)
    tiny = max(SLACK * max(map(abs, (*known, typical))), np.finfo(float).tiny)
    margin, near = max(MARGIN * (best - typical), tiny), max(MARGIN * max(map(abs, known)), tiny)
    margin = min(margin, near) if is_exact else margin
    if "success" not in three:
        return Case(three, CANNOT_TELL, "failure", "success", -np.inf, margin, discount)
    failure, success, fastest = paid.get("failure", -np.inf), paid["success"], paid["fastest"]
    slow, fast, time, horizon = three["success"], three["fastest"], three["fastest"].time, facts.horizon
    # even the fastest success begins near its end, after others that did not last
    is_passing = time > LATEST * horizon and fast.share * fast.steps > fast.steps - time + 1.5
    # or it begins late, in an episode that goes on until the horizon
    comes_late = fast.steps == horizon and LATE[0] * horizon < time < LATE[1] * horizon
    is_late = is_passing or (failure >= success - margin and comes_late)
    # by a discount little counts after `REACH` times its own horizon
    left = horizon - time if discount == 1.0 else min(horizon - time, REACH / (1.0 - discount))
    is_later = slow.time >= LATER * time and slow.time - time >= SPARE * left
    is_slow = success > fastest + margin and is_later
    loiters = is_slow and _gained(walks(slow), walks(fast), discount) > margin
    said = partial(Case, three, margin=margin, discount=discount, is_late=is_late)
    if "failure" in three:
        against: Role = "fastest" if loiters else "success"
        reference, compared = paid[against], fast if loiters else slow
        lead = (failure - reference) / margin
        if lead > 1.0 and _is_worse(three["failure"], compared, lead, facts.directions):
            return said(FAILING, "failure", against, lead)
        if margin > COSTLY * near and failure > reference + near and three["failure"].share < WORSE * compared.share:
            return said(CANNOT_TELL, "failure", against, lead, is_close=True)
        if not loiters:
            return said(NOTHING, "failure", against, min(lead, 1.0))
    return said(LOITERING if loiters else NOTHING, "success", "fastest", (success - fastest) / margin)


def _gained(slow: Sequence[Shown], fast: Sequence[Shown], discount: float) -> float:
    """What a slow success earned by being slow; costs that it saved are none, for slow because effort costs is honest.

    Where success ends an episode, it is what each term paid above 0 before that, less the same of the fast one. Where
    both go on, a number more in every step changes nothing, so it is what the slow one earned above the fast one while
    that was a success already.
    """
    if not (slow and fast):
        return 0.0
    slow_paid, fast_paid = (
        [
            ({name: of * discount ** np.arange(len(of)) for name, of in it.terms.items()}, since(it.success))
            for it in walks
        ]
        for walks in (slow, fast)
    )
    totals = [[np.sum([*terms.values()], axis=0) for terms, _ in of] for of in (slow_paid, fast_paid)]
    if len({np.shape(values) for of in totals for values in of}) == 1:
        until, begun = (int(np.mean([time for _, time in of])) for of in (slow_paid, fast_paid))
        later, early = (np.mean([values[begun : until - 1].sum() for values in of]) for of in totals)
        return float(later - early)
    gained = 0.0
    for name in slow_paid[0][0]:
        before = np.mean([terms[name][: time - 1].sum() for terms, time in slow_paid])
        arriving = np.mean([terms[name][time - 1] for terms, time in slow_paid])  # success pays the fast one this too
        early = np.mean([terms[name][:time].sum() for terms, time in fast_paid]) - arriving
        gained += float(max(before, 0.0) - max(early, 0.0))
    return gained


def _is_worse(failure: Behaviour, success: Behaviour, lead: float, directions: Mapping[str, int]) -> bool:
    """Whether a failure behaves clearly worse than a success, whatever both were paid."""
    if failure.share >= WORSE * success.share:
        return False
    if failure.steps != success.steps or lead > SLIGHT:
        return True
    pairs = [
        of
        for name in directions
        if name in failure.measures and not {*(of := (failure.measures[name], success.measures[name]))} <= {0.0, 1.0}
    ]
    return not pairs or any(abs(one - other) > NEAR * max(abs(one), abs(other)) for one, other in pairs)


def _trusted(case: Case, successes: int, climbing: float) -> Case:
    """The case; that it cannot be told where a longer search may take an alarm back, or find what success is.

    Args:
        case: Of one start.
        successes: How many different ones were met there.
        climbing: By how many margins the best-paid of them still rose.
    """
    may_rise = case.against == "success" and climbing > case.lead
    if case.is_late or (case.is_alarm and (successes < FEW or may_rise)):
        return replace(case, word=CANNOT_TELL)
    return case


def _decided(plain: Case, discounted: Case) -> Case:
    """Which of the two sums decides at a start: an alarm by either, but a plain one that the discount takes back.

    It does where, discounted, doing the task is clearly paid more than what tempts without.
    """
    if discounted.is_alarm and not plain.is_alarm:
        return discounted
    task = discounted.three.get("success")
    if not (plain.is_alarm or plain.is_close) or discounted.word != NOTHING or task is None:
        return plain
    tempting = plain.three[plain.tempting]
    other = (plain.tempting == "failure" and discounted.three.get("failure")) or tempting
    takes_back = task.discounted > max(tempting.discounted, other.discounted) + discounted.margin
    return discounted if takes_back else plain


def _lines(
    word: str, shown: Case, starts: Sequence[tuple[Case, Case, Case]], searched: Searched, facts: World
) -> list[str]:
    """The answer in sentences; `starts` are the cases by the plain sum and the discounted one, and what decided."""
    decided = [case for *_, case in starts]
    count, alarmed = len(starts), [both for *both, case in starts if case.is_alarm]
    on = f"on {len(alarmed)} of {count} starts"
    lines, is_counted = [_three_numbers(shown)], TABLE in searched.how
    if rates := searched.rates:
        rated = {"what is paid most": rates["paid"], "what succeeds most": rates.get("success")}
        succeeds = [(name, *share_interval(of.outcomes.success)) for name, of in rated.items() if of]
        told = (f"{name} succeeds in {share:.0%} [{low:.0%}, {high:.0%}]" for name, share, low, high in succeeds)
        lines.append(
            f"Chance decides here: these are means of policies over {len(rates['paid'].starts)} starts of their own; "
            f"{', '.join(told)} of them."
        )
    if word in (FAILING, LOITERING):
        other, gamma = "", f"discounted by {facts.gamma:g}"
        if facts.gamma < 1.0:  # whether the other sum says so too
            other = f"; {gamma} alone, without discount it does not"
            if any(plain.is_alarm for plain, _ in alarmed):
                other = f"; {gamma} the sums are about equal"
            if 2 * sum(plain.is_alarm and later.is_alarm for plain, later in alarmed) >= len(alarmed):
                other = f", {gamma} too"
        lines.append(f"It holds {'on average' if rates else on}{other}.")
    elif word == CANNOT_TELL:
        lines += _on_unsure(decided, shown, facts.success, is_counted=is_counted)
    else:
        lines.append(
            "All states and actions were counted: nothing pays more."
            if is_counted
            else f"That proves nothing: {searched.steps:,} steps were searched."
        )
        paid = {role: paid_by(of, shown.discount) for role, of in shown.three.items()}
        success = paid.get("success", np.nan)
        if (more := paid.get("failure", np.nan) - success) > SLACK * abs(success):
            why = (
                f"less than {number(shown.margin)}, {MARGIN:.0%} of what the best behaviour earns above random actions"
                if more <= shown.margin
                else "it behaves nearly as the success does"
            )
            lines.append(f"The failure's {number(more)} more are no alarm: {why}.")
        if alarmed:
            lines.append(f"{on} it pays for failing or loitering all the same.")
    back = [plain for plain, _, case in starts if plain.is_alarm and case.word == NOTHING]
    for first in back[:1]:
        one, other = (number(first.three[role].paid) for role in (first.tempting, first.against))
        lines.append(
            f"Without discount the {NAMES[first.tempting]} earns {one} and the {NAMES[first.against]} {other}, on "
            f"{len(back)} of {count} starts; a learner that discounts by {facts.gamma:g} is not tempted."
        )
    return lines


EARNS: Mapping[Role, str] = {
    "failure": "failing earns",
    "fastest": "doing the task at once earns",
    "success": "the best-paid success earns",
}


def _three_numbers(case: Case) -> str:
    """What the three behaviours earn, the two first that decided; successes with when they are reached."""
    rate = "" if case.discount == 1.0 else f"Discounted by {case.discount:g}, "
    order: tuple[Role, ...] = (case.tempting, case.against, *EARNS)
    told = list[str]()
    for role in dict.fromkeys(order):
        if of := case.three.get(role):
            name = EARNS[role].removesuffix(" earns" * bool(told))
            steps = f" ({of.time} step{'s' * (of.time != 1)})" if of.success else ""
            told.append(f"{name} {number(paid_by(of, case.discount))}{steps}")
    told += [] if "success" in case.three else ["no success was found"]
    return f"{rate}{', '.join(told)}."


def _on_unsure(decided: Sequence[Case], shown: Case, success: str, is_counted: bool) -> list[str]:
    """What a search that cannot tell knows all the same, why it cannot, and what would help."""
    count, missing = len(decided), sum("success" not in case.three for case in decided)
    if is_counted:
        return [
            f"All states and actions were counted: none is a success on {missing} of {count} starts.",
            f"Is '{success}' what tells success (--success)?",
        ]
    more = [case for case in decided if case.tempting == "failure" and case.lead > 1.0]
    pair = [number(paid_by(of, shown.discount)) for role, of in shown.three.items() if role != "success"]
    known = count - missing
    where = (
        "On the one start where a success is known"
        if known == 1
        else f"Of the {known} starts where a success is known, on {len(more)}"
    )
    certain = f"{where} a failure earns more than the fastest one: {' against '.join(pair)}."
    late = [case.three["fastest"].time for case in decided if case.is_late]
    close = sum(case.is_close and not case.is_late for case in decided)
    unsure = sum(case.word == CANNOT_TELL for case in decided)
    late_from = f"the first success that lasts begins at step {min(late, default=0)}, too late to tell what it pays,"
    told = {
        "no success was found": missing,
        late_from: len(late),
        "a failure is paid more, by little beside what random actions lose,": close,
        "successes were too few, or still rose in pay,": unsure - missing - len(late) - close,
    }
    return [
        *([certain] if shown in more and count > 1 else ()),
        "; ".join(f"{reason} on {of} of {count} starts" for reason, of in told.items() if of) + ".",
        "Show it the task by a policy (--policy FILE.py:NAME) or by trainings (--from FOLDER), or raise the --budget.",
    ]


def _on_paid_most(case: Case) -> tuple[str, ...]:
    """What is said where nothing measures success."""
    (most,) = case.three.values()
    measures = ", ".join(f"{name} {number(value)} at the end" for name, value in most.measures.items())
    given = (
        f", with one of {', '.join(most.measures)}"
        if most.measures
        else " (a key of info, or a measure: a function of --measure FILE.py, or of --plugin behaviour.py)"
    )
    return (
        f"Nothing measures success. What is paid most earns {number(most.paid)} in {most.steps} steps"
        f"{measures and f': {measures}'}. Does that look right?",
        f"Name a measure, and from where on it is a success: --success 'NAME>0.9'{given}.",
    )
