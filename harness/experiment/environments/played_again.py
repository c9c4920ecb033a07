"""Episodes of a policy's evaluation in an environment, played again so that the environment draws them."""

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from harness.environment import AnyEnv, Environment
from harness.errors import UsageError
from harness.experiment.environments.spaces import Acting
from harness.log.log import BEHAVIOUR, REWARD, SUCCESS, episode_sum
from harness.policy import load_policy
from harness.record.cell import Cell
from harness.record.folder import EVALUATION_RECORDING, POLICY
from harness.record.recording.facts import facts_of
from harness.record.recording.recorded_training import read_recording
from harness.recorder.evaluate_policy import FIRST_SEED
from harness.registry.choice import Registry
from harness.text import one_line

if TYPE_CHECKING:
    from PIL import Image

DRAWN = "rgb_array"
"""The render mode whose pictures are arrays."""


class PlayedAgain:
    """One cell: its policy in a new env, and what was recorded of its evaluation.

    Attributes:
        cell: The cell.
        episodes: Rows of the recording, of each episode that ended, in order.
    """

    def __init__(self, cell: Cell, folder: Path, registry: Registry) -> None:
        """Make an env, and load the policy.

        Args:
            cell: The cell.
            folder: Its folder.
            registry: The plugins.

        Raises:
            UsageError: The env has no render mode that gives pictures.
            PluginError: The environment cannot be made.
            SchemaError: A file of the cell is damaged.
        """
        self.cell = cell
        self._recorded = read_recording(folder / EVALUATION_RECORDING).load()
        ends = np.flatnonzero(self._recorded["terminated"] | self._recorded["truncated"]) + 1
        self.episodes = [np.arange(begin, end) for begin, end in zip([0, *ends], ends, strict=False)]
        policy = load_policy(folder / POLICY)
        with cell.task.blamed(registry, "environments", "an env was made"):
            environment: Environment = cell.task.build(registry, "environments")
            self._env = environment.make()
        let_draw(self._env, cell.task.label)
        self._act = Acting(self._env, policy, None if cell.deterministic else np.random.default_rng(FIRST_SEED))

    def close(self) -> None:
        """Close the env."""
        self._env.close()

    def skip(self, count: int) -> None:
        """Let the first episodes pass, whose chance the next ones rest on; none where the policy takes no chance."""
        for number in range(0 if self.cell.deterministic else count):
            observation, _ = self._env.reset(seed=FIRST_SEED + number)
            for _ in self.episodes[number]:
                observation, *_ = self._env.step(self._act(observation))

    def play(self, number: int, clock: NDArray[np.int_]) -> dict[int, "Image.Image"]:
        """Pictures of an episode by its steps, of those of the clock; episodes have to be played or skipped in order.

        Raises:
            UsageError: The env cannot draw, or the episode is not the one that was recorded.
        """
        length = len(self.episodes[number])
        wanted = {min(int(step), length) for step in clock}
        observation, _ = self._env.reset(seed=FIRST_SEED + number)
        pictures, step, ended = {0: picture_of(self._env, self.cell.task.label)}, 0, False
        while not ended and step < length:
            observation, _, terminated, truncated, _ = self._env.step(self._act(observation))
            step, ended = step + 1, bool(terminated or truncated)
            if step in wanted:
                pictures[step] = picture_of(self._env, self.cell.task.label)
        was_cut = length == facts_of(self._recorded).horizon
        if step < length or not (ended or was_cut):
            raise UsageError(
                f"Cell {self.cell.id}: episode {number} took {length} steps when it was evaluated, and takes "
                f"{'more' if step == length else step} here. Is another version of the environment installed?"
            )
        return pictures

    def told(self, rows: NDArray[np.int_]) -> str:
        """What its own reward has paid so far, and the first measure of behaviour."""
        told = [f"paid {episode_sum(self._recorded[f'{REWARD}{self.cell.reward.label}'][rows]):.4g}"]
        for name in self._recorded.measures[:1]:
            values = self._recorded[f"{BEHAVIOUR}{name}"]
            if len(rows) and np.isfinite(values[rows[-1]]):
                told.append(f"{name.replace('_', ' ')} {values[rows[-1]]:.3g}")
        return "   ".join(told)

    def outcome(self, rows: NDArray[np.int_]) -> str:
        """How an episode with these rows ended, in a word or two."""
        if SUCCESS in self._recorded.measures:
            return SUCCESS if self._recorded[f"{BEHAVIOUR}{SUCCESS}"][rows[-1]] else f"no {SUCCESS}"
        return "ended" if self._recorded["terminated"][rows[-1]] else "time-out"


def picture_of(env: AnyEnv, name: str) -> "Image.Image":
    """What an env draws now.

    Raises:
        UsageError: It draws nothing; says which one, by name.
    """
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of libraries that are tried in vain; an exception follows
            drawn: Any = env.render()
    except Exception as error:  # an env of anybody, and the graphics driver under it
        raise UsageError(
            f"{name} cannot draw here: {one_line(str(error))}. Without a screen set "
            "MUJOCO_GL=egl, or MUJOCO_GL=osmesa; harness doctor says what works"
        ) from error
    if not isinstance(drawn, np.ndarray) or drawn.ndim != 3:
        raise UsageError(f"{name} draws no picture: its render() gave {type(drawn).__name__}")
    return Image.fromarray(drawn)


def let_draw(env: AnyEnv, name: str) -> None:
    """Have an env draw into arrays.

    An environment's `make` takes no render mode, for training needs none. It is set afterwards: envs look at it when
    they draw.

    Raises:
        UsageError: It cannot; says which one, by name.
    """
    if DRAWN not in env.metadata.get("render_modes", ()):
        raise UsageError(f"{name} cannot be drawn: its env has no render mode '{DRAWN}'")
    env.unwrapped.render_mode = DRAWN
