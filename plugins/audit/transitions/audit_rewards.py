"""`audit_rewards`: how far apart rewards are in any Gymnasium environment, potential shaping left out too."""

import tempfile
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from gymnasium.wrappers import TimeLimit

from harness.errors import UsageError
from harness.eta.interval import UNBOUNDED, Bounds
from harness.log import Log
from harness.log.log import REWARD
from harness.record import read_recording
from harness.record.recording.facts import facts_of
from harness.recorder.record_rewards import RecordRewards
from harness.recorder.recorder import differs
from harness.recorder.sealed import KeepWalks, Walk
from harness.results.recordings.episodes import Episodes, can_be, count_text, episodes_of
from harness.reward import Given
from harness.reward.given import OWN

from ..audit import Audit
from ..distance import FORMS, Form
from ..questions import NO_SCRIPTS, NO_SUCCESS, deciding_measure, on_best, rank_success
from ..recorded.earned import RANDOM, earned_by
from ..recorded.pair import pairs_in
from ..recorded.pair_grid import SCALE
from .asked import NoTransitionReward, of_transition
from .canonical_forms import cover, forms_of, one_by_one

GAMMA, EPISODES = 0.99, 10
MEASUREMENTS = 5
"""Each has episodes and samples of its own; intervals are over them."""

Policy = Callable[[Any], Any]
Env = gymnasium.Env[Any, Any]
ByName = Mapping[str, Given]
"""Rewards, or measures."""


def audit_rewards(
    env: Env | str | Callable[[], Env],
    rewards: ByName,
    *,
    policies: Mapping[str, Policy] | None = None,
    gamma: float = GAMMA,
    episodes: int = EPISODES,
    steps: int = 1_000,
    seed: int = 0,
    behaviour: ByName | None = None,
    bounds: Mapping[str, Bounds] | None = None,
    compared: Collection[str] | None = None,
) -> Audit:
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
        behaviour: Measures of what policies do, as of `harness.RecordRewards`; no reward enters them.
        bounds: By name of a measure, the least and the greatest value that it can have.
        compared: Names of the rewards that are told of, ``own`` among them if it is; None for all.

    Raises:
        UsageError: Something of that cannot be used, or a reward fails in a step that was taken.
    """
    policies = policies or {}
    if not rewards:
        raise UsageError("rewards={}: name at least one reward, such as {'upright': function}")
    own = [name for name, given in rewards.items() if isinstance(given, str) and given == OWN]
    if len(own) > 1:
        raise UsageError(f"rewards: {own[0]!r} and {own[1]!r} are both what the env pays: leave one out")
    trained = own[0] if own else OWN
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
    made, drawn = opened_env(env), [np.random.default_rng([seed, number]) for number in range(MEASUREMENTS)]
    try:
        taken = [_take(made, trained, rewards, behaviour or {}, policies, episodes, steps, rng) for rng in drawn]
    finally:
        if made is not env:
            made.close()
    given = {**rewards, trained: OWN}
    names = tuple(name for name in given if compared is None or name in compared)
    forms = [_forms(it, {name: given[name] for name in names}, gamma) for it in taken]
    pairs, _ = pairs_in([("", it.log) for it in taken], names, forms)
    acting = (RANDOM, *policies)
    by_policy = {policy: [it.of(number, episodes) for it in taken] for number, policy in enumerate(acting)}
    everything = [it.episodes for it in taken]
    measures = {name: can_be(name, everything, (bounds or {}).get(name, UNBOUNDED)) for name in behaviour or {}}
    earned = tuple(earned_by(policy, each, names, measures) for policy, each in by_policy.items())
    success, count = deciding_measure(everything), sum(len(it.log) for it in taken)
    name = made.spec.id if made.spec is not None else type(made.unwrapped).__name__
    return Audit(
        title=f"{name}: rewards {', '.join(names)}; discount {gamma:g}",
        facts={
            "env": name,
            "policies": list(acting),
            "gamma": gamma,
            "measurements": MEASUREMENTS,
            "episodes": episodes,
            "steps": count,
        },
        rewards=names,
        pairs=pairs,
        earned=earned,
        success=success,
        rankings={reward: rank_success(everything, reward, success) for reward in names} if success else {},
        verdict=tuple(on_best(earned, names, success)),
        measured=(
            f"{SCALE} Measured {MEASUREMENTS} times in the transitions of {', '.join(acting)}, each time with "
            f"{count_text(episodes, 'new episode')} of each and new samples, {count:,} steps in all. The 95% intervals "
            "are over these measurements. They say how much another measurement with the same policies would differ. "
            "Other policies meet other transitions, where the distances are others.",
        ),
        not_asked=(NO_SCRIPTS.format("an environment"), *([] if success else [NO_SUCCESS])),
    )


def opened_env(env: Env | str | Callable[[], Env]) -> Env:
    """The env that somebody made, or one of an id, or of a function that makes it.

    Raises:
        UsageError: It is none of these, or cannot be made.
    """
    if isinstance(env, str):
        try:
            return gymnasium.make(env)
        except gymnasium.error.Error as error:
            raise UsageError(f"env='{env}' cannot be made: {error}") from error
    made = env() if callable(env) and not isinstance(env, gymnasium.Env) else env
    if not isinstance(made, gymnasium.Env):
        raise UsageError(f"env is {type(made).__name__}: give one gymnasium.Env, its id, or a function that makes it")
    return made


class _Taken(NamedTuple):
    """One measurement: its steps, those of all policies one after the other, and where samples are drawn from."""

    log: Log
    episodes: Episodes
    walks: list[Walk]
    rng: np.random.Generator

    def of(self, number: int, count: int) -> Episodes:
        """The episodes of one policy, of which each has so many."""
        facts, own = facts_of(self.log), slice(number * count, (number + 1) * count)
        return Episodes.of(facts, self.episodes.numbers[:, own])


def _take(
    env: Env,
    own: str,
    rewards: ByName,
    behaviour: ByName,
    policies: Mapping[str, Policy],
    episodes: int,
    steps: int,
    rng: np.random.Generator,
) -> _Taken:
    """Every policy meets the same episodes."""
    seeds = [int(number) for number in rng.integers(2**31, size=episodes)]
    env.action_space.seed(seeds[0])
    keeper = KeepWalks(TimeLimit(env, steps))
    with tempfile.TemporaryDirectory(prefix="harness-audit-") as folder:
        path = Path(folder) / "steps"
        recorder = RecordRewards(
            keeper, path, trained_with=own, rewards=rewards, behaviour=behaviour, evaluation=True, seed=0,
            on_error="raise",
        )  # fmt: skip
        try:
            for policy in (lambda observation: env.action_space.sample(), *policies.values()):
                for seed in seeds:
                    observation, _ = recorder.reset(seed=seed)
                    ended = False
                    while not ended:
                        observation, _, terminated, truncated, _ = recorder.step(policy(observation))
                        ended = terminated or truncated
        finally:
            recorder.finish()
        log = read_recording(path).load()
        return _Taken(log, episodes_of(log), keeper.walks, rng)


def _forms(taken: _Taken, rewards: ByName, gamma: float) -> dict[str, Mapping[str, Form]]:
    """Each reward in every canonical form, or why it has none."""
    coverage, found = cover([len(walk.actions) for walk in taken.walks], taken.rng), dict[str, Mapping[str, Form]]()
    for name, given in rewards.items():
        try:
            ask = one_by_one(of_transition(name, given), taken.walks)
            with np.errstate(all="ignore"):  # what is not finite is refused
                again = ask(coverage.steps, coverage.steps, coverage.steps + 1)
            if differs(again, taken.log[f"{REWARD}{name}"]).any():
                raise NoTransitionReward(
                    "asked again about a step, it pays something else: it looks at more than the transition"
                )
            found[name] = forms_of(ask, gamma, coverage)
        except NoTransitionReward as error:
            found[name] = dict.fromkeys(FORMS, str(error))
    return found
