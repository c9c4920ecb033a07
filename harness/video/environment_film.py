"""The pictures of a film of policies in an environment: the episodes of their evaluations, played again and drawn."""

import warnings
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from harness.environment import AnyEnv, Environment
from harness.errors import UsageError
from harness.experiment.environments.acting import Acting
from harness.policy import load_policy
from harness.record.cell import Cell
from harness.record.folder import EVALUATION_RECORDING, POLICY
from harness.record.recording.recorded_training import RecordedTraining, read_recording
from harness.recorder.evaluate_policy import FIRST_SEED
from harness.registry.spec import blamed_on
from harness.results import Results
from harness.results.replay import find_done
from harness.scene.picture import BACKGROUND, require_pillow
from harness.text import one_line_of
from harness.video.film import COLOURS, HEIGHT, WIDTH, Frame, clock_of, frame_of, view_of

if TYPE_CHECKING:
    from PIL import Image

DRAWN = "rgb_array"
"""The render mode whose pictures are arrays."""
SUCCESS = "success"


def environment_film(results: Results, ids: Sequence[str], episodes: int) -> Iterator[Frame]:
    """The first episodes of the evaluations of some cells beside one another, one after the other.

    Args:
        results: Of an experiment whose task is an environment.
        ids: Of done cells, or how they begin; without any, the baseline and the reward after it, of one seed.
        episodes: How many, at most.

    Raises:
        UsageError: No such cell is done, pillow is missing, or an env draws nothing or does not repeat its episodes.
        SchemaError: A file of a cell is damaged.
    """
    require_pillow()
    cells = [find_done(results, name) for name in ids] or _first_cells(results)
    with ExitStack() as opened:
        sides = [opened.enter_context(closing(_Side(results, cell))) for cell in cells]
        for number in range(min(episodes, *(len(side.episodes) for side in sides))):
            yield from _episode(sides, number)


def _first_cells(results: Results) -> list[Cell]:
    """The baseline, and the first reward that was trained beside it with the same seed."""
    done = [manifest.cell for manifest in results.done]
    for first in (cell for cell in done if cell.reward.label == results.baseline):
        for other in done:
            same = (other.task, other.algorithm, other.seed) == (first.task, first.algorithm, first.seed)
            if same and other.reward != first.reward:
                return [first, other]
    if not done:
        raise UsageError(f"'{results.folder}' has nothing to show: no cell is done")
    return done[:1]


def _episode(sides: Sequence["_Side"], number: int) -> Iterator[Frame]:
    last = max(len(side.episodes[number]) for side in sides)
    clock = np.unique(np.rint(clock_of(last)).astype(int))
    played = [side.play(number, clock) for side in sides]
    for step in clock:
        views = [
            side.view(number, step, pictures, COLOURS[index % len(COLOURS)])
            for index, (side, pictures) in enumerate(zip(sides, played, strict=True))
        ]
        yield frame_of(views, f"episode {number}, step {step} of {last}", step == clock[-1])


class _Side:
    """One cell: its policy in a new env, and what was recorded of its evaluation."""

    def __init__(self, results: Results, cell: Cell) -> None:
        folder = results.store.cell_folder(cell)
        self._cell = cell
        self._recorded = read_recording(folder / EVALUATION_RECORDING)
        self.episodes = _episodes_of(self._recorded)
        """Rows of the recording, of each episode."""
        policy = load_policy(folder / POLICY)
        with blamed_on(results.registry.get("environments", cell.task.name), "an env was made"):
            environment: Environment = cell.task.build(results.registry, "environments")
            self._env = environment.make()
        _let_draw(self._env, cell)
        self._act = Acting(self._env, policy, None if cell.deterministic else np.random.default_rng(FIRST_SEED))

    def close(self) -> None:
        """Close the env."""
        self._env.close()

    def play(self, number: int, clock: NDArray[np.int_]) -> dict[int, "Image.Image"]:
        """Pictures of an episode by its steps, of those of the clock; episodes have to be played in order.

        Raises:
            UsageError: The env cannot draw, or the episode is not the one that was recorded.
        """
        length = len(self.episodes[number])
        wanted = {min(int(step), length) for step in clock}
        observation, _ = self._env.reset(seed=FIRST_SEED + number)
        pictures, step, ended = {0: self._draw()}, 0, False
        while not ended and step < length:
            observation, _, terminated, truncated, _ = self._env.step(self._act(observation))
            step, ended = step + 1, bool(terminated or truncated)
            if step in wanted:
                pictures[step] = self._draw()
        was_cut = length == self._recorded.facts.horizon
        if step < length or not (ended or was_cut):
            raise UsageError(
                f"Cell {self._cell.id}: episode {number} took {length} steps when it was evaluated, and takes "
                f"{'more' if step == length else step} here. Is another version of the environment installed?"
            )
        return pictures

    def view(self, number: int, step: int, pictures: dict[int, "Image.Image"], colour: str) -> "Image.Image":
        """How it stands at a step of an episode."""
        rows, title = self.episodes[number], f"{self._cell.reward.label} · seed {self._cell.seed}"
        at = min(step, len(rows))
        told, outcome = self._told(rows[:at]), self._outcome(rows) if at == len(rows) else ""
        return view_of(pictures[at], title, told, colour, outcome)

    def _told(self, rows: NDArray[np.int_]) -> str:
        """What its own reward has paid so far, and the first measure of behaviour."""
        told = [f"paid {self._recorded.rewards[self._cell.reward.name][rows].sum():.4g}"]
        for name, values in list(self._recorded.behaviour.items())[:1]:
            if len(rows) and np.isfinite(values[rows[-1]]):
                told.append(f"{name.replace('_', ' ')} {values[rows[-1]]:.3g}")
        return "   ".join(told)

    def _outcome(self, rows: NDArray[np.int_]) -> str:
        if SUCCESS in self._recorded.behaviour:
            return SUCCESS if self._recorded.behaviour[SUCCESS][rows[-1]] else f"no {SUCCESS}"
        return "ended" if self._recorded.terminated[rows[-1]] else "time-out"

    def _draw(self) -> "Image.Image":
        from PIL import Image, ImageOps

        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of libraries that are tried in vain; an exception follows
                drawn: Any = self._env.render()
        except Exception as error:  # an env of anybody, and the graphics driver under it
            raise UsageError(
                f"{self._cell.task.label} cannot draw here: {one_line_of(str(error))}. Without a screen set "
                "MUJOCO_GL=egl, or MUJOCO_GL=osmesa; harness doctor says what works"
            ) from error
        if not isinstance(drawn, np.ndarray) or drawn.ndim != 3:
            raise UsageError(f"{self._cell.task.label} draws no picture: its render() gave {type(drawn).__name__}")
        whole = Image.new("RGB", (WIDTH, HEIGHT), BACKGROUND)
        picture = ImageOps.contain(Image.fromarray(drawn), (WIDTH, HEIGHT))
        whole.paste(picture, ((WIDTH - picture.width) // 2, (HEIGHT - picture.height) // 2))
        return whole


def _episodes_of(recorded: RecordedTraining) -> list[NDArray[np.int_]]:
    """The rows of each episode that ended, in order."""
    ends = np.flatnonzero(recorded.terminated | recorded.truncated) + 1
    return [np.arange(begin, end) for begin, end in zip([0, *ends], ends, strict=False)]


def _let_draw(env: AnyEnv, cell: Cell) -> None:
    """Have the env draw into arrays.

    An environment's `make` takes no render mode, for training needs none. It is set afterwards: envs look at it when
    they draw.
    """
    if DRAWN not in env.metadata.get("render_modes", ()):
        raise UsageError(f"{cell.task.label} cannot be filmed: its env has no render mode '{DRAWN}'")
    env.unwrapped.render_mode = DRAWN
