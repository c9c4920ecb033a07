"""The rewards of an arm's experiment beside one another: what its policies did, and what each reward pays for it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from harness import load_results
from harness.cli.output import audits_of
from harness.errors import Unscored, UsageError
from harness.eta.headline import SUCCESS
from harness.log import Log, LogFacts, in_memory
from harness.log.log import REWARD, START
from harness.record import TRACE, Cell, read_trace
from harness.registry import Choice
from harness.results.cell_results import CellResults
from harness.results.logs.told import Told
from harness.results.metrics import measure_of
from harness.results.recordings.episodes import Episodes, Part, count_text
from harness.results.traces import Traces
from harness.reward.steps import ENDS
from harness.score.installed_reward import InstalledReward

from ..audit import Audit
from ..questions import NO_FORMS, NOT_RANKED, on_best
from ..subject import Answered, Asked
from .earned import RANDOM, Earned, earned_by
from .pair import pairs_in
from .pair_grid import SCALE
from .recordings import audit_recordings, chosen_rewards, held_back, title_of

KEYS = ["env", "episode", "step", *ENDS]


def audit_experiment(results: Traces, only: Sequence[str]) -> Audit:
    """How far apart rewards are in the steps of trainings, what policies did, and what each reward pays them for it.

    What policies earned includes the events of the task, which pay the same under every reward.

    Args:
        results: Of an experiment that trained an arm.
        only: Labels of the rewards that are told of; all of them if empty.

    Raises:
        UsageError: No training of it is done.
        SchemaError: A file is damaged or written by a newer version.
    """
    if not results.done_cells:
        raise UsageError(f"'{results.folder}' has nothing to audit: none of its trainings is done")
    labels = {it.cell.reward.label: it.cell.reward for it in results.manifests if it.status != "skipped"}
    rewards = chosen_rewards(labels, only, f"'{results.folder}'")
    payers, notes = _payers(results, {label: labels[label] for label in rewards})
    measures = sorted(results.measures, key=lambda name: name != SUCCESS)  # all others stay in their order
    success = SUCCESS if SUCCESS in measures else ""
    groups = [[it for it in cells if not results.is_control(it)] for cells in results.groups.values()]
    earned = [row for cells in groups for row in _earned(results, cells, payers, rewards, measures)]
    folders = {cell: results.store.cell_folder(cell) for cell in results.done_cells}
    paid = (_paid(results.run(cell), folder, payers) for cell, folder in folders.items())
    pairs, told = pairs_in(paid, tuple(payers), shows_steps=True)
    count = len(results.done_cells)
    return Audit(
        title=title_of(f"'{results.folder}'", count_text(count, "training"), rewards),
        facts={"experiment": str(results.folder), "trainings": count},
        rewards=rewards,
        pairs=pairs,
        earned=tuple(earned),
        success=success,
        verdict=tuple(on_best(earned, rewards, success)),
        measured=(f"{SCALE} Means over trainings, 95% intervals over them in brackets.",) if pairs else (),
        not_asked=(NOT_RANKED, NO_FORMS.format("a trace")),
        notes=(*notes, *told),
        damaged=tuple(f"cell {it.cell.id}: {it.reason}" for it in results.damaged),
    )


def _payers(results: Traces, labels: Mapping[str, Choice]) -> tuple[dict[str, InstalledReward], list[str]]:
    """The rewards that still pay what they paid in the experiment, and a line for each other one."""
    payers: dict[str, InstalledReward] = {}
    notes = []
    trained = {cell.reward.label: cell for cell in results.done_cells}
    for label, choice in labels.items():
        try:
            installed = (
                results.run(trained[label]).unchanged(TRACE) if label in trained else results.cells.installed(choice)
            )
            for cell in results.done_cells:
                results.run(cell).paid_by(installed)  # it is kept
            payers[label] = installed
        except Unscored as error:
            notes.append(f"What {label} pays is not known: {error}")
    return payers, notes


def _earned(
    results: Traces,
    cells: Sequence[Cell],
    payers: Mapping[str, InstalledReward],
    rewards: Sequence[str],
    names: Sequence[str],
) -> Iterable[Earned]:
    """Random actions, then the policies of each reward, all in one simulator and task."""
    first, of = cells[0], results.run(cells[0])
    measures = {it: measure_of(it, results.metrics[it], "", 1, of.manifest, of.longest).ends for it in names}
    where = f" ({first.place.label}, {first.task.label}, {first.learner})" if len(results.groups) > 1 else ""
    values = results.measured(first).random
    acted = of.floor_cell
    floor = {label: acted.floor_returns(it) for label, it in payers.items()} if acted else {}
    if any(map(len, floor.values())):
        count = len(next(iter(floor.values())))
        told: list[Part | Episodes] = [Episodes(np.arange(count), floor, {}, {}), Part(0, {}, values, {})]
        yield earned_by(f"{RANDOM}{where}", told, rewards, measures)
    for label in dict.fromkeys(cell.reward.label for cell in cells):
        parts = [_part(results.run(cell), payers) for cell in cells if cell.reward.label == label]
        yield earned_by(f"trained with {label}, evaluations{where}", parts, rewards, measures)


def _part(of: CellResults, payers: Mapping[str, InstalledReward]) -> Part:
    """The final evaluation of a cell."""
    returns: dict[str, float | None] = {}
    with of:
        for label, payer in payers.items():
            shaped, events = of.evaluation_return(payer), of.recorded_return("events")
            returns[label] = None if shaped is None or events is None else shaped + events
    return Part(next(iter(of.measured.episodes.values())), returns, of.measured.own, {})


def _paid(of: CellResults, folder: Path, payers: Mapping[str, InstalledReward]) -> tuple[str, Log]:
    """The training of a cell, paid by rewards."""
    path = folder / TRACE
    told = read_trace(path).rows(KEYS).columns
    with of:
        paid = {f"{REWARD}{label}": of.paid_by(payer) for label, payer in payers.items()}
    facts = LogFacts(path=path, format="trace")
    return f"cells/{of.cell.id}", in_memory(facts, {**told, START: told["step"] == 0, **paid})


def audited(asked: Asked) -> Answered:
    """An audit of an experiment: of an arm also what its rewards pay scripted movements; else of its recordings.

    Raises:
        UsageError: Recordings of random actions are named, and the experiment of an arm has its own.
    """
    results = load_results(asked.folder, told=Told(leave_out=asked.leave_out), registry=asked.registry)
    if not isinstance(results, Traces):
        return [audit_recordings(asked.folder, asked.random, asked.rewards, account=results.account)], ()
    if asked.random is not None:
        raise UsageError(f"--random does not go with '{asked.named}', whose own cells acted at random: leave it out")
    audit = audit_experiment(results, asked.rewards)
    scripted = dict.fromkeys(
        f"{label}: {' '.join(payoffs.verdict)}"
        for (_, _, label), payoffs in audits_of(results).items()
        if label in audit.rewards
    )
    return [held_back(replace(audit, verdict=(*audit.verdict, *scripted)), results.account)], ()
