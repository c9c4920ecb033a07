"""`audit_dataset`: for each reward, whether it ranks recorded behaviour as success does, and what it pays for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial as bound
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

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

from ..recorded.pair import Mean, Paid, Pair, compare_paid, pair_of
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


@dataclass(frozen=True, eq=False)
class _Compared:
    """Episodes of which some should be paid more than the others.

    Attributes:
        sides: A data set whose successes are compared with its failures; or one, and that of a beginner.
        above: Which of their episodes should be paid more.
        known: Of which that is known.
        clusters: Number of each episode's cluster: those of one resemble one another.
        tasks: Number of each episode's task; only those of one task are compared.
    """

    sides: Sequence[PaidDataset]
    above: Mask
    known: Mask
    clusters: Ints
    tasks: Ints

    def rank(self, returns: Float, told: Mask) -> Auc:
        """How numbers rank those of the episodes that are known, and told."""
        told = told & self.known
        return auc_of(returns[told], self.above[told], self.clusters[told], self.tasks[told])


def _ranked(name: str, compared: _Compared) -> Auc:
    """How a reward ranks episodes, without a word where what could not be paid might change it.

    A step that could not be paid pays no less and no more than the function pays any other step. But where success
    shows in that step alone, as where a function paid no finite number, it may pay anything.
    """
    sides = compared.sides
    returns, lost, unpaid = (
        np.concatenate([getattr(it, what)[name] for it in sides]) for what in ("returns", "lost", "unpaid")
    )
    auc, paid = compared.rank(returns, ~lost), sides[0]
    if auc.answer == CANNOT_TELL or not (unpaid.any() or lost.any()):
        return auc
    if len(sides) == 1 and unpaid.any():
        whole, last = paid.each("recorded"), paid.each("last")
        known = ~np.isnan(whole)
        if len({compared.rank(it, known).answer for it in (whole, whole - last)}) > 1:
            return replace(auc, answer=CANNOT_TELL, reason=DECIDES)
    for best in (compared.above, ~compared.above):
        parts = zip(sides, np.split(best, [len(paid)]), strict=False)
        moved = np.concatenate([_moved(it, name, part) for it, part in parts])
        if compared.rank(moved, compared.known).answer != auc.answer:
            return replace(auc, answer=CANNOT_TELL, reason=UNPAID if paid.unpaid[name].any() else LOST)
    return auc


def _moved(paid: PaidDataset, name: str, best: Mask) -> Float:
    """What each episode is paid where what is not known is the most for some, and the least for all others."""
    steps = paid.paid[name]
    seen = steps[~np.isnan(steps)]
    unpaid, returns = paid.unpaid[name], paid.returns[name]
    moved = returns + np.where(unpaid, np.where(best, seen.max(initial=0.0), seen.min(initial=0.0)), 0.0)
    anything = paid.lost[name] | (unpaid & paid.each("shown_last"))
    far = 1.0 + float(np.ptp(moved))
    return np.where(anything, np.where(best, moved.max() + far, moved.min() - far), moved)


def lines_of(paid: PaidDataset, name: str) -> tuple[str, ...]:
    """What is told of the steps that it could not be paid, a line each."""
    lines = []
    unpaid, lost = paid.unpaid[name], paid.lost[name]
    if unpaid.any():
        lines.append(f"not paid the last step of {int(unpaid.sum()):,} episodes, since it looks at what came then")
    if lost.any():
        first = paid.each("number")[lost][0]
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
    for flag, given in (("--labels", labels), ("--success", success)):
        if given and success_above is not None:
            raise UsageError(f"{flag} and --success-above both say what succeeded: leave out one")
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
    noun, clusters = _clusters(paid, by_file)
    names, tasks = np.unique(paid.each("task"), return_inverse=True)
    compared, level = _Compared([paid], paid.succeeded, paid.known, clusters, tasks), None
    if below is not None:
        under = below.each("task")
        both = np.concatenate([paid.each("task"), under])
        level = _Compared(
            [paid, below],
            np.arange(len(both)) < len(paid),
            np.ones(len(both), bool),
            np.concatenate([clusters, clusters.max() + 1 + _clusters(below, by_file)[1]]),
            np.unique(both, return_inverse=True)[1] * (len(names) > 1 or len({*under.tolist()}) > 1),
        )
    known = np.isfinite(paid.moved)
    still, lengths = paid.summed(paid.still.astype(np.float64)), paid.summed(known.astype(np.float64))
    return DatasetAudit(
        paid.facts,
        None if below is None else below.facts.name,
        len(paid),
        paid.steps,
        int(paid.succeeded.sum()),
        int((paid.known & ~paid.succeeded).sum()),
        (noun, int(clusters.max()) + 1),
        Mean(**vars(share_of(still, lengths, clusters))),
        tuple(_answer(name, compared, level) for name in paid.paid),
        _pairs(paid, clusters),
        {**(below.failed if below else {}), **paid.failed},
        tuple(_notes(paid, below, noun, len(names), places)),
        tuple(names.tolist()),
        paid.facts.success,
    )


def _notes(
    paid: PaidDataset, below: PaidDataset | None, noun: str, tasks: int, places: "ArmPlaces | None"
) -> list[str]:
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
    if declared is not None and declared != tasks:
        notes.append(f"The metadata declares {declared:,} tasks, and {tasks:,} are in what is used")
    if noun == "operators" and (untold := int((paid.each("operator") == "").sum())):
        notes.append(f"Nothing says who made {untold:,} of the episodes: each of them counts by itself")
    unseen = int(np.isnan(paid.moved[paid.begins[1:] - 1]).sum())
    if unseen:
        notes.append(
            f"Nothing is known of what was seen after the last step of {unseen:,} episodes. Recorded pay counts there, "
            "and that of functions that do not look at next_observation"
        )
    if places is None and paid.still.any():
        notes.append("All numbers of an observation tell whether it stands still, also those that are no positions")
    return notes


def _clusters(paid: PaidDataset, by_file: bool) -> tuple[str, Ints]:
    """What intervals are over, and its number of each episode."""
    if by_file:
        return "files", np.unique(paid.each("file"), return_inverse=True)[1]
    if any(it.operator for it in paid.episodes):
        each = [it.operator or f"\0{number}" for number, it in enumerate(paid.episodes)]
        return "operators", np.unique(each, return_inverse=True)[1]
    return "episodes", np.arange(len(paid))


def _answer(name: str, compared: _Compared, level: _Compared | None) -> RewardAnswer:
    (paid,), clusters = compared.sides, compared.clusters
    steps = np.nan_to_num(paid.paid[name])
    earned = np.where(~np.isfinite(paid.moved), 0.0, np.maximum(steps, 0.0))
    held = _ranked(name, compared)
    if name == paid.told_by and held.answer != CANNOT_TELL:  # both what says what succeeds and what is asked about
        held = replace(held, answer=CANNOT_TELL, reason=OWN)
    return RewardAnswer(
        name,
        held,
        None if level is None or name not in level.sides[1].paid else _ranked(name, level),
        *_wrong(name, compared),
        Mean(**vars(share_of(paid.summed(np.where(paid.still, earned, 0.0)), paid.summed(earned), clusters))),
        _most_paid(paid, paid.paid[name]),
        lines_of(paid, name),
    )


def _wrong(name: str, compared: _Compared) -> tuple[int, tuple[WrongPair, ...]]:
    """How many failures are paid more than a success of their task, and the pairs that differ most.

    They are the worst paid success of a task beside its best paid failure, the next worst beside the next best, and so
    on.
    """
    (paid,) = compared.sides
    known, returns, steps = compared.known & ~paid.lost[name], paid.returns[name], np.nan_to_num(paid.paid[name])
    equal, count, found = rounded(returns), 0, list[tuple[int, int]]()
    low, high = (np.argsort(of, kind="stable") for of in (returns, -returns))
    for task in np.unique(compared.tasks[known]):
        success, failure = (known & (compared.tasks == task) & kind for kind in (compared.above, ~compared.above))
        best = np.sort(equal[failure])
        count += int((len(best) - np.searchsorted(best, equal[success], side="right")).sum())
        of_task = low[success[low]], high[failure[high]]
        found += zip(*(it[:MOST_PAIRS].tolist() for it in of_task), strict=False)
    told = [
        WrongPair(
            paid.episodes[one].number,
            paid.episodes[other].number,
            (float(returns[one]), float(returns[other])),
            (np.cumsum(steps[paid.episode_steps(one)]), np.cumsum(steps[paid.episode_steps(other)])),
        )
        for one, other in sorted(found, key=lambda pair: returns[pair[0]] - returns[pair[1]])[:MOST_PAIRS]
        if returns[other] > returns[one]
    ]
    return count, tuple(told)


def _most_paid(paid: PaidDataset, steps: Float) -> tuple[PaidStep, ...]:
    steps = np.where(np.isnan(steps), -np.inf, steps)
    largest = np.maximum.reduceat(steps, paid.begins[:-1])
    return tuple(
        PaidStep(paid.episodes[at].number, int(np.argmax(steps[paid.episode_steps(at)])), float(largest[at]))
        for at in np.argsort(-largest, kind="stable")[:MOST_STEPS].tolist()
        if np.isfinite(largest[at])
    )


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


KEYWORDS = (
    "places", "robot", "success", "labels", "success_above", "cluster", "partial", "beginner", "registry",
)  # fmt: skip
"""What `audit_dataset` takes by names, which are those of what is asked."""


def audited(asked: Asked) -> Answered:
    """An audit of a data set; see `audit_dataset`."""
    keywords = {name: getattr(asked, name) for name in KEYWORDS}
    return [audit_dataset(asked.named, asked.rewards, **keywords)], ()
