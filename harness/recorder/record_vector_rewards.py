"""`harness.RecordVectorRewards`: for a batch of Gymnasium environments."""

import os
import weakref
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite
from types import MappingProxyType
from typing import Any, NamedTuple, cast

import numpy as np
from gymnasium import Space
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv, VectorEnv, VectorWrapper
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import UsageError, reason_of
from harness.eta.interval import Bounds
from harness.record.recording.facts import ActionFacts
from harness.recorder.calls import CHECKED, action_facts
from harness.recorder.column import Column, as_number
from harness.recorder.env_facts import Asked, OnError
from harness.recorder.guard import Asking, Raised
from harness.recorder.parts import (
    FINAL_OBSERVATION,
    Mask,
    info_of,
    infos_last,
    infos_of_step,
    item_of,
    items_of,
    joined,
    with_items,
)
from harness.recorder.recorder import Recorder, differs
from harness.recorder.trial import FIRST_STEPS
from harness.reward import Steps
from harness.reward.given import Before, Given, Now, Untold, told_under, zeros_of


class BatchBefore(NamedTuple):
    """What there was before a step of a batch, sealed.

    Attributes:
        observations: That the envs returned last.
        infos: What they told last; envs that start an episode, of their reset.
        actions: Those of the step before; None before the first.
    """

    observations: Any = None
    infos: Mapping[str, Any] = MappingProxyType({})
    actions: Any = None


@dataclass(eq=False)
class BatchStep:
    """One step of a batch. What it was is made here once, of what the envs returned, and all that reads it reads this.

    Attributes:
        env: Whose step it was.
        before: What there was before it.
        actions: Those given.
        returned: Observations that the env returned; of an env that it reset at once, those of its new start.
        paid: (num_envs,).
        ended: (num_envs,), whether the step ended an episode.
        live: (num_envs,), whether the env took a step; otherwise it was only reset.
        told: Infos as the env returned them.
        reset_at_once: Whether envs whose episode ended are at their new start already (``SAME_STEP``).
        seal: Makes of what functions are given copies that they cannot write into; None where no function is asked.
            What `before` has, and `actions`, are such copies.
        begins: (num_envs,), whether it is the first step of an episode.
    """

    env: VectorEnv[Any, Any, Any]
    before: BatchBefore
    actions: Any
    returned: Any
    paid: Float
    ended: Mask
    live: Mask
    told: Mapping[str, Any]
    reset_at_once: bool
    seal: Callable[[Any], Any] | None = None
    begins: Mask = field(default_factory=lambda: np.zeros(0, bool))

    @cached_property
    def after(self) -> Any:
        """Observations after the step, before any reset; a copy."""
        batch = self.returned
        if self.reset_at_once and self.ended.any():
            finals = {env: item_of(self.told[FINAL_OBSERVATION], env) for env in np.flatnonzero(self.ended).tolist()}
            batch = with_items(self.env.single_observation_space, batch, finals)
        return self._sealed(batch)

    @cached_property
    def infos(self) -> Mapping[str, Any]:
        """What the envs told of the step, of its last one those too that are at their new start already."""
        if self.reset_at_once:
            return cast(Mapping[str, Any], self._sealed(infos_of_step(self.told, self.ended)))
        return self.last

    @cached_property
    def last(self) -> Mapping[str, Any]:
        """What they told last: of the step, or of the reset of those that are at their new start already."""
        return cast(Mapping[str, Any], self._sealed(infos_last(self.told)))

    @cached_property
    def each_after(self) -> list[Any]:
        """`after`, by env."""
        return self._items(self.env.single_observation_space, self.after)

    @cached_property
    def each_action(self) -> list[Any]:
        """`actions`, by env."""
        return self._items(self.env.single_action_space, self.actions)

    @cached_property
    def whole(self) -> Steps:
        """The step of all envs, as functions are given it."""
        before, actions = self.before, zeros_of(self.actions)
        if before.actions is not None:
            zeros = self._items(self.env.single_action_space, actions)
            begun = {env: zeros[env] for env in np.flatnonzero(self.begins).tolist()}
            actions = self._sealed(with_items(self.env.single_action_space, before.actions, begun))
        then = Before._make((before.observations, actions, before.infos))
        return Now._make((self.after, self.actions, self.infos, then))

    def of_each(self, is_of_step: bool) -> Sequence[tuple[Any, ...]]:
        """What functions are called with about the step of each env, (num_envs,)."""
        return self._nows if is_of_step else self._arguments

    def told_under(self, key: str, env: int) -> Any:
        """What one env told under a key.

        Raises:
            Untold: Nothing.
        """
        return told_under(info_of(self.infos, env), key)

    def told_numbers(self, key: str) -> tuple[Float, Mask]:
        """What the envs told under a key, and which of them told something, as far as an array of numbers says it."""
        values, mask, count = self.infos.get(key), self.infos.get(f"_{key}"), len(self.paid)
        if not (isinstance(values, np.ndarray) and values.shape == (count,) and values.dtype.kind in "biuf"):
            return np.zeros(count), np.zeros(count, bool)
        return values.astype(float), np.ones(count, bool) if mask is None else np.asarray(mask, bool)

    @cached_property
    def _arguments(self) -> list[tuple[Any, ...]]:
        infos = [self._sealed(info_of(self.infos, env)) for env in range(len(self.live))]
        return list(zip(self._each_before, self.each_action, self.each_after, infos, strict=True))

    @cached_property
    def _nows(self) -> list[tuple[Steps]]:
        last, begins = self._each_last_action, self.begins.tolist()
        found = []
        for env, (seen, action, observation, info) in enumerate(self._arguments):
            acted = zeros_of(action) if last is None or begins[env] else last[env]
            before = Before._make((seen, acted, self._sealed(info_of(self.before.infos, env))))
            found.append((Now._make((observation, action, info, before)),))
        return found

    @cached_property
    def _each_before(self) -> list[Any]:
        return self._items(self.env.single_observation_space, self.before.observations)

    @cached_property
    def _each_last_action(self) -> list[Any] | None:
        return None if self.before.actions is None else self._items(self.env.single_action_space, self.before.actions)

    def _sealed(self, value: Any) -> Any:
        return value if self.seal is None else self.seal(value)

    def _items(self, space: Space[Any], batch: Any) -> list[Any]:
        if isinstance(batch, np.ndarray):
            return list(batch)
        return list(map(self._sealed, items_of(space, batch)))


Array = NDArray[Any]
RESET_MASK = "reset_mask"
"""The option of ``reset`` that says which envs are reset, (num_envs,)."""


class RecordVectorRewards(VectorWrapper[Any, Any, Any, Any, Any]):
    """Records what several rewards pay for each step of a batch of envs, and changes nothing of them.

    It takes the three ways in which Gymnasium's vector envs start episodes (``AutoresetMode``): in each of them what is
    measured is the step itself, with the last observation and info of an episode that ended. A call that only resets
    an env (``NEXT_STEP``) is no step, and leaves no row.

    A reward or a measure is what `harness.recorder.record_rewards.RecordRewards` takes: it is called for one env after
    the other, with that env's observations, action and info. An object with ``reset()`` is copied for each env.

    Those named in `batched` are called once for all envs instead: the step that they are given has the batches of
    observations and actions, and the infos as the env returned them. They return numbers of shape (num_envs,), or of a
    reward terms of this shape. What they return for an env that was only reset is ignored. Theirs is ``reset(mask)``,
    (num_envs,): the envs that start an episode.
    """

    def __init__(
        self,
        env: VectorEnv[Any, Any, Any],
        path: str | os.PathLike[str],
        *,
        trained_with: str,
        rewards: Mapping[str, Given],
        behaviour: Mapping[str, Given] | None = None,
        lower_is_better: Collection[str] = (),
        higher_is_better: Collection[str] = (),
        bounds: Mapping[str, Bounds] | None = None,
        seed: int | None = None,
        evaluation: bool = False,
        pay: bool = False,
        batched: Collection[str] = (),
        number: int = 0,
        resume: bool = False,
        on_error: OnError = "warn",
        steps_asked: int = 0,
        episodes_asked: int = 0,
        watch: bool = False,
    ) -> None:
        """Check what was given, and start the recording; see `harness.recorder.record_rewards.RecordRewards`.

        Args:
            env: What the learner trains in.
            path: A folder for this training.
            trained_with: Name of the reward that the env pays.
            rewards: By name, at least one.
            behaviour: Measures of what the robot does, by name; reports judge it by the first.
            lower_is_better: Names of measures of which less is better, such as a distance.
            higher_is_better: Names of those of which more is, such as a height. A measure that is 0 or 1 needs neither.
            bounds: By name of a measure, the least and the greatest value that it can have.
            seed: Of the training; by default the first that the envs are reset with.
            evaluation: A finished policy acts, and nothing is trained.
            pay: Pay the learner the reward `trained_with`, and not what the envs pay.
            batched: Names of rewards and measures that take the whole batch.
            number: Of this batch among several that record one training into one path.
            resume: Go on with the recording in `path`, if there is one.
            on_error: ``"warn"``, or ``"raise"`` to stop the training where a reward or a measure fails.
            steps_asked: Environment steps that the whole training is to take, over all envs; 0: not known.
            episodes_asked: Of an evaluation, its episodes; 0: not known.
            watch: Show it in the browser while it goes on.

        Raises:
            UsageError: Something of that cannot be used, or `path` holds another recording.
            SchemaError: The recording to go on with is damaged.
            StorageError: The folder cannot be written.
        """
        super().__init__(env)
        self._mode = _autoreset_mode(env)
        asked = Asked(
            path, trained_with, rewards, behaviour or {}, lower_is_better, seed, evaluation, pay, number, resume,
            on_error, batched, bounds or {}, steps_asked=steps_asked, episodes_asked=episodes_asked,
            watch=watch, higher_is_better=higher_is_better,
        )  # fmt: skip
        self._recorder = Recorder(env, asked, env.num_envs, _action_facts(env))
        self._guard = self._recorder.guard
        self._seal = self._guard.seal if self._recorder.looks else None
        self._before = BatchBefore()
        self._time = self._recorder.next_time
        self._episodes = self._recorder.next_episodes.copy()
        self._steps = np.zeros(env.num_envs, np.int64)
        self._terms: dict[str, Float] = {}  # by column, what its terms paid in this step
        self._is_reset_next = np.zeros(env.num_envs, bool)
        weakref.finalize(self, self._recorder.close)

    @property
    def spec(self) -> EnvSpec | None:  # type: ignore[override] # a plain attribute there
        """The env's own."""
        return self.env.spec

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start episodes, of all envs or of those in ``options["reset_mask"]``."""
        everywhere = np.ones(self.num_envs, bool)
        mask = np.array((options or {}).get(RESET_MASK, everywhere))  # the env takes it out of the options
        observations, infos = self.env.reset(seed=seed, options=options)  # type: ignore[arg-type] # a list is allowed
        self._recorder.note_seed(seed)
        self._end_episode()
        self._note_resets(mask, seed, options)
        self._begin(mask)
        if self._recorder.trial is not None:
            self._recorder.trial.begin(self._recorder.columns)
        if self._seal:
            told = infos_last(infos) if mask.all() else joined(self._before.infos, infos, mask)
            actions = None if mask.all() else self._before.actions
            self._before = BatchBefore(*map(self._seal, (observations, told, actions)))
        self._is_reset_next &= ~mask
        return observations, infos

    def step(self, actions: Any) -> tuple[Any, Array, Array, Array, dict[str, Any]]:
        """Take a step in every env, and record it."""
        observations, paid, terminated, truncated, infos = self.env.step(actions)
        numbers = self._record(actions, observations, paid, terminated, truncated, infos)
        if self._recorder.pays is not None:
            paid = np.nan_to_num(numbers[:, self._recorder.pays])  # an env that was only reset pays 0
        return observations, paid, terminated, truncated, infos

    def close(self, **kwargs: Any) -> None:
        """Write what is left, and close the envs."""
        try:
            if self._time > self._recorder.next_time:
                self._recorder.end_all(self._place(0))
        finally:
            try:
                self._recorder.close()
            finally:
                super().close(**kwargs)

    def _record(
        self, actions: Any, observations: Any, paid: Any, terminated: Any, truncated: Any, infos: dict[str, Any]
    ) -> Float:
        """Record a step; returns its numbers, (num_envs, columns), NaN for an env that was only reset."""
        terminated, truncated = np.asarray(terminated, bool), np.asarray(truncated, bool)
        ended, live = terminated | truncated, ~self._is_reset_next
        at_once, paid = self._mode == AutoresetMode.SAME_STEP, np.array(paid, float)
        if paid.shape != live.shape:
            self._recorder.give_up_pay(paid, self._place(0))
            paid = np.full(live.shape, np.nan)
        step = BatchStep(
            self.env, self._before, actions if self._seal is None else self._seal(actions), observations,
            paid, ended, live, infos, at_once, self._seal, self._steps == 0,
        )  # fmt: skip
        numbers = self._write(step, terminated, truncated)
        self._steps[live] += 1
        self._time += 1
        started = ended if at_once else ~live
        self._note_resets(started)
        self._begin(started)
        self._is_reset_next = ended & (self._mode == AutoresetMode.NEXT_STEP)
        if self._seal:
            self._before = BatchBefore(self._seal(observations), step.last, step.actions)
        if self._time - self._recorder.next_time == FIRST_STEPS:
            self._recorder.end_trial(self._place(0))
        elif ended.any():
            self._end_episode()
        return numbers

    def _end_episode(self) -> None:
        """See `Recorder.end_episode`; nothing while no step was taken."""
        if self._time > self._recorder.next_time:
            self._recorder.end_episode(self._place(0))

    def _note_resets(self, mask: Mask, seed: Any = None, options: Mapping[str, Any] | None = None) -> None:
        """Note that these envs were reset; envs that start the next episode by themselves draw it without a seed."""
        if self._recorder.calls is None:
            return
        told = {key: value for key, value in (options or {}).items() if key != RESET_MASK}
        for env in np.flatnonzero(mask).tolist():
            one = seed[env] if isinstance(seed, Sequence) else None if seed is None else seed + env
            self._recorder.calls.note_reset(env, one, told or None)

    def _begin(self, mask: Mask) -> None:
        """Start an episode in these envs."""
        if not mask.any():
            return
        self._episodes[mask & (self._steps > 0)] += 1
        self._steps[mask] = 0
        for column in self._recorder.columns:
            if column.remembers and not column.given_up:
                self._restart(column, mask)

    def _restart(self, column: Column, mask: Mask) -> None:
        envs = np.flatnonzero(mask).tolist()
        if column.batched:
            self._recorder.restart(column, 0, (envs[0], self._episodes[envs[0]], 0), mask.copy())
            return
        for env in envs:
            if not column.given_up:
                self._recorder.restart(column, env, (env, self._episodes[env], 0))

    def _write(self, step: BatchStep, terminated: Mask, truncated: Mask) -> Float:
        numbers = np.full((self.num_envs, len(self._recorder.columns)), np.nan)
        if not step.live.any():
            return numbers
        read = [it for it in enumerate(self._recorder.columns) if not it[1].measures]  # before any function runs
        asked = [it for it in enumerate(self._recorder.columns) if it[1].measures]
        self._terms = {}
        for index, column in (*read, *asked):
            if not column.given_up:
                self._measure(column, step, numbers[:, index])
        if self._recorder.undirected:
            self._recorder.learn_direction(numbers, self._time)
        if self._recorder.with_terms is None:
            self._recorder.learn_terms()
        terms = [self._terms_of(self._recorder.columns[index]) for index in self._recorder.with_terms or ()]
        if self._recorder.trained is not None:
            self._require_paid(numbers[:, self._recorder.trained], step)
        envs = np.arange(self.num_envs)
        time = np.full(self.num_envs, self._time)
        told = [time, envs, self._episodes, self._steps, numbers, *terms, terminated, truncated]
        rows = np.column_stack(told)[step.live]
        calls = self._recorder.calls
        if calls is not None:
            is_checked = (step.ended | (self._steps % CHECKED == 0)).tolist()
            for env in np.flatnonzero(step.live).tolist():
                answer = step.each_after[env] if is_checked[env] else None
                calls.note_step(env, step.each_action[env], answer, is_checked[env])
            rows = np.column_stack([rows, calls.take()])
        self._recorder.write(rows)
        return numbers

    def _measure(self, column: Column, step: BatchStep, numbers: Float) -> None:
        """Fill in what a column says of the envs, (num_envs,); where it fails it is given up, the rest is NaN."""
        env = int(np.flatnonzero(step.live)[0])
        try:
            values, told, one = self._ways_to_measure(column, step)
            at_once = step.live & told & np.isfinite(values)
            numbers[at_once] = values[at_once]
            for env in np.flatnonzero(step.live & ~at_once).tolist():
                try:
                    value = one(env)
                    is_known = type(value) is float and isfinite(value) and not column.terms  # mostly a call less
                    numbers[env] = value if is_known else self._number(column, env, value)
                except Untold:
                    if step.ended[env] or not column.may_be_untold:
                        raise
        except (Exception, SystemExit) as error:  # whatever rewards of users raise
            numbers[env:] = np.nan
            self._terms_of(column)[env:] = np.nan
            given = self._given(column, step, env)
            reason = self._guard.reason(column.measures[0], given, error) if given else reason_of(error)
            self._recorder.give_up(column, self._place(env), reason, error)
        if (
            self._recorder.trial is not None
            and column.measures
            and not column.given_up
            and (column.batched or step.live[0])
        ):
            answer = numbers.copy() if column.batched else float(numbers[0])
            if not self._recorder.try_again(column, self._given(column, step, 0), answer, self._place(0)):
                numbers[:] = np.nan
                self._terms_of(column)[:] = np.nan

    def _number(self, column: Column, env: int, returned: Any) -> float:
        if not (isinstance(returned, dict | tuple) or column.terms):
            return as_number(returned)
        number, *terms = column.numbers(returned)
        self._terms_of(column)[env] = terms
        return number

    def _terms_of(self, column: Column) -> Float:
        """What its terms have paid in this step, (num_envs, terms)."""
        shape = self.num_envs, len(column.terms or ())
        if column.name not in self._terms or self._terms[column.name].shape != shape:
            self._terms[column.name] = np.full(shape, np.nan)
        return self._terms[column.name]

    def _ways_to_measure(self, column: Column, step: BatchStep) -> tuple[Float, Mask, Callable[[int], Any]]:
        """What a column says of all envs at once, of which of them it does, and how it is asked of a single one."""
        count = len(step.live)
        if column.is_own:
            return step.paid, step.live, step.paid.__getitem__
        if column.key is not None:
            key = column.key
            numbers, told = step.told_numbers(key)
            return numbers, told & (not column.terms), lambda env: step.told_under(key, env)
        if column.batched:
            (answer,) = self._ask(column, column.measures, [self._given(column, step, 0)], [0])
            values = column.batch(_raised(answer), count)
            total, terms = values[:, 0], values[:, 1:]
            self._terms_of(column)[:] = terms
            whole = np.isfinite(values).all(axis=1)
            return total, step.live & whole, lambda env: _named(column, terms[env]) if column.terms else total[env]
        envs = np.flatnonzero(step.live).tolist()
        each = step.of_each(column.takes_step)
        steps = [each[env] for env in envs]
        answers = dict(zip(envs, self._ask(column, [column.measures[env] for env in envs], steps, envs), strict=True))
        return np.zeros(count), np.zeros(count, bool), lambda env: _raised(answers[env])

    def _ask(self, column: Column, functions: list[Any], steps: list[Asking], envs: list[int]) -> list[Any]:
        pays = self._recorder.pays is not None and column is self._recorder.columns[self._recorder.pays]
        answers = self._guard.ask(functions, steps, range(len(steps)) if pays else (), column.is_watched)
        for place, generator in self._guard.drew.items():
            self._recorder.note_draw(column, generator, self._place(envs[place]))
        return answers

    def _given(self, column: Column, step: BatchStep, env: int) -> Asking:
        """What a function is given: the step of the whole batch, or of one env."""
        if not column.measures:
            return ()
        return column.arguments(step.whole) if column.batched else step.of_each(column.takes_step)[env]

    def _place(self, env: int) -> tuple[int, int, int]:
        return env, int(self._episodes[env]), int(self._steps[env])

    def _require_paid(self, numbers: Float, step: BatchStep) -> None:
        apart = np.flatnonzero(step.live & differs(numbers, step.paid))
        if len(apart):
            env = int(apart[0])
            self._recorder.tell_paid_otherwise(numbers[env], step.paid[env], self._place(env))


def _raised(answer: Any) -> Any:
    """The answer, unless the function raised an error: then that is raised."""
    if isinstance(answer, Raised):
        raise answer.error
    return answer


def _named(column: Column, numbers: Float) -> dict[str, float]:
    """Terms of one env as its function would have returned them."""
    return dict(zip(column.terms or (), numbers.tolist(), strict=True))


def _action_facts(env: VectorEnv[Any, Any, Any]) -> ActionFacts | None:
    """How actions are recorded; None where a batch is not made of single envs, one of which could be told the same."""
    is_of_single_envs = isinstance(env.unwrapped, SyncVectorEnv | AsyncVectorEnv)
    return action_facts(env.single_action_space) if is_of_single_envs else None


def _autoreset_mode(env: VectorEnv[Any, Any, Any]) -> AutoresetMode:
    mode = env.metadata.get("autoreset_mode")
    if isinstance(mode, AutoresetMode):
        return mode
    raise UsageError(
        f"{env} does not tell how it starts episodes: its metadata need 'autoreset_mode', one of "
        f"{', '.join(f'AutoresetMode.{each.name}' for each in AutoresetMode)}"
    )
