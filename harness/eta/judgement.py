"""The answer about the robot in whole sentences: what was seen first, then the word, then what would tell.

A word of better or worse stands here only where a test says so whose error rate is known; see ``docs/statistics.md``.
"""

import shlex
from collections.abc import Sequence

from harness.eta.amounts import LUCK, capitalised, listed, same_text, seen_text, trainings_text, unseen_text
from harness.eta.behaviour_change import Change
from harness.eta.headline import (
    LEARNED,
    UNMEASURED,
    Answer,
    Headline,
    difference_of,
    is_hardly_learned,
    is_share,
    is_within,
    key_of,
    margin_of,
    margin_text,
    name_of,
    name_with_article,
    share_undone,
    size_text,
)
from harness.eta.manner import WHOLE
from harness.eta.needed import needed_of, needed_text
from harness.eta.power import FEWEST
from harness.eta.splits import Names
from harness.eta.swaps import p_text
from harness.eta.verdict.looks import luck_in
from harness.eta.verdict.ruling import Ruling

TRAIN_LONGER = "Train longer, or with another algorithm."
LOST = (
    "Those without a value count as what speaks most against a word, the worst or the best there is: find out first "
    "why they have none."
)
NO_TEST = "No test is made without them."
UNSEEN_SUCCESS = "also where trainings succeed that were not seen"
DECIDED = (Answer.HELPS, Answer.HURTS, Answer.LEARNS_FASTER, Answer.LEARNS_SLOWER, Answer.MIXED)
"""Answers that a bound gave: new trainings would differ too."""


def judge(
    names: Names,
    deciding: Sequence[Change],
    number: str,
    ruling: Ruling | None = None,
    unmeasured: str = UNMEASURED,
    where: str = "",
    *,
    same_steps: bool = False,
    is_opposed: bool = False,
) -> Headline:
    """Both answers from the measures that decide.

    Args:
        names: The names of the rewards.
        deciding: Measures of behaviour, of one training of each reward at least.
        number: The sentence about the number.
        ruling: What the test says of them; its measures are these, in their order.
        unmeasured: The sentence for the case that there is no measure.
        where: Where this is so, in words, such as ``over 8 places``; empty for a single place.
        same_steps: Whether the policies of both rewards take the same steps, bit for bit: then no test is needed.
        is_opposed: Whether it goes the other way in some of several places, by more than chance.
    """
    ruling = ruling or Ruling()
    if not deciding:
        return Headline(Answer.CANNOT_TELL, unmeasured, number)
    answer = answer_of(deciding, ruling, same_steps=same_steps, is_opposed=is_opposed)
    seen, there = seen_text(names, deciding, where), f" {where}" if where else ""
    if answer in DECIDED:
        is_mixed = answer is Answer.MIXED
        told = _sides(names, deciding, ruling, there) if is_mixed else _clear(names, deciding, ruling, there, answer)
        lines = [seen, told, sure_text(ruling)]
        by = key_of(deciding[decider_of(deciding, ruling, answer)])
        return Headline(answer, " ".join(filter(None, lines)), number, by)
    if answer in (Answer.AHEAD, Answer.BEHIND, Answer.CANNOT_TELL):
        is_open = answer is Answer.CANNOT_TELL
        lines = [seen, *(_cannot_tell if is_open else _ahead)(names, deciding, ruling, there)]
        rests = None if is_open else key_of(deciding[decider_of(deciding, ruling, answer)])
        return Headline(answer, " ".join(filter(None, lines)), number, rests, needed_of(deciding, ruling))
    if is_same(deciding, ruling, same_steps=same_steps):
        return Headline(answer, _same(names, deciding), number)
    return Headline(answer, _untold(names, deciding, ruling, answer, seen, there), number)


def answer_of(
    deciding: Sequence[Change], ruling: Ruling, *, same_steps: bool = False, is_opposed: bool = False
) -> Answer:
    """The word for what the test says of at least one measure; see `judge`."""
    if ruling.missing:
        return Answer.INTERIM
    # A policy that fails at the task is no better robot, so a difference between two such stands beside this word.
    if _certainly_fail(deciding[0]) or ((ruling.is_decided or ruling.is_ahead) and is_hardly_learned(deciding[0])):
        return Answer.NEITHER_LEARNS
    if ruling.is_decided:
        return _answer_of_decided(deciding, ruling, is_opposed)
    # A plan of looks has a test of its own for small differences, which may be asked again and again.
    is_small = ruling.small is not None or (
        not ruling.has_plan and all(is_within(change, margin_of(change)) for change in deciding)
    )
    if is_small or (same_steps and not ruling.is_ahead):
        return Answer.NO_DIFFERENCE
    if not ruling.is_ahead or ruling.is_contrary:
        return Answer.CANNOT_TELL
    return Answer.AHEAD if ruling.sign > 0 else Answer.BEHIND


def is_same(deciding: Sequence[Change], ruling: Ruling, *, same_steps: bool) -> bool:
    """Whether there is no difference because the steps are the same, and not because a test says so."""
    return same_steps and answer_of(deciding, ruling) is Answer.CANNOT_TELL


def _answer_of_decided(deciding: Sequence[Change], ruling: Ruling, is_opposed: bool) -> Answer:
    if is_opposed or ruling.is_contrary:
        return Answer.MIXED
    is_better = ruling.sign > 0
    passing = [change for at, change in enumerate(deciding) if ruling.passes(at)]
    if asks_end(deciding) and all(change.measure.is_while_training for change in passing):
        return Answer.LEARNS_FASTER if is_better else Answer.LEARNS_SLOWER
    return Answer.HELPS if is_better else Answer.HURTS


def asks_end(deciding: Sequence[Change]) -> bool:
    """Whether the end was asked about: it was measured, or a training is judged over all its steps as nobody knows it.

    An experiment may measure success while training alone: then that is its answer.
    """
    return any(not it.measure.is_while_training or it.measure.manner == WHOLE for it in deciding)


def decider_of(deciding: Sequence[Change], ruling: Ruling, answer: Answer) -> int:
    """Which measure an answer rests on: the first that it is about, or the one with the smallest p."""
    passing = [at for at in range(len(deciding)) if ruling.passes(at)]
    if answer in (Answer.HELPS, Answer.HURTS):
        passing = [at for at in passing if not deciding[at].measure.is_while_training] or passing
    return passing[0] if ruling.is_decided else min(passing, key=ruling.of_measures.__getitem__)


def is_little(deciding: Sequence[Change], ruling: Ruling, answer: Answer) -> bool:
    """Whether the difference of the measure that decided, and of all others that pass, is smaller than its margin."""
    return answer is not Answer.MIXED and all(
        abs(difference_of(change)) < margin_of(change) for at, change in enumerate(deciding) if ruling.passes(at)
    )


def progress_text(deciding: Sequence[Change], ruling: Ruling) -> str:
    """How many trainings there are, and how many are missing."""
    verb = "is" if ruling.missing == 1 else "are"
    return f"{sum(deciding[0].counts):,} trainings are compared, {ruling.missing:,} {verb} missing."


def end_text(ends: Sequence[Change]) -> str:
    """What is said of the end where success while training alone decided."""
    return "whether the end differs too cannot be told" if ends else "what it does at the end is not known"


def reasons(names: Names, deciding: Sequence[Change], ruling: Ruling, where: str) -> list[str]:
    """Why nothing can be told, a sentence each, where that needs saying; over several places few trainings are many."""
    if max(deciding[0].counts) < FEWEST and not where and not ruling.has_plan:
        return [f"Fewer than {FEWEST} of each reward cannot show anything."]
    looks_alike = all(abs(difference_of(it)) < margin_of(it) for it in deciding if is_share(it))
    lost = LOST if any(deciding[0].without) else ""
    lines = [_why_open(deciding, ruling), lost, unseen_text(names, deciding) if looks_alike else ""]
    return [line for line in lines if line]


def _why_open(deciding: Sequence[Change], ruling: Ruling) -> str:
    """Why nothing is told, though a number beside it may seem to; else empty."""
    if ruling.is_held:
        return "A single place is told only where the answer over all is."
    if ruling.is_ahead:
        return "By one measure it is ahead so far, by another it is behind."
    return ends_text(deciding)


def ends_text(changes: Sequence[Change]) -> str:
    """What to type where the ends of a measure are not known, so that its interval gives no plain word; else empty."""
    without = [it for it in changes if not it.measure.has_ends]
    if not without:
        return ""
    flags = " ".join(f"--ends {shlex.quote(it.name)}=LEAST,GREATEST" for it in without)
    return (
        f"How low and how high {listed([name_with_article(it) for it in without])} can go is not known, so one "
        f"training more could undo any difference. {flags} says it."
    )


def reserve_text(names: Names, deciding: Sequence[Change], ruling: Ruling) -> str:
    """What an answer of no difference cannot rule out; empty where no test gave it."""
    return unseen_text(names, deciding) if answer_of(deciding, ruling) is Answer.NO_DIFFERENCE else ""


def allowance_text(deciding: Sequence[Change]) -> str:
    """What an answer of no difference allows for."""
    return ", also where trainings fail that were not seen" if any(map(is_share, deciding)) else ""


def sure_text(ruling: Ruling) -> str:
    """What a plain word rests on."""
    return f"One training more of either reward, however it ends, would not undo that ({100 * ruling.confidence:.3g}%)."


def _clear(names: Names, deciding: Sequence[Change], ruling: Ruling, there: str, answer: Answer) -> str:
    """The plain word where all measures that pass go one way."""
    at = decider_of(deciding, ruling, answer)
    by = f", decided by {name_with_article(deciding[at])}" if len(deciding) > 1 else ""
    little, less = "", ""
    if is_little(deciding, ruling, answer):
        little, less = " by little", f": what was seen is less than {margin_text(deciding[at])}"
    told = f"{names.proposed} {answer.value}{little}{there}{by}{less}"
    if answer in (Answer.LEARNS_FASTER, Answer.LEARNS_SLOWER):
        ends = [it for it in deciding if not it.measure.is_while_training]
        return f"{told}; {end_text(ends)}."
    speed = [
        it for other, it in enumerate(deciding) if other != at and it.measure.is_while_training and ruling.passes(other)
    ]
    word = "faster" if ruling.sign > 0 else "more slowly"
    return f"{told}{f'; it also learns {word}' if speed else ''}."


def _sides(names: Names, deciding: Sequence[Change], ruling: Ruling, there: str) -> str:
    """What is better and what is worse."""
    sides = []
    for sign, word in ((1, "better"), (-1, "worse")):
        of_side = [at for at in range(len(deciding)) if ruling.passes(at) and ruling.signs[at] == sign]
        told = [name_with_article(deciding[at]) for at in of_side]
        sides += [f"{word} in {listed(told)}"] if told else []
    average = f" on average{there}" if there else ""
    return f"{names.proposed} is {' and '.join(sides)}{average}."


def _certainly_fail(change: Change) -> bool:
    return is_hardly_learned(change) and change.most is not None and max(change.most) < LEARNED


def _untold(names: Names, deciding: Sequence[Change], ruling: Ruling, answer: Answer, seen: str, there: str) -> str:
    """The answers that no difference was tested for, or none was found."""
    if answer is Answer.INTERIM:
        return f"Interim: {progress_text(deciding, ruling)} {seen} {NO_TEST}"
    if answer is Answer.NEITHER_LEARNS:
        return f"{seen} {_neither_learns(names, deciding, ruling, there)} {TRAIN_LONGER}"
    told = _small(names, deciding, ruling.small, there) if ruling.small else _no_difference(names, deciding, there)
    return f"{seen} {told} {unseen_text(names, deciding)}".rstrip()


def _neither_learns(names: Names, deciding: Sequence[Change], ruling: Ruling, there: str) -> str:
    """The sentence that both fail at the task, and whether a test tells them apart all the same."""
    sure = " (95%)" * _certainly_fail(deciding[0])
    told = f"Neither reward teaches the task{there}: success is {below_text(deciding[0])}{sure}."
    if not ruling.is_decided:
        return f"{told} So there is no behaviour to compare."
    return f"{told} The two differ all the same: {_sides(names, deciding, ruling, there)}"


def below_text(success: Change) -> str:
    """How low success is under both rewards, and of which trainings this is known."""
    below = f"below {LEARNED:.0%} with either reward"
    return f"{below}, {UNSEEN_SUCCESS}" if _certainly_fail(success) else f"{below} in these trainings"


def _same(names: Names, deciding: Sequence[Change]) -> str:
    """The answer where the steps alone say that there is no difference."""
    told = f"{names.proposed} changes nothing: every step of every evaluation is the same as with {names.baseline}"
    longer = f" {TRAIN_LONGER}" * is_hardly_learned(deciding[0])
    return f"{same_text(names, deciding)} {told}, bit for bit.{longer}"


def _small(names: Names, deciding: Sequence[Change], margin: float, there: str) -> str:
    alone = f" This is said of {name_of(deciding[0])} alone." if len(deciding) > 1 else ""
    return (
        f"The {name_of(deciding[0])} of {names.proposed} differs by less than {size_text(deciding[0], margin)}{there}"
        f"{allowance_text(deciding[:1])}. The training ended here, as planned: more would not be worth its cost.{alone}"
    )


def _no_difference(names: Names, deciding: Sequence[Change], there: str) -> str:
    return (
        f"{names.proposed} makes no difference that counts{there}: less than "
        f"{listed([margin_text(change) for change in deciding])}{allowance_text(deciding)} (each side 95%)."
    )


def _ahead(names: Names, deciding: Sequence[Change], ruling: Ruling, there: str) -> list[str]:
    """The sentences that only these trainings differ, what would undo that, and what would tell."""
    at = decider_of(deciding, ruling, Answer.AHEAD)
    place = "ahead" if ruling.sign > 0 else "behind"
    by = f" by {name_with_article(deciding[at])}" if len(deciding) > 1 else ""
    told = f"{names.proposed} is {place} in these trainings{there}{by} (corrected p {p_text(ruling.of_measures[at])})."
    return [told, *undone_texts(names, deciding, ruling), needed_text(deciding, ruling, there)]


def undone_texts(names: Names, deciding: Sequence[Change], ruling: Ruling) -> list[str]:
    """Why a word that is said so far is no more than that, a sentence each: luck, and trainings that were not seen."""
    change, lines = deciding[decider_of(deciding, ruling, Answer.AHEAD)], []
    if ruling.offered:
        named = f"{capitalised(name_with_article(change))} was named after the trainings"
        lines.append(f"{named}, so p and the interval allow for all {ruling.offered + 1} measures there are.")
    if ruling.grown:
        luck = round(100 * luck_in(sorted({*ruling.grown, max(*ruling.grown, change.seeds)})))
        lines.append(f"This is look {ruling.looks} at the folder: by luck alone {luck} in 100 get such a word by then.")
    share = share_undone(change)
    if share is None:
        return [*lines, ends_text([change])]
    who, seen = names[ruling.sign > 0], change.counts[ruling.sign > 0]
    if share > 1.0 - LUCK ** (1.0 / seen):
        undone = "one training more that ends as badly as it can leaves room for no difference."
    else:
        undone = (
            f"if 1 in {1.0 / share:.0f} with {who} ended as badly as can be, both would be equal, and {seen} trainings "
            "do not rule that out."
        )
    return [*lines, f"Of new trainings that says little yet: {undone}"]


def _cannot_tell(names: Names, deciding: Sequence[Change], ruling: Ruling, there: str) -> list[str]:
    """The sentences that it is not known, why, and what would help."""
    of = trainings_text(names, deciding[0].counts, deciding[0].without)
    return [
        f"Whether {names.proposed} helps or hurts{there} cannot be told from {of}.",
        *reasons(names, deciding, ruling, there),
        TRAIN_LONGER if is_hardly_learned(deciding[0]) else needed_text(deciding, ruling, there),
    ]
