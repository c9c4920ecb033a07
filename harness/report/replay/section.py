"""The replay as a part of a page: HTML with its data, one style sheet and one script, and no request.

The script is our own: some 300 lines of WebGL 2 and canvas draw an arm. A library such as three.js would bring 0.7 MB.
"""

import base64
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from harness.arrays import Float
from harness.report.figures.palette import SIDES, light_colours
from harness.results.pairs import Pairs
from harness.results.replay import Episode, Show, Side

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
    explanation: str = EXPLANATION


def replay_of(shows: Sequence[Show], explanation: str = EXPLANATION) -> Replay | None:
    """The replay of some shows, with what a reader has to know of them; None if there are no shows.

    Raises:
        UsageError: A library of the extra ``report`` is missing.
    """
    if not shows:
        return None
    from harness.report.page.page import render_page

    sides = max(len(show.sides) for show in shows)
    html = render_page(TEMPLATE, "The replay", data=replay_data(shows), sides=sides)
    return Replay(html, _text("replay.css"), _text("replay.js"), explanation)


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
