"""All recorded trainings of a folder, compared."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from itertools import islice
from pathlib import Path
from typing import Any

from harness.eta.curve import Kind
from harness.eta.equal import key_to_json
from harness.eta.seed_mean import SeedMean, mean_over_seeds
from harness.eta.swaps import swaps_of
from harness.eta.verdict.deals import smallest_p
from harness.record.terms import FIRST, Terms
from harness.results.comparison import Comparison
from harness.results.overview import overview_html
from harness.results.recordings.compare import compare_runs
from harness.results.recordings.learning import learning_of
from harness.results.recordings.runs import MANNERS, Runs
from harness.results.verdicts import LookOf, with_verdicts

Table = Mapping[tuple[str, str], SeedMean]
"""R_r(q) over all seeds, by (r, q): who pays, and whose trainings are paid."""


@dataclass(frozen=True, eq=False)
class Study:
    """What the recorded trainings in a folder say.

    Attributes:
        folder: Where they lie.
        runs: The trainings.
        comparisons: Every reward that taught a policy against the first one, or against every one before it.
        tables: By manner, the full table of mean returns.
        kind: Which curves I_N and I_P are read from.
    """

    folder: Path
    runs: Runs
    comparisons: tuple[Comparison, ...]
    tables: Mapping[str, Table]
    kind: Kind

    def __repr__(self) -> str:
        trainings, comparisons = len(self.runs.members), len(self.comparisons)
        return f"<Study of '{self.folder}': {trainings} trainings, {comparisons} comparisons>"

    def _repr_html_(self) -> str:
        """What a notebook shows: a line per comparison."""
        return overview_html(self.comparisons) + f"<p>{escape(repr(self))}</p>"

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        runs = self.runs
        return {
            "env": runs.env,
            "rewards": list(runs.rewards),
            "trained": list(runs.trained),
            "steps": runs.steps,
            "curve": self.kind,
            "notes": [*runs.said, *runs.notes],
            "damaged": list(runs.damaged),
            "equal_trainings": [[key_to_json(key) for key in keys] for keys in runs.equal],
            "rescaled": [{"reward": name, "of": other, **it.to_json()} for (name, other), it in runs.rescaled.items()],
            "comparisons": [_pair_to_json(runs, comparison) for comparison in self.comparisons],
            "returns": {
                manner: [
                    {"paid_by": payer, "trained_by": trained, **mean.to_json()}
                    for (payer, trained), mean in table.items()
                ]
                for manner, table in self.tables.items()
            },
            "trainings": [
                {
                    "folder": run.path.relative_to(self.folder).as_posix(),
                    "trained_by": run.reward,
                    "seed": run.seed,
                    "steps": run.steps,
                    "parts": {manner: part._asdict() for manner, part in run.parts(runs.steps).items()},
                }
                for run in runs.members.values()
            ],
        }


def compare_all(
    folder: Path,
    groups: Sequence[Runs],
    kind: Kind,
    terms: Terms = FIRST,
    look_of: LookOf | None = None,
    to_come: int = 0,
    *,
    pairs: bool = False,
) -> tuple[Study, ...]:
    """A study of each group of trainings. Their questions are asked together, and all hints are one family.

    Args:
        folder: Where all of them lie.
        groups: Trainings that are compared within their group alone.
        kind: Which curves I_N and I_P are read from; see `harness.eta.curve.GroupCurve`.
        terms: What was agreed on before the first training.
        look_of: In an experiment with looks: tells them.
        to_come: How many planned trainings have not ended yet.
        pairs: Whether every two rewards are compared, and not each with the baseline alone.
    """
    swaps = swaps_of(sorted({seed for runs in groups for _, seed in runs.members}))
    found = [
        [compare_runs(runs, *pair, swaps, kind, terms.averaged) for pair in runs.compared(pairs=pairs)]
        for runs in groups
    ]
    family = iter(with_verdicts([it for comparisons in found for it in comparisons], terms, look_of, to_come))
    return tuple(
        Study(folder, runs, tuple(islice(family, len(comparisons))), _tables(runs), kind)
        for runs, comparisons in zip(groups, found, strict=True)
    )


def _tables(runs: Runs) -> dict[str, Table]:
    parts = {key: run.parts(runs.steps) for key, run in runs.members.items()}
    there = [manner for manner in MANNERS if any(manner in found for found in parts.values())]
    return {
        manner: {
            (payer, trained): _mean(runs, parts, manner, payer, trained)
            for payer in runs.rewards
            for trained in runs.trained
        }
        for manner in there
    }


def _mean(runs: Runs, parts: Mapping[tuple[str, int], Any], manner: str, payer: str, trained: str) -> SeedMean:
    members = [found[manner] for (name, _), found in parts.items() if name == trained and manner in found]
    known = [part.returns[payer] for part in members if part.returns.get(payer) is not None]
    seeds = len(runs.of(trained))
    reasons = (part.reasons.get(payer, "not recorded") for part in members if part.returns.get(payer) is None)
    why = next(reasons, "not recorded")
    return mean_over_seeds(
        known, f"{seeds - len(known)} of {seeds} seeds have none: {why}" if len(known) < seeds else None
    )


def _pair_to_json(runs: Runs, comparison: Comparison) -> dict[str, Any]:
    headline = {"agent" if name == "behaviour" else name: told for name, told in comparison.headline.to_json().items()}
    learning = learning_of(runs, comparison)
    return {
        "baseline": comparison.baseline,
        "proposed": comparison.proposed,
        "seeds": list(comparison.seeds),
        "trained": comparison.trained_by,
        "headline": headline,
        "decided_in": comparison.answered_in,
        "deciding_measure": next(iter(comparison.deciding), None),
        "returns": {manner: split.to_json() for manner, split in comparison.returns.items()},
        "returns_missing": dict(comparison.missing),
        "indices": comparison.decomposition and comparison.decomposition.to_json(),
        "behaviour": [change.to_json() for change in comparison.changes],
        "episodes": dict(comparison.episodes),
        "claims": comparison.claims,
        "smallest_p": smallest_p(*comparison.counts) if comparison.has_trainings else None,
        "learning": learning and learning.to_json()["metrics"],
    }
