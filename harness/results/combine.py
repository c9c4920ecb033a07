"""From an experiment's records to its comparisons."""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Literal

from harness.arrays import Float
from harness.errors import Unscored
from harness.eta.behaviour_change import TRAINING, Quantity
from harness.eta.curve import GroupCurve
from harness.eta.headline import DECIDING, SUCCESS
from harness.eta.scored_sums import Pair
from harness.eta.swaps import swaps_of
from harness.measure import is_share
from harness.record.cell import Cell
from harness.record.folder import EVALUATION
from harness.registry.choice import Choice
from harness.results.compare import Match, compare
from harness.results.comparison import Comparison, Group
from harness.results.measured import DETERMINISTIC, STOCHASTIC, Measured, Moment
from harness.results.metrics import measure_of
from harness.results.mixture import Mixture, mixtures_of
from harness.results.records import Records
from harness.results.seen import Seen
from harness.results.verdicts import with_verdicts


def combine(records: Records) -> tuple[Comparison, ...]:
    """Every proposed reward against the baseline, or every two rewards, as the records ask.

    A baseline that is its own proposed reward is the null control.
    """
    asked = sorted(_asked(records), key=lambda it: it[1] == it[2].label)  # the null control comes last
    matches = [(group, _match(records, group, baseline, proposed)) for group, baseline, proposed in asked]
    swaps = swaps_of(sorted({seed for _, match in matches for of in match.seeds_of for seed in of}))
    found = [compare(_Cells(records, group), match, swaps) for group, match in matches]
    seen = Seen.of(records.manifests, records.plan.terms.looks)
    return with_verdicts(found, records.plan.terms, seen.look_of, seen.to_come)


def _asked(records: Records) -> list[tuple[Group, str, Choice]]:
    """The group, the baseline and the proposed reward of each comparison."""
    planned = dict.fromkeys(
        (Group.of(manifest.cell), manifest.cell.reward)
        for manifest in records.manifests
        if manifest.status != "skipped"
    )
    against = [
        (group, records.baseline, reward)
        for group, reward in planned
        if reward.label != records.baseline or records.plan.a_a
    ]
    if not records.pairs:
        return against
    others: dict[Group, list[Choice]] = {}
    for group, reward in planned:
        if reward.label != records.baseline:
            others.setdefault(group, []).append(reward)
    return [
        *against,
        *((group, one.label, other) for group, of in others.items() for one, other in combinations(of, 2)),
    ]


def _match(records: Records, group: Group, label: str, proposed: Choice) -> Match[Cell]:
    members = records.groups.get(group, [])
    baseline = {cell.seed: cell for cell in members if cell.reward.label == label}
    of_control = records.plan.control if label == records.baseline else {}
    control = {seed: baseline[other] for seed, other in of_control.items() if other in baseline}
    other = control if proposed.label == label else {it.seed: it for it in members if it.reward == proposed}
    of_plan = {seed: cell for seed, cell in baseline.items() if not records.is_control(cell)}
    return Match.of_seeds((label, proposed.label), of_plan, other, control)


class _Cells:
    """The cells of one group as a comparison asks about them; see `Trainings`."""

    number_of: Literal["returns", "indices"] = "indices"

    def __init__(self, records: Records, group: Group) -> None:
        self._records, self.group, self.names = records, group, tuple(records.metrics)
        self.averaged = records.plan.terms.averaged
        self.deciding = records.named[:1] or DECIDING
        shares = (name for name in self.deciding if name in records.metrics and is_share(records.metrics[name]))
        self.success = next(shares, SUCCESS)

    def decided_in(self, episodes: Mapping[str, int]) -> str:
        """See `Trainings`."""
        return ""

    def measured(self, training: Cell) -> Measured:
        """See `Trainings`."""
        return self._records.measured(training)

    def moments(self, training: Cell) -> Sequence[Moment]:
        """See `Trainings`."""
        return self._records.moments(training)

    def measure(self, name: str, manner: str, episodes: int) -> Quantity:
        """See `Trainings`."""
        manifest = self._records.manifest(self._records.groups[self.group][0])
        return measure_of(name, self._records.metrics[name], manner, episodes, manifest)

    def has_floor(self, manner: str) -> bool:
        """See `Trainings`: beside everything that metrics measured; nobody measured how random actions learn."""
        return manner in (DETERMINISTIC, STOCHASTIC, TRAINING)

    def reason(self, match: Match[Cell], name: str, manner: str) -> str:
        """See `Trainings`."""
        reasons = (self._records.measured(cell).reasons for side in match.sides for cell in side)
        return next((it[name] for it in reasons if name in it), "")

    def curve(self, match: Match[Cell], pair: Pair) -> GroupCurve:
        """See `Trainings`."""
        own, cells = match.of(pair[0])[0], match.of(pair[1])
        if pair[0] == pair[1]:
            return self._records.curve(cells)
        reward, taught = self._records.installed(own.reward), self._records.of(own)
        is_unchanged = taught.pays_recorded(reward)
        taught.finish()
        reward.require_unchanged(is_unchanged)
        return self._records.curve_paid_by(reward, cells)

    def control(self, match: Match[Cell]) -> GroupCurve | None:
        """See `Trainings`."""
        return self._records.curve(match.control) if match.control else None

    def return_manners(self, episodes: Mapping[str, int]) -> Sequence[str]:
        """See `Trainings`: the final evaluation alone."""
        return [DETERMINISTIC if self.group.deterministic else STOCHASTIC]

    def returned(self, match: Match[Cell], pair: Pair, manner: str) -> list[float]:
        """See `Trainings`: of an episode, its events left out."""
        own, found = match.of(pair[0])[0], []
        reward, taught = self._records.installed(own.reward), self._records.of(own)
        reward.require_unchanged(taught.pays_recorded(reward, EVALUATION))
        for cell in match.of(pair[1]):
            value = self._records.of(cell).evaluation_return(reward)
            self._records.of(cell).finish()
            if value is None:
                raise Unscored(f"no episode ended in the evaluation of seed {cell.seed}")
            found.append(value)
        return found

    def paid_beside_random(self, trainings: Sequence[Cell]) -> tuple[list[float], Float]:
        """See `Trainings`: of an episode, its events included, which the training maximised too."""
        first, paid = trainings[0], []
        reward, taught = self._records.installed(first.reward), self._records.of(first)
        reward.require_unchanged(taught.pays_recorded(reward, EVALUATION))
        for cell in trainings:
            value = self._records.of(cell).evaluation_paid()
            self._records.of(cell).finish()
            if value is None:
                raise Unscored(f"no episode ended in the evaluation of seed {cell.seed}")
            paid.append(value)
        return paid, self._records.floor_returns(first, reward)

    def same_steps(self, match: Match[Cell]) -> bool:
        """See `Trainings`; evaluations are read only if every measure of every seed is the same."""
        pairs = list(zip(match.of_baseline, match.of_proposed, strict=True))
        if any(self.measured(one).manners != self.measured(other).manners for one, other in pairs):
            return False
        return all(self._motion(one) == self._motion(other) for one, other in pairs)

    def _motion(self, cell: Cell) -> str:
        found = self._records.of(cell)
        motion = found.motion()
        found.finish()
        return motion

    def mixtures(self, match: Match[Cell]) -> tuple[Mixture, ...]:
        """See `Trainings`."""
        one, other = match.sides
        cells = dict.fromkeys([*one, *other, *match.control])
        return mixtures_of(map(self._records.manifest, cells))
