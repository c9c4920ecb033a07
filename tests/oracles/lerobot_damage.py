"""What may be wrong in a data set of LeRobot: what has to be refused, and what can be left out if that is told."""

from collections.abc import Sequence

import numpy as np
import pyarrow as pa

from tests.oracles.lerobot_sets import LEFT_OUT, ask, draw_layout, parts_of, write
from tests.oracles.recorded_runs import answer_of, draw_runs
from tests.oracles.trial import Trial


def damaged(rng, folder):
    """Something is wrong, and no number can be right."""
    runs = draw_runs(rng)
    damage = rng.choice(DAMAGES)
    parts = parts_of(runs, draw_layout(rng))
    damage(parts, rng)
    write(parts, folder)
    return Trial(f"{damage.__name__}, {parts.layout.version}", lambda: ask(folder))


def partly(rng, folder):
    """Something is wrong that can be left out, or read around, if it is told."""
    runs = draw_runs(rng)
    change = rng.choice(PARTLY)
    parts = parts_of(runs, draw_layout(rng))
    rest, may_refuse, tells = change(parts, runs, rng)
    write(parts, folder)
    told = f"{change.__name__}, {parts.layout.version}"
    right = [answer_of(one) for one in rest]
    if change is nan_pay:  # one reward loses the episode, and the data set does not
        right = [answer_of(runs) | {"auc": right[0]["auc"]}]
    return Trial(told, lambda: ask(folder), right, may_refuse, tells)


# Damage


def _long(parts, rng, least=2):
    """The rows of an episode of so many rows at least; one is made longer if there is none."""
    number = parts.columns["episode_index"]
    return np.flatnonzero(number == rng.choice(np.flatnonzero(np.bincount(number) >= least).tolist()))


def drop_row(parts, rng):
    """A row of an episode is gone; its metadata still tell of it."""
    gone = rng.choice(_long(parts, rng).tolist())
    parts.keep(np.arange(len(parts.place)) != gone)


def double_row(parts, rng):
    """A row stands there twice."""
    row = rng.randrange(len(parts.place))
    parts.keep(np.sort(np.append(np.arange(len(parts.place)), row)))


def swap_rows(parts, rng):
    """Two rows of an episode have changed places, with their numbers."""
    rows, order = _long(parts, rng), np.arange(len(parts.place))
    one, other = rng.sample(rows.tolist(), 2)
    order[[one, other]] = order[[other, one]]
    parts.keep(order)


def drop_episode(parts, rng):
    """The rows of an episode are gone; the metadata still list it."""
    parts.keep(parts.columns["episode_index"] != rng.randrange(len(parts.episodes)))


def lie_on_length(parts, rng):
    """The metadata tell another length of an episode."""
    episode = rng.choice(parts.episodes)
    episode["length"] += rng.choice((1, 5))
    if "dataset_to_index" in episode:
        episode["dataset_to_index"] = episode["dataset_from_index"] + episode["length"]


def ragged(parts, rng):
    """A number of a state is missing in one row, and one too many stands in another."""
    rows = [row.tolist() for row in parts.columns["observation.state"]]
    rows[0] = rows[0][:-1]
    rows[-1] = [*rows[-1], rng.random()]
    parts.layout.lists = "list"
    parts.columns["observation.state"] = _Ragged(rows)


class _Ragged:
    """Rows of lists of different lengths; as an array as far as the writer needs it."""

    def __init__(self, rows: Sequence[Sequence[float]]) -> None:
        self.rows = list(rows)

    def __getitem__(self, rows):
        return pa.array([self.rows[row] for row in np.arange(len(self.rows))[rows].tolist()], pa.list_(pa.float32()))


def probabilities(parts, rng):
    """Labels are neither 0 nor 1."""
    label = parts.layout.label
    values = parts.columns[label].astype(np.float32)
    values[rng.randrange(len(values))] = rng.choice((0.5, 2.0, 0.97, np.inf))
    parts.columns[label] = values
    parts.info["features"][label]["dtype"] = "float32"


def lie_on_total(parts, rng):
    """Info tells of more episodes, or of more rows, than there are."""
    key = rng.choice(("total_episodes", "total_frames"))
    parts.info[key] += rng.choice((1, 10))


def missing_column(parts, rng):
    """Info tells of a column that is not there."""
    name = rng.choice(("action", "observation.state", "frame_index", "next.reward"))
    del parts.columns[name]


def text_for_numbers(parts, rng):
    """Rewards, or labels, are texts."""
    name = rng.choice(("next.reward", parts.layout.label))
    parts.columns[name] = np.array([f"{value}" for value in parts.columns[name].tolist()])
    parts.layout.scalars_in_lists = False


def backwards(parts, rng):
    """Frames count down."""
    number, frame = parts.columns["episode_index"], parts.columns["frame_index"].copy()
    counts = np.bincount(number)
    parts.columns["frame_index"] = counts[number] - 1 - frame
    if counts.max() == 1:
        parts.columns["frame_index"] = frame + 1


def begins_late(parts, rng):
    """The frames of an episode begin at 1."""
    rows = _long(parts, rng, 1)
    frame = parts.columns["frame_index"].copy()
    frame[rows] += 1
    parts.columns["frame_index"] = frame


DAMAGES = (
    drop_row, double_row, swap_rows, drop_episode, lie_on_length, ragged, probabilities, lie_on_total,
    missing_column, text_for_numbers, backwards, begins_late,
)  # fmt: skip

# What can be left out, or read around: the episodes of each answer that is right, whether a refusal is too, and what
# has to be told.


def left_over(parts, runs, rng):
    """Episodes lie there that the metadata no longer list."""
    count = rng.randrange(1, max(2, len(runs) // 3))
    parts.episodes = parts.episodes[:-count]
    parts.info["total_episodes"] = len(parts.episodes)
    parts.info["total_frames"] = sum(episode["length"] for episode in parts.episodes)
    parts.info["splits"] = {"train": f"0:{len(parts.episodes)}"}
    return [runs[:-count]], True, LEFT_OUT


def nan_pay(parts, runs, rng):
    """A reward is not finite."""
    row = rng.randrange(len(parts.place))
    number = int(parts.columns["episode_index"][row])
    parts.columns["next.reward"][row] = rng.choice((np.nan, np.inf))
    return [[run for place, run in enumerate(runs) if place != number]], False, LEFT_OUT


def nan_state(parts, runs, rng):
    """A state is not finite; what was paid is."""
    parts.columns["observation.state"][rng.randrange(len(parts.place)), rng.randrange(3)] = np.nan
    return [runs], False, ""


def fewer_told(parts, runs, rng):
    """Info tells of fewer episodes than metadata and rows have."""
    parts.info[rng.choice(("total_episodes", "total_frames"))] -= 1
    return [runs], True, r"(?i)total"


def swapped_files(parts, runs, rng):
    """Two files, or two episodes of one, have changed places; rows carry the number of their own episode."""
    one, other = rng.sample(range(len(runs)), 2)
    number, place = parts.columns["episode_index"], parts.place.copy()
    if parts.layout.version == "v3.0":
        order = list(range(len(runs)))
        order[one], order[other] = other, one
        parts.keep(np.concatenate([np.flatnonzero(number == which) for which in order]))
    else:
        place[number == one], place[number == other] = other, one
        parts.place = place
    return [runs], True, ""


PARTLY = (left_over, nan_pay, nan_state, fewer_told, swapped_files)
ORACLES = {"lerobot, damaged": damaged, "lerobot, in part": partly}
