"""`harness.RecordVectorRewards`: for a batch of Gymnasium environments."""

import os
import weakref
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv, VectorEnv, VectorWrapper
from numpy.typing import NDArray

from harness.errors import UsageError
from harness.eta.interval import Bounds
from harness.record.recording.facts import ActionFacts
from harness.recorder.env_facts import Asked, OnError
from harness.recorder.parts import FINAL_OBSERVATION, Mask, infos_last, infos_of_step, item_of, joined, with_items
from harness.recorder.recorder import Recorder, action_facts
from harness.recorder.taken import Taken
from harness.reward.given import Given

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
        spaces = env.single_observation_space, env.single_action_space
        self._taken = Taken(self._recorder, env.num_envs, spaces)
        self._envs, self._episodes = np.arange(env.num_envs), self._recorder.next_episodes
        self._steps = np.zeros(env.num_envs, np.int64)
        self._rests = np.zeros(env.num_envs, bool)  # which envs the next step only resets
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
        self._taken.end_episode()
        told = infos_last(infos) if mask.all() else joined(self._taken.told_last, infos, mask)
        self._taken.start(observations, told)
        rest = {key: value for key, value in (options or {}).items() if key != RESET_MASK}
        self._begin(mask, seed, rest or None)
        self._rests = self._rests & ~mask
        return observations, infos

    def step(self, actions: Any) -> tuple[Any, Array, Array, Array, dict[str, Any]]:
        """Take a step in every env, and record it."""
        observations, paid, terminated, truncated, infos = answer = self.env.step(actions)
        ends, pay = (np.array(terminated, bool), np.array(truncated, bool)), np.array(paid, float)
        ended = ends[0] | ends[1]
        if pay.shape != ended.shape:
            self._recorder.give_up_pay(pay, (0, int(self._episodes[0]), int(self._steps[0])))
            pay = np.zeros(ended.shape)
        after, told, has_ended, started = observations, infos_last(infos), bool(ended.any()), self._rests
        live = ~started if started.any() else slice(None)
        if self._mode == AutoresetMode.SAME_STEP:
            started = ended
        if started is ended and has_ended:
            finals = {env: item_of(infos[FINAL_OBSERVATION], env) for env in np.flatnonzero(ended).tolist()}
            after = with_items(self.single_observation_space, observations, finals)
            told = infos_of_step(infos, ended) if self._taken.reads else {}
        tick = tuple(it[live] for it in (self._envs, self._episodes, self._steps, pay, *ends))
        self._taken.take(tick, actions, after, told, has_ended)
        self._steps = self._steps + ~self._rests
        if after is not observations:
            self._taken.start(observations, infos_last(infos))
        if started.any():
            self._begin(started)
        if self._mode == AutoresetMode.NEXT_STEP:
            self._rests = ended
        return answer if self._recorder.pays is None else (observations, self._taken.paid, terminated, truncated, infos)

    def close(self, **kwargs: Any) -> None:
        """Write what is left, and close the envs."""
        try:
            self._taken.end()
        finally:
            try:
                self._recorder.close()
            finally:
                super().close(**kwargs)

    def _begin(self, mask: Mask, seed: Any = None, options: object = None) -> None:
        """Start an episode in these envs."""
        self._episodes = self._episodes + (mask & (self._steps > 0))
        self._steps = np.where(mask, 0, self._steps)
        self._taken.begin(np.flatnonzero(mask).tolist(), self._episodes, seed, options)


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
