"""Recorded trainings in one environment as a comparison asks about them; see `harness.results.compare.Trainings`."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from harness.arrays import Float
from harness.errors import Unscored
from harness.eta.behaviour_change import Quantity
from harness.eta.curve import GroupCurve, Kind, stream_curve
from harness.eta.scored_sums import Pair
from harness.eta.swaps import Swaps
from harness.log.log import REWARD
from harness.results.compare import Match, compare
from harness.results.comparison import Comparison
from harness.results.measured import EVALUATION, Measured, Moment
from harness.results.mixture import Mixture
from harness.results.recordings.runs import MANNERS, Run, Runs, meet_same_starts, rescaling_between

UNKNOWN = "a reward is not known in all trainings"


def compare_runs(
    runs: Runs, baseline: str, proposed: str, swaps: Swaps, kind: Kind = "accumulated", averaged: int = 1
) -> Comparison:
    """One reward against another, by all of their trainings; p-values are not corrected yet."""
    one, other = (
        {seed: run for (name, seed), run in runs.members.items() if name == label} for label in (baseline, proposed)
    )
    again = runs.control if baseline == runs.trained[0] else {}
    match = Match.of_seeds((baseline, proposed), one, runs.control if baseline == proposed else other, again)
    found = compare(_Recorded(runs, kind, averaged), match, swaps)
    both = [run for side in match.sides for run in side]
    rescaling = None if baseline == proposed else rescaling_between(both, proposed, baseline)
    return replace(found, rescaling=rescaling, same_starts=meet_same_starts(both), counted=runs.counted)


class _Recorded:
    """Recorded trainings of one group."""

    number_of: Literal["returns", "indices"] = "returns"

    def __init__(self, runs: Runs, kind: Kind, averaged: int) -> None:
        self._runs, self._kind, self.averaged = runs, kind, averaged
        self.group, self.names, self.deciding = runs.group, runs.measures, runs.measures[:1]
        self._random = dict(runs.random.whole.behaviour) if runs.random else {}

    @property
    def success(self) -> str:
        """See `Trainings`: the measure that decides, if it is a share of episodes."""
        return next((name for name in self.deciding if self._runs.is_flag(name)), "")

    def decided_in(self, episodes: Mapping[str, int]) -> str:
        """See `Trainings`."""
        return next((manner for manner in episodes if episodes[manner]), MANNERS[-1])

    def measured(self, training: Run) -> Measured:
        """See `Trainings`; what says most about the final policies comes first."""
        parts = training.parts(self._runs.steps)
        there = {manner: parts[manner] for manner in MANNERS if manner in parts}
        return Measured(
            {manner: dict(part.behaviour) for manner, part in there.items()},
            {manner: part.episodes for manner, part in there.items()},
            self._random,
        )

    def moments(self, training: Run) -> Sequence[Moment]:
        """See `Trainings`."""
        return training.moments(self._runs.steps)

    def measure(self, name: str, manner: str, episodes: int) -> Quantity:
        """See `Trainings`."""
        return self._runs.measure(name, manner, episodes)

    def has_floor(self, manner: str) -> bool:
        """See `Trainings`: beside episodes of policies."""
        return manner.startswith(EVALUATION)

    def reason(self, match: Match[Run], name: str, manner: str) -> str:
        """See `Trainings`."""
        for run in (run for side in match.sides for run in side):
            part = run.parts(self._runs.steps).get(manner)
            if part is not None and part.behaviour.get(name) is None:
                return _why(name, run, part.reasons)
        return ""

    def curve(self, match: Match[Run], pair: Pair) -> GroupCurve:
        """See `Trainings`: read from the files."""
        payer, members = getattr(match, pair[0]), match.of(pair[1])
        if not all(payer in run.facts.rewards and f"{REWARD}{payer}" not in run.episodes.reasons for run in members):
            raise Unscored(UNKNOWN)
        return self._curve(payer, members)

    def control(self, match: Match[Run]) -> GroupCurve | None:
        """See `Trainings`."""
        return self._curve(match.baseline, match.control) if match.control else None

    def return_manners(self, episodes: Mapping[str, int]) -> Sequence[str]:
        """See `Trainings`: all that all trainings have."""
        return list(episodes)

    def returned(self, match: Match[Run], pair: Pair, manner: str) -> list[float]:
        """See `Trainings`."""
        if self._runs.returns_apart:
            raise Unscored(self._runs.returns_apart)
        payer, found = getattr(match, pair[0]), []
        for run in match.of(pair[1]):
            part = run.parts(self._runs.steps)[manner]
            value = part.returns.get(payer)
            if value is None:
                raise Unscored(_why(payer, run, part.reasons))
            found.append(value)
        return found

    def paid_beside_random(self, trainings: Sequence[Run]) -> tuple[list[float], Float]:
        """See `Trainings`."""
        reward, random = trainings[0].reward, self._runs.random
        evaluated = [None if run.evaluation is None else run.evaluation.whole.returns.get(reward) for run in trainings]
        paid = [value for value in evaluated if value is not None]
        at_random = None if random is None else random.episodes.returns.get(reward)
        if len(paid) < len(trainings) or at_random is None or np.isnan(at_random).any():
            raise Unscored(UNKNOWN)
        return paid, at_random

    def same_steps(self, match: Match[Run]) -> bool:
        """See `Trainings`: a recording need not hold the actions."""
        return False

    def mixtures(self, match: Match[Run]) -> tuple[Mixture, ...]:
        """See `Trainings`: notes on the code of rewards and measures say it, see `read_runs`."""
        return ()

    def _curve(self, payer: str, members: Sequence[Run]) -> GroupCurve:
        return stream_curve((run.paid_by(payer) for run in members), len(members), self._runs.steps, self._kind)


def _why(name: str, run: Run, reasons: Mapping[str, str]) -> str:
    """Why a reward or a measure has no value in a training."""
    return f"{name} in '{run.path}': {reasons.get(name, 'not recorded')}"
