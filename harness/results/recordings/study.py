"""The recorded trainings of a folder, compared: a study for each algorithm and environment."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

from harness.errors import UsageError
from harness.eta.curve import Kind
from harness.eta.equal import key_to_json
from harness.eta.manner import MANNERS
from harness.eta.seed_mean import SeedMean, mean_over_seeds
from harness.eta.verdict.deals import smallest_p
from harness.record.cell import Cell
from harness.record.cell_folder import is_named
from harness.record.floor import Floor, floors_in
from harness.record.folder import RANDOM, recording_of
from harness.record.recording.recorded_training import recordings_in
from harness.record.terms import FIRST, Terms
from harness.results.compare import compare_all
from harness.results.comparison import Comparison, Group
from harness.results.metrics import require_measures
from harness.results.overview import overview_html
from harness.results.recordings.read_runs import read_runs
from harness.results.recordings.run_trainings import RunTrainings
from harness.results.recordings.runs import Runs
from harness.results.records import Records
from harness.results.verdicts import LookOf, Seen

Table = Mapping[tuple[str, str], SeedMean]
"""R_r(q) over all seeds, by (r, q): who pays, and whose trainings are paid."""


@dataclass(frozen=True, eq=False)
class Study:
    """What the recorded trainings in a folder say.

    Attributes:
        folder: Where they lie.
        trainings: The trainings.
        comparisons: Every reward that taught a policy against the first one, or against every one before it.
        tables: By manner, the full table of mean returns.
    """

    folder: Path
    trainings: RunTrainings
    comparisons: tuple[Comparison, ...]
    tables: Mapping[str, Table]

    @property
    def runs(self) -> Runs:
        """The trainings by reward and seed."""
        return self.trainings.runs

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
            "curve": self.trainings.kind,
            "notes": [*runs.said, *runs.notes],
            "damaged": list(runs.damaged),
            "equal_trainings": [[key_to_json(key) for key in keys] for keys in runs.equal],
            "rescaled": [{"reward": name, "of": other, **it.to_json()} for (name, other), it in runs.rescaled.items()],
            "comparisons": [_pair_to_json(self.trainings, comparison) for comparison in self.comparisons],
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


def studies_of_runs(
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
    trainings = [RunTrainings(runs, kind, terms.averaged) for runs in groups]
    matches = [it.matches(pairs=pairs) for it in trainings]
    asked = [(of, match) for of, matched in zip(trainings, matches, strict=True) for match in matched]
    seeds = {seed for runs in groups for _, seed in runs.members}
    family = iter(compare_all(asked, seeds, terms, look_of, to_come))
    return tuple(
        Study(folder, of, tuple(islice(family, len(matched))), _tables(of.runs))
        for of, matched in zip(trainings, matches, strict=True)
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


def _pair_to_json(trainings: RunTrainings, comparison: Comparison) -> dict[str, Any]:
    headline = {"agent" if name == "behaviour" else name: told for name, told in comparison.headline.to_json().items()}
    learning = trainings.learning(comparison) if comparison.has_trainings else None
    return {
        "baseline": comparison.baseline,
        "proposed": comparison.proposed,
        "seeds": list(comparison.seeds),
        "trained": comparison.trained_by,
        "headline": headline,
        "decided_in": comparison.answered_in,
        "deciding_measure": next(iter(comparison.measured.deciding), None),
        "returns": {manner: split.to_json() for manner, split in comparison.number.returns.items()},
        "returns_missing": dict(comparison.number.missing),
        "indices": comparison.number.decomposition and comparison.number.decomposition.to_json(),
        "behaviour": [change.to_json() for change in comparison.measured.changes],
        "episodes": dict(comparison.measured.episodes),
        "claims": comparison.answer.claims,
        "smallest_p": smallest_p(*comparison.counts) if comparison.has_trainings else None,
        "learning": learning and learning.to_json()["metrics"],
    }


class PlaceStudy(NamedTuple):
    """The study of the done cells of one algorithm in one environment."""

    group: Group
    cells: tuple[Cell, ...]
    study: Study | None
    """The study; None if there is nothing to compare."""
    reason: str
    """Why there is no study; empty if there is one."""
    notes: tuple[str, ...] = ()
    """What to know of the cells where there is no study, which else says it: a line each."""

    def __repr__(self) -> str:
        return f"<PlaceStudy of {self.title}: {len(self.cells)} cells, {self.reason or repr(self.study)}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: a line per comparison, or why there is none."""
        return f"<p>{escape(repr(self))}</p>" if self.study is None else self.study._repr_html_()

    @property
    def title(self) -> str:
        """The algorithm and the environment in which it trained."""
        return self.group.title

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        labels = {"task": self.group.task.label, "algorithm": self.group.algorithm.label, "steps": self.group.steps}
        study = self.study and self.study.to_json()
        return {**labels, "reason": self.reason, "notes": list(self.notes), "study": study}


def study_of_loose(
    folder: Path,
    runs: Runs,
    cells: Sequence[Cell],
    kind: Kind,
    shown: Sequence[str] | None = None,
    *,
    pairs: bool = False,
) -> PlaceStudy:
    """The study of recordings that lie loose.

    Args:
        folder: Where they lie.
        runs: All of them.
        cells: The same as cells.
        kind: Which curves I_N and I_P are read from; see `harness.eta.curve.GroupCurve`.
        shown: Which measures, beside the one that decides; all of them if None.
        pairs: Whether every two rewards are compared, and not each with the baseline alone.

    Raises:
        UsageError: A measure is not recorded.
    """
    if shown is not None:
        require_measures(shown, runs.measures)
        runs = runs.showing(shown)
    (study,) = studies_of_runs(folder, [runs], kind, to_come=len(runs.missing), pairs=pairs)
    return PlaceStudy(runs.group, tuple(cells), study, "")


def studies_of(results: Records, shown: Sequence[str] | None = None) -> tuple[PlaceStudy, ...]:
    """The studies of an experiment whose task is an environment. A group without a done cell is left out.

    The questions of all studies are asked together.

    Raises:
        UsageError: A measure was chosen that no environment has.
    """
    read = {group: _runs_of(results, cells, results.named) for group, cells in results.groups.items()}
    compared = {group: runs for group, runs in read.items() if not isinstance(runs, str)}
    if compared and shown is not None:
        require_measures(shown, {name for runs in compared.values() for name in runs.measures})
        compared = {group: runs.showing(shown) for group, runs in compared.items()}
    terms, runs = results.plan.terms, list(compared.values())
    seen = Seen.of(results.manifests, terms.looks)
    found = studies_of_runs(
        results.folder,
        runs,
        results.kind,
        terms,
        seen.look_of,
        seen.to_come + sum(len(it.missing) for it in runs),
        pairs=results.pairs,
    )
    studies = dict(zip(compared, found, strict=True))
    return tuple(
        PlaceStudy(group, tuple(cells), studies[group], "")
        if group in studies
        else PlaceStudy(
            group,
            tuple(cells),
            None,
            str(read[group]),
            tuple(f"{cell.title}: {note}" for cell in cells if (note := results.manifest(cell).note)),
        )
        for group, cells in results.groups.items()
    )


def _runs_of(results: Records, cells: Sequence[Cell], deciding: Sequence[str]) -> Runs | str:
    """The recorded trainings of cells; why there is nothing to compare where that is so."""
    trained, control = {cell.reward.label for cell in cells}, results.plan.control
    planned = {it.cell.reward.label for it in results.manifests if Group.of(it.cell) == Group.of(cells[0])}
    if len(trained) < 2 and not control and planned > trained:
        return f"nothing to compare: all done cells were trained with {cells[0].reward.label}"
    only = [path for cell in cells for path in _recordings_of(results, cell)]
    floor = floors_in(results.manifests, results.store).get(Floor.of(cells[0]))
    random = None if floor is None else results.store.cell_folder(floor) / recording_of(RANDOM)
    try:
        return read_runs(results.folder, only, results.baseline, deciding, Group.of(cells[0]), random, control)
    except UsageError as error:
        return str(error)


def _recordings_of(results: Records, cell: Cell) -> list[Path]:
    """Those that the cell itself left."""
    folder, done = results.store.cell_folder(cell), results.manifest(cell)
    return [path for path in sorted(recordings_in(folder)) if is_named(done, path.relative_to(folder).as_posix())]
