"""What was found of rewards on a data set: plain data, the words for it, and how a terminal shows it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

from rich.console import Group, RenderableType
from rich.text import Text

from harness import Float
from harness.eta import AGAINST, CANNOT_TELL, RANKS, Estimate
from harness.eta.auc import Auc
from harness.files.plain import Plain, tells
from harness.record.dataset.open_dataset import DatasetFacts
from harness.text import number

from ..recorded.pair import Mean, Pair
from ..recorded.pair_grid import (
    MISSING,
    add_answer,
    answer_grid,
    as_text,
    distance_text,
    pair_grid,
    pair_lines,
    share_text,
)

if TYPE_CHECKING:
    from harness.cli.fail_on import Said

Lines: TypeAlias = tuple[str, ...]
"""Sentences, or names, a line each."""
SCALE = "1: every success is paid more than every failure; 0.5: no better than a coin; 0: every failure is paid more"
PROMISE = (
    "Brackets hold 95% intervals. A word asks for more than that: for each reward by itself it is wrong in "
    "less than 5 of 100 data sets (docs/statistics-tables.md)"
)

TASKS_SHOWN = 10
DISTANCES = (
    "Distances of two rewards: 0 is the same but for scale and offset, 0.71 unrelated, 1 opposite. They are means over "
    "parts of the data set, with 95% intervals over these"
)


@tells("success", "failure", "paid")
@dataclass(frozen=True)
class WrongPair:
    """A failure that is paid more than a success.

    Attributes:
        success: Number of the episode in its data set.
        failure: Likewise.
        paid: The success and the failure.
        curves: What each of the two had been paid after each step; they are drawn, and no part of JSON.
    """

    success: int
    failure: int
    paid: tuple[float, float]
    curves: tuple[Float, Float] = field(repr=False, compare=False)


@dataclass(frozen=True)
class PaidStep:
    """A step that is paid much.

    Attributes:
        episode: Number in the data set.
        step: Counted from 0.
        paid: What it is paid.
    """

    episode: int
    step: int
    paid: float


@tells(
    "reward=name",
    "success=by_success",
    "level=by_level",
    "wrong_pairs=wrong",
    "most_wrong=pairs",
    "paid_most=most",
    "unpaid",
    "paid_standing_still=still",
)
@dataclass(frozen=True)
class RewardAnswer(Plain):
    """What was found of one reward.

    Attributes:
        name: Of the reward.
        by_success: How it ranks successes over failures.
        by_level: How it ranks the data set over that of a beginner; None if none was given.
        wrong: How many pairs of a success and a failure it ranks wrongly.
        pairs: Those that it ranks most wrongly, each episode in one of them at most.
        still: The share of what it pays, where that is above 0, that it pays while nothing happens.
        most: The steps that it pays most, one of an episode at most.
        unpaid: What it could not be paid, a line each.
    """

    name: str
    by_success: Auc
    by_level: Auc | None
    wrong: int
    pairs: tuple[WrongPair, ...]
    still: Mean
    most: tuple[PaidStep, ...]
    unpaid: Lines


@tells(
    "dataset=facts.name",
    "format=facts.format",
    "env=facts.env",
    "episodes",
    "steps",
    "successes",
    "failures",
    "success_told_by=success",
    "tasks",
    "rewards",
    "pairs",
    "failed",
    "notes",
    "beginner",
    "intervals_over",
    "steps_standing_still=still",
)
@dataclass(frozen=True)
class DatasetAudit(Plain):
    """What was found of the rewards on a data set.

    Attributes:
        facts: Of the data set.
        beginner: Name of the data set that it should be paid more than; None if none was given.
        episodes: How many.
        steps: How many.
        successes: Episodes that succeeded.
        failures: Episodes that did not; of the others nothing says it.
        clusters: Over which intervals are, ``episodes``, ``operators`` or ``files``, and how many.
        still: Share of steps in which nothing happens.
        rewards: One of each.
        pairs: Every two rewards.
        failed: By reward that could not pay: why.
        notes: What was left out, and what to keep in mind, a line each.
        tasks: Names of the tasks; episodes of one are compared.
        success: What says which episodes succeeded; empty if nothing does.
    """

    facts: DatasetFacts
    beginner: str | None
    episodes: int
    steps: int
    successes: int
    failures: int
    clusters: tuple[str, int]
    still: Mean
    rewards: tuple[RewardAnswer, ...]
    pairs: tuple[Pair, ...]
    failed: Mapping[str, str]
    notes: Lines
    tasks: Lines
    success: str

    @property
    def intervals_over(self) -> dict[str, Any]:
        """What they are over, and how many of these, by names."""
        return dict(zip(("what", "count"), self.clusters, strict=True))

    def __str__(self) -> str:
        return as_text(self)

    def __rich__(self) -> RenderableType:
        """What ``harness audit DATASET`` prints."""
        return answer_table(self)

    @property
    def wrong(self) -> list[str]:
        """What went wrong, a line each."""
        return [f"reward {name}: n/a ({why})" for name, why in self.failed.items()]

    @property
    def said(self) -> "tuple[Said, ...]":
        """The answers that ``--fail-on`` may name."""
        from harness.cli.fail_on import Said

        levels = [(f"{it.name} beside the beginner's", it.by_level) for it in self.rewards]
        found = [*((it.name, it.by_success) for it in self.rewards), *levels]
        return tuple(Said("ranking", of, auc.answer) for of, auc in found if auc is not None)


def title_of(audit: DatasetAudit) -> str:
    """What was audited."""
    names = ", ".join(reward.name for reward in audit.rewards)
    return f"{audit.facts.name}: {names or 'no reward that pays it'}"


def setting_of(audit: DatasetAudit) -> str:
    """How much of it, and what intervals are over."""
    untold = audit.episodes - audit.successes - audit.failures
    told = f"{audit.successes:,} successes, {audit.failures:,} failures"
    told += f", {untold:,} of which nothing says it" if untold else ""
    told += f", told by {audit.success}" if audit.success else ""
    if len(audit.tasks) > 1:
        shown = ", ".join(name or "none" for name in audit.tasks[:TASKS_SHOWN])
        more = ", ..." if len(audit.tasks) > TASKS_SHOWN else ""
        told += f"; {len(audit.tasks):,} tasks ({shown}{more}), and only episodes of one are compared"
    noun, count = audit.clusters
    over = "each episode counts by itself" if noun == "episodes" else f"intervals over {count:,} {noun}"
    return f"{audit.facts.format}; {audit.episodes:,} episodes, {audit.steps:,} steps; {told}; {over}"


def verdict_of(auc: Auc, what: str = "a success", than: str = "a failure") -> str:
    """One sentence with the answer."""
    if auc.value is None:
        return f"{CANNOT_TELL}: {auc.reason}"
    chance = f"{what} is paid more than {than} with a chance of {auc_text(auc)}"
    if auc.answer in (RANKS, AGAINST):
        return f"{auc.answer}: {chance}"
    return f"{CANNOT_TELL}: {chance}; {auc.reason or 'the interval holds 0.5, or nearly does'}"


def auc_text(auc: Auc) -> str:
    """The chance with its interval."""
    return distance_text(Estimate(auc.value, auc.low, auc.high))


def still_text(reward: RewardAnswer, audit: DatasetAudit) -> str:
    """What it pays while nothing happens."""
    if audit.still.value is None:
        return f"{MISSING} (observations hold no numbers)"
    if reward.still.value is None:
        return f"{MISSING} (it pays nothing above 0)"
    return f"{share_text(reward.still)} of its pay above 0; these are {share_text(audit.still)} of all steps"


def pairs_text(reward: RewardAnswer) -> str:
    """How many pairs it ranks wrongly, and the worst."""
    total = reward.by_success.pairs
    if not total:
        return f"{MISSING} (no episodes of both kinds)"
    worst = "; ".join(
        f"failure {pair.failure} ({number(pair.paid[1])}) above success {pair.success} ({number(pair.paid[0])})"
        for pair in reward.pairs
    )
    return f"{reward.wrong:,} of {total:,} pairs{worst and f'. Worst: {worst}'}"


def most_text(reward: RewardAnswer) -> str:
    """The steps that it pays most."""
    return "; ".join(f"episode {step.episode}, step {step.step}: {number(step.paid)}" for step in reward.most)


def notes_of(audit: DatasetAudit) -> list[str]:
    """What the metadata tells of the env or robot, what to keep in mind, and what failed."""
    env = audit.facts.env
    return [
        *([f"The metadata tells of: {env[:500]} (shown, never run)"] if env else []),
        *(f"{line}." for line in audit.notes),
        *(f"Reward {name}: n/a ({why})." for name, why in audit.failed.items()),
    ]


def answer_table(audit: DatasetAudit) -> RenderableType:
    """What ``harness audit DATASET`` prints."""
    parts: list[RenderableType] = [Text(title_of(audit), style="bold"), Text(setting_of(audit))]
    parts += map(Text, notes_of(audit))
    for reward in audit.rewards:
        parts += [Text(), Text(reward.name, style="bold"), *_of_reward(reward, audit)]
    if audit.rewards:
        parts += [Text(), Text(f"{SCALE}. {PROMISE}.")]
    for pair in audit.pairs:
        parts += [Text(), Text(f"{pair.one} and {pair.other}", style="bold"), pair_grid(pair)]
        parts += map(Text, pair_lines(pair))
    if audit.pairs:
        parts += [Text(), Text(f"{DISTANCES}.")]
    return Group(*parts)


def _of_reward(reward: RewardAnswer, audit: DatasetAudit) -> list[RenderableType]:
    lines: list[RenderableType] = [Text(verdict_of(reward.by_success))]
    if reward.by_level is not None and audit.beginner is not None:
        than = f"one of {audit.beginner}"
        lines.append(Text(verdict_of(reward.by_level, f"an episode of {audit.facts.name}", than)))
    grid = answer_grid()
    for question, answer in answers_of(reward, audit):
        add_answer(grid, question, "", answer)
    return [*lines, grid]


def answers_of(reward: RewardAnswer, audit: DatasetAudit) -> list[tuple[str, str]]:
    """What is told of a reward beside whether it ranks as success does: what is asked, and the answer."""
    return [
        *(("not paid", line) for line in reward.unpaid),
        ("ranked wrongly", pairs_text(reward)),
        ("standing still", still_text(reward, audit)),
        ("paid most", most_text(reward)),
    ]
