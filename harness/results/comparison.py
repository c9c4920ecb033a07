"""One proposed reward against the baseline: what the comparison of their runs says."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from html import escape
from itertools import takewhile, zip_longest
from typing import Any, Literal, NamedTuple

from harness.arrays import Float
from harness.eta.behaviour_change import NO_WORD, Change, with_intervals
from harness.eta.curve import GroupCurve
from harness.eta.headline import (
    DECIDING,
    SUCCESS,
    UNMEASURED,
    Answer,
    Headline,
    PaidAtRandom,
    ReturnSplit,
    number_sentence,
    return_sentence,
)
from harness.eta.index import Estimate
from harness.eta.judgement import Verdict, lead_of
from harness.eta.manner import DETERMINISTIC, LAST, OWN_AND_OTHER, STOCHASTIC, TRAINING, WHOLE
from harness.eta.rescaling import Rescaling
from harness.eta.splits import Decomposition, Names, Pair, Splits, no_splits
from harness.eta.verdict.ruling import Ruling
from harness.files.plain import Plain, tells
from harness.record.cell import BROUGHT, DISCOUNT, EVALUATION_HORIZON, UNKNOWN_ALGORITHM, Cell, Manifest
from harness.registry.choice import Choice
from harness.results.metrics import Counted, Mixture
from harness.results.pool import Pool
from harness.text import visible

UNTOLD = (None, *BROUGHT, UNKNOWN_ALGORITHM)
"""What stands where there is nothing to tell."""


@tells("*labels", "steps", "deterministic")
class Group(NamedTuple):
    """What compared cells share: everything that decides a result, except the seed and what is compared.

    The cells compare rewards, or the simulators that policies were trained in.
    """

    robot: str
    task: Choice
    algorithm: Choice
    steps: int
    evaluation_episodes: int
    evaluate_every: int = 0
    deterministic: bool = True
    evaluation_horizon: int = EVALUATION_HORIZON
    simulator: Choice | None = None
    """The simulator; None if simulators are compared."""
    reward: Choice | None = None
    """The reward; None if rewards are compared."""

    @classmethod
    def of(cls, cell: Cell, compared: Literal["reward", "simulator"] = "reward") -> "Group":
        """The group that a cell belongs to, if rewards or simulators are compared."""
        fields: dict[str, Any] = {name: getattr(cell, name) for name in cls._fields}
        return cls(**{**fields, compared: None})

    @property
    def labels(self) -> dict[str, str]:
        """The labels of what was chosen, by kind, without what is compared; an environment has no robot."""
        chosen = {"simulator": self.simulator, "algorithm": self.algorithm, "reward": self.reward}
        labels = {kind: choice.label for kind, choice in chosen.items() if choice not in UNTOLD}
        robot = {} if self.robot in UNTOLD else {"robot": self.robot}
        return {**labels, **robot, "task": self.task.label}

    @property
    def shown(self) -> dict[str, str]:
        """The labels for people: the algorithm as `harness.record.cell.Cell.learner`."""
        labels = self.labels
        if self.simulator == BROUGHT.simulator and "algorithm" in labels:
            labels["algorithm"] = self.algorithm.label_with(DISCOUNT)
        return labels

    @property
    def subject(self) -> str:
        """What behaves: an arm is a ``robot``, whatever acts in an environment an ``agent``."""
        return "robot" if "robot" in self.labels else "agent"

    @property
    def place(self) -> str:
        """Where the cells trained: the label of the simulator, or of the environment."""
        return self.labels.get("simulator", self.task.label)

    @property
    def title(self) -> str:
        """All labels in a line, for people."""
        return " · ".join(self.shown.values())

    @property
    def manner(self) -> str:
        """How the policies acted when they were evaluated."""
        return "deterministically" if self.deterministic else "stochastically"


def deciding_manner(deterministic: bool, episodes: Mapping[str, int]) -> str:
    """The manner of acting that decides about a robot: the one that the cells name, unless it has fewer episodes.

    Args:
        deterministic: How the cells say that policies act.
        episodes: The number of episodes in each manner in which they were evaluated.
    """
    own = OWN_AND_OTHER[deterministic][0]
    acted = {manner: episodes[manner] for manner in (DETERMINISTIC, STOCHASTIC) if manner in episodes}
    return max(acted, key=lambda manner: (acted[manner], manner == own), default=own)


@tells("steps", "behaviour=changes", "answer")
class StepChange(NamedTuple):
    """The measures that decide about the robot, at an evaluation before the trainings ended."""

    steps: int
    """Environment steps of training before the evaluation."""
    changes: tuple[Change, ...]

    @property
    def answer(self) -> str:
        """What it hints at: ``better``, ``worse`` or ``cannot tell``. It decides nothing."""
        return next((change.direction for change in self.changes if change.direction), Answer.CANNOT_TELL.value)


@dataclass(frozen=True, eq=False)
class Behaviour:
    """What was measured of the trainings under both rewards.

    Attributes:
        changes: Measures of behaviour: of the trained policies in each manner, of the trainings, of learning.
        along: The deciding measures at each evaluation before the end of the trainings.
        episodes: How many finished episodes every seed has at least, in each manner.
        counted: By manner, what `episodes` counts where it counts no episodes of all steps, such as points of a curve.
        mixtures: Plugins of which several versions made the cells that are compared.
        deciding: Names of the measures that decide about the robot, in this order.
        offered: Names of those that could have been named to decide instead, where one was named after they were known.
        decided_in: The manner that decides; by default that in which the cells say that policies act, unless it has
            fewer episodes than another.
        same_steps: Whether the policies of both rewards take the same steps in every evaluation, bit for bit.
        same_starts: Whether policies met the same episodes in their evaluations, as far as that is known.
        paid: What each of both rewards pays its own policies and random actions, as far as that is known.
    """

    changes: tuple[Change, ...] = ()
    along: tuple[StepChange, ...] = ()
    episodes: Mapping[str, int] = field(default_factory=dict)
    counted: Mapping[str, Counted] = field(default_factory=dict)
    mixtures: tuple[Mixture, ...] = ()
    deciding: tuple[str, ...] = DECIDING
    offered: tuple[str, ...] = ()
    decided_in: str = ""
    same_steps: bool = False
    same_starts: bool = True
    paid: tuple[PaidAtRandom, ...] = ()

    def changes_of(self, manner: str) -> tuple[Change, ...]:
        """The measures of one manner."""
        return tuple(change for change in self.changes if change.measure.manner == manner)

    @cached_property
    def speed(self) -> Change | None:
        """Success over the whole training, which says how fast the robot learns; None if it was not measured."""
        names = [SUCCESS, *self.deciding[:1]]
        during = [*self.changes_of(TRAINING), *self.changes_of(WHOLE)]
        there = [it for it in during if it.name in names and it.measure.episodes is not None]
        return next((it for it in there if it.seeds), None)


@dataclass(frozen=True)
class Judged:
    """What the test says.

    Attributes:
        ruling: Of the measures that decide, in this place; None before it was asked.
        pool: The answer over all places; None where there is one place.
        asked: Names and manners of the measures that the ruling is about, as another place may lack some; None before.
        claims: How many hints are corrected together, in all comparisons of the experiment except the null control.
    """

    ruling: Ruling | None = None
    pool: Pool | None = None
    asked: tuple[tuple[str, str], ...] | None = None
    claims: int = 0


@dataclass(frozen=True, eq=False)
class Number:
    """What is paid: by how much the number changed, and how much of that is ruler.

    Attributes:
        decomposition: Both etas with their parts; None without a seed, and where an own reward is not known.
        returns: By manner, the mean return of an episode and its split, where both own returns are known.
        missing: By manner, why a mean return is not known.
        number_of: What the sentence tells: the mean return, or both indices as in the note.
        rescaling: What the proposed reward is, if it is the baseline but for scale and offset; else None.
        manner: How the episodes that decide came about: the mean return of these is told.
        why_none: Why there is no decomposition, where there is none.
    """

    decomposition: Decomposition | None = None
    returns: Mapping[str, ReturnSplit] = field(default_factory=dict)
    missing: Mapping[str, str] = field(default_factory=dict)
    number_of: Literal["returns", "indices"] = "returns"
    rescaling: Rescaling | None = None
    manner: str = DETERMINISTIC
    why_none: str = "an own reward is not known in every step"

    @property
    def splits(self) -> Splits:
        """Both etas and their parts. Where there is none they hold the reason."""
        return self.decomposition.splits if self.decomposition else no_splits(self.why_none)

    @property
    def index_splits(self) -> Splits:
        """Those of `splits` whose index is not 0 under both rewards."""
        sides = (self.decomposition.baseline, self.decomposition.proposed) if self.decomposition else ()
        sums = {"eta_N": [it.negative_sum for it in sides], "eta_P": [it.positive_sum for it in sides]}
        return {name: split for name, split in self.splits.items() if any(sums[name])}

    @property
    def eta_n(self) -> Estimate:
        """The split of eta_N, NOTE eq. 43."""
        return self.splits["eta_N"].eta

    @property
    def eta_p(self) -> Estimate:
        """The split of eta_P, NOTE eq. 44."""
        return self.splits["eta_P"].eta

    @property
    def is_split(self) -> bool:
        """Whether there are runs, and each training was scored by the other's reward."""
        return self.decomposition is not None and self.decomposition.is_split

    @property
    def has_pay(self) -> bool:
        """Whether something is known of how much the pay changed, or else not said why it is not."""
        return self.main is not None or self.decomposition is not None or not self.missing

    @property
    def pay(self) -> ReturnSplit | None:
        """The pay of an episode in the manner that decides, with its split; None if it is not known."""
        return self.returns.get(self.manner)

    @property
    def main(self) -> ReturnSplit | None:
        """The same where it makes the claim about the number; None where the note's indices do."""
        return self.pay if self.number_of == "returns" else None

    def pay_sentence(self, names: Names) -> str:
        """The pay of an episode under both rewards, and its parts; why it is not known; empty without trainings."""
        if self.pay is not None:
            return return_sentence(names, self.pay)
        missing = self.missing.get(self.manner)
        return f"The pay of an episode is not known: {missing}." if missing else ""

    def index_sentence(self, names: Names) -> str:
        """How much the note's indices changed, and their parts; empty where they make no claim."""
        is_told = self.number_of == "indices" or not (self.pay or self.manner in self.missing)
        return number_sentence(names, self.splits) if is_told else ""

    def sentence(self, names: Names) -> str:
        """The sentence about the number that makes a claim."""
        return self.index_sentence(names) or self.pay_sentence(names)


@tells(
    "*group",
    "baseline",
    "proposed",
    "is_control",
    "seeds",
    "mixtures=measured.mixtures",
    "test=answer.ruling",
    "deciding=measured.deciding",
    "decided_in=answered_in",
    "same_steps=measured.same_steps",
    "paid_at_random=measured.paid",
    "not_maximised",
    "returns=number.returns",
    "returns_missing=number.missing",
    "*number.splits",
    "claims=answer.claims",
    "episodes=measured.episodes",
    "behaviour=measured.changes",
    "along_the_budget=measured.along",
)
@dataclass(frozen=True, eq=False)
class Comparison(Plain):
    """One proposed reward against the baseline, with one algorithm in one place: a simulator or an environment.

    Attributes:
        group: What both trainings share.
        baseline: Label of the baseline reward.
        proposed: Label of the proposed reward; the baseline's for the null control, whose proposed runs are the
            baseline trained again with other seeds.
        seeds: The seeds that are done under both rewards. What is paid is compared on them.
        trained: All seeds of each reward's trainings. Behaviour is compared on all of them.
        measured: What was measured of them.
        number: What is paid.
        answer: What the test says.
        curves: S_r(tau_q) by (r, q), as far as the rewards could be scored. A curve is read again at each request.
    """

    group: Group
    baseline: str
    proposed: str
    seeds: tuple[int, ...]
    trained: tuple[tuple[int, ...], tuple[int, ...]] = ((), ())
    measured: Behaviour = Behaviour()
    number: Number = Number()
    answer: Judged = Judged()
    curves: Mapping[Pair, GroupCurve] = field(default_factory=dict)

    @property
    def is_control(self) -> bool:
        """Whether it compares the baseline with itself."""
        return self.baseline == self.proposed

    @property
    def names(self) -> Names:
        """The names of both trainings. They differ even if both trainings have one reward."""
        return Names(self.baseline, f"{self.proposed} (other seeds)" if self.is_control else self.proposed)

    @property
    def counts(self) -> tuple[int, int]:
        """How many trainings of each reward are compared."""
        return len(self.trained[0]), len(self.trained[1])

    @property
    def has_trainings(self) -> bool:
        """Whether each reward has one."""
        return all(self.counts)

    @property
    def manner(self) -> str:
        """How the episodes that decide came about, one of the manners of `changes`."""
        return self.measured.decided_in or deciding_manner(self.group.deterministic, self.measured.episodes)

    @property
    def outcomes(self) -> list[Float | None]:
        """The outcomes of every hint with swapped names, in the order in which `with_corrected` takes p-values.

        The hints are: mean returns, both etas, all changes that do not decide, all evaluations along the budget.
        """
        number, measured = self.number, self.measured
        splits = [split.ratio.outcomes for split in number.returns.values()]
        etas = [split.outcomes for split in number.decomposition.splits.values()] if number.decomposition else []
        changes = [None if self._is_ruled(change) else change.outcomes for change in measured.changes]
        along = [change.outcomes for moment in measured.along for change in moment.changes]
        return [*splits, *etas, *changes, *along]

    def with_corrected(self, p_values: Iterator[float | None], claims: int) -> "Comparison":
        """The comparison with p-values that hold for so many hints together, in the order of `outcomes`."""
        number, measured = self.number, self.measured
        returns = {manner: split.with_corrected(next(p_values)) for manner, split in number.returns.items()}
        decomposition = number.decomposition
        if decomposition is not None:
            decomposition = decomposition.with_corrected(next(p_values), next(p_values))
        told = [(change, next(p_values)) for change in measured.changes]
        changes = tuple(it if self._is_ruled(it) else replace(it, corrected=p) for it, p in told)
        along = tuple(
            moment._replace(changes=tuple(replace(change, corrected=next(p_values)) for change in moment.changes))
            for moment in measured.along
        )
        measured = replace(measured, changes=changes, along=along)
        number = replace(number, returns=returns, decomposition=decomposition)
        return replace(self, measured=measured, number=number, answer=replace(self.answer, claims=claims))

    def with_ruling(self, asked: Sequence[Change], ruling: Ruling, pool: Pool | None) -> "Comparison":
        """The comparison with what the test says; before the plan is trained to its end hints say no word.

        Args:
            asked: The measures that it was asked about: those of `decisive_changes` that decide in all places.
            ruling: What it says of them.
            pool: The answer over all places.
        """
        ruled = {id(it): both for it, *both in zip_longest(asked, ruling.of_measures, ruling.beyond)}
        changes = tuple(
            replace(
                with_intervals(it, ruling.confidence),
                p=ruling.p,
                corrected=ruled[id(it)][0],
                is_plain=bool(ruled[id(it)][1]),
            )
            if id(it) in ruled
            else it
            for it in self.measured.changes
        )
        along = self.measured.along
        if ruling.missing:  # hints have a p, and call nothing better or worse
            changes = tuple(replace(it, level=NO_WORD) for it in changes)
            along = tuple(it._replace(changes=tuple(replace(of, level=NO_WORD) for of in it.changes)) for it in along)
        answer = replace(self.answer, ruling=ruling, pool=pool, asked=tuple(map(_name_and_manner, asked)))
        return replace(self, measured=replace(self.measured, changes=changes, along=along), answer=answer)

    @cached_property
    def decisive_changes(self) -> tuple[Change, ...]:
        """The measures that decide: those of the manner that decides, then success while training.

        A measure without a value in some training does not decide, unless it is known how bad a value can be. It would
        compare the trainings that have one: who succeeds more often where success is hard would be told to be slow.
        Success while training decides beside another one only where it is known of all trainings that have that.
        """
        acted, names, asked = self.measured.changes_of(self.answered_in), self.measured.deciding, self.answer.asked
        known = [change for change in acted if change.can_decide]
        found = [change for name in names for change in known if change.name == name]
        speed = self.measured.speed
        if found and speed is not None and speed.can_decide and all(it is not speed for it in found):
            known_in = zip(speed.lost, found[0].lost, strict=True)
            found += [speed] if all({*ours} <= {*others} for ours, others in known_in) else []
        return tuple(it for it in found if asked is None or _name_and_manner(it) in asked)

    @property
    def offered_changes(self) -> list[Change]:
        """Those of `Behaviour.offered` of the manner that decides, as far as every training has a value."""
        acted = self.measured.changes_of(self.answered_in)
        return [it for it in acted if it.name in self.measured.offered and it.seeds and not any(it.without)]

    @property
    def answered_in(self) -> str:
        """The manner of the measures that decide: the last evaluations where there are several, else `manner`."""
        return LAST if any(change.measure.manner == LAST for change in self.measured.changes) else self.manner

    def _is_ruled(self, change: Change) -> bool:
        """Whether the verdict tells of a change, so that it is no hint."""
        return self.answer.ruling is not None and any(change is it for it in self.decisive_changes)

    @property
    def own_manner(self) -> str:
        """The manner of acting that the cells name. Evaluations along the budget have only this manner."""
        named = OWN_AND_OTHER[self.group.deterministic][0]
        return named if named in self.measured.episodes else self.manner

    @property
    def decisive(self) -> Change | None:
        """The first of the measures that decide, in the manner that decides; None if it was not measured."""
        acted, first = self.measured.changes_of(self.answered_in), self.measured.deciding[:1]
        return next((change for change in acted if change.name in first), None)

    @cached_property
    def verdict(self) -> Verdict:
        """What the measures that decide say."""
        ruling, same_steps = self.answer.ruling or Ruling(), self.measured.same_steps
        return Verdict(self.names, self.decisive_changes, ruling, same_steps=same_steps)

    @cached_property
    def headline(self) -> Headline:
        """The answers of the comparison: about the robot, and about the number."""
        if not self.has_trainings:
            return self.verdict.headline("", f"Nothing to compare: {self.why_none}.")
        told = UNMEASURED if self.decisive is None else _unmeasured(self.names, self.decisive)
        found, pool = self.verdict.headline(self.number.sentence(self.names), told), self.answer.pool
        if pool is None or found.decided_by or not pool.ruling.is_decided:
            return found
        over_all = f"{pool.where.capitalize()} together: {pool.headline.answer.value.upper()}."
        return replace(found, robot=f"{over_all} Of this place alone: {found.robot}")

    @property
    def pay_sentence(self) -> str:
        """The pay of an episode under both rewards; without one, the note's indices; empty without both."""
        return (self.number.pay_sentence(self.names) or self.headline.number) if self.has_trainings else ""

    @property
    def index_sentence(self) -> str:
        """What the note's indices say beside `pay_sentence`; empty where they say nothing, or stand there."""
        told = self.number.index_sentence(self.names) if self.has_trainings else ""
        return told if told != self.pay_sentence else ""

    @cached_property
    def lead(self) -> str:
        """The answer about the robot in a sentence or two without a bracket."""
        return lead_of(self.verdict, self.group.subject) if self.verdict.deciding else self.headline.robot

    @property
    def not_maximised(self) -> tuple[str, ...]:
        """A sentence for each reward that pays random actions more than its policies; none before all have trained."""
        is_interim = self.answer.ruling is not None and self.answer.ruling.missing
        return () if is_interim else tuple(it.told for it in self.measured.paid if it.told)

    def to_json(self) -> dict[str, Any]:
        """Plain data, without the curves; docs/json.md explains it."""
        indices = self.number.decomposition
        over = {manner: list(it.over) for manner, it in self.measured.counted.items() if it.over}
        return {
            **super().to_json(),
            "trained": dict(zip(("baseline", "proposed"), map(list, self.trained), strict=True)),
            "headline": {**self.headline.to_json(), "pay": self.pay_sentence},
            "total": indices and indices.total.to_json(),
            "baseline_index": indices and indices.baseline.to_json(),
            "proposed_index": indices and indices.proposed.to_json(),
            **({"over": over} if over else {}),
        }

    def __repr__(self) -> str:
        told = f"{self.group.title}: {self.names.proposed} against {self.names.baseline}"
        return f"<Comparison in {told}, {min(self.counts)} seeds: {self.headline.answer.value}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: both answers, in words."""
        sentences = (repr(self).strip("<>"), self.headline.robot, self.pay_sentence)
        return "".join(f"<p>{escape(visible(it))}</p>" for it in sentences if it)

    @property
    def why_none(self) -> str:
        """Why there is no decomposition, where there is none."""
        if self.is_control:
            return f"{self.baseline} is not trained again with other seeds yet"
        if self.seeds:
            return "an own reward is not known in every step"
        if not self.has_trainings:
            missing = next(name for name, of in zip(self.names, self.trained, strict=True) if not of)
            return f"no training with {missing} is done"
        return f"no seed is done under both {self.baseline} and {self.proposed}"


def _name_and_manner(change: Change) -> tuple[str, str]:
    """Tells a measure apart from all others of a comparison."""
    return change.name, change.measure.manner


def pools_of(comparisons: Iterable[Comparison]) -> tuple[Pool, ...]:
    """The answers over all places, each once; none where there is one place."""
    return tuple({id(it.answer.pool): it.answer.pool for it in comparisons if it.answer.pool is not None}.values())


def still_to_come(comparisons: Iterable[Comparison]) -> str:
    """How many planned trainings have not ended, before which nothing is said; empty also where a plan has looks."""
    return next((it.answer.ruling.missing for it in comparisons if it.answer.ruling and it.answer.ruling.missing), "")


def _unmeasured(names: Names, change: Change) -> str:
    """Why the measure that should decide does not."""
    name, counts = change.name.replace("_", " "), change.counts
    if not change.measure.better:
        return f"Nobody says whether less or more {name} is better, so it cannot decide."
    if not any(counts):
        return f"{name} is not known: {change.reason or 'no episode ended'}."
    lacking = " and ".join(
        f"in {without} of {without + count} trainings with {label}"
        for label, without, count in zip(names, change.without, counts, strict=True)
        if without
    )
    why = f" ({change.reason})" if change.reason else ""
    return (
        f"{name} has no value {lacking}{why}, so it cannot decide: the trainings that have one are a selection. Let it "
        "give failures a value too, as time_to_target counts them with the whole horizon."
    )


ENDED = ("done", "failed", "damaged", "skipped")
COUNTED, LOST = ("done", "skipped", "not needed"), ("failed", "damaged")
"""How cells end that no answer waits for. How one ends that failed is an outcome too, which nobody measured."""


@dataclass(frozen=True, eq=False)
class Seen:
    """The trainings of an experiment that a plan divides into looks.

    The seeds of a place come in the order of the plan: those of the first look first.

    Attributes:
        looks: Seeds of each reward in each place at each look, increasing.
        status: How each cell ended, by group and reward, in the order of the plan.
    """

    looks: Sequence[int]
    status: Mapping[tuple[Group, str], Mapping[Cell, str]]

    @classmethod
    def of(cls, manifests: Sequence[Manifest], looks: Sequence[int]) -> "Seen":
        """What manifests tell, in the order of the plan."""
        found: dict[tuple[Group, str], dict[Cell, str]] = {}
        for it in manifests:
            found.setdefault((Group.of(it.cell), it.cell.reward.label), {})[it.cell] = it.status
        return cls(looks, found)

    @property
    def to_come(self) -> int:
        """How many trainings are missing: they have not ended, failed, or left files that cannot be read.

        A plan to the end counts those that ended, however they did: whoever fails does not hold it up for ever.
        """
        counted = (*COUNTED, *LOST) if self.looks else COUNTED
        return sum(status not in counted for cells in self.status.values() for status in cells.values())

    def lost(self, group: Group, reward: str) -> tuple[int, ...]:
        """In a plan to the end, the seeds of a reward's trainings that failed or cannot be read."""
        cells = self.status.get((group, reward), {}) if self.looks else {}
        return tuple(cell.seed for cell, status in cells.items() if status in LOST)

    @property
    def groups(self) -> tuple[Group, ...]:
        """The places."""
        return tuple(dict.fromkeys(group for group, _ in self.status))

    def look_of(self, comparison: Comparison) -> tuple[Mapping[int, int], int]:
        """The look of each seed, counted from 0, and how many looks are complete under both rewards."""
        cells = self.status.get((comparison.group, comparison.baseline), {})
        of_seed = {cell.seed: sum(at >= end for end in self.looks) for at, cell in enumerate(cells)}
        rewards = (comparison.baseline, comparison.proposed)
        return of_seed, min(self.complete(reward, [comparison.group]) for reward in rewards)

    def complete(self, reward: str, groups: Iterable[Group] | None = None) -> int:
        """How many looks are complete for a reward: all of their cells have ended, in all places."""
        there = [self.status.get((group, reward), {}) for group in (self.groups if groups is None else groups)]
        ended = [sum(1 for _ in takewhile(ENDED.__contains__, cells.values())) for cells in there]
        return sum(min(ended, default=0) >= end for end in self.looks)

    def cells_of(self, rewards: Iterable[str], look: int) -> list[Cell]:
        """The cells of some rewards up to a look, counted from 0, in the order of the plan within each place."""
        wanted = set(rewards)
        return [
            cell
            for (_, reward), cells in self.status.items()
            if reward in wanted
            for cell in list(cells)[: self.looks[look]]
        ]
