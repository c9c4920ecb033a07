"""Tells how far a training is."""

from stable_baselines3.common.callbacks import BaseCallback

from harness.algorithm import Progress

EVERY = 100


class SilentProgress(BaseCallback):
    """Passes the number of steps on, now and then and at the end; ends a training that would go beyond its budget."""

    def __init__(self, progress: Progress, budget: int) -> None:
        super().__init__()
        self._progress = progress
        self._budget = budget
        self._told = 0

    def _on_step(self) -> bool:
        if self.num_timesteps >= self._told + EVERY:
            self._told = self.num_timesteps
            self._progress(self.num_timesteps)
        return self._is_within_budget()

    def _is_within_budget(self) -> bool:
        """False at the last step of the budget, unless a rollout ends there: then the update that is due still runs."""
        if self.num_timesteps < self._budget:
            return True
        length = self.model.train_freq.frequency * self.training_env.num_envs  # type: ignore[attr-defined]
        return self.num_timesteps % length == 0

    def _on_training_end(self) -> None:
        self._progress(self.num_timesteps)
