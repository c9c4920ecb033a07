"""`audit_recordings`: the rewards of recorded trainings beside one another, in any environment. Trains nothing."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.audit.recorded.earned import Earned
from harness.audit.recorded.paid import Apart, Paid, compare_paid, paid_in, pairs_of
from harness.audit.recorded.pair import Pair, pair_of
from harness.audit.recorded.step_apart import MOST, StepApart, steps_apart
from harness.errors import UsageError
from harness.eta.rescaling import Line
from harness.eta.seed_mean import mean_over_seeds
from harness.log import Log
from harness.log.log import REWARD
from harness.record.recording.facts import facts_of
from harness.record.recording.recorded_training import INTEGERS, read_recording, weighed
from harness.results.recordings.episodes import Part
from harness.results.recordings.read_runs import env_of, read_all, without_short
from harness.results.recordings.runs import LAST_SHARE, Run

RANDOM = "random actions"


@dataclass(frozen=True)
class RecordedAudit:
    """What the rewards of a folder of recordings paid for the same steps.

    Attributes:
        env: Its id.
        compared: Folders of the recordings that distances are means over.
        evaluations: Whether these are evaluations, because the folder holds no training.
        rewards: That were recorded.
        pairs: Every two of them.
        earned: What each recorded behaviour earned.
        notes: What to keep in mind, a line each.
        damaged: What could not be read, a line each.
    """

    env: str
    compared: tuple[str, ...]
    evaluations: bool
    rewards: tuple[str, ...]
    pairs: tuple[Pair, ...]
    earned: tuple[Earned, ...]
    notes: tuple[str, ...]
    damaged: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """Plain data, finite numbers only."""
        return {
            "env": self.env,
            "recordings": list(self.compared),
            "evaluations": self.evaluations,
            "rewards": list(self.rewards),
            "pairs": [pair.to_json() for pair in self.pairs],
            "earned": [row.to_json() for row in self.earned],
            "notes": list(self.notes),
            "damaged": list(self.damaged),
        }


def audit_recordings(folder: Path, random: Path | None = None) -> RecordedAudit:
    """How far apart the rewards in a folder of recordings are, and what recorded behaviour earned under each.

    Args:
        folder: With recordings of one env, at any depth.
        random: With recordings of random actions in the same env, if there are any.

    Raises:
        UsageError: There is nothing to compare, or the recordings are of several envs.
    """
    found, damaged = _read(folder)
    at_random, damaged_too = ([], []) if random is None else _read(random)
    paths = {run.path.resolve() for run in at_random}  # they may lie in the same folder
    found = [run for run in found if run.path.resolve() not in paths]
    env, notes = env_of(folder, [*found, *at_random])
    _, short = without_short(found)
    notes += short
    found = [run for run in found if not (run.facts.evaluation and run.shortfall)]
    trainings, evaluations = ([run for run in found if run.facts.evaluation is it] for it in (False, True))
    compared = trainings or evaluations or at_random
    if not any(run.steps for run in compared):
        raise UsageError(f"'{folder}' has nothing to compare: no recording in it has a step")
    rewards = tuple(dict.fromkeys(name for run in compared for name in run.facts.rewards))
    if len(rewards) < 2:
        raise UsageError(
            f"'{folder}' has nothing to compare: its recordings have only one reward, {rewards[0]!r}. Record another "
            "one beside it, see docs/your-environment.md"
        )
    notes += [f"'{run.path}' is left out: it has no steps" for run in found if not run.steps]
    pairs, told = _pairs(folder, [run for run in compared if run.steps], rewards)
    earned = [*_earned_at_random(at_random, rewards), *_earned(trainings, evaluations, rewards)]
    return RecordedAudit(
        env,
        tuple(_name(folder, run) for run in compared if run.steps),
        not trainings,
        rewards,
        pairs,
        tuple(earned),
        (*notes, *told),
        (*damaged, *damaged_too),
    )


def _read(folder: Path) -> tuple[list[Run], list[str]]:
    found, damaged = read_all(folder)
    if not found:
        told = f" Damaged: {'; '.join(damaged)}" if damaged else ""
        raise UsageError(f"'{folder}' holds no recorded training: harness.RecordRewards makes one.{told}")
    return found, damaged


def _name(folder: Path, run: Run) -> str:
    return run.path.relative_to(folder).as_posix() if run.path.is_relative_to(folder) else run.path.as_posix()


def _pairs(folder: Path, runs: Sequence[Run], rewards: tuple[str, ...]) -> tuple[tuple[Pair, ...], list[str]]:
    """Every pair; and a line for each reward that is not known in a recording."""
    each: dict[tuple[str, str], list[Apart]] = {pair: [] for pair in pairs_of(rewards)}
    lines: dict[tuple[str, str], list[Line | None]] = {pair: [] for pair in each}
    largest: dict[tuple[str, str], list[StepApart]] = {pair: [] for pair in each}
    notes: list[str] = []
    for run in runs:
        log = weighed(read_recording(run.path), rewards)
        recording = log.loaded([*INTEGERS, *(f"{REWARD}{name}" for name in facts_of(log).rewards)])
        paid = paid_in(recording, run.episodes)
        notes += _unknown(_name(folder, run), paid, rewards)
        for pair, found in each.items():
            if set(pair) <= paid.steps.keys():
                found.append(compare_paid(paid, *pair))
                lines[pair].append(run.likeness.lines[pair])
                largest[pair] = _most(largest[pair], _name(folder, run), recording, *pair)
    notes += [f"No recording knows both {one!r} and {other!r}" for (one, other), found in each.items() if not found]
    return tuple(pair_of(*pair, each[pair], lines[pair], largest[pair]) for pair in each), notes


def _unknown(name: str, paid: Paid, rewards: Iterable[str]) -> list[str]:
    missing = [it for it in rewards if it not in paid.steps]
    return [f"'{name}' does not count for reward {it!r}: {paid.unknown.get(it, 'not recorded')}" for it in missing]


def _most(known: Sequence[StepApart], name: str, recording: Log, one: str, other: str) -> list[StepApart]:
    found = [*known, *steps_apart(name, recording, one, other)]
    return sorted(found, key=lambda step: -step.difference)[:MOST]


def _earned_at_random(runs: Sequence[Run], rewards: tuple[str, ...]) -> list[Earned]:
    """Its episodes are independent of one another, so that intervals are over them."""
    if not runs:
        return []
    returns = {name: mean_over_seeds(_known_returns(runs, name)) for name in rewards}
    return [Earned(RANDOM, sum(len(run.episodes.last) for run in runs), returns)]


def _known_returns(runs: Sequence[Run], reward: str) -> list[float]:
    found: list[Float] = [run.episodes.returns[reward] for run in runs if reward in run.episodes.returns]
    whole = np.concatenate([np.zeros(0), *found])
    return [] if np.isnan(whole).any() else whole.tolist()


def _earned(trainings: Sequence[Run], evaluations: Sequence[Run], rewards: tuple[str, ...]) -> Iterable[Earned]:
    """By the reward that taught: early, late, and in evaluations; means of trainings, intervals over them."""
    for taught in dict.fromkeys(run.reward for run in (*trainings, *evaluations)):
        members = [run for run in trainings if run.reward == taught and run.steps]
        stretches = {
            "first fifth": [run.episodes.part(0, round(LAST_SHARE * run.steps)) for run in members],
            "last fifth": [run.episodes.part(round((1.0 - LAST_SHARE) * run.steps), run.steps) for run in members],
            "evaluations": [it.episodes.part(0, it.steps) for it in evaluations if it.reward == taught],
        }
        for stretch, parts in stretches.items():
            if parts:
                yield _mean(f"trained with {taught}, {stretch}", parts, rewards)


def _mean(behaviour: str, parts: Sequence[Part], rewards: tuple[str, ...]) -> Earned:
    returns = {
        name: mean_over_seeds([value for part in parts if (value := part.returns.get(name)) is not None])
        for name in rewards
    }
    return Earned(behaviour, sum(part.episodes for part in parts), returns)
