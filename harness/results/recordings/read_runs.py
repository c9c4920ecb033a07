"""Reads the recorded trainings below a folder, finds out what makes them one study, and what to keep in mind of it."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from types import MappingProxyType
from typing import Any

from harness.errors import SchemaError, UsageError
from harness.eta.equal import equal_sentences, equal_trainings
from harness.eta.laws import Account, Missing, counted, shortfall_beside
from harness.eta.manner import ACTED_AT_RANDOM, DETERMINISTIC, OWN_AND_OTHER
from harness.record.cell import UNKNOWN_ALGORITHM
from harness.record.plan_file import PLAN
from harness.record.recording.facts import OWN_SOURCE, TrainingFacts
from harness.record.recording.recorded_training import facts_name, recordings_in, weights_of
from harness.record.store import MOST_NAMED
from harness.results.comparison import Group
from harness.results.logs.told import FOUND_OUT, Told
from harness.results.recordings.episodes import count_text, cut_notes, cut_text
from harness.results.recordings.recording_results import RecordingResults
from harness.results.recordings.runs import (
    NO_NAME,
    Directions,
    Run,
    Runs,
    brought,
    meet_same_starts,
    rescaling_between,
)
from harness.text import command_text

UNLIKE_STARTS = (
    "The policies did not meet the same starts: the first observations of their evaluations differ, so that luck with "
    "the starts is part of every difference. An env has to draw everything random from the generator that reset(seed) "
    "seeds, and every evaluation has to begin with the same seed"
)
GOES_ON = "it is still going on, or was killed"


def _length_notes(runs: Collection[Run]) -> list[str]:
    told = cut_notes({f"'{run.path}'": run.steps for run in runs})
    late = ["Evaluations are of policies at the end of their trainings, which were not of one length"]
    return [*told, *(late if told and any(run.evaluation for run in runs) else [])]


def _end_notes(trained: Sequence[str], members: Mapping[tuple[str, int], Run]) -> list[str]:
    """Trainings in which no episode ended, and evaluations whose episodes were cut, for each reward that trained."""
    notes = []
    for reward in trained:
        runs = [run for (name, _), run in members.items() if name == reward]
        unended = sum(not len(run.episodes.last) for run in runs)
        if unended:
            told = f"No episode ended in {unended} of {count_text(len(runs), 'training')} by {reward}"
            notes.append(f"{told}: give the environment a time limit")
        evaluations: dict[int, list[Run]] = {}
        for evaluation in (run.evaluation for run in runs if run.evaluation is not None):
            evaluations.setdefault(evaluation.facts.horizon, []).append(evaluation)
        for horizon, some in evaluations.items():
            cut = sum(it.facts.cut for it in some)
            if cut:
                told = cut_text(cut, sum(len(it.episodes.last) for it in some), horizon)
                notes.append(f"Policies trained by {reward}: {told}")
    return notes


def _code_notes(runs: Iterable[Run]) -> list[str]:
    """Rewards and measures that have one name and are not the same."""
    found: dict[str, dict[str, Path]] = {}
    for run in runs:
        for column, source in run.facts.sources.items():
            if source.text and source.text != OWN_SOURCE:
                found.setdefault(column, {}).setdefault(source.text, run.path)
    return [
        f"The code of {column.replace('/', ' ', 1)} is not the same in '{paths[0]}' and '{paths[1]}': its numbers may "
        "not be comparable"
        for column, of in found.items()
        if len(paths := list(of.values())) > 1
    ]


def _bounds_notes(runs: Iterable[Run]) -> list[str]:
    """Measures that left the bounds that their recordings name."""
    left = {
        name: (run.path, bounds)
        for run in runs
        for name, bounds in run.facts.bounds.items()
        if not run.episodes.is_within(name, bounds)
    }
    return [
        f"{name} leaves its bounds, {low:g} to {high:g}, in '{path}': its intervals are not cut to them"
        for name, (path, (low, high)) in left.items()
    ]


def has_recordings(folder: Path) -> bool:
    """Whether a recorded training lies somewhere in a folder."""
    return next(recordings_in(folder), None) is not None


def read_runs(
    folder: Path,
    only: Sequence[Path] | None = None,
    deciding: Sequence[str] = (),
    group: Group | None = None,
    random: Path | None = None,
    control: Mapping[int, int] = MappingProxyType({}),
    told: Told = FOUND_OUT,
) -> Runs:
    """All recorded trainings and evaluations in a folder, at any depth, sorted into what is compared and what is not.

    Args:
        folder: Where they lie.
        only: Of these folders in it, and not at any depth; None for all.
        deciding: Measures that come before the others, the one that decides first.
        group: What the trainings share, if they are known to be of one group of cells.
        random: The recording of random actions in the same env, if it lies somewhere else.
        control: By each seed the other seed that the baseline was trained with again, for the null control.
        told: What the user says: the reward that the others are compared with, by default the one that was given first;
            the trainings that are left out; and which values of the measure that decides are better.

    Raises:
        UsageError: There are none, they are of several envs, two have the same reward and seed, or none has all of its
            steps.
    """
    everything, damaged = read_all(folder, only)
    if not everything:
        unread = f" Damaged: {'; '.join(it.why for it in damaged)}" if damaged else ""
        raise UsageError(f"'{folder}' holds no recorded training: harness.RecordRewards makes one.{unread}")
    at_random = _read(folder, random, _weighed([it.path for it in everything])) if random else None
    env, env_notes = env_of(folder, everything) if group is None else (group.task.label, [])
    account, whole, short = account_of_runs(everything, damaged, told.leave_out)
    seeds, seed_notes = _with_seeds([it for it in whole if not it.facts.evaluation])
    evaluated = [it for it in whole if it.facts.evaluation]
    evaluations, evaluation_notes = _evaluations(folder, evaluated, seeds, group is None or group.deterministic)
    members = {key: replace(run, **evaluations.get(key, {})) for key, run in _by_key(seeds).items()}
    others = {other: seed for seed, other in control.items() if other not in control}
    again = {others[key[1]]: members.pop(key) for key in list(members) if key[0] == told.baseline and key[1] in others}
    named = _in_order(run.facts.rewards for run in members.values())
    rewards = tuple(sorted(named, key=lambda name: name != told.baseline))  # all others stay in their order
    trained = tuple(name for name in rewards if any(name == reward for reward, _ in members))
    if not trained:
        why = "".join(f". {line}" for line in account.lines[:MOST_NAMED])
        raise UsageError(f"'{folder}' has nothing to report: no training in it has a step, or all of its steps{why}")
    shortest = min(run.steps for run in members.values())
    notes = [*account.lines, *short, *env_notes, *seed_notes, *evaluation_notes]
    notes += [*_length_notes(members.values()), *([] if meet_same_starts(members.values()) else [UNLIKE_STARTS])]
    notes += [*_end_notes(trained, members), *_code_notes(everything), *_bounds_notes(everything)]
    equal = equal_trainings({key: run.likeness.digest for key, run in members.items()})
    notes += [*equal_sentences(equal), *_rescaled_notes(rewards, members.values())]
    notes += [f"{run.path}: {run.facts.paid_otherwise}" for run in members.values() if run.facts.paid_otherwise]
    notes += _told_notes(everything)
    at_random = at_random or next((it for it in evaluated if it.facts.acted == ACTED_AT_RANDOM), None)
    return Runs(
        group or brought(env, UNKNOWN_ALGORITHM, shortest),
        rewards,
        trained,
        _in_order([deciding, *(run.facts.behaviour for run in members.values())]),
        Directions.of([run.facts for run in members.values()], told.deciding),
        members,
        shortest,
        tuple(notes),
        tuple(it.why for it in damaged if it in account.missing),
        at_random,
        again,
        missing=account.missing,
    )


def _told_notes(runs: Iterable[Run]) -> list[str]:
    """What recorders told of rewards, measures and wrappers; once, though every recording may say it with its step."""
    told: dict[str, str] = {}
    for run in runs:
        for line in run.facts.notes:
            told.setdefault(line.partition(",")[0], f"{run.path}: {line}")
    return [*told.values()]


def _rescaled_notes(rewards: Sequence[str], runs: Collection[Run]) -> list[str]:
    """For each reward the first one before it that it is but for scale and offset."""
    found: dict[str, str] = {}
    for other, name in combinations(rewards, 2):
        rescaling = rescaling_between(runs, name, other)
        if rescaling is not None:
            found.setdefault(name, rescaling.sentence(name, other))
    return [*found.values()]


def read_all(folder: Path, only: Sequence[Path] | None = None) -> tuple[list[Run], list[Missing]]:
    """Every recording in a folder, at any depth, evaluations too, by its path; and what could not be read.

    The seed of one that was recorded without is -1. With `only` it reads these folders alone.

    Raises:
        UsageError: Whole experiments lie among them.
    """
    inside = sorted(path.parent for path in folder.rglob(PLAN) if path.parent != folder) if only is None else []
    if inside:  # each has a plan of its own, and perhaps an arm's cells
        named = ", ".join(f"'{path}'" for path in inside[:MOST_NAMED])
        raise UsageError(
            f"'{folder}' holds whole experiments, not only recorded trainings: {named}. "
            "Name an experiment itself, and move recordings that belong to none into a folder of their own"
        )
    runs, damaged = [], []
    paths = sorted(recordings_in(folder)) if only is None else only
    weighed = _weighed(paths)
    for path in paths:
        try:
            runs.append(_read(folder, path, weighed))
        except SchemaError as error:
            damaged.append(Missing(path, str(error)))
    paid = {(run.reward, run.seed) for run in runs if run.facts.pay}
    return [run if (run.reward, run.seed) in paid else _without_mistaken(run) for run in runs], damaged


def account_of_runs(
    runs: Sequence[Run], damaged: Iterable[Missing] = (), leave_out: Collection[Path] = ()
) -> tuple[Account[Run], list[Run], list[str]]:
    """Which trainings count, then the same with the evaluations that count, then lines on those that others replace.

    A training is missing with its evaluation. One that was repeated with the same seed is no outcome of its own.

    Args:
        runs: Trainings and evaluations.
        damaged: Those that could not be read.
        leave_out: What the user leaves out.

    Raises:
        UsageError: Nothing lies at one of these.
    """
    why = {run: why_short(run) for run in runs}
    trainings = [run for run in runs if not run.facts.evaluation]
    untold = [it for it in trainings if not (why[it] or it.facts.asked > 0)]
    why |= shortfall_beside({it: (it.reward, it.steps, len(it.episodes.last)) for it in untold}, "steps")
    whole = {_place(run): run for run in runs if not why[run]}
    replaced = [run for run in runs if why[run] and (_place(run) in whole or run.facts.acted == ACTED_AT_RANDOM)]
    lines = [f"'{run.path}' is left out: {why[run]}" for run in replaced]
    begun = [run for run in trainings if run not in replaced]
    by_key, by_path = {(run.reward, run.seed): run for run in begun}, {run.path: run for run in begun}
    evaluations = [it for it in runs if it.facts.evaluation and why[it] and it not in replaced]
    parts = [(by_key.get((it.reward, it.seed)), Missing(it.path, why[it])) for it in evaluations]
    parts += [(by_path.get(it.path.parent), it) for it in damaged]
    for home, part in parts:
        if home is not None:
            why[home] = why[home] or f"its evaluation '{part.path}': {part.why}"
    lone = [part for home, part in parts if home is None]
    account = counted([*((run, run.path, why[run]) for run in begun), *((None, *it) for it in lone)], leave_out)
    out = {(run.reward, run.seed) for run in begun} - {(run.reward, run.seed) for run in account.whole}
    kept = [
        it for it in runs if it.facts.evaluation and not why[it] and (it.seed < 0 or (it.reward, it.seed) not in out)
    ]
    return account, [*account.whole, *kept], lines


def why_short(run: Run) -> str:
    """Why a recording is not whole by what it says of itself; empty if it is."""
    facts = run.facts
    if run.shortfall:
        return f"it has {run.shortfall}. {'It ended early' if facts.closed else GOES_ON.capitalize()}"
    if not run.steps:
        return "it has no steps"
    return "" if facts.closed or facts.asked or facts.episodes_asked else GOES_ON


def _place(run: Run) -> tuple[object, ...]:
    """What a repetition has in common with the run that it replaces."""
    facts = run.facts
    return (
        facts.evaluation,
        run.reward,
        run.seed if run.seed >= 0 else run.path,
        facts.after,
        facts.acted or DETERMINISTIC,
    )


def _weighed(paths: Sequence[Path]) -> list[str]:
    """The rewards with weights of their terms that some of the recordings were trained with."""
    found: dict[str, None] = {}
    for path in paths:
        with suppress(SchemaError):  # the next reader says so
            label = TrainingFacts.read(path / facts_name(0)).trained_with
            found |= {label: None} if weights_of(label)[1] else {}
    return [*found]


def _read(folder: Path, path: Path, weighed: Sequence[str] = ()) -> Run:
    recorded = RecordingResults(folder, path, weighed)
    facts = recorded.facts
    seed = -1 if facts.seed is None else facts.seed
    run = Run(recorded, facts, seed, recorded.steps, recorded.episodes, recorded.likeness)
    recorded.keep()
    return run


def _without_mistaken(run: Run) -> Run:
    """The same without rewards recorded as what the env pays where the env paid the reward that taught instead.

    Under their names other recordings have another reward. Where the recorder paid the learner, the env itself pays the
    same whatever taught.
    """
    paid = f"recorded as what the env pays, and that was {run.reward} here"
    for name, other in run.likeness.paid_alike:
        if other == run.reward:
            run = replace(run, episodes=run.episodes.without(name, paid))
    return run


def env_of(folder: Path, runs: Sequence[Run]) -> tuple[str, list[str]]:
    """The id of the one env of all, and notes.

    Raises:
        UsageError: There are several.
    """
    names: dict[str, Path] = {}
    for run in runs:
        names.setdefault(run.facts.env or NO_NAME, run.path)
    if len(names) > 1:
        told = ", ".join(f"{name} ('{path}')" for name, path in names.items())
        raise UsageError(f"'{folder}' mixes trainings in several envs: {told}. Name a folder of one env")
    given = {str(run.facts.spec.get("kwargs") or {}) for run in runs}
    notes = [f"The env was made with different arguments: {' and '.join(sorted(given))}"] if len(given) > 1 else []
    return next(iter(names)), notes


def _with_seeds(runs: Sequence[Run]) -> tuple[list[Run], list[str]]:
    """Whoever has no seed gets the lowest number that is free: any pairs do that do not depend on what came out."""
    taken, found = {(run.reward, run.seed) for run in runs}, []
    for run in runs:
        free = next(it for it in range(len(runs) + 1) if (run.reward, it) not in taken)
        found.append(replace(run, seed=free if run.seed < 0 else run.seed))
        taken.add((run.reward, found[-1].seed))
    numbered = sum(run.seed < 0 for run in runs)
    told = f"{count_text(numbered, 'training')} recorded without a seed: numbered in the order of their folders"
    return found, [told] if numbered else []


def _by_key(runs: Iterable[Run]) -> dict[tuple[str, int], Run]:
    found: dict[tuple[str, int], Run] = {}
    for run in runs:
        other = found.setdefault((run.reward, run.seed), run)
        if other is not run:
            raise UsageError(
                f"'{other.path.name}' was trained with {run.reward} and seed {run.seed} too: "
                f"give each a seed of its own, or leave one out, {command_text('--leave-out', run.path)}"
            )
    return found


def _keyed(runs: Iterable[Run]) -> dict[tuple[str, int], Run]:
    """Evaluations of one kind by reward and seed; those without a seed are numbered."""
    return _by_key(_with_seeds(list(runs))[0])


def _evaluations(
    folder: Path, runs: Sequence[Run], trainings: Sequence[Run], deterministic: bool
) -> tuple[dict[tuple[str, int], dict[str, Any]], list[str]]:
    """By reward and seed of the trainings: the fields of `Run` that their evaluations fill; and notes.

    Args:
        folder: Where they lie.
        runs: All evaluations, those of random actions too.
        trainings: The trainings.
        deterministic: How policies act in the evaluations that decide.
    """
    _, other = OWN_AND_OTHER[deterministic]
    by_policies = [run for run in runs if run.facts.acted != ACTED_AT_RANDOM]
    final = [run for run in by_policies if not run.facts.after]
    own = _keyed(run for run in final if run.facts.acted != other)
    others = _keyed(run for run in final if run.facts.acted == other)
    steps = sorted({run.facts.after for run in by_policies if run.facts.after})
    early = [_keyed(run for run in by_policies if run.facts.after == after) for after in steps]
    found = {**others, **own}  # where only the other manner was recorded, it decides
    known = {(run.reward, run.seed) for run in trainings}
    lost = [run for key, run in found.items() if key not in known]
    notes = [
        f"'{run.path}' is left out: it evaluates {run.reward} of seed {run.seed}, whose training is not in '{folder}'"
        for run in lost
    ]
    missing = len(known - found.keys())
    if 0 < missing < len(known):
        notes.append(f"{missing} of {count_text(len(known), 'training')} have no evaluation beside them")
    before = {key: tuple(of[key] for of in early if key in of) for key in known}
    fields = {
        key: {"evaluation": found.get(key), "other": others.get(key) if key in own else None, "before": before[key]}
        for key in known
    }
    return fields, notes


def _in_order(names: Iterable[Sequence[str]]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for some in names for name in some))


def read_loose(folder: Path, told: Told = FOUND_OUT) -> Runs:
    """The recorded trainings that lie in a folder which is no experiment's, at any depth; see `read_runs`.

    Raises:
        UsageError: There are none, none that can be compared, or whole experiments lie among them; no training was
            taught by the baseline; or nobody says which values of what decides are better.
    """
    baseline, decides = told.baseline, told.deciding.name
    runs = read_runs(folder, None, [decides] if decides else [], told=told)
    known = {name for run in runs.members.values() for name in run.episodes.behaviour}
    if decides and decides not in known:
        raise UsageError(f"--measure {decides}: the recordings tell {', '.join(sorted(known)) or 'none'}")
    runs.require_direction()
    if baseline and baseline not in runs.trained:
        raise UsageError(f"--baseline {baseline}: no training was taught by it. There are: {', '.join(runs.trained)}")
    return runs
