"""`audit_dataset`: for each reward, whether it ranks recorded behaviour as success does, and what it pays for."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.audit.dataset.dataset_audit import DatasetAudit, PaidStep, RewardAnswer, WrongPair
from harness.audit.dataset.paid_dataset import FAILURE, SUCCESS, UNKNOWN, PaidDataset, pay_dataset
from harness.audit.dataset.payers import Payer, given_payers, payers_of, places_of
from harness.audit.recorded.paid import Paid, compare_paid, pairs_of
from harness.audit.recorded.pair import Pair, pair_of
from harness.eta.auc import Auc, auc_of, rounded
from harness.eta.clustered_share import share_of
from harness.eta.rescaling import line_of
from harness.record.dataset.dataset import Dataset
from harness.record.dataset.open_dataset import open_dataset
from harness.registry.registry import Registry, load_registry
from harness.score.places import ArmPlaces

MOST_PAIRS, MOST_STEPS = 5, 3
"""So many wrongly ranked pairs, and steps, are told of each reward."""
BLOCKS = 10
"""Distances between rewards are means over so many parts of the data set."""
FILE = "file"
"""What `--cluster` says for episodes of one file to count as alike."""


def audit_dataset(
    dataset: str,
    rewards: Mapping[str, Any] | Sequence[str] = (),
    *,
    places: str | None = None,
    robot: str | None = None,
    success: str = "",
    cluster: str = "",
    beginner: str | None = None,
    registry: Registry | None = None,
) -> DatasetAudit:
    """Whether rewards rank recorded behaviour as success does.

    Args:
        dataset: ``minari:NAME`` or ``lerobot:FOLDER``.
        rewards: By name, functions of (observation, action, next_observation, info) or rewards of an arm; or names, as
            ``harness audit --reward`` takes them. Without any: those that are recorded, and the functions of plugin
            files in `registry`.
        places: Where an arm's end effector and target stand in an observation, ``end_effector=0:3,target=3:6``.
        robot: The robot whose joints `places` names.
        success: What says whether a step was a success: a key of infos, or a column; found by its name if empty.
        cluster: What says who made an episode: an attribute or a column, or ``file``; found by its name if empty.
        beginner: Another data set that should be paid less.
        registry: The plugins; loaded if None.

    Raises:
        UsageError: A data set, a reward, a place or a robot is none.
        SchemaError: A data set is damaged.
    """
    plugins = registry or load_registry()
    arm = places_of(places, robot, plugins)
    by_file = cluster == FILE
    opened = open_dataset(dataset, success, "" if by_file else cluster)
    other = open_dataset(beginner, "", "" if by_file else cluster) if beginner is not None else None

    def payers(of: Dataset) -> dict[str, Payer]:
        if isinstance(rewards, Mapping):
            return given_payers(rewards, arm)
        return payers_of(of, plugins, rewards, arm)

    paid = pay_dataset(opened, payers(opened), arm)
    below = None if other is None else pay_dataset(other, payers(other), arm)
    return judge(paid, below, arm, by_file)


def judge(
    paid: PaidDataset, below: PaidDataset | None = None, places: ArmPlaces | None = None, by_file: bool = False
) -> DatasetAudit:
    """What the paid steps say.

    Args:
        paid: Of the data set.
        below: Of one that should be paid less.
        places: By which standing still was told; None for all numbers of an observation.
        by_file: Whether episodes of one file count as alike, and not those of one operator.
    """
    noun, groups = _clusters(paid, by_file)
    known = paid.told != UNKNOWN
    still = paid.summed(paid.still.astype(np.float64))
    lengths = np.diff(paid.begins).astype(np.float64)
    answers = [_answer(paid, below, name, groups, by_file) for name in paid.paid]
    notes = list(paid.facts.notes)
    if not known.any():
        notes.append("Nothing says which episodes succeeded: name the column with --success")
    elif not known.all():
        notes.append(f"Episodes left out, since nothing says whether they succeeded: {int((~known).sum()):,}")
    if places is None and paid.still.any():
        notes.append("All numbers of an observation tell whether it stands still, also those that are no positions")
    return DatasetAudit(
        paid.facts,
        None if below is None else below.facts,
        len(paid),
        paid.steps,
        int((paid.told == SUCCESS).sum()),
        int((paid.told == FAILURE).sum()),
        (noun, int(groups.max()) + 1),
        share_of(still, lengths, groups),
        tuple(answers),
        _pairs(paid, groups),
        {**(below.failed if below else {}), **paid.failed},
        tuple(notes),
    )


def _clusters(paid: PaidDataset, by_file: bool) -> tuple[str, NDArray[np.int64]]:
    """What intervals are over, and the number of each episode's cluster."""
    if by_file:
        return "files", np.unique(paid.files, return_inverse=True)[1].astype(np.int64)
    if all(paid.operators):
        return "operators", np.unique(paid.operators, return_inverse=True)[1].astype(np.int64)
    return "episodes", np.arange(len(paid), dtype=np.int64)


def _answer(
    paid: PaidDataset, below: PaidDataset | None, name: str, groups: NDArray[np.int64], by_file: bool
) -> RewardAnswer:
    known, returns, steps = paid.told != UNKNOWN, paid.returns[name], paid.paid[name]
    success = paid.told == SUCCESS
    earned = np.maximum(steps, 0.0)
    wrong = _wrong(rounded(returns), success, known & ~success)
    return RewardAnswer(
        name,
        auc_of(returns[known], success[known], groups[known]),
        _by_level(paid, below, name, groups, by_file),
        wrong,
        _most_wrong(paid, name, success, known & ~success) if wrong else (),
        share_of(paid.summed(np.where(paid.still, earned, 0.0)), paid.summed(earned), groups),
        _most_paid(paid, steps),
    )


def _by_level(
    paid: PaidDataset, below: PaidDataset | None, name: str, groups: NDArray[np.int64], by_file: bool
) -> Auc | None:
    if below is None or name not in below.paid:
        return None
    returns = np.concatenate([paid.returns[name], below.returns[name]])
    above = np.arange(len(returns)) < len(paid)
    return auc_of(returns, above, np.concatenate([groups, groups.max() + 1 + _clusters(below, by_file)[1]]))


def _wrong(returns: Float, success: Mask, failure: Mask) -> int:
    best = np.sort(returns[failure])
    return int((len(best) - np.searchsorted(best, returns[success], side="right")).sum())


def _most_wrong(paid: PaidDataset, name: str, success: Mask, failure: Mask) -> tuple[WrongPair, ...]:
    """The worst paid success beside the best paid failure, the next worst beside the next best, and so on."""
    returns = paid.returns[name]
    low, high = (
        np.flatnonzero(it)[np.argsort(s * returns[it], kind="stable")] for it, s in ((success, 1), (failure, -1))
    )
    found = []
    for one, other in zip(low[:MOST_PAIRS].tolist(), high[:MOST_PAIRS].tolist(), strict=False):
        if returns[other] > returns[one]:
            curves = tuple(np.cumsum(paid.paid[name][paid.episode_steps(it)]) for it in (one, other))
            numbers = int(paid.numbers[one]), int(paid.numbers[other])
            found.append(WrongPair(*numbers, (float(returns[one]), float(returns[other])), (curves[0], curves[1])))
    return tuple(found)


def _most_paid(paid: PaidDataset, steps: Float) -> tuple[PaidStep, ...]:
    largest = np.maximum.reduceat(steps, paid.begins[:-1])
    found = []
    for place in np.argsort(-largest, kind="stable")[:MOST_STEPS].tolist():
        step = int(np.argmax(steps[paid.episode_steps(place)]))
        found.append(PaidStep(int(paid.numbers[place]), step, float(largest[place])))
    return tuple(found)


def _pairs(paid: PaidDataset, groups: NDArray[np.int64]) -> tuple[Pair, ...]:
    """Every two rewards: means over parts of the data set, no cluster in two of them."""
    names = tuple(paid.paid)
    part = groups % min(BLOCKS, int(groups.max()) + 1)
    step_part = np.repeat(part, np.diff(paid.begins))
    members = [(part == number, step_part == number) for number in range(int(part.max()) + 1)]
    blocks = [
        Paid(
            {name: paid.paid[name][steps] for name in names}, {name: paid.returns[name][it] for name in names}, {}
        )
        for it, steps in (members if len(names) > 1 else ())
    ]  # fmt: skip
    return tuple(
        pair_of(
            one,
            other,
            [compare_paid(block, one, other) for block in blocks],
            [line_of(block.steps[one], block.steps[other]) for block in blocks],
        )
        for one, other in pairs_of(names)
    )
