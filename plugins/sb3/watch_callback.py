"""Records a training of one's own script, and shows it while it goes on."""

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from harness import RecordVectorRewards
from harness.reward import Given


class WatchCallback(BaseCallback):
    """Records every step that a model of stable-baselines3 learns from, and shows the training in the browser.

    It reads what the learner is given, and wraps nothing: the script stays as it is. Where ``VecNormalize`` normalises,
    it records what stands inside of that. `harness.RecordRewards` says what a reward and a measure may be; it records
    actions too, so that episodes can be played again.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        behaviour: Mapping[str, Given] | None = None,
        rewards: Mapping[str, Given] | None = None,
        watch: bool = True,
        **names: Any,
    ) -> None:
        """Name what is recorded.

        Args:
            path: A folder for this training; it is made when the training starts.
            behaviour: Measures of what the robot does, by name.
            rewards: Others that look on, by name. What the environment pays is always recorded, as ``own``.
            watch: Show it.
            names: Further arguments of `harness.RecordVectorRewards`, such as `lower_is_better`.
        """
        super().__init__()
        self._path, self._recorded = path, False
        self._seen: _Seen | None = None
        self._recorder: RecordVectorRewards | None = None
        self._asked: dict[str, Any] = {
            "trained_with": "own",
            "rewards": rewards or {},
            "behaviour": behaviour,
            "watch": watch,
            **names,
        }

    def _on_training_start(self) -> None:
        norm = self.model.get_vec_normalize_env()
        first = self.model._last_obs if norm is None else norm.get_original_obs()
        self._seen = _Seen(self.training_env if norm is None else norm.venv, norm, first)
        asked = {"seed": self.model.seed, "resume": self._recorded, **self._asked}
        self._recorder, self._recorded = RecordVectorRewards(self._seen, self._path, **asked), True
        self._recorder.reset()

    def _on_step(self) -> bool:
        assert self._seen is not None
        assert self._recorder is not None
        self._seen.look(self.locals)
        self._recorder.step(self.locals.get("clipped_actions", self.locals["actions"]))
        return True

    def _on_training_end(self) -> None:
        if self._recorder is not None:
            self._recorder.close()


class _Seen(VectorEnv[Any, Any, Any]):
    """A batch of environments whose steps somebody else takes: it answers with what they came to."""

    metadata = {"autoreset_mode": AutoresetMode.SAME_STEP}  # noqa: RUF012 -- Gymnasium's own form

    def __init__(self, envs: VecEnv, norm: VecNormalize | None, first: Any) -> None:
        self.num_envs, self._norm, self._first = envs.num_envs, norm, first
        self.single_observation_space, self.single_action_space = envs.observation_space, envs.action_space
        self.observation_space = batch_space(envs.observation_space, envs.num_envs)
        self.action_space = batch_space(envs.action_space, envs.num_envs)
        self.spec = envs.get_attr("spec", 0)[0]
        self._answer: tuple[Any, ...] = ()

    def reset(self, **_: Any) -> tuple[Any, dict[str, Any]]:
        """Where the envs are."""
        return self._first, {}

    def look(self, told: Mapping[str, Any]) -> None:
        """Keep what a learner was given for a step, its local variables."""
        observations, paid, ended = told["new_obs"], told["rewards"], np.asarray(told["dones"], bool)
        if self._norm is not None:
            observations, paid = self._norm.get_original_obs(), self._norm.get_original_reward()
        cut = np.array([bool(info.get("TimeLimit.truncated")) for info in told["infos"]])
        infos: dict[str, Any] = {}
        for env, info in enumerate(told["infos"]):
            own = {key: value for key, value in info.items() if key not in TOLD_BY_LIBRARY}
            if ended[env]:
                last = info["terminal_observation"]
                own["final_obs"] = last if self._norm is None else self._norm.unnormalize_obs(last)
            infos = self._add_info(infos, own, env)
        self._answer = observations, paid, ended & ~cut, ended & cut, infos

    def step(self, actions: Any) -> tuple[Any, ...]:
        """What they came to."""
        return self._answer


TOLD_BY_LIBRARY = ("terminal_observation", "TimeLimit.truncated", "episode")
"""Keys of the infos that stable-baselines3 itself adds."""
