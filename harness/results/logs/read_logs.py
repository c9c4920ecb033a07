"""Turns sorted logs into the trainings of a study, which the same tests compare as recorded trainings."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from harness.arrays import Float
from harness.errors import SchemaError, UsageError
from harness.eta.amounts import listed
from harness.eta.equal import equal_sentences, equal_trainings
from harness.log import Log, LogFacts, Unit, in_memory
from harness.log.log import BEHAVIOUR, RECORDED, REWARD, SUCCESS, TIME
from harness.record.cell import BROUGHT, UNKNOWN_ALGORITHM
from harness.registry.choice import Choice
from harness.results.comparison import Group
from harness.results.logs.checks import (
    budget_notes,
    facts_notes,
    no_steps_notes,
    require_comparable,
    without_short,
)
from harness.results.logs.labels import LABELS
from harness.results.logs.told import LENGTH, RETURN, SUCCESS_DECIDES, Deciding
from harness.results.logs.trainings import Sorted, Training, digest_of
from harness.results.measured import EVALUATION
from harness.results.recordings.episodes import require_ends
from harness.results.recordings.recording_results import NOTHING_ALIKE
from harness.results.recordings.runs import LAST, NO_NAME, TRAINING, Run, Runs, run_of

OWN_ALONE = (
    "each reward paid its own trainings alone, and returns of two rewards are not comparable: every reward has its own "
    "scale"
)


def runs_of(found: Sorted, deciding: Deciding = SUCCESS_DECIDES, *, is_told: bool = False) -> Runs:
    """Sorted trainings that can be compared.

    Args:
        found: The trainings.
        deciding: What decides; ``success`` where it is told, if the user says nothing.
        is_told: Whether the user said which trainings there are.

    Raises:
        UsageError: They cannot be compared, or the measure is not told.
        SchemaError: A log is damaged.
    """
    require_comparable(found, is_told=is_told)
    found = without_short(found)
    trainings = found.trainings
    for training in trainings:
        require_ends(training.logs[0])
    logs = [log for it in trainings for log in it.all_logs]
    lower = {name for log in logs for name in log.facts.lower_is_better}
    told = list(dict.fromkeys(name for log in logs for name in log.measures))
    measures = _measures(told, lower, deciding)
    runs, steps, axis = read_trainings(trainings, measures)
    members = {(run.reward, run.seed): run for run in runs}
    every, episodes = _rhythm(runs)
    equal = equal_trainings({key: run.likeness.digest for key, run in members.items()})
    rewards = tuple(dict.fromkeys(name for name in (*found.rewards, *(it for run in runs for it in run.facts.rewards))))
    return Runs(
        _group(trainings, min(steps), every, episodes),
        rewards,
        found.rewards,
        measures,
        frozenset(lower - {deciding.name} | ({deciding.name} if deciding.better == "lower" else set())),
        members,
        min(steps),
        no_steps_notes(logs),
        (),
        equal,
        {},
        said=(
            found.sentence + _deciding_text(measures, told, trainings),
            *found.notes,
            *facts_notes([log for log in logs if log.facts.format != LABELS]),
            *budget_notes(trainings, steps, axis.noun),
            *_final_notes(runs, min(steps), axis.noun),
            *equal_sentences(equal),
        ),
        counted=_counted(trainings),
        returns_apart="" if _share_pay(runs) else OWN_ALONE,
    )


def read_trainings(trainings: Sequence[Training], measures: Sequence[str]) -> tuple[list[Run], list[int], "Axis"]:
    """Each training with its evaluations up to the end of the shortest, and how long each was, counted in what.

    Raises:
        SchemaError: A log is damaged.
    """
    axis = _axis_of(trainings)
    steps = [_steps(it, axis) for it in trainings]
    return [_run(it, of, min(steps), measures, axis) for it, of in zip(trainings, steps, strict=True)], steps, axis


def _counted(trainings: Sequence[Training]) -> dict[str, str]:
    """The manners in which points of a curve stand for episodes."""
    trained = {log.facts.unit for it in trainings for log in it.logs if not it.is_evaluated_alone}
    evaluated = {log.facts.unit for it in trainings if (log := it.evaluated) is not None}
    manners = [*((TRAINING, LAST) if "point" in trained else ()), *([EVALUATION] if "point" in evaluated else [])]
    return dict.fromkeys(manners, "point")


def _share_pay(runs: Sequence[Run]) -> bool:
    """Whether every reward that taught some training is known to have paid all of them."""
    unknown = np.array([np.nan])
    taught = {run.reward for run in runs}
    return all(not np.isnan(run.episodes.returns.get(name, unknown)).any() for run in runs for name in taught)


def _final_notes(runs: Sequence[Run], shortest: int, noun: str) -> list[str]:
    """After how much training the policies were evaluated that count as final, where it was before the end."""
    ends = sorted({run.evaluation.facts.after for run in runs if run.evaluation is not None} - {shortest})
    if not ends:
        return []
    return [f"As final count policies after {listed([f'{it:,}' for it in ends])} {noun}, which were evaluated last"]


def _deciding_text(measures: Sequence[str], told: Sequence[str], trainings: Sequence[Training]) -> str:
    others = [f"`{name}`" for name in told if name not in measures]
    more = f". The logs tell {listed(others)} too: --measure NAME:better=lower lets one decide" if others else ""
    if not measures:
        return (
            "; only returns are told, and returns of two rewards are not comparable. --labels FILE says which "
            f"trainings succeeded, --measure length:better=lower lets the length of episodes decide{more}"
        )
    first, count = measures[0], len(trainings)
    lacking = sum(not any(f"{BEHAVIOUR}{first}" in log for log in it.all_logs) for it in trainings)
    without = f", which {lacking} of {count} trainings do not tell" if lacking and first == SUCCESS else ""
    return f"; {first} decides{without}{more}"


def _measures(told: Sequence[str], lower: Collection[str], deciding: Deciding) -> tuple[str, ...]:
    """The names of the measures of which it is known which values are better; the one that decides first."""
    known = [name for name in told if name == SUCCESS or name in lower]
    known.sort(key=lambda name: name != SUCCESS)
    if not deciding.name:
        return tuple(known) if SUCCESS in known else ()
    named = deciding.name
    if named not in (*told, RETURN, LENGTH):
        raise UsageError(f"--measure {named}: the logs tell {', '.join([*told, RETURN, LENGTH])}")
    if named not in (*known, RETURN) and not deciding.better:
        raise UsageError(f"--measure {named}: say which is better, --measure {named}:better=lower or better=higher")
    return tuple(dict.fromkeys([named, *known]))


def _group(trainings: Sequence[Training], steps: int, every: int, episodes: int) -> Group:
    env = next((it.logs[0].facts.env for it in trainings if it.logs[0].facts.env), NO_NAME)
    algorithms = {it.logs[0].facts.algorithm for it in trainings}
    name = algorithms.pop() if len(algorithms) == 1 else ""
    algorithm = Choice(name, (), name) if name else UNKNOWN_ALGORITHM
    return Group(
        BROUGHT.robot,
        Choice(env, (), env),
        algorithm,
        steps,
        episodes,
        evaluate_every=every,
        simulator=BROUGHT.simulator,
    )


# One training


class Axis(NamedTuple):
    """What a training's length is counted in."""

    column: str
    """The column that tells it; empty where rows are counted."""
    noun: str
    is_summed: bool = False
    """Whether the column tells it of each row alone."""


AXES = (Axis("time", "steps"), Axis(LENGTH, "steps", is_summed=True), Axis("iteration", "iterations"))


def _axis_of(trainings: Sequence[Training]) -> Axis:
    """The first of these that all logs tell; else their rows."""
    logs = [log for it in trainings for log in it.logs]
    unit = logs[0].facts.unit
    usable = AXES if unit == "episode" else [axis for axis in AXES if not axis.is_summed]
    return next((axis for axis in usable if all(axis.column in log for log in logs)), Axis("", f"{unit}s"))


def _steps(training: Training, axis: Axis) -> int:
    """How long it was, over all of its environments.

    An episode that had not ended has no row: a policy that was evaluated later than that was trained for longer.
    """
    rows = int(max(_ends(log, axis)[-1] for log in training.logs)) * len(training.logs)
    evaluated = training.evaluation
    if evaluated is None or not axis.column or axis.is_summed or axis.column not in evaluated:
        return rows
    return max(rows, int(_ends(evaluated, axis)[-1]))


def _ends(log: Log, axis: Axis) -> Float:
    """How much of the training was done when each row ended, (rows,)."""
    if not axis.column:
        return np.arange(1.0, len(log) + 1)
    told: Float = np.asarray(log[axis.column], np.float64)
    ends: Float = np.cumsum(told) if axis.is_summed else told
    if not np.isfinite(ends).all() or (np.diff(ends) < 0).any():
        raise SchemaError(f"{log.facts.path}: its rows are not in the order of their {axis.noun}")
    return ends


def _run(training: Training, steps: int, until: int, measures: Sequence[str], axis: Axis) -> Run:
    """A training of so many steps with its evaluations, of which those after `until` are left out."""
    if training.logs[0].facts.unit == "step":
        return run_of(_named_after(training, training.logs[0]))
    whole = in_memory(_facts(training, training.path), _joined(training, axis, measures))
    evaluated = training.evaluated
    if training.is_evaluated_alone:
        whole = in_memory(whole.facts, {name: values[:0] for name, values in whole.rows().columns.items()})
    run = replace(run_of(whole), steps=steps, likeness=replace(NOTHING_ALIKE, digest=digest_of(training.logs)))
    found = [] if evaluated is None else _evaluations(training, evaluated, measures, axis, min(steps, until))
    return replace(run, evaluation=found[-1], before=tuple(found[:-1])) if found else run


def _evaluations(training: Training, log: Log, measures: Sequence[str], axis: Axis, until: int) -> list[Run]:
    """What policies did in each evaluation up to a step of the training, in order."""
    if log.facts.format == LABELS:
        ends = np.full(len(log), float(until))
    elif axis.column in log:
        ends = _ends(log, axis)
    else:
        raise UsageError(f"'{log.facts.path}' does not tell the {axis.noun} at which it evaluated: move it elsewhere")
    columns = _columns(training, log, ends, measures)
    runs = []
    for after in np.unique(columns[TIME][columns[TIME] <= until]):
        rows = {name: values[columns[TIME] == after] for name, values in columns.items()}
        rows[TIME] = np.arange(1.0, len(rows[TIME]) + 1)
        run = run_of(in_memory(replace(_facts(training, log.facts.path), evaluation=True), rows))
        runs.append(replace(run, facts=replace(run.facts, after=int(after))))
    return runs


def _named_after(training: Training, log: Log) -> Log:
    return replace(log, facts=replace(log.facts, trained_with=training.reward, seed=training.seed))


def _facts(training: Training, path: Path) -> LogFacts:
    facts = training.logs[0].facts
    unit: Unit = "point" if facts.unit == "point" else "episode"
    return LogFacts(
        path=path,
        format=facts.format,
        unit=unit,
        run=facts.run,
        trained_with=training.reward,
        seed=training.seed,
        env=facts.env,
        bounds=facts.bounds,
    )


def _joined(training: Training, axis: Axis, measures: Sequence[str]) -> dict[str, Float]:
    """The rows of all logs of one training in the order in which they ended; environments of a batch step together."""
    parts = [_columns(training, log, _ends(log, axis) * len(training.logs), measures) for log in training.logs]
    whole = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    order = np.argsort(whole[TIME], kind="stable")
    return {name: values[order] for name, values in whole.items()}


def _columns(training: Training, log: Log, ends: Float, measures: Sequence[str]) -> dict[str, Float]:
    """The numbers of a log under the names of the study; NaN of what decides and is not told.

    A row before the first step, such as a first point at 0, counts as one of the first.
    """
    unknown = np.full(len(ends), np.nan)
    found: dict[str, Float] = {TIME: np.maximum(ends, 1.0), f"{REWARD}{training.reward}": unknown}
    for name in log.rewards:
        own = training.reward if name == RECORDED else name
        found[f"{REWARD}{own}"] = np.asarray(log[f"{REWARD}{name}"], np.float64)
    for name in measures:
        other = {RETURN: f"{REWARD}{RECORDED}", LENGTH: LENGTH}.get(name, "")
        column = f"{BEHAVIOUR}{name}" if f"{BEHAVIOUR}{name}" in log else other
        found[f"{BEHAVIOUR}{name}"] = np.asarray(log[column], np.float64) if column in log else unknown
    return found


def _rhythm(runs: Sequence[Run]) -> tuple[int, int]:
    """After how many steps policies were evaluated, if that is the same in all trainings; and how many episodes."""
    times = {tuple(it.facts.after for it in (*run.before, run.evaluation) if it is not None) for run in runs}
    episodes = min((len(run.evaluation.episodes.last) for run in runs if run.evaluation), default=0)
    if len(times) != 1:
        return 0, episodes
    (of,) = times
    gaps = {*np.diff([0, *of]).tolist()}
    return (int(gaps.pop()), episodes) if len(gaps) == 1 and len(of) > 1 else (0, episodes)
