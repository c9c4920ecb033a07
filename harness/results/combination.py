"""One proposed reward against the baseline: what the comparison of their runs says."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal, NamedTuple

from harness.arrays import Float
from harness.eta.behaviour_change import Change
from harness.eta.curve import GroupCurve
from harness.eta.headline import SUCCESS, Answer, Headline, Names, headline_of
from harness.eta.index import Index, Ratio
from harness.eta.scored_sums import Pair
from harness.eta.splits import Decomposition, Splits, no_splits, splits_to_json
from harness.eta.swaps import smallest_p
from harness.record.cell import EVALUATION_HORIZON, Cell
from harness.registry.choice import Choice
from harness.results.measured import DETERMINISTIC, STOCHASTIC
from harness.results.mixture import Mixture


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
        """The labels of what was chosen, by kind, without what is compared."""
        chosen = {"simulator": self.simulator, "algorithm": self.algorithm, "reward": self.reward}
        labels = {kind: choice.label for kind, choice in chosen.items() if choice is not None}
        return {**labels, "robot": self.robot, "task": self.task.label}

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
class Combination:
    """One proposed reward against the baseline, on one simulator, robot, task and algorithm.

    Attributes:
        group: What both trainings share.
        baseline: Label of the baseline reward.
        proposed: Label of the proposed reward; the baseline's for the null control, whose proposed runs are the
            baseline trained again with other seeds.
        seeds: The seeds that are done under both rewards, and compared.
        decomposition: Both etas with their parts; None without a seed.
        changes: Measures of behaviour: of the trained policies in each manner, of the trainings, of learning.
        curves: S_r(tau_q) by (r, q), as far as the rewards could be scored. A curve is read again at each request.
        along: The deciding measures at each evaluation before the end of the trainings.
        episodes: How many finished episodes every seed has at least, in each manner.
        claims: How many claims are made together, in all combinations of the experiment except the null control.
        mixtures: Plugins of which several versions made the cells that are compared.
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
        """Both etas and their parts. Without a seed they hold the reason why there are none."""
        return self.decomposition.splits if self.decomposition else no_splits(self._empty)

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
        """None without a seed."""
        return self.decomposition.baseline if self.decomposition else None

    @property
    def proposed_index(self) -> Index | None:
        """None without a seed."""
        return self.decomposition.proposed if self.decomposition else None

    @property
    def outcomes(self) -> list[Float | None]:
        """The outcomes of every claim with swapped names: both etas, all changes, all evaluations along the budget."""
        if self.decomposition is None:
            return []
        changes = [*self.changes, *(change for moment in self.along for change in moment.changes)]
        return [
            self.decomposition.negative.outcomes,
            self.decomposition.positive.outcomes,
            *(change.outcomes for change in changes),
        ]

    @property
    def own_manner(self) -> str:
        """The manner of acting that the cells name. Evaluations along the budget have only this manner."""
        return DETERMINISTIC if self.group.deterministic else STOCHASTIC

    @property
    def manner(self) -> str:
        """The manner of acting that decides about the robot: that of the cells, unless it has fewer episodes."""
        return deciding_manner(self.group.deterministic, self.episodes)

    def changes_of(self, manner: str) -> tuple[Change, ...]:
        """The measures of one manner."""
        return tuple(change for change in self.changes if change.measure.manner == manner)

    @property
    def success(self) -> Change | None:
        """The change of the success rate that decides about the robot."""
        return next((change for change in self.changes_of(self.manner) if change.name == SUCCESS), None)

    @cached_property
    def headline(self) -> Headline:
        """The answers of the comparison: about the robot, and about the number."""
        if self.decomposition is None:
            return Headline(Answer.CANNOT_TELL, f"Nothing to compare: {self._empty}.", "")
        return headline_of(self.names, self.decomposition, self.changes_of(self.manner), self.claims)

    def headline_at(self, moment: StepChange) -> Headline:
        """The answers that would have been given after so many steps."""
        assert self.decomposition is not None  # there is no evaluation without a cell
        return headline_of(self.names, self.decomposition, moment.changes, self.claims)

    def to_json(self) -> dict[str, Any]:
        """Plain data, without the curves."""
        return {
            **self.group.to_json(),
            "baseline": self.baseline,
            "proposed": self.proposed,
            "is_control": self.is_control,
            "seeds": list(self.seeds),
            "mixtures": [mixture.to_json() for mixture in self.mixtures],
            "headline": self.headline.to_json(),
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
        return f"no seed is done under both {self.baseline} and {self.proposed}"
