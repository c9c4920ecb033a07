"""Reports how a training goes, and ends it at its budget."""

from collections.abc import Callable, Mapping
from typing import Any

import torch
from stable_baselines3.common.callbacks import BaseCallback

from harness.algorithm import Progress, TrainingEnv, TrainingState, as_state, under
from harness.policy import Policy

from ..hyperparameters import SCALARS_EVERY, TOLD_EVERY
from .state import can_be_packed, pack_model, restore_logged

NAMES = {
    "train/actor_loss": ("Losses/Policy Loss", 1.0),
    "train/policy_gradient_loss": ("Losses/Policy Loss", 1.0),
    "train/critic_loss": ("Losses/Value Loss", 1.0),
    "train/value_loss": ("Losses/Value Loss", 1.0),
    "train/loss": ("Losses/Value Loss", 1.0),
    "train/entropy_loss": ("Policy/Entropy", -1.0),
    "train/ent_coef": ("Policy/Continuous Entropy Coeff", 1.0),
    "train/learning_rate": ("Policy/Learning Rate", 1.0),
    "rollout/exploration_rate": ("Policy/Epsilon", 1.0),
}
"""Names of the library's logger, each with the name that is used here and a factor."""


def losses(logged: Mapping[str, Any]) -> dict[str, float]:
    """The values that were logged last, by the names in `NAMES`."""
    # PPO's ``train/loss`` is the sum of its other losses; DQN logs only that one.
    told = {key for key in logged if key != "train/loss" or "train/value_loss" not in logged}
    return {name: factor * float(logged[key]) for key, (name, factor) in NAMES.items() if key in told}


LAST = 256
"""The mean is taken over this many of the newest observations in the replay buffer."""


def actor_entropy(model: Any) -> float | None:
    """Mean entropy of the actions, squashed into [-1, 1], in nats.

    It is None if the model has no soft actor, or if its replay buffer is empty. It is estimated from one draw per
    observation. The draws do not change the random numbers of the training.
    """
    draw = getattr(getattr(model, "actor", None), "action_log_prob", None)
    buffer = getattr(model, "replay_buffer", None)
    if draw is None or buffer is None or buffer.pos == 0:
        return None
    rows, seen = slice(max(buffer.pos - LAST, 0), buffer.pos), buffer.observations
    newest = {key: _of_all(part[rows]) for key, part in seen.items()} if isinstance(seen, dict) else _of_all(seen[rows])
    with torch.random.fork_rng(devices=[]), torch.no_grad():
        _, log_prob = draw(newest)
    return -float(log_prob.mean())


def _of_all(rows: Any) -> torch.Tensor:
    """Observations (steps, envs, ...) as (steps * envs, ...)."""
    return torch.as_tensor(rows.reshape(-1, *rows.shape[2:]))


def steps_done(state: TrainingState | None) -> int:
    """Environment steps that a training had done when it left `state`; 0 if there is no state."""
    return 0 if state is None else int(state["done"])


class ProgressCallback(BaseCallback):
    """Reports environment steps, the policy and scalars, now and then and at the end; ends a training at its budget.

    The library counts decisions, but a decision may last several environment steps. A model whose parameters are not
    PyTorch's, such as one of sbx, leaves no checkpoints. If its training is killed, it starts over.
    """

    def __init__(
        self,
        env: TrainingEnv,
        progress: Progress,
        budget: int,
        policy_of: Callable[[Any], Policy],
        decisions_per_update: int = 1,
        state: TrainingState | None = None,
    ) -> None:
        """Begin to count, or go on.

        Args:
            env: The env to train on.
            progress: Gets the reports.
            budget: Environment steps to take.
            policy_of: A function of a model, which returns its present policy.
            decisions_per_update: Decisions between two updates, over all envs.
            state: What the last checkpoint holds, if the training goes on from one.
        """
        super().__init__()
        self._env, self._before = env, env.environment_steps - steps_done(state)
        self._progress, self._budget, self._policy_of = progress, budget, policy_of
        self._decisions_per_update = decisions_per_update
        self._told = self._scalars_told = 0
        self._state = state
        if state is not None:
            self._told, self._scalars_told = int(state["told"]), int(state["scalars_told"])

    @property
    def _steps(self) -> int:
        return self._env.environment_steps - self._before

    def _on_training_start(self) -> None:
        if self._state is not None:  # the model has its logger by now
            restore_logged(self.model, under("model.", self._state))
            self._state = None

    def _on_rollout_start(self) -> None:
        # This is between an update and the next decision, so nothing is half done.
        if can_be_packed(self.model):
            self._progress.checkpoint(self._steps, self._make_state)

    def _make_state(self) -> TrainingState:
        counters = {"done": self._steps, "told": self._told, "scalars_told": self._scalars_told}
        return as_state({**counters, "model": pack_model(self.model)})

    def _on_step(self) -> bool:
        steps = self._steps
        self._progress.policy(steps, self._make_policy)
        if steps >= self._told + TOLD_EVERY:
            self._told = steps
            self._progress(steps)
        if steps >= self._scalars_told + SCALARS_EVERY:
            self._tell_scalars(steps)
        return self._is_within_budget(steps)

    def _is_within_budget(self, steps: int) -> bool:
        """False at the last step of the budget, but True if a rollout ends there: the due update then still runs."""
        if steps < self._budget:
            return True
        if self.num_timesteps < self._budget:
            return False
        return self.num_timesteps % self._decisions_per_update == 0

    def _on_training_end(self) -> None:
        steps = self._steps
        if steps > self._scalars_told:
            self._tell_scalars(steps)
        self._progress.policy(steps, self._make_policy)
        self._progress(steps)

    def _make_policy(self) -> Policy:
        return self._policy_of(self.model)

    def _tell_scalars(self, steps: int) -> None:
        self._scalars_told = steps
        values, entropy = losses(self.logger.name_to_value), actor_entropy(self.model)
        self._progress.scalars(steps, values if entropy is None else {**values, "Policy/Entropy": entropy})
