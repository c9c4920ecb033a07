"""The trainings of one group as results ask about them, the same for traces of an arm and for recordings."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, Literal, NamedTuple, Protocol, Self, TypeVar

from harness.arrays import Float
from harness.eta.behaviour_change import Quantity
from harness.eta.curve import GroupCurve
from harness.eta.rescaling import Rescaling
from harness.eta.scored_sums import Pair
from harness.results.by_term import ByTerm
from harness.results.comparison import Comparison, Group
from harness.results.learning import Learning, LearningCurve
from harness.results.measured import Counted, Measured, Mixture, Moment


class Seeded(Protocol):
    """A training, told from the others of its reward by its seed."""

    @property
    def seed(self) -> int:
        """The seed of the training."""


Training = TypeVar("Training", bound=Seeded)


class Ends(NamedTuple):
    """What one training was paid, and what its policy did, by name."""

    start: Mapping[str, float | None]
    end: Mapping[str, float | None]
    evaluation: Mapping[str, float | None]
    episodes: tuple[int, int]
    """How many episodes start and end rest on each, and how many the evaluation."""


class TermsOfTraining(NamedTuple):
    """What the terms of one reward paid one training."""

    training: ByTerm | None
    """In the training itself; None where it is not asked for."""
    evaluation: ByTerm | None
    """In the evaluation of its final policy; None where there is none."""

    def final(self, term: str) -> float | None:
        """What a term paid an episode of the evaluation, or where there is none of the end of the training."""
        told = self.evaluation or self.training
        found = told.terms.get(term) if told else None
        return None if found is None else found.whole if self.evaluation else found.end


@dataclass(frozen=True)
class Match(Generic[Training]):
    """The trainings of one comparison, in the order of the seeds.

    Attributes:
        baseline: The label of the reward that the other one is compared with.
        proposed: The label of the other one.
        seeds: The seeds that both have; of the null control those of the baseline. What is paid is compared on them.
        of_baseline: The trainings by the baseline, of these seeds.
        of_proposed: The trainings by the other reward, of these seeds.
        control: The baseline's trainings again with other seeds, if there are some for all seeds.
        others: The trainings of each reward whose seed the other one lacks, by seed. Behaviour is compared on them too.
    """

    baseline: str
    proposed: str
    seeds: tuple[int, ...]
    of_baseline: Sequence[Training]
    of_proposed: Sequence[Training]
    control: Sequence[Training] = ()
    others: tuple[Mapping[int, Training], Mapping[int, Training]] = field(default=({}, {}))

    @classmethod
    def of_seeds(
        cls,
        names: tuple[str, str],
        baseline: Mapping[int, Training],
        proposed: Mapping[int, Training],
        control: Mapping[int, Training],
    ) -> Self:
        """Sort trainings by what both rewards have.

        Args:
            names: The labels of both rewards. Equal ones are the null control.
            baseline: The baseline's trainings, by seed.
            proposed: The other reward's.
            control: The baseline's trainings with other seeds, by the seed that they stand beside.
        """
        seeds = tuple(sorted(baseline.keys() & proposed.keys()))
        again = [control[seed] for seed in seeds if seed in control]
        alone = {seed: baseline[seed] for seed in sorted(baseline.keys() - proposed.keys())}
        others = {seed: proposed[seed] for seed in sorted(proposed.keys() - baseline.keys())}
        return cls(
            *names,
            seeds,
            [baseline[seed] for seed in seeds],
            [proposed[seed] for seed in seeds],
            again if len(again) == len(seeds) else [],
            ({}, {}) if names[0] == names[1] else (alone, others),
        )

    @property
    def sides(self) -> tuple[Sequence[Training], Sequence[Training]]:
        """All trainings of both rewards, those of the seeds that both have first."""
        alone, others = self.others
        return [*self.of_baseline, *alone.values()], [*self.of_proposed, *others.values()]

    @property
    def seeds_of(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """The seeds of `sides`."""
        alone, others = self.others
        return (*self.seeds, *alone), (*self.seeds, *others)

    @property
    def is_paired(self) -> bool:
        """Whether both rewards trained with the same seeds."""
        return not any(self.others)

    def of(self, who: str) -> Sequence[Training]:
        """The trainings of one side with the seeds that both have, ``baseline`` or ``proposed``."""
        return self.of_baseline if who == "baseline" else self.of_proposed


class Trainings(Protocol[Training]):
    """The trainings of one group, as far as results ask about them: cells of an arm, or recordings."""

    @property
    def group(self) -> Group:
        """What all of them share."""

    @property
    def names(self) -> Sequence[str]:
        """The names of the measures."""

    @property
    def deciding(self) -> tuple[str, ...]:
        """The names of the measures that decide, in this order."""

    @property
    def leading(self) -> Sequence[str]:
        """The names of the measures that are shown first."""

    @property
    def success(self) -> str:
        """The name of the share of episodes by which learning is measured; empty if there is none."""

    @property
    def averaged(self) -> int:
        """The final policy counts with the mean over so many of the last evaluations, at most."""

    @property
    def number_of(self) -> Literal["returns", "indices"]:
        """What the sentence about the number tells. Only what it tells makes a claim, besides the indices."""

    def decided_in(self, episodes: Mapping[str, int]) -> str:
        """The manner that decides; empty for that of the cells."""

    def measured(self, training: Training) -> Measured:
        """Every measure of a training, by manner."""

    def moments(self, training: Training) -> Sequence[Moment]:
        """Its evaluations, the one after the training last."""

    def measure(self, name: str, manner: str, episodes: int) -> Quantity:
        """What a measure is in the episodes of one manner, of which each seed has so many at least."""

    def has_floor(self, manner: str) -> bool:
        """Whether random actions are shown beside the episodes of a manner."""

    def reason(self, match: Match[Training], name: str, manner: str) -> str:
        """Why a measure has no value in some training; empty if it has one in all."""

    def curve(self, match: Match[Training], pair: Pair) -> GroupCurve:
        """S_r(tau_q) of one pair (r, q).

        Raises:
            Unscored: It is not known what r pays these trainings.
        """

    def control(self, match: Match[Training]) -> GroupCurve | None:
        """The curve of the baseline's trainings with other seeds."""

    def return_manners(self, episodes: Mapping[str, int]) -> Sequence[str]:
        """The manners in which mean returns are compared."""

    def returned(self, match: Match[Training], pair: Pair, manner: str) -> list[float]:
        """R_r(q) of every seed, of one pair (r, q).

        Raises:
            Unscored: It is not known.
        """

    def paid_beside_random(self, trainings: Sequence[Training]) -> tuple[list[float], Float]:
        """What one reward paid in the evaluation of each of its trainings, and what it pays random actions.

        Args:
            trainings: At least one; all by one reward.

        Returns:
            The mean return of an episode, of each training; the returns of random actions, (episodes,).

        Raises:
            Unscored: It is not known.
        """

    def same_steps(self, match: Match[Training]) -> bool:
        """Whether both rewards taught the same steps: every step of each evaluation of every seed, bit for bit."""

    def mixtures(self, match: Match[Training]) -> tuple[Mixture, ...]:
        """Plugins of which several versions were used."""

    def rescaling(self, match: Match[Training]) -> Rescaling | None:
        """What the proposed reward is, if it is the baseline but for scale and offset; None where it is not known."""

    def same_starts(self, match: Match[Training]) -> bool:
        """Whether policies met the same episodes in their evaluations, as far as that is known."""

    @property
    def counted(self) -> Mapping[str, Counted]:
        """By manner, what is counted where it is not all episodes."""

    # What each reward did

    @property
    def rewards(self) -> Sequence[str]:
        """The labels of the rewards that taught."""

    @property
    def baseline(self) -> str:
        """The label of the reward that the others are compared with; it need not be among them."""

    @property
    def is_alone(self) -> bool:
        """Whether one reward taught them, and nothing is to be compared with it."""

    def members(self, reward: str) -> Sequence[Training]:
        """The trainings by a reward, in the order of their seeds; without those of the null control."""

    def learning(self, comparison: Comparison) -> Learning:
        """The learning curves of both rewards, each of which has a training."""

    def learned(self, reward: str, members: Sequence[Training]) -> LearningCurve:
        """What trainings by a reward came to, over their steps."""

    def pay_name(self, reward: str) -> str:
        """What the pay of an episode is called in the curve."""

    def ends(self, training: Training) -> Ends:
        """What a training was paid, and what it did, at its start, at its end, and in its evaluation."""

    def at_random(self, reward: str) -> Mapping[str, float | None]:
        """What random actions come to, by measure, and what a reward pays them, by `pay_name`."""

    def has_terms(self, reward: str) -> bool:
        """Whether a reward may have terms."""

    def terms_paid(self, reward: str) -> list[TermsOfTraining]:
        """What the terms of a reward paid its own trainings."""

    def terms_beside(self, reward: str, trained: str) -> tuple[list[TermsOfTraining], str]:
        """What the terms of a reward pay another one's trainings; or why they cannot."""

    def terms_at_random(self, reward: str) -> ByTerm | None:
        """What the terms of a reward pay random actions; None where that is not known."""
