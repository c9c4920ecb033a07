"""The rewards of recorded trainings, and of logs that other programs wrote, beside one another. Trains nothing."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from harness.errors import UsageError
from harness.eta import CANNOT_TELL
from harness.eta.interval import Bounds
from harness.eta.laws import Account, Missing, is_left_out
from harness.eta.manner import ACTED_AT_RANDOM
from harness.log.log import SUCCESS
from harness.log.open_log import Found, find_logs
from harness.registry import unknown_name
from harness.results.logs.read_logs import account_of, facts_notes, read_trainings, require_comparable
from harness.results.logs.results_of_logs import sort_found
from harness.results.logs.told import SUCCESS_DECIDES, Told
from harness.results.recordings.episodes import LAST_SHARE, count_text
from harness.results.recordings.recordings import account_of_runs, env_of, read_all
from harness.results.recordings.runs import NO_NAME, Run, quantities_of

from ..audit import Audit
from ..questions import (
    NO_FORMS,
    NO_SCRIPTS,
    NO_SUCCESS,
    deciding_measure,
    on_best,
    rank_success,
)
from ..subject import Answered, Asked
from .earned import RANDOM, Earned, earned_by
from .pair import pairs_in
from .pair_grid import SCALE

INTERIM = "Interim: {} missing"


def audit_recordings(
    folder: Path,
    random: Path | None = None,
    only: Sequence[str] = (),
    leave_out: Collection[Path] = (),
    account: Account[Any] | None = None,
) -> Audit:
    """How far apart the rewards in a folder of recordings are, what behaviour was like, and what it earned under each.

    Args:
        folder: With recordings of one env, at any depth: those of an experiment too.
        random: With recordings of random actions in the same env, if they lie somewhere else.
        only: The rewards that are told of; all of them if empty.
        leave_out: The trainings that the user leaves out.
        account: Of all trainings of an experiment, which knows them better; None of loose recordings.

    Raises:
        UsageError: There is nothing to compare, or the recordings are of several envs.
    """
    found, damaged = _read(folder)
    apart, damaged_too = ([], []) if random is None else _read(random)
    apart = [replace(run, facts=replace(run.facts, acted=ACTED_AT_RANDOM)) for run in apart]
    paths = {run.path.resolve() for run in apart}  # they may lie in the same folder
    found = [run for run in found if run.path.resolve() not in paths]
    env, notes = env_of(folder, [*found, *apart])
    if account is None:
        account, found, lines = account_of_runs(found, damaged, leave_out)
        notes += lines
    else:
        out = [it.path for it in (*account.missing, *account.left_out)]
        found = [run for run in found if not is_left_out(run.path, out)]
    # Evaluations before the training ended are of other policies than the one that it left.
    final = [run for run in (*apart, *found) if run.steps and (not run.facts.after or _is_random(run))]
    audit = _audit(folder, f"'{folder}'", env, ("recorded", "a recording"), final, only, notes)
    unread = tuple(it.why for it in (*damaged, *damaged_too) if it not in account.left_out)
    return held_back(replace(audit, damaged=unread), account)


def held_back(audit: Audit, account: Account[Any]) -> Audit:
    """The same with what is missing told, and without a verdict until it is left out."""
    audit = replace(audit, notes=(*audit.notes, *account.lines))
    if not account.missing:
        return audit
    why = INTERIM.format(count_text(len(account.missing), "training"))
    rankings = {name: replace(auc, answer=CANNOT_TELL, reason=why) for name, auc in audit.rankings.items()}
    return replace(audit, verdict=(f"{why}.",), rankings=rankings)


def audit_logs(
    path: Path, found: Found, only: Sequence[str] = (), sort: str = "", leave_out: Sequence[Path] = ()
) -> Audit:
    """The same of logs that other programs wrote, as far as their rows tell it.

    Args:
        path: Where they lie.
        found: Those that were read, and what could not be.
        only: The rewards that are told of; all of them if empty.
        sort: How names are made, if the user says it; see `harness.results.logs.names.sort_names`.
        leave_out: The trainings that the user leaves out.

    Raises:
        UsageError: There is none, none has a row, or they cannot be compared.
        SchemaError: One is damaged.
    """
    if not found.logs:
        unread = (f"'{place}' cannot be read: {why}" for place, why in found.left_out)
        raise UsageError(". ".join([f"'{path}' holds no log that is read: harness describe logs tells which", *unread]))
    folder = path if path.is_dir() else path.parent
    sorted_, other = sort_found(path, found, Told(sort=sort, leave_out=tuple(leave_out)))
    require_comparable(sorted_.trainings)
    account = account_of(sorted_.trainings, other, leave_out, SUCCESS)
    logs = [log for it in account.whole for log in (*it.logs, it.evaluation) if log is not None]
    measures = list(dict.fromkeys(name for log in logs for name in log.measures))
    runs, _, _ = read_trainings(account.whole, measures)
    everything = [it for run in runs for it in (run, run.evaluation) if it is not None and len(it.recorded.log)]
    env = next((log.facts.env for log in logs if log.facts.env), NO_NAME)
    notes = [sorted_.sentence, *sorted_.notes, *facts_notes(logs)]
    audit = _audit(folder, f"'{path}'", env, ("logged", "a log"), everything, only, notes)
    return held_back(audit, account)


def _read(folder: Path) -> tuple[list[Run], list[Missing]]:
    found, damaged = read_all(folder)
    if not found:
        told = f" Damaged: {'; '.join(it.why for it in damaged)}" if damaged else ""
        raise UsageError(f"'{folder}' holds no recorded training: harness.RecordRewards makes one.{told}")
    return found, damaged


def _is_random(run: Run) -> bool:
    return run.facts.acted == ACTED_AT_RANDOM


def _name_of(folder: Path, run: Run) -> str:
    """Where it lies in a folder, and what its file calls it."""
    path = run.path.relative_to(folder) if run.path.is_relative_to(folder) else run.path
    return f"{path.as_posix()}, {run.facts.run}" if run.facts.run else path.as_posix()


def _audit(
    folder: Path,
    where: str,
    env: str,
    nouns: tuple[str, str],
    found: Sequence[Run],
    only: Sequence[str],
    notes: Sequence[str],
) -> Audit:
    """What is told of any recorded steps or episodes; `nouns` say how these were kept, and what holds them."""
    at_random, acted = ([run for run in found if _is_random(run) is kind] for kind in (True, False))
    trainings, evaluations = ([run for run in acted if run.facts.evaluation is kind] for kind in (False, True))
    compared = trainings or evaluations or at_random
    if not compared:
        raise UsageError(f"{where} has nothing to compare: no recording in it has a step")
    rewards = chosen_rewards(dict.fromkeys(name for run in compared for name in run.episodes.returns), only, where)
    acting = evaluations or trainings or at_random
    judged = [run.episodes for run in acting]
    # two evaluations of one training are no two trainings
    owners = [(run.reward, _name_of(folder, run) if run.facts.seed is None else run.seed) for run in acting]
    success = deciding_measure(judged)
    named = dict.fromkeys(name for run in (*acted, *at_random) for name in run.episodes.behaviour)
    ordered = sorted(named, key=lambda name: name != success)  # all others stay in their order
    measures = {name: it.ends for name, it in quantities_of(ordered, found, (), SUCCESS_DECIDES).items()}
    chance = [earned_by(RANDOM, [run.episodes for run in at_random], rewards, measures)] if at_random else []
    early, final = _earned(trainings, evaluations, rewards, measures)
    names = [_name_of(folder, run) for run in compared]
    pairs, told = pairs_in(
        ((name, run.recorded.log) for name, run in zip(names, compared, strict=True)), rewards, shows_steps=True
    )
    if not pairs:
        told.append(
            f"There is only one reward, {rewards[0]}, so none is compared with it. Record another one beside it, see "
            "docs/recording.md"
        )
    known = [name for name in rewards if all(name in it.returns for it in judged)] if success else []
    count, kind = len(compared), "training" if trainings else "evaluation"
    kept, holder = nouns
    few = "" if count >= 3 else " No intervals below three of them."
    return Audit(
        title=title_of(env, count_text(count, f"{kept} {kind}"), rewards),
        facts={"env": env, "recordings": names, "evaluations": not trainings},
        rewards=rewards,
        pairs=pairs,
        earned=(*chance, *early, *final),
        success=success,
        rankings={name: rank_success(judged, name, success, owners) for name in known},
        verdict=tuple(on_best([*chance, *final], rewards, success)),
        measured=(f"{SCALE} Means over {kind}s, 95% intervals over them in brackets.{few}",) if pairs else (),
        not_asked=(NO_SCRIPTS.format(holder), NO_FORMS.format(holder), *(() if success else (NO_SUCCESS,))),
        notes=(*notes, *told),
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
    trainings: Sequence[Run], evaluations: Sequence[Run], rewards: Sequence[str], measures: Mapping[str, Bounds]
) -> tuple[list[Earned], list[Earned]]:
    """By the reward that taught, means of trainings with intervals over them: while learning; of the final policies.

    Without evaluations the last part of a training stands for its final policy.
    """

    def earned(what: str, of: Sequence[Run], begin: float = 0.0, end: float = 1.0) -> Earned:
        parts = [run.episodes.part(round(begin * run.steps), round(end * run.steps)) for run in of]
        return earned_by(f"trained with {taught}, {what}", parts, rewards, measures)

    early: list[Earned] = []
    final: list[Earned] = []
    for taught in dict.fromkeys(run.reward for run in (*trainings, *evaluations)):
        members, evaluated = ([run for run in of if run.reward == taught] for of in (trainings, evaluations))
        if members:
            early.append(earned("first fifth", members, end=LAST_SHARE))
            last = earned("last fifth", members, begin=1.0 - LAST_SHARE)
            (early if evaluated else final).append(last)
        for manner in sorted({run.facts.acted for run in evaluated}):
            of = [run for run in evaluated if run.facts.acted == manner]
            final.append(earned(f"{manner} evaluations".lstrip(), of))
    return early, final


def audited(asked: Asked) -> Answered:
    """An audit of loose recordings; see `audit_recordings`."""
    return [audit_recordings(asked.folder, asked.random, asked.rewards, asked.leave_out)], ()


def audited_logs(asked: Asked) -> Answered:
    """An audit of logs; see `audit_logs`."""
    found = find_logs(asked.folder, asked.registry, asked.log_format)
    return [audit_logs(asked.folder, found, asked.rewards, asked.sort, asked.leave_out)], ()
