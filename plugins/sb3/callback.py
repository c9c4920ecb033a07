"""Tells how far a training is."""

from stable_baselines3.common.callbacks import BaseCallback

from harness.algorithm import Progress

EVERY = 100


class SilentProgress(BaseCallback):
    """Passes the number of steps on, now and then and at the end."""

    def __init__(self, progress: Progress) -> None:
        super().__init__()
        self._progress = progress
        self._told = 0

    def _on_step(self) -> bool:
        if self.num_timesteps >= self._told + EVERY:
            self._told = self.num_timesteps
            self._progress(self.num_timesteps)
        return True

    def _on_training_end(self) -> None:
        self._progress(self.num_timesteps)
