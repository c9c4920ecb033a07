"""What to record, as it is given to `harness.RecordRewards` and `harness.RecordVectorRewards`."""

import os
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Literal

from harness.errors import UsageError
from harness.eta.interval import Bounds, are_bounds
from harness.record.recording.facts import ACTED, Acted
from harness.recorder.env_facts import LEARNERS
from harness.reward.given import OWN, Given

OnError = Literal["warn", "raise"]


@dataclass(frozen=True)
class Asked:
    """Their arguments; `harness.recorder.record_rewards.RecordRewards` says what each one is.

    Raises:
        UsageError: One of them cannot be used.
    """

    path: str | os.PathLike[str]
    trained_with: str
    rewards: Mapping[str, Given]
    behaviour: Mapping[str, Given]
    lower_is_better: Collection[str]
    seed: int | None
    evaluation: bool
    pay: bool
    number: int
    resume: bool
    on_error: OnError
    batched: Collection[str] = ()
    bounds: Mapping[str, Bounds] = field(default_factory=dict)
    learners: Collection[str] = LEARNERS
    horizon: int | None = None
    acted: Acted = ""
    after: int = 0
    steps_asked: int = 0
    episodes_asked: int = 0

    def __post_init__(self) -> None:
        if self.on_error not in {"warn", "raise"}:
            raise UsageError(f"on_error={self.on_error!r}: it is 'warn' or 'raise'")
        if not isinstance(self.number, int) or self.number < 0:
            raise UsageError(f"number={self.number!r}: recorders of one training are numbered 0, 1, 2 ...")
        if self.horizon is not None and self.horizon < 1:
            raise UsageError(f"horizon={self.horizon!r}: an episode has one step at least; None: it is never cut")
        if self.acted not in ACTED:
            raise UsageError(f"acted={self.acted!r}: it is one of {', '.join(map(repr, ACTED))}")
        if not isinstance(self.after, int) or self.after < 0:
            raise UsageError(f"after={self.after!r}: it is a number of environment steps; 0: all of the training")
        self._require_amounts()
        if (self.acted or self.after) and not self.evaluation:
            raise UsageError("acted and after tell of an evaluation: say evaluation=True too")
        for argument, names in (("lower_is_better", self.lower_is_better), ("bounds", self.bounds)):
            for name in names:
                if name not in self.behaviour:
                    measures = sorted(self.behaviour)
                    raise UsageError(f"{argument} names {name!r}, which is none of the measures {measures}")
        for name, given in self.bounds.items():
            if not are_bounds(given):
                raise UsageError(f"bounds of {name!r} are {given!r}: give two numbers, the lower one first")
        if self.trained_with not in {*self.rewards, OWN}:
            raise UsageError(
                f"trained_with={self.trained_with!r} is none of the rewards {sorted(self.rewards)}: name one of them, "
                f'or record what the env pays under this name, rewards={{..., "{self.trained_with}": "{OWN}"}}'
            )

    def _require_amounts(self) -> None:
        for name, amount in (("steps_asked", self.steps_asked), ("episodes_asked", self.episodes_asked)):
            if not isinstance(amount, int) or isinstance(amount, bool) or amount < 0:
                raise UsageError(f"{name}={amount!r}: it is a whole number; 0: not known")
        if self.steps_asked if self.evaluation else self.episodes_asked:
            raise UsageError("steps_asked goes with a training, and episodes_asked with evaluation=True")

    @property
    def all_rewards(self) -> dict[str, Given]:
        """Those given, and under the name ``own`` what the env pays where the learner is trained with that."""
        own = {} if self.trained_with in self.rewards else {OWN: OWN}
        return {**self.rewards, **own}
