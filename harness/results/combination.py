"""One proposed reward against the baseline: what the comparison of their runs says."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

from harness.eta.behaviour_change import Change
from harness.eta.curve import GroupCurve
from harness.eta.decompose import Decomposition, Pair, Splits, no_splits, splits_to_json
from harness.eta.index import Index, Ratio
from harness.eta.verdict import SUCCESS, basis, verdict
from harness.record.cell import Cell
from harness.registry.choice import Choice


class Group(NamedTuple):
    """What cells share that are compared: all that decides a result, but for the seed and what is compared.

    Rewards are compared with one another, or the simulators that policies were trained in.
    """

    robot: str
    task: Choice
    algorithm: Choice
    steps: int
    evaluation_episodes: int
    evaluate_every: int = 0
    deterministic: bool = True
    simulator: Choice | None = None
    """None where simulators are compared."""
    reward: Choice | None = None
    """None where rewards are."""

    @classmethod
    def of(cls, cell: Cell, compared: Literal["reward", "simulator"] = "reward") -> "Group":
        """The group that a cell belongs to where rewards, or simulators, are compared."""
        fields: dict[str, Any] = {name: getattr(cell, name) for name in cls._fields}
        return cls(**{**fields, compared: None})

    @property
    def labels(self) -> dict[str, str]:
        """Of what was chosen, by kind; what is compared is left out."""
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
        """Plain data, by label."""
        return {**self.labels, "steps": self.steps, "deterministic": self.deterministic}


@dataclass(frozen=True, eq=False)
class Combination:
    """One proposed reward against the baseline, on one simulator, robot, task and algorithm.

    Attributes:
        group: What both share.
        baseline: Label of the baseline reward.
        proposed: Label of the proposed reward.
        seeds: Those that are done under both rewards, and compared.
        decomposition: Both etas and how they split; None without a seed.
        changes: Measures of behaviour of the trained policies, and of random actions.
        curves: S_r(tau_q) by (r, q), as far as the rewards could be scored.
        corrected: p-values that hold for all combinations of the experiment together, by ``eta_n``, ``eta_p``,
            ``success``; None where there is none.
    """

    group: Group
    baseline: str
    proposed: str
    seeds: tuple[int, ...]
    decomposition: Decomposition | None
    changes: tuple[Change, ...]
    curves: Mapping[Pair, GroupCurve]
    corrected: Mapping[str, float | None] = field(default_factory=dict)

    @property
    def splits(self) -> Splits:
        """Both etas and their parts; without a seed the reason why there are none."""
        return self.decomposition.splits if self.decomposition else no_splits(self._empty)

    @property
    def eta_n(self) -> Ratio:
        """NOTE eq. 43."""
        return self.splits["eta_N"].eta

    @property
    def eta_p(self) -> Ratio:
        """NOTE eq. 44."""
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
    def verdict(self) -> str:
        """What it comes to, in one line."""
        if self.decomposition is None:
            return f"Nothing to compare: {self._empty}."
        return verdict(self.decomposition, self.changes, self.corrected.get("success"))

    @property
    def basis(self) -> str:
        """What the verdict rests on."""
        if self.decomposition is None:
            return ""
        return basis(self.decomposition, self.changes, self.group.evaluation_episodes)

    @property
    def success(self) -> Change | None:
        """The change of the success rate."""
        return next((change for change in self.changes if change.name == SUCCESS), None)

    def to_json(self) -> dict[str, Any]:
        """Plain data, the curves left out."""
        return {
            **self.group.to_json(),
            "baseline": self.baseline,
            "proposed": self.proposed,
            "seeds": list(self.seeds),
            **splits_to_json(self.splits),
            "baseline_index": self.baseline_index and self.baseline_index.to_json(),
            "proposed_index": self.proposed_index and self.proposed_index.to_json(),
            "success": {who: self.success and getattr(self.success, who) for who in ("baseline", "proposed", "random")},
            "behaviour": [change.to_json() for change in self.changes],
            "p_corrected": dict(self.corrected),
            "verdict": self.verdict,
            "basis": self.basis,
        }

    @property
    def _empty(self) -> str:
        return f"no seed is done under both {self.baseline} and {self.proposed}"
