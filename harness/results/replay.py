"""Episodes of the final evaluations, shown side by side, and the paths of the end effector. Reads results only."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import SchemaError, UsageError
from harness.eta.manner import OWN_AND_OTHER
from harness.log import Log
from harness.log.log import sums_so_far
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, SCENE, SUFFIX
from harness.record.scene import Scene, read_scene
from harness.record.trace import OBSTACLE, OBSTACLES, PAID, episode_facts, paid_in, read_trace, with_episode_facts
from harness.results.comparison import Comparison, Group
from harness.results.metrics import Values
from harness.results.pairs import READ, Met, Pairs, cells_by_seed, kind_of, kinds_of
from harness.results.results import Results

Outcome = Literal["reached", "ground", "obstacle", "time-out"]
MOST = 6
"""The most episodes of a show."""
FRAMES = 150
"""The most frames of an episode. Of a longer episode, every n-th row is shown."""
ROOM = 16_000
"""About how many frames a page has room for, in all of its shows: some 700 kB."""
AXES = "xyz"
SHOWN, LARGEST = ("qpos", "distance", *PAID, *(f"target_{axis}" for axis in AXES)), 1e9
"""The columns that are shown, and the largest number that they may hold."""
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
    """Every metric of this episode alone; of `MOST` episodes of a show."""
    obstacles: Float = NO_OBSTACLES
    """Obstacles, (count, 7), world frame, [m], see `harness.conditions.obstacles`; (0, 7) if there are none."""


@dataclass(frozen=True, eq=False)
class Side:
    """What the policies of one reward did, or that of one cell.

    Attributes:
        title: What tells it from the other side.
        seeds: The seed of its training, of each episode.
        scene: What its arm looks like.
        episodes: As many as the show has, in the same order.
        period: The duration of an environment step, [s].
        error: What the episodes' distances are: ``distance``, or the name of the task's own error.
        unit: The unit of the distances.
    """

    title: str
    seeds: tuple[int, ...]
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
        pairs: All pairs of episodes of the comparison, the shown ones among them.
        first: The place of the episode that is shown first: of pairs, the typical one.
        kinds: The place of the typical episode of each kind of pairs.
    """

    title: str
    numbers: tuple[int, ...]
    sides: tuple[Side, ...]
    comparison: Comparison | None = None
    told: str = ""
    pairs: Pairs | None = None
    first: int = 0
    kinds: Mapping[int, int] = field(default_factory=dict)


def shows_of(results: Results, most: int = MOST) -> tuple[Show, ...]:
    """A show for each combination, of the seeds that both rewards have, and one for each other reward that is done.

    Cells without a scene, as those of version 0.1, are left out.

    Args:
        results: The experiment.
        most: Episodes of a show; one of a combination has more where the page has room.

    Raises:
        SchemaError: A file is damaged or written by a newer version.
    """
    pairs = [*_pairs(results)]
    return tuple(filter(None, (_show(results, pair, most, ROOM // len(pairs)) for pair in pairs)))


def first_show(results: Results, most: int) -> Show:
    """The first of `shows_of`.

    Raises:
        UsageError: There is none.
        SchemaError: A file is damaged or written by a newer version.
    """
    found = next(filter(None, (_show(results, pair, most) for pair in _pairs(results))), None)
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
    show = _show(results, ShownCells(tuple((cell,) for cell in cells), common, titles), episodes)
    if show is None:
        raise UsageError(f"Of {', '.join(ids)}, a cell has no {SCENE}: an earlier version made it. Run it again.")
    return show


def choose(outcomes: Sequence[Sequence[Outcome]], pairs: Pairs | None = None) -> list[int]:
    """All episodes by what a reader wants to see of them first.

    The first, or of pairs the typical one of each kind, the most frequent kind first; one for each outcome of each
    side; then the others by number, pairs of other kinds than the most frequent one before those of it.

    Args:
        outcomes: The outcomes of each side, of the same episodes.
        pairs: What the same episodes are in a comparison.

    Returns:
        Their places.
    """
    first, others = [0], [*range(len(outcomes[0]))]
    if pairs is not None:
        met, usual = pairs.met, pairs.usual
        first = [*map(pairs.typical, pairs.counts)]
        others.sort(key=lambda it: (met[it].kind == usual, met[it].number))
    ends = [side.index(outcome) for side in outcomes for outcome in dict.fromkeys(side)]
    return list(dict.fromkeys([*first, *ends, *others]))


class ShownCells(NamedTuple):
    """Cells to be shown beside one another, the title of what they share, and those that tell them apart."""

    cells: tuple[tuple[Cell, ...], ...]
    """Those of each side, as many of each."""
    title: str
    titles: tuple[str, ...]
    comparison: Comparison | None = None

    @property
    def files(self) -> list[str]:
        """The evaluation of the cells of each side. For a combination it is the one that decides about the robot."""
        told = self.comparison
        if told is None or told.manner == told.own_manner:
            return [EVALUATION] * len(self.cells)
        return [f"{OWN_AND_OTHER[cells[0].deterministic][1]}{SUFFIX}" for cells in self.cells]


def _pairs(results: Results) -> Iterator[ShownCells]:
    """Pairs with both rewards of each combination, and the first seed of each reward that is in no combination."""
    shown: set[tuple[Group, str]] = set()
    for it in results.combinations:
        if it.seeds and not it.is_control:
            rewards = (it.baseline, it.proposed)
            shown |= {(it.group, reward) for reward in rewards}
            titles = (f"Baseline: {it.baseline}", f"Proposed: {it.proposed}")
            yield ShownCells(cells_by_seed(results, it), it.group.title, titles, it)
    for cell in results.done_cells:
        group, reward = Group.of(cell), cell.reward.label
        if (group, reward) not in shown:
            shown.add((group, reward))
            yield ShownCells(((cell,),), group.title, (reward,))


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


class Way(NamedTuple):
    """One episode of an evaluation as it was recorded."""

    trace: Log
    rows: NDArray[np.int64]
    seed: int = 0
    """The seed of its training."""
    number: int = 0
    """From 0."""

    @property
    def outcome(self) -> Outcome:
        """How it ended."""
        trace, last = self.trace, self.rows[-1]
        if trace["reached"][self.rows].any():
            return "reached"
        if trace[OBSTACLE][last]:
            return "obstacle"
        return "ground" if trace["ground"][last] and trace["terminated"][last] else "time-out"

    @property
    def took(self) -> int:
        """Steps until the target was reached, or to its end."""
        reached = self.trace["reached"][self.rows]
        return int(reached.argmax()) if reached.any() else len(self.rows) - 1


def _show(results: Results, shown: ShownCells, most: int, room: int = 0) -> Show | None:
    """The show of some cells; None if one has no scene, or if no episode ended.

    Args:
        results: The experiment.
        shown: The cells.
        most: The most episodes.
        room: Frames for which there is room: of a comparison more than `most` episodes are shown up to these.
    """
    folder_of = results.store.cell_folder
    scenes = [scene for cells in shown.cells if cells and (scene := read_scene(folder_of(cells[0])))]
    if len(scenes) < len(shown.cells):
        return None
    met = [
        ways
        for cells in zip(*shown.cells, strict=True)
        for ways in zip(*map(_ways, cells, map(folder_of, cells), shown.files, scenes), strict=False)
    ]
    if not met:
        return None
    outcomes = [[way.outcome for way in ways] for ways in zip(*met, strict=True)]
    pairs, kinds = None, dict[int, int]()
    if shown.comparison is not None:
        ends = [kind_of(*(way.outcome == "reached" for way in ways)) for ways in met]
        found = (Met(one.seed, one.number, kind, it.took - one.took) for (one, it), kind in zip(met, ends, strict=True))
        pairs = Pairs(kinds_of("reach", shown.comparison.proposed, "es"), tuple(found))
    chosen = choose(outcomes, pairs)
    measured, chosen = set(chosen[:MOST]), sorted(_within(met, chosen, most, room if pairs else 0))
    if pairs is not None:
        kinds = {kind: chosen.index(it) for kind in pairs.counts if (it := pairs.typical(kind)) in chosen}
    sides = []
    for title, scene, ways in zip(shown.titles, scenes, zip(*met, strict=True), strict=True):
        facts = episode_facts(ways[0].trace)
        sides.append(
            Side(
                title,
                tuple(ways[place].seed for place in chosen),
                scene,
                tuple(_episode(results, ways[place], place in measured) for place in chosen),
                facts.control_period or CONTROL_PERIOD,
                facts.error or "distance",
                "m" if facts.error is None else facts.unit or "",
            )
        )
    numbers, first = tuple(met[place][0].number + 1 for place in chosen), kinds[pairs.usual] if pairs else 0
    return Show(shown.title, numbers, tuple(sides), shown.comparison, pairs=pairs, first=first, kinds=kinds)


def _within(met: Sequence[tuple[Way, ...]], chosen: Sequence[int], most: int, room: int) -> Iterator[int]:
    """The first `most` of them, and more as long as there is room."""
    frames = 0
    for count, place in enumerate(chosen):
        frames += sum(min(FRAMES, len(way.rows)) for way in met[place])
        if count >= most and frames > room:
            return
        yield place


def _ways(cell: Cell, folder: Path, name: str, scene: Scene) -> list[Way]:
    """The episodes of an evaluation, in order."""
    path = folder / name
    trace = read_trace(path).load()  # at once: a file is opened for each column that is asked for alone
    shown = (*SHOWN, OBSTACLES) if OBSTACLES in trace else SHOWN
    if max(float(np.abs(trace[name]).max(initial=0.0)) for name in shown) > LARGEST:
        raise SchemaError(f"{path} holds numbers beyond {LARGEST:g}, which cannot be shown")
    dof = trace["qpos"].shape[1]
    if dof != len(scene.joints):
        raise SchemaError(f"{path} has {dof} joint positions a row, the arm {len(scene.joints)} joints")
    return [Way(trace, rows, cell.seed, number) for number, rows in enumerate(trace.episodes[:READ])]


def _episode(results: Results, way: Way, is_measured: bool) -> Episode:
    trace, rows = way.trace, way.rows
    steps = np.unique(np.linspace(0, len(rows) - 1, min(FRAMES, len(rows))).round().astype(np.int64))
    kept = rows[steps]
    paid = sums_so_far(paid_in(trace)[rows[1:]])  # the first row is the start
    return Episode(
        steps,
        trace["qpos"][kept],
        _places(trace, "target", kept),
        trace["distance"][kept],
        paid[steps],
        way.outcome,
        results.measure(_alone(trace, rows)) if is_measured else {},
        _obstacles(trace, rows),
    )


def _places(trace: Log, name: str, rows: NDArray[np.int64]) -> Float:
    """Where a point is in some rows, (rows, 3), world frame, [m]."""
    return np.stack([trace[f"{name}_{axis}"][rows] for axis in AXES], axis=1)


def _obstacles(trace: Log, rows: NDArray[np.int64]) -> Float:
    if OBSTACLES not in trace:
        return NO_OBSTACLES
    all_of_them: Float = trace[OBSTACLES][rows[0]].reshape(-1, NO_OBSTACLES.shape[1])
    return all_of_them[all_of_them[:, 3:].any(axis=1)]


def _alone(trace: Log, rows: NDArray[np.int64]) -> Log:
    """An evaluation, which has one episode in each env, with the episode of these rows alone, in env 0."""
    env = int(trace["env"][rows[0]])
    alone = trace.part(rows).add({"env": np.zeros(len(rows), np.int32)})
    facts, own = episode_facts(trace), slice(env, env + 1)
    steps, work = facts.ik_steps, facts.work
    return with_episode_facts(alone, replace(facts, ik_steps=steps and steps[own], work=work and work[own]))


EPISODES = 30
"""The most episodes that are read of an evaluation. More paths could not be told apart."""
POINTS = ("end_effector", "target")


class Trajectory(NamedTuple):
    """One episode, from its start to the first time that the target is reached, or else to its end."""

    points: Float
    """Places of the end effector at the start and after each step, (steps + 1, 3), world frame, [m]."""
    target: Float
    """The target, (3,), world frame, [m]."""
    reached: bool


@dataclass(frozen=True)
class Trajectories:
    """The first episodes of two evaluations, which began in the same poses with the same targets.

    Attributes:
        seed: The seed of both trainings.
        baseline: The paths under the baseline reward.
        proposed: The paths under the proposed reward.
    """

    seed: int
    baseline: tuple[Trajectory, ...]
    proposed: tuple[Trajectory, ...]


def trajectories_of(results: Results, comparison: Comparison) -> Trajectories | None:
    """The end effector's paths under both rewards, for the first seed that both have.

    None if there is no such seed, or for the null control, which has only one reward.

    Raises:
        SchemaError: A file is damaged or written by a newer version.
    """
    files = [results.store.cell_folder(cells[0]) / EVALUATION for cells in cells_by_seed(results, comparison) if cells]
    if comparison.is_control or not files or not all(map(Path.is_file, files)):  # recordings of no arm
        return None
    found = []
    for trace in map(read_trace, files):
        ways = [Way(trace, rows) for rows in trace.episodes[:EPISODES]]
        places = [[_places(trace, name, it.rows[: it.took + 1]) for name in POINTS] for it in ways]
        ends = [it.outcome == "reached" for it in ways]
        found.append(tuple(Trajectory(way, target[0], end) for (way, target), end in zip(places, ends, strict=True)))
    return Trajectories(comparison.seeds[0], *found)
