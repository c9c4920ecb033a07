"""The replay as a part of a page: HTML with its data, one style sheet and one script, and no request.

The script is our own: some 300 lines of WebGL 2 and canvas draw an arm. A library such as three.js would bring 0.7 MB.
"""

import base64
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from harness.arrays import Float
from harness.eta.behaviour_change import Change
from harness.eta.headline import SUCCESS
from harness.record.scene import Scene, SceneJoint
from harness.report.figures.chart import SIDES, light_colours
from harness.report.rows.comparison import text_of
from harness.results.comparison import Comparison
from harness.results.pairs import Pairs
from harness.results.replay import Episode, Outcome, Show, Side

TURN, RISE = -0.9, 0.35
"""Where the camera stands, as in the replay, [rad]."""
AIR = 0.15
"""Around what is seen, as a share of its size."""


def draw_sticks(sides: Sequence[Side], index: int) -> tuple[str, ...]:
    """The end of an episode of each side, with the target as a ring; all in one scale.

    Args:
        sides: The sides of a show.
        index: The place of the episode in it.
    """
    ends = [side.episodes[index] for side in sides]
    arms = [_seen(joints_of(side.scene, it.qpos[-1])) for side, it in zip(sides, ends, strict=True)]
    targets = [_seen(it.target[-1:])[0] for it in ends]
    points = np.vstack([*arms, *targets])
    middle, size = (points.min(axis=0) + points.max(axis=0)) / 2, float(np.ptp(points, axis=0).max()) * (1 + AIR)
    left, top = middle - size / 2
    box = f'viewBox="{left:.3f} {top:.3f} {size:.3f} {size:.3f}" aria-hidden="true"'
    return tuple(
        f'<svg class="stick" {box}><polyline points="{" ".join(f"{x:.3f},{y:.3f}" for x, y in arm)}" fill="none" '
        f'stroke="currentColor" stroke-width="{size / 30:.4f}" stroke-linejoin="round"/><circle cx="{target[0]:.3f}" '
        f'cy="{target[1]:.3f}" r="{size / 25:.4f}" fill="none" stroke="#00805c" stroke-width="{size / 60:.4f}"/></svg>'
        for arm, target in zip(arms, targets, strict=True)
    )


def joints_of(scene: Scene, qpos: Float) -> Float:
    """The foot, each joint and the end effector at joint positions, (dof,), in the world frame, [m], (dof + 2, 3)."""
    frame, points = np.eye(4), [np.zeros(3)]
    for joint, position in zip(scene.joints, qpos, strict=True):
        frame = frame @ _whole(joint.frame) @ _motion(joint, float(position))
        points.append(frame[:3, 3])
    return np.array([*points, (frame @ _whole(scene.tip))[:3, 3]])


def _motion(joint: SceneJoint, position: float) -> Float:
    motion, (x, y, z) = np.eye(4), joint.axis
    if joint.slides:
        motion[:3, 3] = joint.axis * position
    else:  # Rodrigues' formula
        across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        motion[:3, :3] += math.sin(position) * across + (1.0 - math.cos(position)) * across @ across
    return motion


def _whole(frame: Float) -> Float:
    """A frame of three rows, (3, 4), as one of four."""
    return np.vstack([frame, [0.0, 0.0, 0.0, 1.0]])


def _seen(points: Float) -> Float:
    """To the right and downwards in the picture, (count, 2), [m]."""
    c, s, up, level = math.cos(TURN), math.sin(TURN), math.sin(RISE), math.cos(RISE)
    seen: Float = points @ np.array([[-s, c, 0.0], [up * c, up * s, -level]]).T
    return seen


BASELINE, PROPOSED = 0, 1
"""Places of the sides in a show."""
ENDS: tuple[Outcome, ...] = ("reached", "time-out", "ground", "obstacle")
"""The ways to end, in the order in which a link looks for them."""


class Link(NamedTuple):
    """A link of the page."""

    address: str
    title: str
    """Which episode it is, and what it shows."""


class Still(NamedTuple):
    """The end of a pair of episodes, as the first screen shows it."""

    show: int
    """Number of its show, from 0."""
    ends: tuple[str, ...]
    """The reward of each side, and how its episode ended."""
    share: str
    """How often pairs end so."""
    link: Link
    """To the pair in the replay."""
    otherwise: str
    """How many pairs end otherwise; empty if none does."""
    other: Link | None
    """To one of them."""
    sticks: tuple[str, ...]
    """The end of each side as SVG, for where no script draws it."""


@dataclass(frozen=True)
class EpisodeLinks:
    """Links to the episodes of one comparison.

    Attributes:
        place: Number of the show on the page, from 1.
        show: The show, with episodes under both rewards.
    """

    place: int
    show: Show

    def ending(self, side: int, outcome: str) -> Link | None:
        """A link to the first episode that ended so under the side's reward; None if no such episode is shown."""
        for index, episode in enumerate(self.show.sides[side].episodes):
            if episode.outcome == outcome:
                return self._link(side, index, outcome)
        return None

    def showing(self, side: int, change: Change) -> Link | None:
        """To the shown episode whose value is nearest to a measure's mean; None where none has a value.

        Of a measure that is 0 or 1 in every episode, a share, to an episode that it counts, if there is one.
        """
        mean = change.proposed if side == PROPOSED else change.baseline
        found = enumerate(self.show.sides[side].episodes)
        values = {index: value for index, it in found if (value := it.values.get(change.name)) is not None}
        if mean is None or not values:
            return None
        wanted = 1.0 if set(values.values()) <= {0.0, 1.0} else mean
        index = min(values, key=lambda index: abs(values[index] - wanted))
        return self._link(side, index, self._told(change, values[index], self.show.sides[side].episodes[index]))

    @property
    def kinds(self) -> list[tuple[str, Link]]:
        """How often pairs end so, and a link to the typical one, of each way to end; the most frequent one first."""
        pairs = self.show.pairs
        if pairs is None:
            return []
        return [
            (pairs.share(kind), self._pair(index))
            for kind in pairs.counts
            if (index := self.show.kinds.get(kind)) is not None
        ]

    @property
    def still(self) -> "Still":
        """What stands beside the answer: the pair that is shown first, and what it is typical of."""
        index, told, pairs, sides = self.show.first, self.kinds, self.show.pairs, self.show.sides
        names = [side.title.partition(": ")[2] or side.title for side in sides]
        others = [link for _, link in told[1:2]]
        return Still(
            self.place - 1,
            tuple(f"{name}: {side.episodes[index].outcome}" for name, side in zip(names, sides, strict=True)),
            told[0][0] if told else "",
            self._pair(index),
            pairs.otherwise if pairs is not None and others else "",
            others[0] if others else None,
            draw_sticks(sides, index),
        )

    def _told(self, change: Change, value: float, episode: Episode) -> str:
        name = change.name.replace("_", " ")
        if change.name == SUCCESS:
            return episode.outcome
        return f"{name} {text_of(change.measure)(value)}, {episode.outcome}"

    def _pair(self, index: int) -> Link:
        """A link to a pair, and how it ended under both rewards. It is said once if it is the same."""
        return self._link(
            BASELINE, index, " | ".join(dict.fromkeys(it.episodes[index].outcome for it in self.show.sides))
        )

    def _link(self, side: int, index: int, told: str) -> Link:
        number, seed = self.show.numbers[index], self.show.sides[side].seeds[index]
        return Link(f"#replay-{self.place}-{number}-{seed}", f"Watch episode {number} of seed {seed}: {told}")


def links_of(shows: Sequence[Show], combinations: Sequence[Comparison]) -> list[EpisodeLinks | None]:
    """The links of each comparison; None if it has no episodes to show."""
    found = {id(show.comparison): EpisodeLinks(place, show) for place, show in enumerate(shows, start=1)}
    return [found.get(id(comparison)) for comparison in combinations]


HERE = Path(__file__).parent
TEMPLATE = HERE / "replay.html.j2"
FULL = 32_767
"""Values are scaled to whole numbers up to this, by their column's largest. A unit is 1e-4 rad for a joint."""

EXPLANATION = (
    "Episodes of the final evaluations, drawn from the recorded joint positions: both policies began in the same pose "
    "with the same target (green). First comes a pair that ends as most pairs do. Line: the way of the end effector. "
    "Drag to turn the view."
)


class Replay(NamedTuple):
    """The parts of the replay in a page: `html` in the body, `style` in <style>, `script` in <script> after `html`."""

    html: str
    style: str
    script: str


def replay_of(shows: Sequence[Show], explanation: str = EXPLANATION) -> Replay | None:
    """The replay of some shows, with what a reader has to know of them; None if there are no shows.

    Raises:
        UsageError: A library of the extra ``report`` is missing.
    """
    if not shows:
        return None
    from harness.report.page.page import render_page

    sides = max(len(show.sides) for show in shows)
    html = render_page(TEMPLATE, "The replay", data=replay_data(shows), sides=sides, explanation=explanation)
    return Replay(html, _text("replay.css"), _text("replay.js"))


def replay_data(shows: Sequence[Show]) -> dict[str, Any]:
    """What the script reads: every scene once, and the shows."""
    scenes: list[dict[str, Any]] = []
    colours = [light_colours()[name] for name in SIDES]
    return {"shows": [_show(show, scenes) for show in shows], "scenes": scenes, "colours": colours}


def _show(show: Show, scenes: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "title": show.title,
        "numbers": show.numbers,
        "first": show.first,
        **({"told": show.told} if show.told else {}),
        **({} if show.pairs is None else {"pairs": _pairs(show.pairs, show.kinds)}),
        "sides": [_side(side, scenes) for side in show.sides],
    }


def _pairs(pairs: Pairs, typical: Mapping[int, int]) -> dict[str, Any]:
    """How often pairs end so, the most frequent way first, and how each ended, a digit for each by seed and number."""
    seeds = {it.seed: "" for it in pairs.met}
    for it in pairs.met:
        seeds[it.seed] += str(it.kind)
    kinds = [
        {"kind": kind, "told": pairs.kinds[kind], "share": pairs.share(kind), "typical": typical.get(kind)}
        for kind in pairs.counts
    ]
    return {"kinds": kinds, "seeds": [[seed, ended] for seed, ended in seeds.items()]}


def _side(side: Side, scenes: list[dict[str, Any]]) -> dict[str, Any]:
    scene = side.scene.to_json()
    if scene not in scenes:
        scenes.append(scene)
    return {
        "title": side.title,
        "scene": scenes.index(scene),
        "seeds": side.seeds,
        "period": side.period,
        "error": side.error,
        "unit": side.unit,
        "episodes": [_episode(episode) for episode in side.episodes],
    }


def _episode(episode: Episode) -> dict[str, Any]:
    values = np.column_stack([episode.qpos, episode.distance, episode.paid])
    scales = _short(np.maximum(np.abs(values).max(axis=0), 1e-9) / FULL)
    return {
        "outcome": episode.outcome,
        "last": int(episode.steps[-1]),
        "scales": scales.tolist(),
        "values": base64.b64encode(np.rint(values / scales).astype("<i2").tobytes()).decode(),
        "targets": _changes(episode.target),
        **({"obstacles": np.round(episode.obstacles, 5).tolist()} if len(episode.obstacles) else {}),
    }


def _short(scales: Float) -> Float:
    """The next larger numbers of four digits: a page with many episodes stays small, and no value exceeds `FULL`."""
    digits = 10.0 ** (np.floor(np.log10(scales)) - 3)
    return np.array([float(f"{scale:.3e}") for scale in np.ceil(scales / digits) * digits])


def _changes(target: Float) -> list[list[float]]:
    """The frame from which each target counts, and the target, [m]."""
    new = [0, *(np.flatnonzero((np.diff(target, axis=0) != 0).any(axis=1)) + 1)]
    return [[int(frame), *(round(float(value), 5) for value in target[frame])] for frame in new]


@cache
def _text(name: str) -> str:
    return (HERE / name).read_text(encoding="utf-8")
