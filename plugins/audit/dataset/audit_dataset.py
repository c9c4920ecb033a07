"""`audit_dataset`: for each reward, whether it ranks recorded behaviour as success does, and what it pays for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial as bound
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from harness import Float, Ints, Mask
from harness.errors import UsageError
from harness.eta import CANNOT_TELL, auc_of
from harness.eta.auc import Auc, share_of
from harness.eta.rescaling import rounded
from harness.log import Log
from harness.log.log import RECORDED
from harness.payoff.dataset.paid_dataset import Labels, PaidDataset, pay_dataset
from harness.payoff.dataset.rewards import given_rewards, rewards_of
from harness.payoff.dataset.steps import Payer
from harness.record.dataset.labels import parse_success, read_labels
from harness.record.dataset.open_dataset import dataset_facts, open_dataset
from harness.registry import Registry, load_registry

from ..recorded.pair import Paid, Pair, compare_paid, pair_of
from ..subject import Answered, Asked
from .dataset_audit import DatasetAudit, PaidStep, RewardAnswer, WrongPair

if TYPE_CHECKING:
    from harness.score.places import ArmPlaces


UNPAID = (
    "it looks at next_observation, which nothing tells after the last step. What it would pay there could change the "
    "order. A function that looks at observation, action and info alone is paid for every step"
)
DECIDES = "it cannot be paid the last step, and by that step the recorded reward gets another answer"
LOST = "it pays no finite number in some episodes, which could change the order"
OWN = "success is told by this very reward"


def _ranked(
    name: str,
    sides: Sequence[PaidDataset],
    above: Mask,
    known: Mask,
    clusters: Ints,
    tasks: NDArray[Any],
) -> Auc:
    """How a reward ranks episodes, without a word where what could not be paid might change it.

    A step that could not be paid pays no less and no more than the function pays any other step. But where success
    shows in that step alone, as where a function paid no finite number, it may pay anything.

    Args:
        name: The reward.
        sides: A data set whose successes are compared with its failures; or one, and that of a beginner.
        above: Which episodes of these should be paid more.
        known: Of which that is known.
        clusters: Of each episode.
        tasks: Of each episode.
    """
    returns, lost, unpaid = (
        np.concatenate([getattr(it, what)[name] for it in sides]) for what in ("returns", "lost", "unpaid")
    )
    told, paid = known & ~lost, sides[0]
    auc = auc_of(returns[told], above[told], clusters[told], tasks[told])
    if auc.answer == CANNOT_TELL or not (unpaid.any() or lost.any()):
        return auc
    if len(sides) == 1 and unpaid.any() and _last_step_decides(paid, clusters, tasks):
        return replace(auc, answer=CANNOT_TELL, reason=DECIDES)
    for best in (above, ~above):
        parts = zip(sides, np.split(best, [len(paid)]), strict=False)
        moved = np.concatenate([_moved(it, name, part) for it, part in parts])
        if auc_of(moved[known], above[known], clusters[known], tasks[known]).answer != auc.answer:
            return replace(auc, answer=CANNOT_TELL, reason=UNPAID if paid.unpaid[name].any() else LOST)
    return auc


def _moved(paid: PaidDataset, name: str, best: Mask) -> Float:
    """What each episode is paid where what is not known is the most for some, and the least for all others."""
    steps = paid.paid[name]
    seen = steps[~np.isnan(steps)]
    unpaid, returns = paid.unpaid[name], paid.returns[name]
    moved = returns + np.where(unpaid, np.where(best, seen.max(initial=0.0), seen.min(initial=0.0)), 0.0)
    anything = paid.lost[name] | (unpaid & paid.shown_last)
    far = 1.0 + float(np.ptp(moved))
    return np.where(anything, np.where(best, moved.max() + far, moved.min() - far), moved)


def _last_step_decides(paid: PaidDataset, clusters: Ints, tasks: Ints) -> bool:
    """Whether the recorded reward would get another answer without its last steps."""
    whole, last = paid.recorded.T
    known, success = paid.known & ~np.isnan(whole), paid.succeeded
    if not known.any():
        return False
    answers = (auc_of(it[known], success[known], clusters[known], tasks[known]).answer for it in (whole, whole - last))
    return len({*answers}) > 1


def lines_of(paid: PaidDataset, name: str) -> tuple[str, ...]:
    """What is told of the steps that it could not be paid, a line each."""
    lines = []
    unpaid, lost = paid.unpaid[name], paid.lost[name]
    if unpaid.any():
        lines.append(f"not paid the last step of {int(unpaid.sum()):,} episodes, since it looks at what came then")
    if lost.any():
        first = int(paid.numbers[lost][0])
        lines.append(
            f"left out of this answer, since it pays no finite number there: {int(lost.sum()):,} episodes "
            f"(the first is {first})"
        )
    return tuple(lines)


MOST_PAIRS, MOST_STEPS = 5, 3
"""So many wrongly ranked pairs, and steps, are told of each reward."""
BLOCKS = 10
"""Distances between rewards are means over so many parts of the data set."""
UNTOLD = "Nothing says which episodes"
FILE = "file"
"""What `--cluster` says for episodes of one file to count as alike."""


@dataclass(frozen=True)
class _Grouped:
    """How episodes belong together.

    Attributes:
        noun: What intervals are over.
        clusters: Number of each episode's cluster.
        tasks: Number of each episode's task; only those of one task are compared.
        names: Of the tasks.
        untold: How many episodes nothing says the operator of, though it does of others.
    """

    noun: str
    clusters: Ints
    tasks: Ints
    names: tuple[str, ...]
    untold: int


def audit_dataset(
    dataset: str,
    rewards: Mapping[str, Any] | Sequence[str] = (),
    *,
    places: str | None = None,
    robot: str | None = None,
    success: str = "",
    labels: str | Path | None = None,
    success_above: float | None = None,
    cluster: str = "",
    partial: bool = False,
    beginner: str | None = None,
    registry: Registry | None = None,
) -> DatasetAudit:
    """Whether rewards rank recorded behaviour as success does.

    Args:
        dataset: ``minari:NAME``, ``lerobot:FOLDER``, ``d4rl:FILE`` or ``robomimic:FILE``.
        rewards: By name, rewards of a step, see `harness.reward.given`, or rewards of an arm; or names, as
            ``harness audit --reward`` takes them. Without any: those that are recorded, and the functions of plugin
            files in `registry`.
        places: Where an arm's end effector and target stand in an observation, ``end_effector=0:3,target=3:6``.
        robot: The robot whose joints `places` names.
        success: What says whether a step, or an episode, was a success: a key, a column or an attribute, also
            ``KEY>0.5``; found by its name if empty. With `labels` a column of that file.
        labels: A CSV file with the columns ``episode`` and ``success``.
        success_above: The recorded return above which an episode is a success.
        cluster: What says who made an episode: an attribute or a column, or ``file``; found by its name if empty.
        partial: Whether less than the metadata declares is enough.
        beginner: Another data set that should be paid less.
        registry: The plugins; loaded if None.

    Raises:
        UsageError: A data set, a reward, a place, a robot or a label is none.
        SchemaError: A data set is damaged, or is not what its metadata declares.
    """
    plugins = registry or load_registry()
    arm = None
    if places is not None or robot is not None:
        from harness.payoff.dataset.arm_pay import places_of

        arm = places_of(places, robot, plugins)
    by_file = cluster == FILE
    outside = _outside(success, labels, success_above)
    open_it = bound(open_dataset, registry=plugins, cluster="" if by_file else cluster, partial=partial)
    opened = open_it(dataset, success="" if outside is not None else success)
    other = open_it(beginner) if beginner is not None else None
    if success_above is not None and RECORDED not in opened.rewards:
        raise UsageError(
            f"--success-above needs a recorded reward, and {dataset_facts(opened).name} has none: give --labels FILE"
        )

    def paying(of: Log) -> dict[str, Payer]:
        if isinstance(rewards, Mapping):
            return given_rewards(rewards, arm)
        return rewards_of(of, plugins, rewards, arm, labelled=outside is not None or beginner is not None)

    paid = pay_dataset(opened, paying(opened), arm, outside)
    below = None if other is None else pay_dataset(other, paying(other), arm)
    found = judge(paid, below, arm, by_file)
    if outside is None:
        return found
    return replace(
        found,
        success=f"the file {labels}" if labels is not None else f"a recorded return above {success_above:g}",
        notes=(*_unmatched(outside, paid), *found.notes),
    )


def _outside(success: str, labels: str | Path | None, success_above: float | None) -> Labels | None:
    if labels is not None and success_above is not None:
        raise UsageError("--labels and --success-above both say what succeeded: leave out one")
    if success_above is not None and success:
        raise UsageError("--success and --success-above both say what succeeded: leave out one")
    if success_above is not None and not np.isfinite(success_above):
        raise UsageError(f"--success-above {success_above}: give a finite return")
    if labels is not None:
        return Labels(by_episode=read_labels(Path(labels), parse_success(success)).get("", {}))
    return None if success_above is None else Labels(above=success_above)


def _unmatched(outside: Labels, paid: PaidDataset) -> list[str]:
    labelled, there = {*(outside.by_episode or {})}, paid.all_numbers
    if len(there) > 1 and labelled == {number + 1 for number in there} and min(there) == 0:
        raise UsageError(f"--labels counts the episodes from 1, and {paid.facts.name} from 0: subtract 1 from each")
    beside = sorted(labelled - there)
    return [f"Labels of episodes that are not there: {len(beside):,} (the first is {beside[0]})"] if beside else []


def judge(paid: PaidDataset, below: PaidDataset | None, places: "ArmPlaces | None", by_file: bool) -> DatasetAudit:
    """What the paid steps say.

    Args:
        paid: Of the data set.
        below: Of one that should be paid less.
        places: By which standing still was told; None for all numbers of an observation.
        by_file: Whether episodes of one file count as alike, and not those of one operator.
    """
    grouped = _grouped(paid, by_file)
    groups = grouped.clusters
    known = np.isfinite(paid.moved)
    still, lengths = paid.summed(paid.still.astype(np.float64)), paid.summed(known.astype(np.float64))
    return DatasetAudit(
        paid.facts,
        None if below is None else below.facts,
        len(paid),
        paid.steps,
        int(paid.succeeded.sum()),
        int((paid.known & ~paid.succeeded).sum()),
        (grouped.noun, int(groups.max()) + 1),
        share_of(still, lengths, groups),
        tuple(_answer(paid, below, name, grouped, by_file) for name in paid.paid),
        _pairs(paid, groups),
        {**(below.failed if below else {}), **paid.failed},
        tuple(_notes(paid, below, grouped, places)),
        grouped.names,
        paid.facts.success,
    )


def _notes(paid: PaidDataset, below: PaidDataset | None, grouped: _Grouped, places: "ArmPlaces | None") -> list[str]:
    """What was left out, and what to keep in mind."""
    notes = [*paid.facts.notes, *paid.notes]
    notes += [f"{below.facts.name}: {line}" for line in (*below.facts.notes, *below.notes)] if below else []
    unknown = int((~paid.known).sum())
    if unknown == len(paid):
        who = f"{paid.facts.success} does not say of any episode whether it" if paid.facts.success else UNTOLD
        notes.append(
            f"{who} succeeded: name the key with --success KEY, or give --labels episodes.csv or --success-above RETURN"
        )
    elif unknown:
        notes.append(f"Episodes left out, since nothing says whether they succeeded: {unknown:,}")
    declared = paid.facts.declared.get("tasks")
    if declared is not None and declared != len(grouped.names):
        notes.append(f"The metadata declares {declared:,} tasks, and {len(grouped.names):,} are in what is used")
    if grouped.untold:
        notes.append(f"Nothing says who made {grouped.untold:,} of the episodes: each of them counts by itself")
    unseen = int(np.isnan(paid.moved[paid.begins[1:] - 1]).sum())
    if unseen:
        notes.append(
            f"Nothing is known of what was seen after the last step of {unseen:,} episodes. Recorded pay counts there, "
            "and that of functions that do not look at next_observation"
        )
    if places is None and paid.still.any():
        notes.append("All numbers of an observation tell whether it stands still, also those that are no positions")
    return notes


def _grouped(paid: PaidDataset, by_file: bool) -> _Grouped:
    """What intervals are over, and what is compared."""
    names, tasks = np.unique(np.array(paid.tasks, object).astype(str), return_inverse=True)
    noun, clusters, untold = "episodes", np.arange(len(paid)), 0
    if by_file:
        noun, clusters = "files", np.unique(paid.files, return_inverse=True)[1]
    elif any(paid.operators):
        each = [who or f"\0{number}" for number, who in enumerate(paid.operators)]
        noun, clusters = "operators", np.unique(each, return_inverse=True)[1]
        untold = sum(not who for who in paid.operators)
    return _Grouped(noun, clusters.astype(np.int64), tasks, tuple(names.tolist()), untold)


def _answer(paid: PaidDataset, below: PaidDataset | None, name: str, grouped: _Grouped, by_file: bool) -> RewardAnswer:
    known, returns, steps = paid.known & ~paid.lost[name], paid.returns[name], np.nan_to_num(paid.paid[name])
    success = paid.succeeded
    earned = np.where(~np.isfinite(paid.moved), 0.0, np.maximum(steps, 0.0))
    groups, tasks = grouped.clusters, grouped.tasks
    held = _ranked(name, [paid], success, paid.known, groups, tasks)
    if name == paid.told_by and held.answer != CANNOT_TELL:  # both what says what succeeds and what is asked about
        held = replace(held, answer=CANNOT_TELL, reason=OWN)
    return RewardAnswer(
        name,
        held,
        _by_level(paid, below, name, grouped, by_file),
        _wrong(rounded(returns), success, known, tasks),
        _most_wrong(paid, name, known, tasks),
        share_of(paid.summed(np.where(paid.still, earned, 0.0)), paid.summed(earned), groups),
        _most_paid(paid, paid.paid[name]),
        lines_of(paid, name),
    )


def _by_level(paid: PaidDataset, below: PaidDataset | None, name: str, grouped: _Grouped, by_file: bool) -> Auc | None:
    if below is None or name not in below.paid:
        return None
    under = _grouped(below, by_file)
    count = len(paid) + len(below)
    clusters = np.concatenate([grouped.clusters, grouped.clusters.max() + 1 + under.clusters])
    several = len(grouped.names) > 1 or len(under.names) > 1
    tasks = np.array([*paid.tasks, *below.tasks] if several else [""] * count)
    return _ranked(name, [paid, below], np.arange(count) < len(paid), np.ones(count, bool), clusters, tasks)


def _wrong(returns: Float, success: Mask, known: Mask, tasks: Ints) -> int:
    """Pairs of one task in which the failure is paid more."""
    count = 0
    for task in np.unique(tasks):
        here = known & (tasks == task)
        best = np.sort(returns[here & ~success])
        count += int((len(best) - np.searchsorted(best, returns[here & success], side="right")).sum())
    return count


def _most_wrong(paid: PaidDataset, name: str, known: Mask, tasks: Ints) -> tuple[WrongPair, ...]:
    """The worst paid success of a task beside its best paid failure, the next worst beside the next best, and so on."""
    returns, found = paid.returns[name], list[tuple[int, int]]()
    low, high = (np.argsort(of, kind="stable") for of in (returns, -returns))
    for task in np.unique(tasks[known]):
        here = known & (tasks == task)
        of_task = low[(here & paid.succeeded)[low]], high[(here & ~paid.succeeded)[high]]
        found += zip(*(it[:MOST_PAIRS].tolist() for it in of_task), strict=False)
    worst = sorted(found, key=lambda pair: returns[pair[0]] - returns[pair[1]])[:MOST_PAIRS]
    steps, told = np.nan_to_num(paid.paid[name]), []
    for one, other in worst:
        if returns[other] > returns[one]:
            curves = np.cumsum(steps[paid.episode_steps(one)]), np.cumsum(steps[paid.episode_steps(other)])
            numbers = int(paid.numbers[one]), int(paid.numbers[other])
            told.append(WrongPair(*numbers, (float(returns[one]), float(returns[other])), curves))
    return tuple(told)


def _most_paid(paid: PaidDataset, steps: Float) -> tuple[PaidStep, ...]:
    steps = np.where(np.isnan(steps), -np.inf, steps)
    largest = np.maximum.reduceat(steps, paid.begins[:-1])
    found = []
    for place in np.argsort(-largest, kind="stable")[:MOST_STEPS].tolist():
        step = int(np.argmax(steps[paid.episode_steps(place)]))
        if np.isfinite(largest[place]):
            found.append(PaidStep(int(paid.numbers[place]), step, float(largest[place])))
    return tuple(found)


def _pairs(paid: PaidDataset, groups: Ints) -> tuple[Pair, ...]:
    """Every two rewards: means over parts of the data set, no cluster in two of them. What one lacks is left out."""
    names = tuple(paid.paid)
    whole = ~np.any([paid.lost[name] for name in names], axis=0) if names else np.ones(len(paid), bool)
    part = groups % min(BLOCKS, int(groups.max()) + 1)
    common = np.repeat(whole, np.diff(paid.begins))
    for name in names:
        common &= ~np.isnan(paid.paid[name])
    step_part = np.repeat(part, np.diff(paid.begins))
    members = [((part == number) & whole, (step_part == number) & common) for number in np.unique(part[whole])]
    blocks = [
        Paid(
            {name: paid.paid[name][steps] for name in names}, {name: paid.returns[name][it] for name in names}
        )
        for it, steps in (members if len(names) > 1 else ())
        if steps.any()
    ]  # fmt: skip
    return tuple(
        pair_of(one, other, [compare_paid(block, one, other) for block in blocks])
        for one, other in combinations(names, 2)
    )


def audited(asked: Asked) -> Answered:
    """An audit of a data set; see `audit_dataset`."""
    found = audit_dataset(
        asked.named,
        asked.rewards,
        places=asked.places,
        robot=asked.robot,
        success=asked.success,
        labels=asked.labels,
        success_above=asked.success_above,
        cluster=asked.cluster,
        partial=asked.partial,
        beginner=asked.beginner,
        registry=asked.registry,
    )
    return [found], ()
