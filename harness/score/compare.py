"""Compares two groups of recorded runs: their indices, eta_N, eta_P, and how much of each is only a change of ruler."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from harness.errors import UsageError
from harness.eta.curve import GroupCurve, Kind
from harness.eta.decompose import decompose
from harness.eta.number import number_sentence
from harness.eta.scored_sums import BB, BK, KB, KK, Pair
from harness.eta.splits import Decomposition, Names
from harness.eta.swaps import corrected_p
from harness.log import Log
from harness.registry.choice import choose
from harness.registry.registry import Registry
from harness.reward import Reward
from harness.score.compared_rows import copy_notes, notes_of, stream_groups
from harness.score.csv_steps import EVENTS
from harness.score.reward_guess import Guess, guess_reward, misfit
from harness.score.scorer import can_be_paid


@dataclass(frozen=True, eq=False)
class ComparedRuns:
    """Two groups of recorded runs, compared.

    Attributes:
        decomposition: Both etas, split where both rewards are known and the distances are recorded.
        curves: S_r(tau_q) by (r, q).
        rewards: What paid each group, ``baseline`` and ``proposed``; None where no registered reward did.
        runs: How many runs each group has.
        rows_left_out: The group's rows behind the shortest run of both groups: no two curves have them both.
        with_events: Whether the event terms are in the curves.
        notes: What a reader has to know of the files: budgets that were cut, copies that count once.
    """

    decomposition: Decomposition
    curves: Mapping[Pair, GroupCurve]
    rewards: dict[str, str | None]
    runs: dict[str, int]
    rows_left_out: dict[str, int]
    with_events: bool
    notes: tuple[str, ...] = ()

    @property
    def kind(self) -> Kind:
        """Which curve the indices are taken from."""
        return self.curves[BB].kind

    @property
    def number(self) -> str:
        """How much the indices changed, and how much of that is ruler, in words; see `harness.eta.number`."""
        known = [self.rewards[who] or f"the {who} reward" for who in ("baseline", "proposed")]
        return number_sentence(Names(*known), self.decomposition.splits)

    def to_json(self) -> dict[str, Any]:
        """What ``harness eta --json`` prints."""
        return {
            "format": 1,
            **self.decomposition.to_json(),
            "rewards": self.rewards,
            "runs": self.runs,
            "rows_left_out": self.rows_left_out,
            "curve": self.kind,
            "with_events": self.with_events,
            "number": self.number,
            "notes": list(self.notes),
        }


def compare_logs(
    baseline: Sequence[Log],
    proposed: Sequence[Log],
    registry: Registry,
    *,
    kind: Kind = "accumulated",
    with_events: bool = False,
    baseline_reward: str | None = None,
    proposed_reward: str | None = None,
) -> ComparedRuns:
    """Indices and etas of two groups of runs, read in lock-step: files of any length, in bounded memory.

    Args:
        baseline: Runs trained under the baseline reward.
        proposed: Runs trained under the proposed one.
        registry: Where rewards are looked up.
        kind: Which curve; see `GroupCurve`.
        with_events: Add the event terms to the shaped reward.
        baseline_reward: What paid the baseline's runs; found out if None.
        proposed_reward: The same for the proposed ones.

    Raises:
        UsageError: A file cannot be read or has no event terms, or a reward that is given did not pay the runs.
    """
    _require_events([*baseline, *proposed] if with_events else [])
    groups = [_in_order_of_seeds(baseline), _in_order_of_seeds(proposed)]
    _require_apart(*groups)
    given = (baseline_reward, proposed_reward)
    guesses = [_reward_of(group, name, registry) for group, name in zip(groups, given, strict=True)]
    missing = _why_not_split([*baseline, *proposed], guesses)
    others = [None, None] if missing is not None else [_build(guess, registry) for guess in reversed(guesses)]
    stream = partial(stream_groups, others=others, kind=kind, with_events=with_events)
    sides = stream(groups)
    copies = [side.copies for side in sides]
    if any(copies):
        groups = [[run for run in group if run not in of] for group, of in zip(groups, copies, strict=True)]
        sides = stream(groups)
    curves: dict[Pair, GroupCurve] = {BB: sides[0].own, KK: sides[1].own}
    if sides[0].other is not None and sides[1].other is not None:
        curves |= {KB: sides[0].other, BK: sides[1].other}
    elif missing is None:
        missing = "one group's reward is not finite on the other group's runs"
    names = ("baseline", "proposed")
    return ComparedRuns(
        _corrected(decompose(curves, _are_paired(*groups), missing)),
        curves,
        {name: guess.choice for name, guess in zip(names, guesses, strict=True)},
        {name: len(group) for name, group in zip(names, groups, strict=True)},
        {name: side.left_out for name, side in zip(names, sides, strict=True)},
        with_events,
        (*copy_notes(copies), *notes_of(sides)),
    )


def _corrected(found: Decomposition) -> Decomposition:
    """Both etas with corrected p-values, because they are claims that are made together."""
    outcomes = [split.outcomes for split in found.splits.values()]
    known = [claim for claim in outcomes if claim is not None]
    return found.with_corrected(*corrected_p(known)) if len(known) == len(outcomes) else found


# Which rewards


def _reward_of(group: Sequence[Log], given: str | None, registry: Registry) -> Guess:
    """The reward that paid a group: the one that pays every run of it as recorded."""
    if given is not None:
        choose(registry, "rewards", given)
    guess = Guess(given) if given is not None else guess_reward(group[0], registry)
    if guess.choice is None:
        return guess
    for log in group:
        problem = misfit(log, guess.choice, registry) if can_be_paid(log) else None
        if problem is not None and given is not None:
            raise UsageError(f"The runs were not paid by {given}: {problem}")
        if problem is not None:
            return Guess(None, f"no one reward pays all runs of a group: {problem}")
    return guess


def _why_not_split(logs: Sequence[Log], guesses: Sequence[Guess]) -> str | None:
    """Why the runs cannot be scored again; None if they can."""
    bare = next((log for log in logs if not can_be_paid(log)), None)
    if bare is not None:
        return f"{bare.facts.path} has no distances to score again"
    return next((guess.reason for guess in guesses if guess.choice is None), None)


def _build(guess: Guess, registry: Registry) -> Reward:
    assert guess.choice is not None  # or there is a reason not to split
    reward: Reward = choose(registry, "rewards", guess.choice).build(registry, "rewards")
    return reward


# Which runs


def _require_events(logs: Sequence[Log]) -> None:
    for log in logs:
        if not all(name in log for name in EVENTS):
            raise UsageError(f"{log.facts.path} has no event terms: leave out --with-events")


def _require_apart(baseline: Sequence[Log], proposed: Sequence[Log]) -> None:
    """Check that no file is in both groups, unless both are the same group."""
    ours, theirs = ({log.facts.path.resolve(): log.facts.path for log in group} for group in (baseline, proposed))
    both = [path for place, path in ours.items() if place in theirs]
    if both and ours.keys() != theirs.keys():
        raise UsageError(f"'{both[0]}' is in both groups: let --baseline and --proposed name different files")


def _in_order_of_seeds(group: Sequence[Log]) -> list[Log]:
    """The logs by seed if all seeds are known, else as given."""
    known = {log: log.facts.seed for log in group if log.facts.seed is not None}
    return sorted(group, key=lambda log: known[log]) if len(known) == len(group) else list(group)


def _are_paired(baseline: Sequence[Log], proposed: Sequence[Log]) -> bool:
    """Whether run i of both groups has the same seed, or is the same run."""
    if [log.facts.path for log in baseline] == [log.facts.path for log in proposed]:
        return True
    seeds_b, seeds_k = ([log.facts.seed for log in group] for group in (baseline, proposed))
    return seeds_b == seeds_k and None not in seeds_b and len(set(seeds_b)) == len(seeds_b)
