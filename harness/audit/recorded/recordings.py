"""The rewards of recorded trainings, and of logs that other programs wrote, beside one another. Trains nothing."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from harness.audit.audit import Audit
from harness.audit.questions import LOGS, NO_SUCCESS, NOT_ASKED, RECORDED, deciding_measure, on_best, rank_success
from harness.audit.recorded.earned import Earned, earned_in_episodes, earned_in_parts
from harness.audit.recorded.paid import Acted, acted_in
from harness.audit.recorded.pair import pairs_in
from harness.audit.recorded.pair_grid import SCALE
from harness.audit.recorded.step_apart import MOST
from harness.errors import UsageError
from harness.log import Log
from harness.log.log import RECORDED as PAID
from harness.log.log import REWARD, Columns
from harness.record.recording.recorded_training import read_recording, weighed
from harness.registry.names import unknown_name
from harness.results.recordings.episodes import count_text
from harness.results.recordings.read_runs import env_of, read_all, without_short
from harness.results.recordings.runs import LAST_SHARE, Run
from harness.results.recordings.runs import RANDOM as ACTED_AT_RANDOM

RANDOM = "random actions"
UNITS = {
    "episode": "A row is an episode, so rewards are compared by episodes alone",
    "point": "A row is a point of a curve, the mean of some episodes, and is taken for an episode",
}
"""What is told of logs whose rows are no steps."""


def audit_recordings(folder: Path, random: Path | None = None, only: Sequence[str] = ()) -> Audit:
    """How far apart the rewards in a folder of recordings are, what behaviour was like, and what it earned under each.

    Args:
        folder: With recordings of one env, at any depth: those of an experiment too.
        random: With recordings of random actions in the same env, if they lie somewhere else.
        only: The rewards that are told of; all of them if empty.

    Raises:
        UsageError: There is nothing to compare, or the recordings are of several envs.
    """
    found, damaged = _read(folder)
    apart, damaged_too = ([], []) if random is None else _read(random)
    paths = {run.path.resolve() for run in apart}  # they may lie in the same folder
    found = [run for run in found if run.path.resolve() not in paths]
    env, notes = env_of(folder, [*found, *apart])
    _, short = without_short(found)
    found = [run for run in found if not (run.facts.evaluation and run.shortfall)]
    at_random = [*apart, *(run for run in found if run.facts.acted == ACTED_AT_RANDOM)]
    # Evaluations before the training ended are of other policies than the one that it left.
    acted = [run for run in found if run not in at_random and not run.facts.after]
    notes += [*short, *(f"'{run.path}' is left out: it has no steps" for run in found if not run.steps)]
    return _audit(
        f"'{folder}'",
        env,
        "recorded",
        [_of_run(folder, run) for run in acted if run.steps],
        [_of_run(folder, run) for run in at_random if run.steps],
        only,
        notes,
        (*damaged, *damaged_too),
        NOT_ASKED[RECORDED],
    )


def audit_logs(
    path: Path, logs: Sequence[Log], left_out: Iterable[tuple[Path, str]], only: Sequence[str] = ()
) -> Audit:
    """The same of logs that other programs wrote, as far as their rows tell it.

    Args:
        path: Where they lie.
        logs: Those that were read.
        left_out: What could not be read, and why.
        only: The rewards that are told of; all of them if empty.

    Raises:
        UsageError: There is none, or none has a row.
    """
    left = [f"'{place}' is left out: {why}" for place, why in left_out]
    if not logs:
        raise UsageError(". ".join([f"'{path}' holds no log that is read: harness list logs tells which are", *left]))
    notes = [line for unit, line in UNITS.items() if any(log.facts.unit == unit for log in logs)]
    notes += dict.fromkeys(line for log in logs for line in (*log.facts.notes, log.facts.thinned) if line)
    names = dict.fromkeys(log.facts.env for log in logs if log.facts.env)
    told = [log.facts.trained_with or _place(path, log) for log in logs]
    acted = [_of_log(path, log, taught, len({*told}) > 1) for log, taught in zip(logs, told, strict=True)]
    audit = _audit(
        f"'{path}'", ", ".join(names) or str(path), "logged", acted, [], only, (*notes, *left), (), NOT_ASKED[LOGS]
    )
    return replace(audit, setting=(", ".join(sorted({log.facts.format for log in logs})),))


def _read(folder: Path) -> tuple[list[Run], list[str]]:
    found, damaged = read_all(folder)
    if not found:
        told = f" Damaged: {'; '.join(damaged)}" if damaged else ""
        raise UsageError(f"'{folder}' holds no recorded training: harness.RecordRewards makes one.{told}")
    return found, damaged


def _of_run(folder: Path, run: Run) -> Acted:
    name = run.path.relative_to(folder).as_posix() if run.path.is_relative_to(folder) else run.path.as_posix()
    rewards, facts = tuple(run.episodes.returns), run.facts
    read = partial(_log_of, run.path, rewards)
    return Acted(name, run.steps, run.episodes, read, run.reward, facts.evaluation, facts.acted, facts.seed)


def _log_of(path: Path, rewards: Sequence[str]) -> Log:
    """The steps of a recording, paid by these rewards, also by those with other weights as far as terms tell it."""
    return weighed(read_recording(path), rewards)


def _place(path: Path, log: Log) -> str:
    """What tells the trainings of a log from others: its folder below `path`, or its own name in that."""
    place = log.facts.path
    inside = place.relative_to(path) if place.is_relative_to(path) else place
    return inside.parent.as_posix() if len(inside.parts) > 1 else place.name


def _of_log(path: Path, log: Log, taught: str, several: bool) -> Acted:
    """One log. Where there are several rewards, its own pay is that of the one that taught."""
    place, own = log.facts.path, f"{REWARD}{PAID}"
    name = place.relative_to(path).as_posix() if place.is_relative_to(path) and place != path else place.name
    if several and own in log:
        log = _renamed(log, own, f"{REWARD}{taught}")
    name = f"{name}, {log.facts.run}" if log.facts.run else name
    return acted_in(name, log, taught, log.facts.evaluation)


def _renamed(log: Log, old: str, new: str) -> Log:
    """The same log with another name for one of its columns."""

    def read(names: tuple[str, ...]) -> Iterable[Columns]:
        asked = {name: old if name == new else name for name in names}
        return ({name: table[of] for name, of in asked.items()} for table in log.read(tuple(asked.values())))

    return replace(log, columns=tuple(new if name == old else name for name in log.columns), read=read)


def _audit(
    where: str,
    env: str,
    noun: str,
    acted: Sequence[Acted],
    at_random: Sequence[Acted],
    only: Sequence[str],
    notes: Sequence[str],
    damaged: tuple[str, ...],
    not_asked: tuple[str, ...],
) -> Audit:
    """What is told of any recorded steps or episodes."""
    trainings, evaluations = ([it for it in acted if it.evaluation is kind] for kind in (False, True))
    compared = trainings or evaluations or at_random
    if not compared:
        raise UsageError(f"{where} has nothing to compare: no recording in it has a step")
    rewards = chosen_rewards(dict.fromkeys(name for it in compared for name in it.episodes.returns), only, where)
    judged = evaluations or trainings or at_random
    success = deciding_measure([it.episodes for it in judged])
    named = dict.fromkeys(name for it in (*acted, *at_random) for name in it.episodes.behaviour)
    measures = sorted(named, key=lambda name: name != success)  # all others stay in their order
    chance = [earned_in_episodes(RANDOM, [it.episodes for it in at_random], rewards, measures)] if at_random else []
    early, final = _earned(trainings, evaluations, rewards, measures)
    pairs, told = pairs_in(compared, rewards, most=MOST)
    if not pairs:
        told.append(
            f"There is only one reward, {rewards[0]}, so none is compared with it. Record another one beside it, see "
            "docs/your-environment.md"
        )
    known = [name for name in rewards if all(name in it.episodes.returns for it in judged)] if success else []
    count, kind = len(compared), "training" if trainings else "evaluation"
    few = "" if count >= 3 else " No intervals below three of them."
    return Audit(
        title=title_of(env, count_text(count, f"{noun} {kind}"), rewards),
        setting=(),
        facts={"env": env, "recordings": [it.name for it in compared], "evaluations": not trainings},
        rewards=rewards,
        pairs=pairs,
        earned=(*chance, *early, *final),
        success=success,
        rankings={
            name: rank_success([it.episodes for it in judged], name, success, [it.training for it in judged])
            for name in known
        },
        verdict=tuple(on_best([*chance, *final], rewards, success)),
        measured=(f"{SCALE} Means over {kind}s, 95% intervals over them in brackets.{few}",) if pairs else (),
        not_asked=(*not_asked, *([] if success else [NO_SUCCESS])),
        notes=(*notes, *told),
        damaged=damaged,
    )


def title_of(what: str, counted: str, rewards: Sequence[str]) -> str:
    """What was audited, ``Pendulum-v1: 4 recorded trainings, 2 rewards: own, calm``."""
    return f"{what}: {counted}, {count_text(len(rewards), 'reward')}: {', '.join(rewards)}"


def chosen_rewards(known: Iterable[str], only: Sequence[str], where: str) -> tuple[str, ...]:
    """The rewards that are told of.

    Args:
        known: Those that are recorded.
        only: Those that the user named; all if empty.
        where: In which folder, quoted.

    Raises:
        UsageError: One of them is not recorded.
    """
    names = tuple(known)
    for name in only:
        if name not in names:
            raise UsageError(
                f"{unknown_name('reward', name, names)} Those are recorded in {where}; harness score lets another one "
                "pay recorded steps"
            )
    return tuple(name for name in names if name in only) if only else names


def _earned(
    trainings: Sequence[Acted], evaluations: Sequence[Acted], rewards: Sequence[str], measures: Sequence[str]
) -> tuple[list[Earned], list[Earned]]:
    """By the reward that taught, means of trainings with intervals over them: while learning; of the final policies.

    Without evaluations the last part of a training stands for its final policy.
    """
    early: list[Earned] = []
    final: list[Earned] = []
    for taught in dict.fromkeys(it.taught for it in (*trainings, *evaluations)):
        who, members = f"trained with {taught}", [it for it in trainings if it.taught == taught]
        first = [it.episodes.part(0, round(LAST_SHARE * it.steps)) for it in members]
        last = [it.episodes.part(round((1.0 - LAST_SHARE) * it.steps), it.steps) for it in members]
        by_manner: dict[str, list[Acted]] = {}
        for it in (it for it in evaluations if it.taught == taught):
            by_manner.setdefault(it.manner, []).append(it)
        evaluated = [
            earned_in_parts(
                f"{who}, {f'{manner} ' if manner else ''}evaluations",
                [it.episodes.part(0, it.steps) for it in of],
                rewards,
                measures,
            )
            for manner, of in sorted(by_manner.items())
        ]
        if members:
            early.append(earned_in_parts(f"{who}, first fifth", first, rewards, measures))
            (early if evaluated else final).append(earned_in_parts(f"{who}, last fifth", last, rewards, measures))
        final += evaluated
    return early, final
