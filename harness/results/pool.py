"""One answer about a reward over all places in which it trained."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import zip_longest
from typing import Any

from harness.eta.behaviour_change import Change
from harness.eta.headline import Answer, Headline
from harness.eta.judgement import Verdict, lead_of
from harness.eta.splits import Names
from harness.eta.verdict.ruling import Ruling
from harness.files.plain import Plain, tells


@tells(
    "baseline=names.baseline",
    "proposed=names.proposed",
    "steps",
    "places",
    "answer=headline.answer.value",
    "behaviour=headline.robot",
    "decided_by=headline.decided_by",
    "better_in",
    "opposed_in",
    "test=ruling",
)
@dataclass(frozen=True, eq=False)
class Pool(Plain):
    """A reward against the baseline over several places: simulators, drives, algorithms or tasks of one budget.

    Attributes:
        names: The two rewards.
        steps: Environment steps of each training.
        places: The places, in words.
        ruling: What the test says of the mean over all of them.
        measures: The measures that decide, means over places; empty where each place measures something else.
        better_in: In how many places at least the robot does better, or worse, as the answer says.
        opposed_in: In how many places at least it goes the other way.
        subject: Who behaves: ``robot`` or ``agent``.
    """

    names: Names
    steps: int
    places: tuple[str, ...]
    ruling: Ruling
    measures: Sequence[Change]
    better_in: int = 0
    opposed_in: int = 0
    subject: str = "robot"

    @cached_property
    def verdict(self) -> Verdict:
        """What the measures say."""
        return Verdict(self.names, self.measures, self.ruling, self.where, is_opposed=self.opposed_in > 0)

    @cached_property
    def headline(self) -> Headline:
        """The answer."""
        if not self.measures:
            return self._without_values()
        found = self.verdict.headline("")
        return replace(found, robot=" ".join(filter(None, (found.robot, self.where_at_least))))

    @cached_property
    def lead(self) -> str:
        """The answer in a sentence or two without a bracket."""
        if not self.measures:
            return self.headline.robot
        told = lead_of(self.verdict, self.subject)
        return " ".join(filter(None, (told, self.where_at_least)))

    @property
    def where(self) -> str:
        """Over how many places."""
        return f"over {len(self.places)} places"

    @property
    def where_at_least(self) -> str:
        """In how many places it goes which way, at least; empty where nothing is decided."""
        if not self.ruling.is_decided:
            return ""
        word, other = ("better", "worse") if self.ruling.sign > 0 else ("worse", "better")
        opposed = f"it is {other} in {f'at least {self.opposed_in}' if self.opposed_in else 'none by more than chance'}"
        count = len(self.places)
        if not self.better_in:
            return f"In which of the {count} places it is {word} is not decided; {opposed}."
        if self.better_in == count:
            whole = f"It is {word} in {'both' if count == 2 else f'all {count}'} places"
            return f"{whole}; by another measure {opposed}." if self.opposed_in else f"{whole}."
        return f"It is {word} in at least {self.better_in} of {count} places; {opposed}."

    def _without_values(self) -> Headline:
        """The answer where no measure is that of all places."""
        ruling = self.ruling
        if ruling.missing:
            told = f"Interim: {ruling.missing} {self.where}."
            return Headline(Answer.INTERIM, told, "")
        if not ruling.is_decided:
            answer = (Answer.AHEAD if ruling.sign > 0 else Answer.BEHIND) if ruling.is_ahead else Answer.CANNOT_TELL
            told = f"{answer.value.capitalize()} {self.where}: each place measures something else."
            return Headline(answer, told, "")
        if self.opposed_in:
            return Headline(Answer.MIXED, self.where_at_least, "")
        answer = Answer.HELPS if ruling.sign > 0 else Answer.HURTS
        return Headline(answer, f"{self.names.proposed} {answer.value} {self.where}. {self.where_at_least}", "")

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        told = ("name", "is_relative", "baseline", "proposed", "low", "high")
        measures = [
            {**{name: getattr(it, name) for name in told}, "manner": it.measure.manner, "p_corrected": p}
            for it, p in zip_longest(self.measures, self.ruling.of_measures[: len(self.measures)])
        ]
        return {**super().to_json(), "measures": measures}
