"""What an algorithm must satisfy. Each check takes the algorithm.

They train it for real, on an easy task without an engine, with the hyperparameters that it was given: `FEW` steps have
to be enough for it to begin learning, `MANY` to learn something. The task's actions are of the kind that it takes; what
may go wrong with one kind alone is tried with each. One that says that it does not learn, ``learns = False``, is
held to that, and to nothing about learning.
"""

import random
import shutil
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from harness import Float, Mask
from harness.algorithm import Algorithm, TrainingState, learns, needs_goals
from harness.env.vector_env import ReachVectorEnv
from harness.experiment.checkpoints.checkpoint import Checkpoint, read_checkpoint, store
from harness.policy import Policy, load_policy

from .contract import check, require, settings_are_frozen, settings_survive_json
from .trainings import (
    ENV_SEED,
    Told,
    Training,
    WatchedEnv,
    in_several_envs,
    mean_return,
    observations,
    steps_for,
    train,
    train_anew,
    trainings,
)

ORIGIN = {"cell": "the easy task"}


@dataclass
class Left:
    """A checkpoint that a training left, alone in a folder of its own, and the rows that were recorded before."""

    folder: Path
    steps: int
    rows: int


@dataclass
class Resumable:
    """A training that was done: the policy, every row that was recorded, the checkpoints that were left.

    Also the scalars that were told, with the steps after which they were.
    """

    policy: Policy
    rows: Float
    left: list[Left]
    scalars: list[tuple[int, dict[str, float]]]


class _Keeping(Told):
    """Writes a checkpoint every so many steps into a folder; may go on from one."""

    def __init__(
        self, env: ReachVectorEnv, rows: list[Float], folder: Path, every: int, start: Checkpoint | None
    ) -> None:
        super().__init__()
        self._env, self._rows, self._folder, self._every, self._start = env, rows, folder, every, start
        self._last = start.steps if start else 0
        self._rings = start.rings if start else {}
        self.left: list[Left] = []
        self.told_scalars: list[tuple[int, dict[str, float]]] = []

    def checkpoint(self, steps: int, make: Callable[[], TrainingState]) -> None:
        if steps < self._last + self._every:
            return
        stored = store(self._folder, make(), self._env.state(), self._rings)
        Checkpoint(steps, ORIGIN, **stored).write(self._folder)
        self._last, self._rings = steps, stored["rings"]
        copied = self._folder.with_name(f"{self._folder.name}-{steps}")
        shutil.copytree(self._folder, copied)
        self.left.append(Left(copied, steps, sum(map(len, self._rows))))

    def scalars(self, steps: int, values: Mapping[str, float]) -> None:
        self.told_scalars.append((steps, dict(values)))

    def restored(self) -> TrainingState | None:
        return self._start.restored(self._folder) if self._start else None


def open_easy(algorithm: Algorithm) -> ReachVectorEnv:
    """The easy task with as many envs as the algorithm wants."""
    return WatchedEnv(algorithm.num_envs, min(algorithm.action_spaces), needs_goals(algorithm))


def train_with_checkpoints(
    algorithm: Algorithm,
    steps: int,
    every: int,
    folder: Path,
    start: Left | None = None,
    open_env: Callable[[Algorithm], ReachVectorEnv] = open_easy,
) -> Resumable:
    """Train; leave a checkpoint every so many steps, or as soon after as the algorithm offers one.

    Args:
        algorithm: What learns.
        steps: Environment steps in all, or a few more to make it a multiple of the algorithm's envs.
        every: Environment steps from one checkpoint to the next, at least.
        folder: Where the checkpoints are left, and beside it.
        start: To go on from.
        open_env: What to train on.
    """
    folder.mkdir(exist_ok=True)
    env, rows = open_env(algorithm), list[Float]()
    env.recorder = _Rows(rows)
    checkpoint = None
    if start is None:
        env.reset(seed=ENV_SEED)
    else:
        shutil.copytree(start.folder, folder, dirs_exist_ok=True)
        checkpoint = read_checkpoint(folder, ORIGIN)
        env.restore(checkpoint.env)
    progress = _Keeping(env, rows, folder, every, checkpoint)
    policy = algorithm.train(env, steps_for(algorithm, steps), 0, progress)
    env.close()
    return Resumable(policy, np.concatenate(rows), progress.left, progress.told_scalars)


class _Rows:
    """A `harness.record.trace.Recorder` that keeps the rows."""

    def __init__(self, rows: list[Float]) -> None:
        self._rows = rows

    def append(self, rows: Float) -> None:
        self._rows.append(rows.copy())


def differences(whole: Resumable, again: Resumable, left: Left | None = None) -> str:
    """How a training that went on from `left`, or from the beginning, ended otherwise; empty if it did not."""
    if not np.array_equal(again.rows, whole.rows[left.rows if left else 0 :]):
        return "does other steps"
    same = all(np.array_equal(again.policy.weights[name], array) for name, array in whole.policy.weights.items())
    return "" if same else "ends with other weights"


COMPARED = {True: 0.6, False: 0.25}
"""The share of a training that is compared, at its end: where it tells its policy on the way, and where not."""
MARGIN = {True: 0.08, False: 0.25}
"""By how much the share of actions above the policy's may be off one half."""
SURE = {True: 4.5, False: 6.0}
"""Standard errors that it has to be off besides."""
FEWEST_TOGETHER = 6
MOST_TOGETHER = 2.5
"""The mean of the squares, in standard errors, over so many shares or more: together they tell more than one alone."""
FEWEST = 30
"""Actions that anything is concluded from."""
AT_THE_END = 1e-4
"""How near to an end of the box an action was clipped, and has nothing on its other side."""


def require_in_the_middle(training: Training) -> None:
    """Raise AssertionError where the training took actions that its policy is not in the middle of."""
    tells, decisions = training.tells_its_policy, training.env.decisions
    kept = decisions[len(decisions) - int(COMPARED[tells] * len(decisions)) :]
    compared = [each for each in kept if each.policy is not None or not tells]
    if not compared:
        return
    done = np.concatenate([each.action for each in compared])
    own = np.concatenate([(each.policy or training.policy).act(each.observation) for each in compared])
    if training.env.space == "discrete":
        _require_most_frequent(done, own, tells)
    else:
        # No two numbers of different envs are alike.
        numbers = [each.episode * len(each.episode) + np.arange(len(each.episode)) for each in compared]
        episodes = np.concatenate(numbers)
        _require_median(done.astype(float), own.astype(float), episodes, tells)


def _require_most_frequent(done: Any, own: Any, tells: bool) -> None:
    """Where the policy would choose k, the training chose nothing else far more often than k."""
    for choice in np.unique(own):
        counts = np.bincount(done[own == choice], minlength=int(choice) + 1)
        total, most = counts.sum(), int(counts.argmax())
        ahead = (counts[most] - counts[choice]) / total
        sure = ahead > SURE[tells] / np.sqrt(total) and ahead > MARGIN[tells]
        require(
            total < FEWEST or not sure,
            f"where the policy chooses {choice}, the training chose {most} in {counts[most]} of {total} steps and "
            f"{choice} in {counts[choice]}: the policy is not the one that was trained",
        )


def _require_median(done: Float, own: Float, episodes: Any, tells: bool) -> None:
    """Training actions are as often above the policy's as below, where that one is large and where it is small."""
    shares = [
        _share_above(done[:, number], own[:, number], where, episodes, f"action {number + 1}{part}")
        for number in range(own.shape[1])
        for part, where in _parts(own[:, number])
        if np.count_nonzero(where) >= FEWEST
    ]
    for share in shares:
        require(share.off <= max(MARGIN[tells], SURE[tells] * share.error), share.told)
    together = np.array([(share.off / share.error) ** 2 for share in shares])
    if tells and len(together) >= FEWEST_TOGETHER:
        worst = shares[int(together.argmax())]
        require(together.mean() <= MOST_TOGETHER, f"{worst.told}; the other actions are off too")


def _parts(own: Float) -> list[tuple[str, Mask]]:
    """Where an action of the policy is inside the box: large, and small."""
    inside: Mask = np.abs(own) < 1.0 - AT_THE_END
    middle = np.median(own[inside]) if inside.any() else 0.0
    return [(" where it is large", inside & (own > middle)), (" where it is small", inside & (own <= middle))]


class _Share(NamedTuple):
    """How far the share of actions above the policy's is off one half, its standard error, and that in words."""

    off: float
    error: float
    told: str


def _share_above(done: Float, own: Float, where: Mask, episodes: Any, name: str) -> _Share:
    done, own = done[where], own[where]
    above = float(np.where(done > own, 1.0, np.where(done < own, 0.0, 0.5)).mean())
    told = (
        f"{above:.0%} of the actions in training are above the policy's {name}, and half of them should be: it is "
        f"{own.mean():.2f} on average, in training {done.mean():.2f}; the policy does not act as it trained"
    )
    return _Share(abs(above - 0.5), _error_of_share(done - own, episodes[where]), told)


def _error_of_share(noise: Float, episodes: Any) -> float:
    """Standard error of the share of actions that are above: that of a coin, thrown as often as noise was drawn.

    Some learners draw noise anew in every step, some keep it for an episode. The intraclass correlation of the steps of
    an episode tells which.
    """
    _, numbers, counts = np.unique(episodes, return_inverse=True, return_counts=True)
    means = np.bincount(numbers, weights=noise) / counts
    total, within = float(noise.var()), float(((noise - means[numbers]) ** 2).mean())
    common = 1.0 - within / total if total > 0.0 else 1.0
    drawn = len(noise) / (1.0 + (counts.mean() - 1.0) * common)
    return float(0.5 / np.sqrt(drawn))


FEW, MANY = 200, 1000
LONGER, EVERY = 336, 120
"""The steps of a training with checkpoints, and from one to the next."""
MIN_RISE = 5.0
"""The least rise of the mean return, [m]: 20 steps on the way instead of away from it bring several times as much."""


@check("algo-action-spaces")
def action_spaces_are_declared(algorithm: Algorithm) -> None:
    """`action_spaces` is a frozenset of ``continuous``, ``discrete`` or both."""
    spaces = algorithm.action_spaces
    known = isinstance(spaces, frozenset) and spaces and spaces <= {"continuous", "discrete"}
    require(known, f"action_spaces is {spaces!r}, not a frozenset of 'continuous' and 'discrete'")


@check("algo-budget")
def the_budget_is_spent_exactly(algorithm: Algorithm) -> None:
    """Training takes exactly as many environment steps as it was given, counted over all envs."""
    given = steps_for(algorithm, FEW)
    for done in trainings(algorithm, FEW):
        require(done.env.steps == given, f"{done.env.steps} environment steps were taken, {given} were given")


@check("algo-progress")
def progress_is_told_to_the_end(algorithm: Algorithm) -> None:
    """`progress` is told of ever more steps, and the last number is the budget."""
    told, given = train(algorithm, FEW).told, steps_for(algorithm, FEW)
    require(told and told[-1] == given, f"progress was told {told[-3:]} in the end, {given} steps were given")
    require(told == sorted(told), f"progress was told {told}: steps that are done cannot be undone")


@check("algo-env-seed")
def the_env_keeps_its_seed(algorithm: Algorithm) -> None:
    """Training resets the env without a seed: starts and targets are the same for every algorithm and reward."""
    seeds = train(algorithm, FEW).env.seeds
    require(all(seed is None for seed in seeds), f"the env was reset with the seed {seeds}")


@check("algo-training-actions")
def actions_of_training_are_in_the_box(algorithm: Algorithm) -> None:
    """Every action while training is finite and in the env's action space."""
    for done in trainings(algorithm, FEW):
        require(done.env.actions_in_box, f"an action was outside the env's action space, {done.env.action_space}")


@check("algo-policy-actions")
def actions_of_the_policy_are_in_the_box(algorithm: Algorithm) -> None:
    """The policy's actions, with noise and without, are finite, in the action space, one row per observation."""
    seen = observations()
    for done in trainings(algorithm, FEW):
        space = done.env.single_action_space
        for rng in (None, np.random.default_rng(0)):
            actions = done.policy.act(seen, rng)
            shape = (len(seen), *(space.shape or ()))
            given = f"{len(seen)} observations gave actions of shape {actions.shape}"
            require(actions.shape == shape, f"{given}, not {shape}")
            require(all(map(space.contains, actions)), f"an action is outside the action space: {actions}")


@check("algo-same-seed")
def the_same_seed_gives_the_same_policy(algorithm: Algorithm) -> None:
    """Two trainings with the same seed give the same weights, bit for bit, whatever drew random numbers before."""
    first = train(algorithm, FEW, seed=1).policy
    np.random.random(7)
    random.random()
    require(_same_weights(first, train_anew(algorithm, FEW, seed=1).policy), "the same seed gave other weights")


@check("algo-other-seed")
def another_seed_gives_another_policy(algorithm: Algorithm) -> None:
    """Two trainings with two seeds give different weights: the seed is used."""
    if not learns(algorithm):
        return
    first, second = (train(algorithm, FEW, seed=seed).policy for seed in (1, 2))
    require(not _same_weights(first, second), "two seeds gave the same weights")


@check("algo-goes-on")
def learning_goes_on(algorithm: Algorithm) -> None:
    """A longer training changes the weights further: learning does not stop half-way."""
    if not learns(algorithm):
        return
    first, second = (train(algorithm, steps).policy for steps in (FEW, 2 * FEW))
    require(not _same_weights(first, second), f"{2 * FEW} steps gave the weights of {FEW} steps")


@check("algo-learns")
def the_return_rises(algorithm: Algorithm) -> None:
    """On an easy task the trained policy's return is higher than that of a policy that was barely trained.

    In several envs too, where their number can be chosen, and given as many steps of each: a reward that is counted for
    another env teaches nothing.
    """
    if not learns(algorithm):
        return
    _require_rise(algorithm, MANY)
    several = in_several_envs(algorithm)
    if several is not algorithm:
        _require_rise(several, MANY * several.num_envs)


@check("algo-every-env")
def every_env_counts(algorithm: Algorithm) -> None:
    """The pay of every single env makes a difference: the training uses all envs."""
    if not learns(algorithm):
        return
    each = in_several_envs(algorithm)
    for env in range(each.num_envs):
        fined, paid = (train(each, FEW, bonus=bonus, env=env).policy for bonus in (-100.0, 100.0))
        require(not _same_weights(fined, paid), f"whatever env {env} of {each.num_envs} pays, the weights are the same")


@check("algo-hindsight")
def it_learns_in_hindsight(algorithm: Algorithm) -> None:
    """An algorithm with `needs_goals` pays steps again for other goals, and that pay makes a difference."""
    if needs_goals(algorithm):
        fined, paid = (train(algorithm, FEW, hindsight_bonus=bonus).policy for bonus in (-100.0, 100.0))
        same = _same_weights(fined, paid)
        require(not same, "needs_goals is True, and whatever steps are paid for other goals, the weights are the same")


@check("algo-learns-nothing")
def what_learns_nothing_says_so(algorithm: Algorithm) -> None:
    """`learns` is False only if neither the length of a training nor its seed makes a difference."""
    if learns(algorithm):
        return
    first, longer, other = (train(algorithm, *how).policy for how in ((FEW, 1), (2 * FEW, 1), (FEW, 2)))
    same = _same_weights(first, longer) and _same_weights(first, other)
    require(same, "learns is False, and a longer training or another seed gave other weights")


@check("algo-policy-saved")
def the_policy_comes_back_from_its_folder(algorithm: Algorithm) -> None:
    """`harness.policy.load_policy` gives what `Policy.save` wrote: it acts the same, bit for bit."""
    policy, seen = train(algorithm, FEW).policy, observations()
    with tempfile.TemporaryDirectory() as folder:
        policy.save(Path(folder) / "policy")
        loaded = load_policy(Path(folder) / "policy")
    require(np.array_equal(policy.act(seen), loaded.act(seen)), "the loaded policy acts differently")


@check("algo-policy-box")
def the_policy_has_the_envs_actions(algorithm: Algorithm) -> None:
    """The ends of the policy's actions, or the number of its choices, are those of the env that it was trained on."""
    for done in trainings(algorithm, FEW):
        space: Any = done.env.single_action_space
        for name, ends in (("action_low", "low"), ("action_high", "high")):
            own, right = getattr(done.policy, name, None), getattr(space, ends, None)
            if own is not None and right is not None:
                same = np.array_equal(np.asarray(own, np.float32), right)
                require(same, f"{name} of the policy is {own}, that of the env is {tuple(right.tolist())}")
        choices = getattr(done.policy, "choices", None)
        if choices is not None and done.env.space == "discrete":
            require(choices == space.n, f"the policy has {choices} choices, the env {space.n}")


@check("algo-acts-as-trained")
def the_policy_acts_as_it_trained(algorithm: Algorithm) -> None:
    """At the same observations the policy's actions lie in the middle of those that the training drew around them.

    Where the algorithm tells its policy on the way, by `Progress.policy`, each step is compared with the policy of that
    step; else the last steps, roughly, with the last policy.
    """
    steps = MANY if learns(algorithm) else FEW
    for space in sorted(algorithm.action_spaces):
        require_in_the_middle(train(algorithm, steps, space=space))


@check("algo-checkpoint-silent")
def checkpoints_change_nothing(algorithm: Algorithm) -> None:
    """A training that leaves checkpoints does the same steps and gives the same weights as one that leaves none."""
    with tempfile.TemporaryDirectory() as folder:
        without = train_with_checkpoints(algorithm, LONGER, 2 * LONGER, Path(folder) / "without")
        left = train_with_checkpoints(algorithm, LONGER, EVERY, Path(folder) / "with")
    difference = differences(without, left)
    require(not difference, f"a training that leaves checkpoints {difference}: making one changes something")


@check("algo-resume")
def a_training_goes_on_where_it_stood(algorithm: Algorithm) -> None:
    """A training that goes on from a checkpoint in a new process does what the first one did from there, bit for bit.

    And so does one that goes on from a checkpoint of that. Of an algorithm that leaves no checkpoints nothing is asked.
    """
    with tempfile.TemporaryDirectory() as folder:
        last = whole = train_with_checkpoints(algorithm, LONGER, EVERY, Path(folder) / "whole")
        for left in whole.left:
            np.random.random(7)
            last = train_with_checkpoints(algorithm, LONGER, EVERY, Path(folder) / f"from-{left.steps}", last.left[0])
            difference = differences(whole, last, left)
            where = f"went on from the checkpoint after {left.steps} steps"
            require(not difference, f"a training that {where} {difference}: something is not in the checkpoint")


ALGORITHM_CHECKS = (
    settings_are_frozen,
    settings_survive_json,
    action_spaces_are_declared,
    the_budget_is_spent_exactly,
    progress_is_told_to_the_end,
    the_env_keeps_its_seed,
    actions_of_training_are_in_the_box,
    actions_of_the_policy_are_in_the_box,
    the_same_seed_gives_the_same_policy,
    another_seed_gives_another_policy,
    learning_goes_on,
    the_return_rises,
    every_env_counts,
    it_learns_in_hindsight,
    what_learns_nothing_says_so,
    the_policy_comes_back_from_its_folder,
    the_policy_has_the_envs_actions,
    the_policy_acts_as_it_trained,
    checkpoints_change_nothing,
    a_training_goes_on_where_it_stood,
)


@check("algo-tells-policy", "warning")
def the_policy_is_told_on_the_way(algorithm: Algorithm) -> None:
    """The training calls `progress.policy`: without it there is no learning curve of what the policy does."""
    if learns(algorithm):
        told = train(algorithm, FEW).env.told.newest
        require(
            told,
            "progress.policy is not called: there is no learning curve, and what it yields is compared with what it "
            "trained only roughly; compare it with your library's model in a test",
        )


@check("algo-leaves-checkpoints", "warning")
def checkpoints_are_offered(algorithm: Algorithm) -> None:
    """The training calls `progress.checkpoint`: without it a killed training starts over."""
    with tempfile.TemporaryDirectory() as folder:
        left = train_with_checkpoints(algorithm, FEW, FEW // 2, Path(folder) / "left").left
    require(left, "progress.checkpoint is not called: a training that is killed starts over, and going on is not tried")


ALGORITHM_WARNINGS = (the_policy_is_told_on_the_way, checkpoints_are_offered)


def _require_rise(algorithm: Algorithm, steps: int) -> None:
    """A slow learner is given twice the steps before it is found not to learn."""
    for space in sorted(algorithm.action_spaces):
        before = mean_return(train(algorithm, 1, space=space))
        for given in (steps, 2 * steps):
            after = mean_return(train(algorithm, given, space=space))
            if after > before + MIN_RISE:
                break
        else:
            where = f"with {space} actions, in {algorithm.num_envs} {'env' if algorithm.num_envs == 1 else 'envs'}"
            require(False, f"{where}, the mean return goes from {before:.2f} to {after:.2f} in {given} steps")


def _same_weights(first: Policy, second: Policy) -> bool:
    return all(np.array_equal(first.weights[name], second.weights[name]) for name in first.weights)
