"""The one result of an audit, and its one table: of scripted movements, an environment, recorded trainings, a log."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from harness.eta.auc import Auc
from harness.experiment.screening import FAILING, NOTHING
from harness.files.plain import Plain, tells, to_plain
from harness.payoff.rollout import NOISE, Finishing
from harness.text import number

from .dataset.dataset_audit import Lines, auc_text
from .distance import DARD, EPIC, STARC
from .properties import FACTOR, Property
from .recorded.earned import Earned
from .recorded.pair import Pair
from .recorded.pair_grid import (
    add_answer,
    answer_grid,
    as_text,
    earned_grid,
    pair_grid,
    pair_lines,
    plain_grid,
)
from .search.disturb import NOISES
from .search.finding import NAMES, Finding

if TYPE_CHECKING:
    from harness.cli.fail_on import Said

COLUMN = (
    "Compare down a column: each reward has a scale of its own. Means whose intervals overlap may differ by chance. "
    "The interval of random actions is over episodes, that of trainings over trainings."
)
RANKING = "The chance that an episode with {} is paid more than one without; 0.5: no better than a coin."
EVENTS = "Event terms are the task's, and stay as they are."
KEYS = {EPIC: "distance", DARD: "reachable_distance", STARC: "starc_distance"}
"""What JSON calls the distances of rewards on scripted movements."""


@dataclass(frozen=True)
class OfScripts:
    """What only scripted movements of an arm can answer of a reward.

    Attributes:
        finishing: What it pays for.
        properties: Bounded, scale-free, potential-based.
        workspace: Of each policy, by what its shaped return grows when all distances double.
        compared: How many recorded steps the distances rest on.
        disturbed: What the policies earn while their actions are disturbed; None where that was not tried.
    """

    finishing: Finishing
    properties: tuple[Property, ...]
    workspace: Mapping[str, float | None]
    compared: int
    disturbed: Finishing | None

    def to_json(self, pair: Pair) -> dict[str, Any]:
        """Plain data. What a reward of distances without terms has not is left out."""
        of = self.finishing
        more = {
            "never_paid": list(of.never_paid) if of.payoffs[0].terms else None,
            "disturbed_policies": self.disturbed and to_plain(self.disturbed.payoffs),
        }
        return {
            "gamma": of.gamma,
            "policies": to_plain(of.payoffs),
            "best": of.payoffs[0].policy,
            "not_finishing_pays": to_plain((*of.undiscounted, *of.discounted)),
            "holding_pays": of.holding_pays,
            "properties": {answer.name.replace("-", "_"): to_plain(answer) for answer in self.properties},
            "workspace_twice_as_large": dict(self.workspace),
            **{
                KEYS[form]: {
                    "value": mean.value,
                    "transitions": self.compared,
                    **({"reason": pair.reasons[form]} if form in pair.reasons else {}),
                }
                for form, mean in pair.forms.items()
            },
            "rescaled": pair.rescaling and pair.rescaling.to_json(),
            **{name: value for name, value in more.items() if value is not None},
        }


@tells(
    "*facts",
    "verdict",
    "rewards",
    "pairs",
    "earned",
    "success_told_by=success",
    "ranks_success=rankings",
    "not_asked",
    "notes",
    "damaged",
    "cheats",
)
@dataclass(frozen=True, kw_only=True)
class Audit(Plain):
    """What was found of rewards.

    Attributes:
        title: What was audited.
        facts: Where and how as plain data, the first keys of JSON.
        rewards: Names.
        pairs: Rewards beside one another.
        earned: What each behaviour was like, and what it earned under each reward.
        setting: Where and how, a line each.
        success: The measure that says which episodes succeeded; empty where there is none.
        rankings: By reward, whether it ranks these episodes as success does.
        verdict: The answer in words, a line each.
        scripts: What only scripted movements can answer, of the last of `rewards`; None of other subjects.
        measured: What the numbers and their intervals rest on, a line each.
        not_asked: Questions that this subject leaves open, and why, a line each.
        notes: What to keep in mind, a line each.
        damaged: What could not be read, a line each.
        cheats: What a search found of each reward; empty where nothing was searched.
    """

    title: str
    facts: Mapping[str, Any]
    rewards: Lines
    pairs: tuple[Pair, ...] = ()
    earned: tuple[Earned, ...] = ()
    setting: Lines = ()
    success: str = ""
    rankings: Mapping[str, Auc] = field(default_factory=dict)
    verdict: Lines = ()
    scripts: OfScripts | None = None
    measured: Lines = ()
    not_asked: Lines = ()
    notes: Lines = ()
    damaged: Lines = ()
    cheats: tuple[Finding, ...] = ()

    def __str__(self) -> str:
        return as_text(self)

    def __rich__(self) -> RenderableType:
        """What ``harness audit`` prints of any other subject than a data set."""
        return audit_table(self)

    @property
    def wrong(self) -> list[str]:
        """What went wrong, a line each."""
        return [f"left out, damaged: {line}" for line in self.damaged]

    @property
    def said(self) -> "tuple[Said, ...]":
        """The answers that ``--fail-on`` may name; scripts answer where nothing was searched."""
        from harness.cli.fail_on import Said

        found = [Said("pay", f"{it.reward} in {it.world}", it.word) for it in self.cheats]
        if self.scripts is not None and not found:
            of = self.scripts.finishing
            found = [Said("pay", self.rewards[-1], FAILING if of.undiscounted or of.discounted else NOTHING)]
        return (*found, *(Said("ranking", name, auc.answer) for name, auc in self.rankings.items()))

    def to_json(self) -> dict[str, Any]:
        """Plain data, finite numbers only."""
        return {**super().to_json(), **(self.scripts.to_json(self.pairs[0]) if self.scripts else {})}


def audit_table(audit: Audit) -> RenderableType:
    """What ``harness audit`` prints of any subject."""
    if audit.scripts is not None:
        earned = _of_payoffs(audit.scripts)
    else:
        earned = iter((earned_grid(audit.earned, audit.rewards), Text(), Text(COLUMN), Text()) if audit.earned else ())
    return Group(
        Text(audit.title, style="bold"),
        *map(Text, audit.setting),
        *(Text(f"{line}.") for line in audit.notes),
        Text(),
        *(part for finding in audit.cheats for part in finding_parts(finding)),
        *earned,
        *(Text(line, style="" if number else "bold") for number, line in enumerate(audit.verdict)),
        *([Text()] if audit.verdict else []),
        *_answers(audit),
        *(part for pair in audit.pairs for part in _of_pair(audit, pair)),
        *map(Text, audit.measured),
        *map(Text, audit.not_asked),
    )


def _of_pair(audit: Audit, pair: Pair) -> Iterator[RenderableType]:
    """How far apart two rewards are."""
    yield Text(f"{pair.one} and {pair.other}", style="bold")
    yield pair_grid(pair)
    for line in pair_lines(pair):
        yield Text(f"{line} {EVENTS}" if audit.scripts is not None else line)
    yield Text()


def _of_payoffs(scripts: OfScripts) -> Iterator[RenderableType]:
    """What scripted policies earned, in two lines of headings, so that names and values are whole in 60 columns."""
    payoffs, gamma = scripts.finishing.payoffs, f"return\ngamma {scripts.finishing.gamma:g}"
    noisy = {of.policy: number(of.total) for of in scripts.disturbed.payoffs} if scripts.disturbed else {}
    grid = _grid(
        "policy",
        ("return", "shaped\nalone", gamma, "steps", "success", *([f"noise\n{NOISE:g}"] if noisy else [])),
    )
    for place, payoff in enumerate(payoffs):
        name = f"{payoff.policy} paid most" if place == 0 else payoff.policy
        paid = map(number, (payoff.total, payoff.shaped, payoff.total_discounted))
        cells = (*paid, f"{payoff.steps:.1f}", f"{payoff.success:.0%}", *([noisy[payoff.policy]] if noisy else []))
        grid.add_row(Text(name), *map(Text, cells), style="bold" if place == 0 else "")
    yield from (grid, Text())
    if payoffs[0].terms:
        grid = _grid("term", [payoff.policy for payoff in payoffs])
        for name in payoffs[0].terms:
            grid.add_row(Text(name), *(Text(number(payoff.terms[name])) for payoff in payoffs))
        yield from (Text("What each term paid in an episode, without discount:\n"), grid, Text())


def _grid(first: str, headings: Iterable[str]) -> Table:
    """A column of names, and columns of numbers."""
    grid = plain_grid()
    grid.add_column(first, overflow="fold", no_wrap=first != "term")
    for heading in headings:
        grid.add_column(Text(heading), justify="right", no_wrap=True)
    return grid


def _answers(audit: Audit) -> Iterator[RenderableType]:
    """What is asked, the answer, and what that rests on."""
    grid = answer_grid()
    if (scripts := audit.scripts) is not None:
        asked, larger = [answer.name for answer in scripts.properties], f"all distances times {FACTOR:g}"
        if scripts.properties[0].holds is None:
            add_answer(grid, "\n".join((*asked, larger)), "n/a", scripts.properties[0].evidence)
        else:
            for answer in scripts.properties:
                add_answer(grid, answer.name, "yes" if answer.holds else "no", answer.evidence)
            ratios = [
                f"{name} {'n/a' if ratio is None else number(ratio)}" for name, ratio in scripts.workspace.items()
            ]
            told = f"the shaped return grows by a factor: {', '.join(ratios)}; the event terms stay the same"
            add_answer(grid, larger, "", told)
    for name, auc in audit.rankings.items():
        add_answer(
            grid, f"{name} and {audit.success}", auc_text(auc), f"{auc.answer}{auc.reason and f': {auc.reason}'}"
        )
    if grid.row_count:
        yield from (grid, Text())
    if audit.rankings:
        yield from (Text(RANKING.format(audit.success)), Text())


MOST_MEASURES = 2
"""So many measures are shown; JSON has all."""


def finding_parts(finding: Finding) -> Iterator[RenderableType]:
    """The table and the answer of one reward; the word stands first in it."""
    yield Text(f"What a cheat would do for {finding.reward}", style="bold")
    yield Text()
    if finding.three:
        start = next(iter(finding.three.values())).start
        where = "the means of policies" if finding.searched.rates else f"from start {start}"
        yield Text(f"What is paid most for failing and for succeeding, {where}:\n")
        yield from (_behaviours(finding), Text())
    first, *others = finding.lines
    word = f"{finding.word}, {finding.strength}" if finding.strength else finding.word
    yield Text.assemble((f"{word}.", "bold"), f" {first}")
    yield from map(Text, others)
    yield Text()


def _behaviours(finding: Finding) -> Table:
    measures = list(dict.fromkeys(name for of in finding.three.values() for name in of.measures))[:MOST_MEASURES]
    noises = [f"noise\n{noise:g}" for noise in NOISES]
    grid = _grid("behaviour", ("pay", f"pay\n@ {finding.gamma:g}", "steps", "success\nat step", *noises))
    for name in measures:
        grid.add_column(Text(name), justify="right", overflow="fold")
    paid = {(of.role, of.noise): of.paid for of in finding.noise}
    for role, of in finding.three.items():
        grid.add_row(
            Text(NAMES[role].removeprefix("best-paid ")),
            *map(number, (of.paid, of.discounted)),
            str(of.steps),
            str(of.time) if of.success else "never",
            *(number(paid[role, noise]) if (role, noise) in paid else "" for noise in NOISES),
            *(number(of.measures[name]) if name in of.measures else "" for name in measures),
        )
    return grid
