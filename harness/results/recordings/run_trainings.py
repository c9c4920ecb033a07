"""Recorded trainings in one environment, as results ask about them."""

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np

from harness.arrays import Float
from harness.errors import Unscored
from harness.eta.behaviour_change import Quantity
from harness.eta.curve import GroupCurve, Kind, stream_curve
from harness.eta.manner import EVALUATION, MANNERS
from harness.eta.rescaling import Rescaling
from harness.eta.scored_sums import Pair
from harness.log.log import REWARD
from harness.results.by_term import ByTerm, part_of
from harness.results.comparison import Comparison
from harness.results.learning import Learning, LearningCurve, Point, mean_point, stretches
from harness.results.measured import Measured, Mixture, Moment
from harness.results.recordings.episodes import Part
from harness.results.recordings.runs import Run, Runs, meet_same_starts, rescaling_between
from harness.results.trainings import Ends, Match, TermsOfTraining

UNKNOWN = "a reward is not known in all trainings"


def return_name(reward: str) -> str:
    """What the curve of a reward is called."""
    return f"return paid by {reward}"


class RunTrainings:
    """Recorded trainings of one group; see `harness.results.trainings.Trainings`."""

    number_of: Literal["returns", "indices"] = "returns"

    def __init__(self, runs: Runs, kind: Kind = "accumulated", averaged: int = 1) -> None:
        self.runs, self.kind, self.averaged = runs, kind, averaged
        self.group, self.names, self.rewards, self.baseline = runs.group, runs.measures, runs.trained, runs.trained[0]
        self.leading = self.deciding = runs.measures[:1]
        self.counted, self.is_alone = runs.counted, len(runs.trained) == 1 and not runs.control
        self._random = dict(runs.random.whole.behaviour) if runs.random else {}

    def matches(self, *, pairs: bool) -> list[Match[Run]]:
        """The trainings of each two rewards that are compared, of the null control last; see `Runs.compared`."""
        return [self._match(*names) for names in self.runs.compared(pairs=pairs)]

    def _match(self, baseline: str, proposed: str) -> Match[Run]:
        one, other = (
            {seed: run for (name, seed), run in self.runs.members.items() if name == label}
            for label in (baseline, proposed)
        )
        control = self.runs.control
        again = control if baseline == self.baseline else {}
        return Match.of_seeds((baseline, proposed), one, control if baseline == proposed else other, again)

    @property
    def success(self) -> str:
        """See `Trainings`: the measure that decides, if it is a share of episodes."""
        return next((name for name in self.deciding if self.runs.is_flag(name)), "")

    def decided_in(self, episodes: Mapping[str, int]) -> str:
        return next((manner for manner in episodes if episodes[manner]), MANNERS[-1])

    def measured(self, training: Run) -> Measured:
        """See `Trainings`; what says most about the final policies comes first."""
        parts = training.parts(self.runs.steps)
        there = {manner: parts[manner] for manner in MANNERS if manner in parts}
        return Measured(
            {manner: dict(part.behaviour) for manner, part in there.items()},
            {manner: part.episodes for manner, part in there.items()},
            self._random,
        )

    def moments(self, training: Run) -> Sequence[Moment]:
        return training.moments(self.runs.steps)

    def measure(self, name: str, manner: str, episodes: int) -> Quantity:
        return self.runs.measure(name, manner, episodes)

    def has_floor(self, manner: str) -> bool:
        """See `Trainings`: beside episodes of policies."""
        return manner.startswith(EVALUATION)

    def reason(self, match: Match[Run], name: str, manner: str) -> str:
        for run in (run for side in match.sides for run in side):
            part = run.parts(self.runs.steps).get(manner)
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
        return self._curve(match.baseline, match.control) if match.control else None

    def return_manners(self, episodes: Mapping[str, int]) -> Sequence[str]:
        """See `Trainings`: all that all trainings have."""
        return list(episodes)

    def returned(self, match: Match[Run], pair: Pair, manner: str) -> list[float]:
        if self.runs.returns_apart:
            raise Unscored(self.runs.returns_apart)
        payer, found = getattr(match, pair[0]), []
        for run in match.of(pair[1]):
            part = run.parts(self.runs.steps)[manner]
            value = part.returns.get(payer)
            if value is None:
                raise Unscored(_why(payer, run, part.reasons))
            found.append(value)
        return found

    def paid_beside_random(self, trainings: Sequence[Run]) -> tuple[list[float], Float]:
        reward, random = trainings[0].reward, self.runs.random
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

    def rescaling(self, match: Match[Run]) -> Rescaling | None:
        if match.baseline == match.proposed:
            return None
        return rescaling_between([run for side in match.sides for run in side], match.proposed, match.baseline)

    def same_starts(self, match: Match[Run]) -> bool:
        """See `Trainings`: as far as the first observations tell."""
        return meet_same_starts([run for side in match.sides for run in side])

    def members(self, reward: str) -> Sequence[Run]:
        return self.runs.of(reward)

    def learning(self, comparison: Comparison) -> Learning:
        """See `Trainings`: every measure and every reward over the steps of all trainings of both."""
        baseline, proposed = (
            self.learned(reward, [self.runs.members[reward, seed] for seed in seeds])
            for reward, seeds in zip((comparison.baseline, comparison.proposed), comparison.trained, strict=True)
        )
        return Learning(baseline, proposed, {name: self._random.get(name) for name in baseline.points})

    def learned(self, reward: str, members: Sequence[Run]) -> LearningCurve:
        """See `Trainings`: every measure and every reward."""
        runs = self.runs
        parts = self._evaluated(members) or [
            (end, [run.episodes.part(begin, end) for run in members]) for begin, end in stretches(runs.steps)
        ]
        points = {name: tuple(self._point(end, of, name) for end, of in parts) for name in runs.measures}
        for paid in runs.rewards:
            returns = ((end, [part.returns.get(paid) for part in of]) for end, of in parts)
            points[return_name(paid)] = tuple(mean_point(end, values) for end, values in returns)
        return LearningCurve(reward, (), points)

    def _evaluated(self, members: Sequence[Run]) -> list[tuple[int, list[Part]]]:
        """What policies did in the evaluations that all trainings have; empty if there are none before the end."""
        every = self.group.evaluate_every
        if not every or not all(run.before and run.evaluation for run in members):
            return []
        evaluated = [{it.facts.after // every * every: it.whole for it in run.before} for run in members]
        last = [run.evaluation.whole for run in members if run.evaluation]
        in_all = set.intersection(*map(set, evaluated))
        return [*((due, [of[due] for of in evaluated]) for due in sorted(in_all)), (self.runs.steps, last)]

    def _point(self, end: int, parts: Sequence[Part], measure: str) -> Point:
        values = [part.behaviour.get(measure) for part in parts]
        episodes = min(part.episodes for part in parts) if self.runs.is_flag(measure) else None
        return mean_point(end, values, episodes, self.runs.bounds(measure))

    def pay_name(self, reward: str) -> str:
        return return_name(reward)

    def ends(self, training: Run) -> Ends:
        last, part = training.episodes.last, training.episodes.part
        count = min(part_of(len(last)), len(last))
        start = part(0, int(last[count - 1]) + 1) if count else part(0, 0)
        end = part(int(last[-count]), int(last[-1]) + 1) if count else start
        evaluated = training.evaluation.whole if training.evaluation else None
        acted = {} if evaluated is None else _values(evaluated, training.reward)
        episodes = (count, evaluated.episodes if evaluated else 0)
        return Ends(_values(start, training.reward), _values(end, training.reward), acted, episodes)

    def at_random(self, reward: str) -> Mapping[str, float | None]:
        return _values(self.runs.random.whole, reward) if self.runs.random else {}

    def has_terms(self, reward: str) -> bool:
        """See `Trainings`: what they paid tells."""
        return True

    def terms_paid(self, reward: str) -> list[TermsOfTraining]:
        return self.terms_beside(reward, reward)[0]

    def terms_beside(self, reward: str, trained: str) -> tuple[list[TermsOfTraining], str]:
        """See `Trainings`. All rewards have paid all recordings already."""
        found = []
        for run in self.runs.of(trained):
            evaluation = run.evaluation.recorded.terms_paid(reward) if run.evaluation else None
            found.append(TermsOfTraining(run.recorded.terms_paid(reward), evaluation))
        return found, ""

    def terms_at_random(self, reward: str) -> ByTerm | None:
        return self.runs.random.recorded.terms_paid(reward) if self.runs.random else None

    def _curve(self, payer: str, members: Sequence[Run]) -> GroupCurve:
        return stream_curve((run.paid_by(payer) for run in members), len(members), self.runs.steps, self.kind)


def _why(name: str, run: Run, reasons: Mapping[str, str]) -> str:
    """Why a reward or a measure has no value in a training."""
    return f"{name} in '{run.path}': {reasons.get(name, 'not recorded')}"


def _values(part: Part, reward: str) -> Mapping[str, float | None]:
    return {**part.behaviour, return_name(reward): part.returns.get(reward)}
