"""Episodes of the final evaluations, to be shown side by side. Reads results only."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import SchemaError, UsageError
from harness.log import Log
from harness.record.cell import Cell
from harness.record.episode_facts import episode_facts, with_episode_facts
from harness.record.folder import EVALUATION, SCENE, other_manner
from harness.record.scene import Scene, read_scene
from harness.record.trace import OBSTACLE, OBSTACLES, read_trace
from harness.results.comparison import Comparison, Group
from harness.results.measured import Values
from harness.results.results import Results

Outcome = Literal["reached", "ground", "obstacle", "time-out"]
FIRST, DIFFERENT, MOST = 1, 3, 6
"""The most episodes of a show: first ones, episodes that end differently, and all together."""
FRAMES = 150
"""The most frames of an episode. Of a longer episode, every n-th row is shown."""
READ = 200
"""How many episodes of an evaluation are looked at."""
AXES = "xyz"
PAID = ("reward", "reward_ground", "reward_target", "reward_step")
SHOWN, LARGEST = ("qpos", "distance", *PAID, *(f"target_{axis}" for axis in AXES)), 1e9
"""The columns that are shown, and the largest number that they may hold."""
REACHED, TIMEOUTS = "success_rate", "timeouts"
"""Metrics that say how the episodes of a cell ended."""
NO_OBSTACLES: Float = np.empty((0, 7))
CONTROL_PERIOD = 0.1
"""The control period of an evaluation that does not record its own, [s]."""


class Episode(NamedTuple):
    """One episode of an evaluation. `frames` of its rows are shown, with the first and the last."""

    steps: NDArray[np.int64]
    """Environment steps done at each frame, (frames,); the first is 0."""
    qpos: Float
    """Joint positions, [rad] or [m], (frames, dof)."""
    target: Float
    """The target in the world frame, [m], (frames, 3)."""
    distance: Float
    """From the end effector to the target, [m], (frames,)."""
    paid: Float
    """What the cell's own reward and the task's events have paid so far, (frames,)."""
    outcome: Outcome
    values: Values
    """Every metric of this episode alone."""
    obstacles: Float = NO_OBSTACLES
    """Obstacles, (count, 7), world frame, [m], see `harness.conditions.obstacles`; (0, 7) if there are none."""


@dataclass(frozen=True, eq=False)
class Side:
    """What one cell's policy did.

    Attributes:
        title: What tells it from the other side.
        cell: Id of the cell.
        seed: The seed of its training.
        scene: What its arm looks like.
        episodes: As many as the show has, in the same order.
        period: The duration of an environment step, [s].
        error: What the episodes' distances are: ``distance``, or the name of the task's own error.
        unit: The unit of the distances.
    """

    title: str
    cell: str
    seed: int
    scene: Scene
    episodes: tuple[Episode, ...]
    period: float
    error: str = "distance"
    unit: str = "m"


@dataclass(frozen=True, eq=False)
class Show:
    """Episodes that several policies began in the same pose with the same target.

    Attributes:
        title: What the sides have in common.
        numbers: The numbers of the episodes in the evaluation, from 1.
        sides: One, or the baseline's and the proposed reward's.
        comparison: The combination that compares both rewards; None if nothing compares the cells.
        told: What its episodes are, where they are none of a final evaluation.
    """

    title: str
    numbers: tuple[int, ...]
    sides: tuple[Side, ...]
    comparison: Comparison | None = None
    told: str = ""


def shows_of(results: Results, most: int = MOST) -> tuple[Show, ...]:
    """A show for each combination, with one seed that both rewards have, and one for each other reward that is done.

    The seed is the one whose episodes end in the most ways, the first of several. Cells without a scene, as those of
    version 0.1, are left out.

    Args:
        results: The experiment.
        most: Episodes of a show.

    Raises:
        SchemaError: A file is damaged or written by a newer version.
    """
    shows = [_show(results, pair, most) for pair in _pairs(results)]
    return tuple(show for show in shows if show is not None)


def first_show(results: Results, most: int) -> Show:
    """The first of `shows_of`.

    Raises:
        UsageError: There is none.
        SchemaError: A file is damaged or written by a newer version.
    """
    shows = (_show(results, pair, most) for pair in _pairs(results))
    found = next((show for show in shows if show is not None), None)
    if found is None:
        raise UsageError(
            f"'{results.folder}' has no episode to show: no cell is done, or an earlier version made them all. "
            "Run the experiment again."
        )
    return found


def show_cells(results: Results, ids: Sequence[str], episodes: int = MOST) -> Show:
    """The evaluations of named cells beside one another.

    Args:
        results: The experiment.
        ids: Ids of done cells, or how they begin.
        episodes: How many are chosen.

    Raises:
        UsageError: No such cell is done, several are meant, or one has no scene.
        SchemaError: A file is damaged or written by a newer version.
    """
    cells = [find_done(results, name) for name in ids]
    titles = tuple(f"{cell.reward.label} · seed {cell.seed}" for cell in cells)
    common = " · ".join(dict.fromkeys(Group.of(cell).title for cell in cells))
    show = _show(results, ShownCells(tuple(cells), common, titles), episodes)
    if show is None:
        raise UsageError(f"Of {', '.join(ids)}, a cell has no {SCENE}: an earlier version made it. Run it again.")
    return show


def choose_episodes(outcomes: Sequence[Sequence[Outcome]], most: int = MOST) -> list[int]:
    """The episodes that show most: the first, one that ends differently, and one for each outcome of each side.

    Then others that end differently, one that fails on every side, and others.

    Args:
        outcomes: The outcomes of each side, for the same episodes.
        most: The most episodes.

    Returns:
        Their numbers, from 0, in order.
    """
    together = list(zip(*outcomes, strict=True))
    everything = list(range(len(together)))
    different = [number for number in everything if len(set(together[number])) > 1]
    failed = [number for number in everything if "reached" not in together[number]]
    ends = [side.index(outcome) for side in outcomes for outcome in dict.fromkeys(side)]
    wanted = [*everything[:FIRST], *different[:1], *ends, *different[:DIFFERENT], *failed[:1], *everything]
    return sorted(list(dict.fromkeys(wanted))[:most])


class ShownCells(NamedTuple):
    """Cells to be shown beside one another, the title of what they share, and those that tell them apart."""

    cells: tuple[Cell, ...]
    title: str
    titles: tuple[str, ...]
    comparison: Comparison | None = None

    @property
    def files(self) -> list[str]:
        """The evaluation of each cell that is shown. For a combination it is the one that decides about the robot."""
        told = self.comparison
        if told is None or told.manner == told.own_manner:
            return [EVALUATION] * len(self.cells)
        return [other_manner(cell.deterministic) for cell in self.cells]


def _pairs(results: Results) -> Iterator[ShownCells]:
    """Pairs with both rewards of each combination, and the first seed of each reward that is in no combination."""
    cells_of = {(Group.of(cell), cell.reward.label, cell.seed): cell for cell in results.done_cells}
    shown: set[tuple[Group, str]] = set()
    for it in results.combinations:
        if it.seeds and not it.is_control:
            rewards = (it.baseline, it.proposed)
            shown |= {(it.group, reward) for reward in rewards}
            seeds = [tuple(cells_of[it.group, reward, seed] for reward in rewards) for seed in it.seeds]
            cells = max(seeds, key=lambda pair: sum(_count_outcomes(results, cell, it.manner) for cell in pair))
            yield ShownCells(cells, it.group.title, (f"Baseline: {it.baseline}", f"Proposed: {it.proposed}"), it)
    for cell in results.done_cells:
        group, reward = Group.of(cell), cell.reward.label
        if (group, reward) not in shown:
            shown.add((group, reward))
            yield ShownCells((cell,), group.title, (reward,))


def _count_outcomes(results: Results, cell: Cell, manner: str) -> int:
    """In how many ways the episodes of a cell ended."""
    values = results.measured(cell).manners.get(manner, {})
    reached, over = (values.get(name) or 0.0 for name in (REACHED, TIMEOUTS))
    return sum(share > 1e-9 for share in (reached, over, 1.0 - reached - over))


def find_done(results: Results, name: str) -> Cell:
    """The done cell whose id begins with `name`.

    Raises:
        UsageError: There is none, or there are several.
    """
    found = [manifest.cell for manifest in results.done if manifest.cell.id.startswith(name)]
    if len(found) != 1:
        told = "several" if found else "none"
        raise UsageError(
            f"--cells {name}: {told} of the done cells have an id that begins so. "
            "results.parquet and the report page list the ids"
        )
    return found[0]


def _show(results: Results, pair: ShownCells, most: int) -> Show | None:
    """The show of a pair; None if a cell has no scene, or if no episode ended."""
    cells, title, titles, comparison = pair
    folders = [results.store.cell_folder(cell) for cell in cells]
    scenes = [read_scene(folder) for folder in folders]
    known = [scene for scene in scenes if scene is not None]
    if len(known) < len(scenes):
        return None
    paths = [folder / name for folder, name in zip(folders, pair.files, strict=True)]
    traces = [_read(path, scene) for path, scene in zip(paths, known, strict=True)]
    ways = [trace.episodes[:READ] for trace in traces]
    count = min(map(len, ways))
    outcomes = [[_outcome(trace, rows) for rows in way[:count]] for trace, way in zip(traces, ways, strict=True)]
    chosen = choose_episodes(outcomes, most)
    sides = tuple(
        Side(
            told,
            cell.id,
            cell.seed,
            scene,
            tuple(_episode(results, trace, way[number]) for number in chosen),
            episode_facts(trace).control_period or CONTROL_PERIOD,
            episode_facts(trace).error or "distance",
            "m" if episode_facts(trace).error is None else episode_facts(trace).unit or "",
        )
        for told, cell, scene, trace, way in zip(titles, cells, known, traces, ways, strict=True)
    )
    return Show(title, tuple(number + 1 for number in chosen), sides, comparison) if chosen else None


def _read(path: Path, scene: Scene) -> Log:
    trace = read_trace(path)
    shown = (*SHOWN, OBSTACLES) if OBSTACLES in trace else SHOWN
    if max(float(np.abs(trace[name]).max(initial=0.0)) for name in shown) > LARGEST:
        raise SchemaError(f"{path} holds numbers beyond {LARGEST:g}, which cannot be shown")
    dof = trace["qpos"].shape[1]
    if dof != len(scene.joints):
        raise SchemaError(f"{path} has {dof} joint positions a row, the arm {len(scene.joints)} joints")
    return trace


def _episode(results: Results, trace: Log, rows: NDArray[np.int64]) -> Episode:
    steps = np.unique(np.linspace(0, len(rows) - 1, min(FRAMES, len(rows))).round().astype(np.int64))
    kept = rows[steps]
    paid = np.cumsum(np.sum([trace[name][rows] for name in PAID], axis=0))
    target = np.stack([trace[f"target_{axis}"][kept] for axis in AXES], axis=1)
    return Episode(
        steps,
        trace["qpos"][kept],
        target,
        trace["distance"][kept],
        paid[steps],
        _outcome(trace, rows),
        results.measure(single_episode(trace, rows)),
        _obstacles(trace, rows),
    )


def _obstacles(trace: Log, rows: NDArray[np.int64]) -> Float:
    if OBSTACLES not in trace:
        return NO_OBSTACLES
    all_of_them: Float = trace[OBSTACLES][rows[0]].reshape(-1, NO_OBSTACLES.shape[1])
    return all_of_them[all_of_them[:, 3:].any(axis=1)]


def _outcome(trace: Log, rows: NDArray[np.int64]) -> Outcome:
    if trace["reached"][rows].any():
        return "reached"
    if trace[OBSTACLE][rows[-1]]:
        return "obstacle"
    return "ground" if trace["ground"][rows[-1]] and trace["terminated"][rows[-1]] else "time-out"


def single_episode(trace: Log, rows: NDArray[np.int64]) -> Log:
    """The trace of an evaluation with this episode alone, in env 0.

    Args:
        trace: An evaluation: one episode in each env.
        rows: Row numbers of the episode, its start row first.
    """
    env = int(trace["env"][rows[0]])
    alone = trace.part(rows).add({"env": np.zeros(len(rows), np.int32)})
    facts, own = episode_facts(trace), slice(env, env + 1)
    steps, work = facts.ik_steps, facts.work
    return with_episode_facts(alone, replace(facts, ik_steps=steps and steps[own], work=work and work[own]))
