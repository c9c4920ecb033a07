"""One proposed reward against the baseline: what the comparison of their runs says."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple

from harness.arrays import Float
from harness.eta.behaviour_change import Change
from harness.eta.curve import GroupCurve
from harness.eta.headline import (
    DECIDING,
    UNMEASURED,
    Answer,
    Headline,
    Names,
    judge,
    number_sentence,
    return_sentence,
)
from harness.eta.index import Index, Ratio
from harness.eta.return_split import ReturnSplit
from harness.eta.scored_sums import Pair
from harness.eta.splits import Decomposition, Splits, no_splits, splits_to_json
from harness.eta.swaps import corrected_where_known, smallest_p
from harness.record.cell import EVALUATION_HORIZON, NO_ROBOT, NO_SIMULATOR, UNKNOWN_ALGORITHM, Cell
from harness.registry.choice import Choice
from harness.results.measured import DETERMINISTIC, STOCHASTIC
from harness.results.mixture import Mixture

UNTOLD = (None, NO_SIMULATOR, UNKNOWN_ALGORITHM)
"""What stands where there is nothing to tell."""


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
        robot = {} if self.robot == NO_ROBOT else {"robot": self.robot}
        return {**labels, **robot, "task": self.task.label}

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
        """All labels in a line."""
        return " · ".join(self.labels.values())

    @property
    def manner(self) -> str:
        """How the policies acted when they were evaluated."""
        return "deterministically" if self.deterministic else "stochastically"

    def to_json(self) -> dict[str, Any]:
        """The labels as plain data."""
        return {**self.labels, "steps": self.steps, "deterministic": self.deterministic}


def deciding_manner(deterministic: bool, episodes: Mapping[str, int]) -> str:
    """The manner of acting that decides about a robot: the one that the cells name, unless it has fewer episodes.

    Args:
        deterministic: How the cells say that policies act.
        episodes: The number of episodes in each manner in which they were evaluated.
    """
    own = DETERMINISTIC if deterministic else STOCHASTIC
    acted = {manner: episodes[manner] for manner in (DETERMINISTIC, STOCHASTIC) if manner in episodes}
    return max(acted, key=lambda manner: (acted[manner], manner == own), default=own)


class StepChange(NamedTuple):
    """The measures that decide about the robot, at an evaluation before the trainings ended."""

    steps: int
    """Environment steps of training before the evaluation."""
    changes: tuple[Change, ...]

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {"steps": self.steps, "behaviour": [change.to_json() for change in self.changes]}


@dataclass(frozen=True, eq=False)
class Comparison:
    """One proposed reward against the baseline, with one algorithm in one place: a simulator or an environment.

    Attributes:
        group: What both trainings share.
        baseline: Label of the baseline reward.
        proposed: Label of the proposed reward; the baseline's for the null control, whose proposed runs are the
            baseline trained again with other seeds.
        seeds: The seeds that are done under both rewards, and compared.
        decomposition: Both etas with their parts; None without a seed, and where an own reward is not known.
        changes: Measures of behaviour: of the trained policies in each manner, of the trainings, of learning.
        curves: S_r(tau_q) by (r, q), as far as the rewards could be scored. A curve is read again at each request.
        along: The deciding measures at each evaluation before the end of the trainings.
        episodes: How many finished episodes every seed has at least, in each manner.
        claims: How many claims are made together, in all comparisons of the experiment except the null control.
        mixtures: Plugins of which several versions made the cells that are compared.
        returns: By manner, the mean return of an episode and its split, where both own returns are known.
        missing: By manner, why a mean return is not known.
        deciding: Names of the measures that decide about the robot, in this order.
        decided_in: The manner that decides; by default that in which the cells say that policies act, unless it has
            fewer episodes than another.
        number_of: What the sentence about the number tells: the mean return, or both indices as in the note.
    """

    group: Group
    baseline: str
    proposed: str
    seeds: tuple[int, ...]
    decomposition: Decomposition | None
    changes: tuple[Change, ...]
    curves: Mapping[Pair, GroupCurve]
    along: tuple[StepChange, ...] = ()
    episodes: Mapping[str, int] = field(default_factory=dict)
    claims: int = 0
    mixtures: tuple[Mixture, ...] = ()
    returns: Mapping[str, ReturnSplit] = field(default_factory=dict)
    missing: Mapping[str, str] = field(default_factory=dict)
    deciding: tuple[str, ...] = DECIDING
    decided_in: str = ""
    number_of: Literal["returns", "indices"] = "returns"

    @property
    def is_control(self) -> bool:
        """Whether it compares the baseline with itself."""
        return self.baseline == self.proposed

    @property
    def names(self) -> Names:
        """The names of both trainings. They differ even if both trainings have one reward."""
        return Names(self.baseline, f"{self.proposed} (other seeds)" if self.is_control else self.proposed)

    @property
    def splits(self) -> Splits:
        """Both etas and their parts. Where there is none they hold the reason."""
        return self.decomposition.splits if self.decomposition else no_splits(self._empty)

    @property
    def index_splits(self) -> Splits:
        """Those of `splits` whose index is not 0 under both rewards."""
        if self.decomposition is None:
            return {}
        sides = (self.decomposition.baseline, self.decomposition.proposed)
        is_there = {
            "eta_N": any(index.negative_sum for index in sides),
            "eta_P": any(index.positive_sum for index in sides),
        }
        return {name: split for name, split in self.splits.items() if is_there[name]}

    @property
    def eta_n(self) -> Ratio:
        """The split of eta_N, NOTE eq. 43."""
        return self.splits["eta_N"].eta

    @property
    def eta_p(self) -> Ratio:
        """The split of eta_P, NOTE eq. 44."""
        return self.splits["eta_P"].eta

    @property
    def is_split(self) -> bool:
        """Whether there are runs, and each training was scored by the other's reward."""
        return self.decomposition is not None and self.decomposition.is_split

    @property
    def baseline_index(self) -> Index | None:
        """The indices of the baseline's trainings under their own reward; None where there are none."""
        return self.decomposition.baseline if self.decomposition else None

    @property
    def proposed_index(self) -> Index | None:
        """The indices of the proposed reward's trainings under their own reward; None where there are none."""
        return self.decomposition.proposed if self.decomposition else None

    @property
    def manner(self) -> str:
        """How the episodes that decide came about, one of the manners of `changes`."""
        return self.decided_in or deciding_manner(self.group.deterministic, self.episodes)

    @property
    def main(self) -> ReturnSplit | None:
        """The split of the mean return in the manner that decides; None if it is not known, or does not count."""
        return self.returns.get(self.manner) if self.number_of == "returns" else None

    @property
    def outcomes(self) -> list[Float | None]:
        """The outcomes of every claim with swapped names, in the order in which `with_corrected` takes p-values.

        The claims are: mean returns, both etas, all changes, all evaluations along the budget.
        """
        splits = [split.ratio.outcomes for split in self.returns.values()]
        etas = [split.outcomes for split in self.decomposition.splits.values()] if self.decomposition else []
        changes = [*self.changes, *(change for moment in self.along for change in moment.changes)]
        return [*splits, *etas, *(change.outcomes for change in changes)]

    def with_corrected(self, p_values: Iterator[float | None], claims: int) -> "Comparison":
        """The comparison with p-values that hold for so many claims together, in the order of `outcomes`."""
        returns = {manner: split.with_corrected(next(p_values)) for manner, split in self.returns.items()}
        decomposition = self.decomposition
        if decomposition is not None:
            decomposition = decomposition.with_corrected(next(p_values), next(p_values))
        changes = tuple(replace(change, corrected=next(p_values)) for change in self.changes)
        along = tuple(
            moment._replace(changes=tuple(replace(change, corrected=next(p_values)) for change in moment.changes))
            for moment in self.along
        )
        return replace(self, returns=returns, decomposition=decomposition, changes=changes, along=along, claims=claims)

    @property
    def own_manner(self) -> str:
        """The manner of acting that the cells name. Evaluations along the budget have only this manner."""
        named = DETERMINISTIC if self.group.deterministic else STOCHASTIC
        return named if named in self.episodes else self.manner

    def changes_of(self, manner: str) -> tuple[Change, ...]:
        """The measures of one manner."""
        return tuple(change for change in self.changes if change.measure.manner == manner)

    @property
    def decisive(self) -> Change | None:
        """The first of the measures that decide, in the manner that decides; None if it was not measured."""
        return next((change for change in self.changes_of(self.manner) if change.name in self.deciding[:1]), None)

    @cached_property
    def headline(self) -> Headline:
        """The answers of the comparison: about the robot, and about the number."""
        if not self.seeds:
            return Headline(Answer.CANNOT_TELL, f"Nothing to compare: {self._empty}.", "")
        return self._judge(self.changes_of(self.manner))

    def headline_at(self, moment: StepChange) -> Headline:
        """The answers that would have been given after so many steps."""
        return self._judge(moment.changes)

    def _judge(self, changes: Sequence[Change]) -> Headline:
        known = [change for name in self.deciding for change in changes if change.name == name and change.seeds]
        told = UNMEASURED
        if self.decisive is not None:
            name = self.decisive.name.replace("_", " ")
            told = f"{name} is not known: {self.decisive.reason or 'no episode ended'}."
        return judge(self.names, known, self.number, self.claims, told)

    @property
    def number(self) -> str:
        """A sentence on how much the pay changed, and how much of that is ruler: mean returns, else both indices."""
        if self.main is not None:
            return return_sentence(self.names, self.main)
        if self.number_of == "returns" and self.manner in self.missing:
            return f"The mean return is not known: {self.missing[self.manner]}."
        return number_sentence(self.names, self.splits)

    def to_json(self) -> dict[str, Any]:
        """Plain data, without the curves; docs/json.md explains it."""
        headline = self.headline.to_json()
        if self.group.subject == "robot":
            # `robot` is its name in version 0.1; it leaves with the next format
            headline = {"answer": headline["answer"], "robot": headline["behaviour"], **headline}
        return {
            **self.group.to_json(),
            "baseline": self.baseline,
            "proposed": self.proposed,
            "is_control": self.is_control,
            "seeds": list(self.seeds),
            "mixtures": [mixture.to_json() for mixture in self.mixtures],
            "headline": headline,
            "deciding": list(self.deciding),
            "decided_in": self.manner,
            "returns": {manner: split.to_json() for manner, split in self.returns.items()},
            "returns_missing": dict(self.missing),
            **splits_to_json(self.splits),
            "total": self.decomposition and self.decomposition.total.to_json(),
            "baseline_index": self.baseline_index and self.baseline_index.to_json(),
            "proposed_index": self.proposed_index and self.proposed_index.to_json(),
            "claims": self.claims,
            "smallest_p": smallest_p(len(self.seeds)) if self.seeds else None,
            "episodes": dict(self.episodes),
            "behaviour": [change.to_json() for change in self.changes],
            "along_the_budget": [
                {**moment.to_json(), "answer": self.headline_at(moment).answer.value} for moment in self.along
            ],
        }

    @property
    def _empty(self) -> str:
        if self.is_control:
            return f"{self.baseline} is not trained again with other seeds yet"
        if self.seeds:
            return "an own reward is not known in every step"
        return f"no seed is done under both {self.baseline} and {self.proposed}"


def correct(family: Sequence[Comparison]) -> tuple[Comparison, ...]:
    """Comparisons with p-values that hold for all of their claims together."""
    p_values = corrected_where_known(outcomes for comparison in family for outcomes in comparison.outcomes)
    left, count = iter(p_values), sum(p is not None for p in p_values)
    return tuple(comparison.with_corrected(left, count) for comparison in family)


def correct_all(found: Sequence[Comparison]) -> tuple[Comparison, ...]:
    """Comparisons, in their order, with p-values that hold for all of their claims together.

    A null control makes no claim about rewards. So it is corrected by itself, and makes no other p-value larger.
    """
    family = iter(correct([it for it in found if not it.is_control]))
    return tuple(correct([it])[0] if it.is_control else next(family) for it in found)
