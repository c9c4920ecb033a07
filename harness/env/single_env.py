"""The same environment, one arm, as `gymnasium.make("harness/Reach-v0")` gives it."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from harness.arrays import Float32
from harness.env.make import Given, make_env
from harness.errors import UsageError

Action = NDArray[Any]


class ReachEnv(gymnasium.Env[Float32, Action]):
    """A `ReachVectorEnv` of one env, without its leading axis."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012 (Gymnasium declares it so)

    def __init__(
        self,
        simulator: Given = "mujoco",
        task: Given = "fd100-reach",
        reward: Given = "baseline",
        robot: str | Path | None = None,
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in {None, *self.metadata["render_modes"]}:
            raise UsageError(
                f"render_mode {render_mode!r}: the env itself draws 'rgb_array' or nothing. "
                "gymnasium.make(..., render_mode='human') opens a window around it, which takes "
                "pip install 'gymnasium[classic-control]'"
            )
        self.vector_env = make_env(simulator, task, reward, robot, autoreset_mode=AutoresetMode.DISABLED)
        self.observation_space = self.vector_env.single_observation_space
        self.action_space = self.vector_env.single_action_space
        self.render_mode = render_mode

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32, dict[str, Any]]:
        """Start an episode; see `ReachVectorEnv.reset`."""
        super().reset(seed=seed)
        observations, infos = self.vector_env.reset(seed=seed, options=options)
        return observations[0], _first(infos)

    def step(self, action: Action) -> tuple[Float32, float, bool, bool, dict[str, Any]]:
        """One control period; see `ReachVectorEnv.step`."""
        observations, rewards, terminated, truncated, infos = self.vector_env.step(np.asarray(action)[None])
        return observations[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), _first(infos)

    def render(self) -> NDArray[np.uint8] | None:
        """One RGB frame, (480, 640, 3), in the render mode ``rgb_array``."""
        return self.vector_env.render()[0] if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Close the simulator."""
        self.vector_env.close()


def _first(infos: dict[str, Any]) -> dict[str, Any]:
    return {key: values[0].item() for key, values in infos.items()}
