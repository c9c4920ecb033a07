"""`harness.audit_rewards`: how far apart rewards are in any Gymnasium environment, potential shaping left out too."""

import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium.wrappers import TimeLimit

from harness.audit.recorded.earned import Earned
from harness.audit.recorded.paid import Paid, compare_paid, paid_in, pairs_of
from harness.audit.recorded.pair import mean_within, pair_of
from harness.audit.recorded.recordings import RANDOM
from harness.audit.transitions.asked import of_transitions
from harness.audit.transitions.canonical_forms import one_by_one
from harness.audit.transitions.form_distances import FORMS, FormVector, draw_coverages, form_distance, form_vector
from harness.audit.transitions.reward_audit import FormsOfPair, RewardAudit
from harness.errors import UsageError
from harness.eta.rescaling import line_of
from harness.eta.seed_mean import mean_over_seeds
from harness.record.recording.recorded_training import read_recording
from harness.recorder.record_rewards import RecordRewards
from harness.recorder.walk import KeepWalks, Walk
from harness.results.recordings.episodes import episodes_of
from harness.reward.given import OWN, Given

MEASUREMENTS = 5
"""Each has episodes and samples of its own; intervals are over them."""

Policy = Callable[[Any], Any]
Env = gymnasium.Env[Any, Any]


def audit_rewards(
    env: Env | str | Callable[[], Env],
    rewards: Mapping[str, Given],
    *,
    policies: Mapping[str, Policy] | None = None,
    gamma: float = 0.99,
    episodes: int = 10,
    steps: int = 1_000,
    seed: int = 0,
) -> RewardAudit:
    """How far apart rewards are: in the steps of random actions and of policies, and as EPIC, DARD and STARC see them.

    The last three do not change when gamma phi(s') - phi(s) is added to a reward. They ask it about transitions that
    nobody took, and need a function of (observation, action, next_observation) alone. A reward that reads `info`, has
    a memory, or is what the env pays, is compared in the steps that were taken only. Nothing is trained.

    Args:
        env: One that was made, which is left open; the id of one; or a function that makes one.
        rewards: As of `harness.RecordRewards`. What the env pays is added to them as ``own``.
        policies: By name, from an observation to an action; random actions are always there beside them.
        gamma: Discount per step, above 0 and below 1.
        episodes: Of each policy in each of 5 measurements.
        steps: Most of an episode; a longer one is cut.
        seed: Of all that is drawn.

    Raises:
        UsageError: Something of that cannot be used, or a reward fails in a step that was taken.
    """
    policies = policies or {}
    _check(rewards, policies, gamma, episodes, steps, seed)
    made = _make(env)
    try:
        taken = [
            _take(made, rewards, policies, episodes, steps, np.random.default_rng([seed, number]))
            for number in range(MEASUREMENTS)
        ]
    finally:
        if made is not env:
            made.close()
    names = taken[0].names
    found = [_measure(it, gamma) for it in taken]
    return RewardAudit(
        made.spec.id if made.spec is not None else type(made.unwrapped).__name__,
        (RANDOM, *policies),
        gamma,
        MEASUREMENTS,
        episodes,
        sum(len(walk.actions) for it in taken for walk in it.walks),
        names,
        tuple(_pair(pair, taken, found) for pair in pairs_of(names)),
        tuple(_earned(policy, taken, names) for policy in (RANDOM, *policies)),
    )


def _check(
    rewards: Mapping[str, Given], policies: Mapping[str, Policy], gamma: float, episodes: int, steps: int, seed: int
) -> None:
    if not rewards:
        raise UsageError("rewards={}: name at least one reward, such as {'upright': function}")
    own = [name for name, given in rewards.items() if isinstance(given, str) and given == OWN]
    if len(own) > 1:
        raise UsageError(f"rewards: {own[0]!r} and {own[1]!r} are both what the env pays: leave one out")
    if not 0.0 < gamma < 1.0:
        raise UsageError(f"gamma={gamma:g}: must be above 0 and below 1")
    for name, number, least in (("episodes", episodes, 1), ("steps", steps, 1), ("seed", seed, 0)):
        if number < least:
            raise UsageError(f"{name}={number}: must be at least {least}")
    for name, policy in policies.items():
        if name == RANDOM or not callable(policy):
            raise UsageError(
                f"policies: {name!r} is {policy!r}: give a function from an observation to an action, under another "
                f"name than {RANDOM!r}"
            )


def _own(rewards: Mapping[str, Given]) -> str:
    """Under which name what the env pays is recorded."""
    return next((name for name, given in rewards.items() if isinstance(given, str) and given == OWN), OWN)


def _make(env: Env | str | Callable[[], Env]) -> Env:
    if isinstance(env, str):
        try:
            return gymnasium.make(env)
        except gymnasium.error.Error as error:
            raise UsageError(f"env='{env}' cannot be made: {error}") from error
    made = env() if callable(env) and not isinstance(env, gymnasium.Env) else env
    if not isinstance(made, gymnasium.Env):
        raise UsageError(f"env is {type(made).__name__}: give one gymnasium.Env, its id, or a function that makes it")
    return made


@dataclass(frozen=True, eq=False)
class _Taken:
    """The steps of one measurement.

    Attributes:
        rewards: By name, as given, ``own`` among them.
        walks: Of all policies, one after the other.
        paid: For their steps.
        returns: By policy, then by reward, (episodes,).
        rng: Where samples are drawn from.
    """

    rewards: Mapping[str, Given]
    walks: list[Walk]
    paid: Paid
    returns: Mapping[str, Mapping[str, Any]]
    rng: np.random.Generator

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the rewards."""
        return tuple(self.rewards)


def _take(
    env: Env,
    rewards: Mapping[str, Given],
    policies: Mapping[str, Policy],
    episodes: int,
    steps: int,
    rng: np.random.Generator,
) -> _Taken:
    """Every policy meets the same episodes."""
    seeds = [int(number) for number in rng.integers(2**31, size=episodes)]
    env.action_space.seed(seeds[0])
    acting = {RANDOM: lambda observation: env.action_space.sample(), **policies}
    walks: list[Walk] = []
    paid: list[Paid] = []
    returns = {}
    with tempfile.TemporaryDirectory(prefix="harness-audit-") as folder:
        for number, (name, policy) in enumerate(acting.items()):
            path = Path(folder) / str(number)
            walks += _record(env, rewards, policy, path, seeds, steps)
            recording = read_recording(path)
            paid.append(paid_in(recording, episodes_of(recording)))
            returns[name] = paid[-1].returns
    own = _own(rewards)
    return _Taken(rewards if own in rewards else {**rewards, own: OWN}, walks, sum(paid[1:], paid[0]), returns, rng)


def _record(
    env: Env, rewards: Mapping[str, Given], policy: Policy, path: Path, seeds: Iterable[int], steps: int
) -> list[Walk]:
    keeper = KeepWalks(TimeLimit(env, steps))
    recorder = RecordRewards(
        keeper, path, trained_with=_own(rewards), rewards=rewards, evaluation=True, seed=0, on_error="raise"
    )
    try:
        for seed in seeds:
            observation, _ = recorder.reset(seed=seed)
            ended = False
            while not ended:
                observation, _, terminated, truncated, _ = recorder.step(policy(observation))
                ended = terminated or truncated
    finally:
        recorder.finish()
    return keeper.walks


@dataclass(frozen=True, eq=False)
class _Measured:
    """By canonical form and reward, a vector or why there is none."""

    vectors: Mapping[tuple[str, str], FormVector | str]

    def distance(self, form: str, one: str, other: str) -> float | str | None:
        """None where it is not defined, the reason where a reward cannot be asked."""
        first, second = self.vectors[form, one], self.vectors[form, other]
        if isinstance(first, str):
            return f"{one}: {first}"
        if isinstance(second, str):
            return f"{other}: {second}"
        return form_distance(first, second)


def _measure(taken: _Taken, gamma: float) -> _Measured:
    pays, reasons = of_transitions(taken.rewards, taken.walks, taken.paid.steps)
    coverages = draw_coverages(taken.walks, taken.rng)
    vectors: dict[tuple[str, str], FormVector | str] = {
        (form, name): form_vector(one_by_one(pays[name]), form, gamma, coverages) if name in pays else reasons[name]
        for form in FORMS
        for name in taken.names
    }
    return _Measured(vectors)


def _pair(pair: tuple[str, str], taken: Sequence[_Taken], found: Sequence[_Measured]) -> FormsOfPair:
    distances, reasons = {}, {}
    for form in FORMS:
        each = [it.distance(form, *pair) for it in found]
        told = [it for it in each if isinstance(it, str)]
        known = [] if told else [it for it in each if isinstance(it, float)]
        distances[form] = mean_within(known)
        if told:
            reasons[form] = told[0]
        elif not known:
            reasons[form] = "one of the two is nothing but an offset and shaping by a potential"
    lines = [line_of(*(it.paid.steps[name] for name in pair)) for it in taken]
    return FormsOfPair(pair_of(*pair, [compare_paid(it.paid, *pair) for it in taken], lines), distances, reasons)


def _earned(policy: str, taken: Sequence[_Taken], names: Iterable[str]) -> Earned:
    returns = {name: np.concatenate([it.returns[policy][name] for it in taken]).tolist() for name in names}
    count = len(next(iter(returns.values())))
    return Earned(policy, count, {name: mean_over_seeds(values) for name, values in returns.items()})
