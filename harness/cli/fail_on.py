"""``--fail-on``: the exit status of a command by what it answered. What was decided is said on standard error."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias

from harness.cli.output import say
from harness.errors import UsageError
from harness.eta.auc import AGAINST
from harness.eta.headline import Answer
from harness.experiment.screening import FAILING, LOITERING
from harness.registry.choice import split_list
from harness.registry.spec import unknown_name
from harness.report.rows.comparison import word_of

if TYPE_CHECKING:
    from harness.results import Results

GIVEN, UNTOLD = 1, 3
"""A named answer was given; none was, and one that could have been is not known."""
Question: TypeAlias = Literal["behaviour", "pay", "ranking"]
"""What is answered: how a robot behaves, what a reward pays for, how it ranks recorded episodes."""
CANNOT_TELL = "cannot-tell"
UNSAID = (Answer.CANNOT_TELL, Answer.INTERIM, Answer.AHEAD, Answer.BEHIND)
"""Answers of which none is plain: they count as ``cannot-tell``."""
NAMES: Mapping[Question, Mapping[str, str]] = {
    "behaviour": {it.value.replace(" ", "-"): word_of(it) for it in Answer if it not in UNSAID},
    "pay": {"failing": FAILING, "loitering": LOITERING},
    "ranking": {"against": AGAINST},
}
"""By question, each answer that may be named, and its word. ``cannot-tell`` may be named of all."""
UNASKED: Mapping[Question, str] = {
    "behaviour": "no two rewards were compared",
    "pay": "nobody asked what a reward pays for",
    "ranking": "no recorded episodes were ranked",
}
MOST_TOLD = 3


class Said(NamedTuple):
    """One answer of a command."""

    question: Question
    of: str
    """What it is said of: ``arp in mujoco · sac-fast``."""
    word: str
    """The answer as it is shown: ``HURTS``."""

    @property
    def name(self) -> str:
        """How ``--fail-on`` names it; empty of an answer that nobody fails on, such as RANKS AS SUCCESS DOES."""
        if self.word in map(word_of, UNSAID):
            return CANNOT_TELL
        return next((name for name, word in NAMES[self.question].items() if word == self.word), "")


def named_answers(given: Sequence[str] | None, *questions: Question) -> tuple[str, ...]:
    """The answers that ``--fail-on`` names; none without the flag.

    Args:
        given: What was given for it.
        questions: Those that the command asks.

    Raises:
        UsageError: The command gives no such answer.
    """
    known = [*(name for question in questions for name in NAMES[question]), CANNOT_TELL]
    named = tuple(it.lower().replace(" ", "-") for it in split_list(given)) if given else ()
    for name in named:
        if name not in known:
            raise UsageError(f"--fail-on {name}: {unknown_name('answer', name, known)}")
    return named


def decide(named: Sequence[str], said: Sequence[Said]) -> tuple[int, str]:
    """The exit status, and why.

    Args:
        named: The answers that the user fails on.
        said: What was answered.
    """
    if found := [it for it in said if it.name in named]:
        return GIVEN, _told(found)
    asked = [question for question, names in NAMES.items() if any(name in names for name in named)]
    unasked = [UNASKED[it] for it in asked if all(of.question != it for of in said)]
    if unasked or not said:
        return UNTOLD, ", and ".join(unasked) or "nothing was judged"
    if unknown := [it for it in said if it.question in asked and it.name == CANNOT_TELL]:
        return UNTOLD, _told(unknown)
    return 0, f"none of {len(said)} answers" if len(said) > 1 else _told(said)


def status_of(named: Sequence[str], said: Sequence[Said], failed: int = 0) -> int:
    """The exit status of a command that has told its answers; says on standard error what was decided.

    Args:
        named: See `named_answers`; without any the status is `failed`.
        said: What was answered.
        failed: The status without the flag. Unless it is 0 it stays: what failed could have answered anything.
    """
    if not named:
        return failed
    found, told = decide(named, said)
    why = f"{told}, and something failed" if failed else told
    say(f"--fail-on {','.join(named)}: {why}: status {failed or found}", err=True)
    return failed or found


def said_of(results: "Results") -> list[Said]:
    """What comparisons of trainings say; what is missing for them cannot be told.

    The answer over several places stands for those of them that cannot tell by themselves. Null controls say nothing
    of a reward.
    """
    from harness.results.results import told_manifests

    compared = [it for it in results.combinations if not it.is_control]
    pooled = [(f"{it.names.proposed} {it.where}", it.headline.answer) for it in results.pools]
    placed = [
        (f"{it.names.proposed} against {it.baseline} in {it.group.title}", it.headline.answer)
        for it in compared
        if it.answer.pool is None or it.headline.answer not in UNSAID
    ]
    manifests = told_manifests(results)
    counts = Counter(it.status for it in manifests)
    rewards = dict.fromkeys(it.cell.reward.label for it in manifests) if compared else ()
    alone = [it for it in rewards if all(it not in (of.baseline, of.proposed) for of in compared)]
    missing = [f"{count} {status} cells" for status in ("pending", "failed", "damaged") if (count := counts[status])]
    unsaid = [(of, Answer.CANNOT_TELL) for of in (*(f"{it}, not compared" for it in alone), *missing)]
    return [Said("behaviour", of, word_of(answer)) for of, answer in (*pooled, *placed, *unsaid)]


def _told(said: Sequence[Said]) -> str:
    more = f"; and {len(said) - MOST_TOLD} more" if len(said) > MOST_TOLD else ""
    return "; ".join(f"{it.of}: {it.word}" for it in said[:MOST_TOLD]) + more
