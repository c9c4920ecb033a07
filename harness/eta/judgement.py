"""The answer about the robot in whole sentences: what was seen first, then the word, then what would tell.

A word of better or worse stands here only where a test says so whose error rate is known; see ``docs/statistics.md``.
"""

import math
import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from harness.eta.amounts import (
    LUCK,
    capitalised,
    listed,
    relative_text,
    same_text,
    seen_text,
    short_values,
    trainings_text,
    unseen_text,
)
from harness.eta.behaviour_change import Change
from harness.eta.headline import (
    LEARNED,
    TIME,
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
    reaches_of,
    share_undone,
    size_text,
)
from harness.eta.interval import ONE_SIDED
from harness.eta.manner import WHOLE
from harness.eta.power import FEWEST, Range, range_text, seeds_to_tell
from harness.eta.splits import Names
from harness.eta.swaps import p_text
from harness.eta.verdict.looks import luck_in
from harness.eta.verdict.ruling import Ruling

TRAIN_LONGER = "Train longer, or with another algorithm."
PLANNABLE = 10
"""A number of trainings that is known only to a larger factor is no plan."""
LOST = (
    "Those without a value count as what speaks most against a word, the worst or the best there is: find out first "
    "why they have none."
)
NO_TEST = "No test is made without them."
UNSEEN_SUCCESS = "also where trainings succeed that were not seen"
NOT_TOLD, OTHER_WAY = "not told apart: ", "the other way: "
"""What stands before the number of a measure that the answer is not about, or that goes against it."""
DECIDED = (Answer.HELPS, Answer.HURTS, Answer.LEARNS_FASTER, Answer.LEARNS_SLOWER, Answer.MIXED)
"""Answers that a bound gave: new trainings would differ too."""
TOLD = (*DECIDED, Answer.AHEAD, Answer.BEHIND)
"""Answers that rest on a measure."""
OPEN = (Answer.AHEAD, Answer.BEHIND, Answer.CANNOT_TELL)
"""Answers that more trainings may change."""


@dataclass(frozen=True, eq=False)
class Verdict:
    """What the measures that decide say of a reward, and the sentences of it.

    Attributes:
        names: The names of the rewards.
        deciding: Measures of behaviour, of one training of each reward at least. Without any there is a headline alone.
        ruling: What the test says of them; its measures are these, in their order.
        where: Where this is so, in words, such as ``over 8 places``; empty for a single place.
        same_steps: Whether the policies of both rewards take the same steps, bit for bit: then no test is needed.
        is_opposed: Whether it goes the other way in some of several places, by more than chance.
    """

    names: Names
    deciding: Sequence[Change]
    ruling: Ruling
    where: str = ""
    same_steps: bool = False
    is_opposed: bool = False

    def headline(self, number: str, unmeasured: str = UNMEASURED) -> Headline:
        """Both answers.

        Args:
            number: The sentence about the number.
            unmeasured: The sentence for the case that there is no measure.
        """
        if not self.deciding:
            return Headline(Answer.INTERIM if self.ruling.missing else Answer.CANNOT_TELL, unmeasured, number)
        by = key_of(self.deciding[self.decider]) if self.answer in TOLD else None
        sentences = " ".join(filter(None, self._sentences()))
        return Headline(self.answer, sentences, number, by, self.needed if self.answer in OPEN else None)

    @cached_property
    def answer(self) -> Answer:
        """The word for what the test says of at least one measure."""
        ruling = self.ruling
        if ruling.missing:
            return Answer.INTERIM
        # A policy that fails at the task is no better robot, so a difference between two such stands beside this word.
        if self._certainly_fail or ((ruling.is_decided or ruling.is_ahead) and self.hardly_learned):
            return Answer.NEITHER_LEARNS
        if ruling.is_decided:
            return self._plain_word()
        # A plan of looks has a test of its own for small differences, which may be asked again and again.
        is_small = ruling.small is not None or (
            not ruling.has_plan and all(is_within(it, margin_of(it)) for it in self.deciding)
        )
        if is_small or (self.same_steps and not ruling.is_ahead):
            return Answer.NO_DIFFERENCE
        if not ruling.is_ahead or ruling.is_contrary:
            return Answer.CANNOT_TELL
        return Answer.AHEAD if ruling.sign > 0 else Answer.BEHIND

    def _plain_word(self) -> Answer:
        if self.is_opposed or self.ruling.is_contrary:
            return Answer.MIXED
        # The end was asked about where it was measured, or where a training is judged over all its steps as nobody
        # knows it. An experiment may measure success while training alone: then that is its answer.
        is_better, measures = self.ruling.sign > 0, [it.measure for it in self.deciding]
        asks_end = any(not it.is_while_training or it.manner == WHOLE for it in measures)
        if asks_end and all(measures[at].is_while_training for at in self.passing):
            return Answer.LEARNS_FASTER if is_better else Answer.LEARNS_SLOWER
        return Answer.HELPS if is_better else Answer.HURTS

    @property
    def is_same(self) -> bool:
        """Whether there is no difference because the steps are the same, and not because a test says so."""
        return self.same_steps and replace(self, same_steps=False).answer is Answer.CANNOT_TELL

    @property
    def hardly_learned(self) -> bool:
        """See `harness.eta.headline.is_hardly_learned`."""
        return is_hardly_learned(self.deciding[0])

    @property
    def _certainly_fail(self) -> bool:
        most = self.deciding[0].most
        return self.hardly_learned and most is not None and max(most) < LEARNED

    @cached_property
    def passing(self) -> list[int]:
        """Which measures say the word."""
        return [at for at in range(len(self.deciding)) if self.ruling.passes(at)]

    def of_side(self, sign: int) -> list[Change]:
        """Those of them that are better, or worse."""
        return [self.deciding[at] for at in self.passing if self.ruling.signs[at] == sign]

    @cached_property
    def decider(self) -> int:
        """Which measure an answer of `TOLD` rests on: the first that it is about, or the one with the smallest p."""
        passing = self.passing
        if self.answer in (Answer.HELPS, Answer.HURTS):
            passing = [at for at in passing if not self.deciding[at].measure.is_while_training] or passing
        return passing[0] if self.ruling.is_decided else min(passing, key=self.ruling.of_measures.__getitem__)

    @property
    def asides(self) -> list[str]:
        """What stands before the number of each measure whose answer is another one than that of `decider`."""
        if self.answer not in TOLD:
            return [""] * len(self.deciding)
        signs, own = self.ruling.signs, self.ruling.signs[self.decider]
        return [
            NOT_TOLD if at not in self.passing else "" if signs[at] == own else OTHER_WAY
            for at in range(len(self.deciding))
        ]

    @property
    def is_little(self) -> bool:
        """Whether the differences of all measures that pass are smaller than their margins."""
        passing = (self.deciding[at] for at in self.passing)
        return all(abs(difference_of(it)) < margin_of(it) for it in passing)

    # Parts of sentences

    @property
    def there(self) -> str:
        """Where it is so, behind a word."""
        return f" {self.where}" if self.where else ""

    @property
    def progress(self) -> str:
        """How many trainings there are, and how many are missing."""
        return f"{sum(self.deciding[0].counts):,} trainings are compared, {self.ruling.missing}."

    @property
    def below(self) -> str:
        """How low success is under both rewards, and of which trainings this is known."""
        of = f", {UNSEEN_SUCCESS}" if self._certainly_fail else " in these trainings"
        return f"below {LEARNED:.0%} with either reward{of}"

    @property
    def why(self) -> list[str]:
        """Why an answer of `OPEN` is no more than that, a sentence each, where that needs saying."""
        return self._why_open() if self.answer is Answer.CANNOT_TELL else self._undone()

    @property
    def sure(self) -> str:
        """What a plain word rests on."""
        sure = f"{100 * self.ruling.confidence:.3g}%"
        return f"One training more of either reward, however it ends, would not undo that ({sure})."

    @property
    def reserve(self) -> str:
        """What an answer of no difference cannot rule out; empty where no test gave it."""
        is_tested = self.answer is Answer.NO_DIFFERENCE and not self.is_same
        return unseen_text(self.names, self.deciding) if is_tested else ""

    @property
    def _looks_alike(self) -> bool:
        """Whether what was seen of every measure counts as none; then all of them have to be told, else one."""
        return not self.ruling.is_ahead and all(abs(difference_of(it)) < margin_of(it) for it in self.deciding)

    @cached_property
    def needed(self) -> Range | None:
        """How many trainings of each reward would give a plain word, or show that nothing differs.

        If what was seen so far is true. None where no number is known, and where more of the same trainings are no
        help: where no end of a measure is known, in a single place while the answer over all places is open, where
        hardly any training learned, and where some left no value.
        """
        ruling, deciding = self.ruling, self.deciding
        if ruling.is_held or self.hardly_learned or any(deciding[0].without):
            return None
        if self._looks_alike:
            found = [_seeds_for(it, margin_of(it), ONE_SIDED, max(reaches_of(it))) for it in deciding]
            known = [max(filter(None, found))] if all(found) else []
        else:
            found = [_seeds_for(it, abs(difference_of(it)), ruling.confidence, max(reaches_of(it))) for it in deciding]
            known = list(filter(None, found))
        more = deciding[0].seeds + 1
        return (max(min(known)[0], more), max(min(known)[1], more)) if known else None

    def needed_text(self, noun: str = "trainings of each reward") -> str:
        """The same in a sentence; empty where it is not known, or where more trainings of this kind are no help."""
        if self.needed is None:
            return ""
        if self.needed[1] > PLANNABLE * self.needed[0]:
            return "So few trainings do not tell how many would be enough."
        # Of one of several places labels are not dealt: more places would not tell of this one.
        spread = ", in one place or spread over several," * (self.ruling.corrected is not None)
        there = " in each place" if self.where else spread
        seen = ("nothing differs", "show it") if self._looks_alike else ("what was seen is true", "tell")
        return f"If {seen[0]}, {range_text(self.needed)} {noun}{there} would {seen[1]}."

    def _sentences(self) -> list[str]:
        names, deciding, answer = self.names, self.deciding, self.answer
        seen = seen_text(names, deciding, self.where, self.asides)
        if answer in DECIDED:
            return [seen, self._sides() if answer is Answer.MIXED else self._clear(), self.sure]
        if answer in OPEN:
            return [seen, self._open(), *self.why, TRAIN_LONGER if self.hardly_learned else self.needed_text()]
        if answer is Answer.INTERIM:
            return ["Interim:", self.progress, seen, NO_TEST]
        if answer is Answer.NEITHER_LEARNS:
            return [seen, *self._neither_learns(), TRAIN_LONGER]
        if self.is_same:
            told = f"{names.proposed} changes nothing: every step of every evaluation is the same as with"
            return [
                same_text(names, deciding),
                told,
                f"{names.baseline}, bit for bit.",
                TRAIN_LONGER * self.hardly_learned,
            ]
        return [seen, self._small() if self.ruling.small else self._no_difference(), self.reserve]

    def _clear(self) -> str:
        """The plain word where all measures that pass go one way."""
        deciding, at, answer = self.deciding, self.decider, self.answer
        by = f", decided by {name_with_article(deciding[at])}" if len(deciding) > 1 else ""
        little, less = "", ""
        if self.is_little:
            little, less = " by little", f": what was seen is less than {margin_text(deciding[at])}"
        told = f"{self.names.proposed} {answer.value}{little}{self.there}{by}{less}"
        if answer in (Answer.LEARNS_FASTER, Answer.LEARNS_SLOWER):
            ends = [it for it in deciding if not it.measure.is_while_training]
            return f"{told}; {end_text(ends)}."
        has_speed = any(other != at and deciding[other].measure.is_while_training for other in self.passing)
        word = "faster" if self.ruling.sign > 0 else "more slowly"
        return f"{told}{f'; it also learns {word}' * has_speed}."

    def _sides(self) -> str:
        """What is better and what is worse."""
        sides = [
            f"{word} in {listed(told)}"
            for sign, word in ((1, "better"), (-1, "worse"))
            if (told := list(map(name_with_article, self.of_side(sign))))
        ]
        average = f" on average{self.there}" if self.where else ""
        return f"{self.names.proposed} is {' and '.join(sides)}{average}."

    def _neither_learns(self) -> list[str]:
        """The sentences that both fail at the task, and whether a test tells them apart all the same."""
        sure = " (95%)" * self._certainly_fail
        told = f"Neither reward teaches the task{self.there}: success is {self.below}{sure}."
        if not self.ruling.is_decided:
            return [told, "So there is no behaviour to compare."]
        return [told, "The two differ all the same:", self._sides()]

    def _small(self) -> str:
        first, margin = self.deciding[0], size_text(self.deciding[0], self.ruling.small or 0.0)
        alone = f" This is said of {name_of(first)} alone." if len(self.deciding) > 1 else ""
        return (
            f"The {name_of(first)} of {self.names.proposed} differs by less than {margin}{self.there}"
            f"{allowance_text([first])}. The training ended here, as planned: more would not be worth its cost.{alone}"
        )

    def _no_difference(self) -> str:
        return (
            f"{self.names.proposed} makes no difference that counts{self.there}: less than "
            f"{listed(list(map(margin_text, self.deciding)))}{allowance_text(self.deciding)} (each side 95%)."
        )

    def _open(self) -> str:
        """The sentence that nothing is known, or only of these trainings."""
        if self.answer is Answer.CANNOT_TELL:
            of = trainings_text(self.names, self.deciding[0].counts, self.deciding[0].without)
            return f"Whether {self.names.proposed} helps or hurts{self.there} cannot be told from {of}."
        place = "ahead" if self.ruling.sign > 0 else "behind"
        by = f" by {name_with_article(self.deciding[self.decider])}" if len(self.deciding) > 1 else ""
        p = p_text(self.ruling.of_measures[self.decider])
        return f"{self.names.proposed} is {place} in these trainings{self.there}{by} (corrected p {p})."

    def _undone(self) -> list[str]:
        """What would undo a word that is said so far: luck, and trainings that were not seen."""
        change, ruling, lines = self.deciding[self.decider], self.ruling, []
        if ruling.offered:
            named = f"{capitalised(name_with_article(change))} was named after the trainings"
            lines.append(f"{named}, so p and the interval allow for all {ruling.offered + 1} measures there are.")
        if ruling.grown:
            luck = round(100 * luck_in(sorted({*ruling.grown, max(*ruling.grown, change.seeds)})))
            lines.append(
                f"This is look {ruling.looks} at the folder: by luck alone {luck} in 100 get such a word by then."
            )
        share = share_undone(change)
        if share is None:
            return [*lines, _ends_text([change])]
        who, seen = self.names[ruling.sign > 0], change.counts[ruling.sign > 0]
        if share > 1.0 - LUCK ** (1.0 / seen):
            undone = "one training more, at the end that speaks most against it, leaves room for no difference."
        else:
            undone = (
                f"if 1 in {1.0 / share:.0f} with {who} ended as badly as can be, both would be equal, and {seen} "
                "trainings do not rule that out."
            )
        return [*lines, f"Of new trainings that says little yet: {undone}"]

    def _why_open(self) -> list[str]:
        """Why nothing can be told; over several places few trainings are many."""
        first, ruling = self.deciding[0], self.ruling
        if max(first.counts) < FEWEST and not self.where and not ruling.has_plan:
            return [f"Fewer than {FEWEST} of each reward cannot show anything."]
        if ruling.is_held:
            why = "A single place is told only where the answer over all is."
        elif ruling.is_ahead:
            why = "By one measure it is ahead so far, by another it is behind."
        else:
            why = _ends_text(self.deciding)
        looks_alike = all(abs(difference_of(it)) < margin_of(it) for it in self.deciding if is_share(it))
        unseen = unseen_text(self.names, self.deciding) if looks_alike else ""
        return [line for line in (why, LOST * any(first.without), unseen) if line]


def _seeds_for(change: Change, size: float, confidence: float, reach: float) -> Range | None:
    if change.spread is None or not size or not math.isfinite(reach):
        return None
    return seeds_to_tell(size, change.spread, change.seeds, confidence, reach / len(change.parts))


def end_text(ends: Sequence[Change]) -> str:
    """What is said of the end where success while training alone decided."""
    return "whether the end differs too cannot be told" if ends else "what it does at the end is not known"


def _ends_text(changes: Sequence[Change]) -> str:
    """What to type where the ends of a measure are not known, so that its interval gives no plain word; else empty."""
    without = [it for it in changes if not it.measure.has_ends]
    if not without:
        return ""
    flags = " ".join(f"--ends {shlex.quote(it.name)}=LEAST,GREATEST" for it in without)
    return (
        f"How low and how high {listed([name_with_article(it) for it in without])} can go is not known, so one "
        f"training more could undo any difference. {flags} says it."
    )


def allowance_text(deciding: Sequence[Change]) -> str:
    """What an answer of no difference allows for."""
    return ", also where trainings fail that were not seen" if any(map(is_share, deciding)) else ""


INSTEAD = " instead of "


def lead_of(verdict: Verdict, subject: str) -> str:
    """The answer about the robot in a sentence or two.

    Args:
        verdict: What at least one measure says.
        subject: Who behaves: ``robot`` or ``agent``.
    """
    answer, deciding, ruling, there = verdict.answer, verdict.deciding, verdict.ruling, _there(verdict)
    if answer is Answer.INTERIM:
        return f"{verdict.progress} {NO_TEST}"
    if answer is Answer.NEITHER_LEARNS:
        differ = f" The two differ all the same. {_sides(verdict)}" if ruling.is_decided else ""
        return f"Success is {verdict.below}{there}.{differ} {TRAIN_LONGER}"
    if answer is Answer.MIXED:
        return _sides(verdict)
    if answer in TOLD:
        return _told(verdict, subject)
    if answer is Answer.CANNOT_TELL:
        return TRAIN_LONGER if verdict.hardly_learned else f"{_trainings(deciding[0])} not enough to tell{there}."
    return _no_difference(verdict, subject, there)


def _no_difference(verdict: Verdict, subject: str, there: str) -> str:
    deciding, small = verdict.deciding, verdict.ruling.small
    if verdict.is_same:
        return f"The {subject} takes the same steps with either reward, bit for bit{there}."
    if small is not None:
        first = deciding[0]
        size = size_text(first, small)
        return f"{capitalised(name_of(first))} differs by less than {size}{there}{allowance_text([first])}."
    margins = listed([margin_text(it) for it in deciding])
    return f"The rewards differ by less than {margins}{there}{allowance_text(deciding)}."


def _told(verdict: Verdict, subject: str) -> str:
    """What the robot does instead; then what else passed; then what did not, at the end of the trainings."""
    deciding, first, is_decided = verdict.deciding, verdict.decider, verdict.ruling.is_decided
    sign = verdict.ruling.sign * is_decided
    lines = [f"{_does(deciding[first], subject, sign)}{_there(verdict)}."]
    lines += [f"{_does(deciding[at], subject, sign, 'also ')}." for at in verdict.passing if at != first]
    if not is_decided:
        return f"In these trainings: {lines[0][0].lower()}{' '.join(lines)[1:]} New ones may not differ."
    if verdict.is_little:
        lines.append(f"That is little: less than {margin_text(deciding[first])}.")
    others = (it for at, it in enumerate(deciding) if at not in verdict.passing)
    ends = [it for it in others if not it.measure.is_while_training]
    if verdict.answer in (Answer.LEARNS_FASTER, Answer.LEARNS_SLOWER):
        lines.append(f"{end_text(ends).capitalize()}.")
    elif ends:
        verb = "differs" if len(ends) == 1 else "differ"
        lines.append(f"Whether {listed([name_with_article(it) for it in ends])} {verb} too cannot be told.")
    return " ".join(lines)


def _sides(verdict: Verdict) -> str:
    """What is better and what is worse, that of the measure that says most first."""
    sign = verdict.ruling.sign
    return " ".join(
        f"{'Better' if side > 0 else 'Worse'}{_there(verdict)}: {'; '.join(told)}."
        for side in (sign, -sign)
        if (told := [f"{name_of(it)}, {_instead(it)}" for it in verdict.of_side(side)])
    )


def _does(change: Change, subject: str, sign: int, also: str = "") -> str:
    """What the robot does instead of what it does under the baseline; the sign is 0 where only these trainings do."""
    if change.measure.is_while_training and is_share(change) and "success" in change.name:
        told = f"{_instead(change)} of its episodes succeed {change.measure.manner}"
        return f"The {subject} {also}learns {'faster' if sign > 0 else 'more slowly'}: {told}" if sign else told
    if change.is_relative:
        return f"The {name_of(change)} is {also}{_instead(change)}"
    if change.name == TIME:
        return f"The {subject} {also}reaches its target in {_instead(change)}"
    if is_share(change) and "success" in change.name:
        return f"The {subject} {also}succeeds in {_instead(change)} of its episodes"
    return f"{capitalised(name_of(change))} is {also}{_instead(change)}"


def _instead(change: Change) -> str:
    if change.is_relative:
        return relative_text(change)
    baseline, proposed = short_values(change)
    unit = proposed.partition(" ")[2]
    return f"{proposed}{INSTEAD}{baseline} {unit}".rstrip()


def _trainings(change: Change) -> str:
    fewest, most = sorted(change.counts)
    if fewest != most:
        return "These trainings are"
    return f"{most:,} training{'s' * (most != 1)} of each reward {'is' if most == 1 else 'are'}"


def _there(verdict: Verdict) -> str:
    return f", on average {verdict.where}" if verdict.where else ""
