"""What a search found as one HTML file: behaviours beside one another, as films, as curves of pay, as numbers."""

import base64
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from harness import Float
from harness.log.log import episode_sum, sums_so_far
from harness.record.scene import Scene
from harness.registry.given import plugin_flags
from harness.report import Dots, Grid, Line, draw_chart, replay_of
from harness.report.figures.accumulated import select_points
from harness.report.page.page import render_page
from harness.results.replay import Episode, Show, Side
from harness.text import number, visible

from ..chart import chart_of
from .behaviour import Role
from .certificate import Certificate, file_names, rating_text
from .finding import CANNOT_TELL, FAILING, LOITERING, NAMES
from .world import Data

TEMPLATE = Path(__file__).parent / "cheats.html.j2"
BADGES: Mapping[str, str] = {FAILING: "hurts", LOITERING: "hurts", CANNOT_TELL: "cannot-tell"}
"""The colour of each answer; nothing found is none."""
COLOURS: Mapping[Role, str] = {"fastest": "baseline", "failure": "proposed", "success": "pair-5"}
"""Those that the replay of an arm has too."""
DASHES: Mapping[Role, str] = {"fastest": "6 3", "failure": "", "success": "2 3"}
MEASURES = 3
"""So many measures are drawn."""
FRAMES = 150
"""The most frames of an arm's replay."""
EXPLANATION = (
    "All began in the same pose with the same target (green). Line: the way of the end effector. Drag to turn the view."
)
NONE: Float = np.zeros(0)
Shown: TypeAlias = Mapping[str, Certificate]
"""The behaviours of one reward, by what they are called."""


def cheats_page(
    certificates: Sequence[Certificate],
    scene: Scene | None = None,
    remarks: Sequence[str] = (),
    files: bool = True,
) -> str:
    """The page, as HTML.

    Args:
        certificates: Of one world, of any number of rewards.
        scene: What the arm looks like; None of an environment.
        remarks: Sentences that stand below the title, such as why a behaviour was not certified.
        files: Whether the certificates lie beside the page.

    Raises:
        UsageError: A library of the extra ``report`` is missing.
    """
    keys = [(it.place.reward.label, it.role) for it in certificates]
    found = dict(zip(keys, certificates, strict=True))
    names = dict(zip(keys, file_names(certificates), strict=True)) if files else {}
    groups = [
        {role: found[label, role] for role in NAMES if (label, role) in found}
        for label in sorted({label for label, _ in keys})
    ]
    shows = [] if scene is None else [show for group in groups if (show := _show(group, scene)) is not None]
    titles = dict.fromkeys(visible(it.place.name) for it in certificates)
    return render_page(
        TEMPLATE,
        "The page",
        title=f"What a cheat would do: {', '.join(titles)}",
        remarks=list(remarks),
        groups=[_group(place, group, names) for place, group in enumerate(groups)],
        replay=replay_of(shows, EXPLANATION),
    )


def _group(row: int, group: Mapping[Role, Certificate], names: Mapping[tuple[str, Role], str]) -> Data:
    """What is said of one reward; `names` are those of files, if there are some."""
    first = next(iter(group.values()))
    reward = first.place.reward.label
    answer, found, place, shown = first.answer, first.found, first.place, _distinct(group)
    told = f"success: {place.success}" if place.success else "nothing measures success"
    terms = dict.fromkeys(name for it in shown.values() for name in it.shown.terms)
    paid: list[tuple[str, ...]] = [
        (name, *(number(episode_sum(it.shown.terms.get(name, NONE))) for it in shown.values())) for name in terms
    ]
    return {
        "name": reward,
        "anchor": f"reward-{row}",
        "badge": BADGES.get(answer["word"], "no-difference"),
        "word": ", ".join(filter(None, (answer["word"], answer["strength"]))),
        "lead": answer["lines"][0] if answer["lines"] else "",
        "lines": answer["lines"][1:],
        "setting": f"{told}; of {answer['starts']} starts, start {first.shown.start} is shown; gamma {place.gamma:g}; "
        f"a search of {found['steps']:,} steps with seed {found['seed']}: {', '.join(found['how'])}",
        "table": _table(shown),
        "terms": Grid(("term", *shown), paid if len(terms) > 1 else [], [], "What each term paid"),
        "figures": [*_figures(shown)],
        "films": _films(shown),
        "plugins": plugin_flags(list(place.plugins)),
        "files": [(names[reward, role], NAMES[role]) for role in group if names],
    }


def _distinct(group: Mapping[Role, Certificate]) -> dict[str, Certificate]:
    """The behaviours by what they are called; the best-paid success is often the fastest one too."""
    success, fastest = group.get("success"), group.get("fastest")
    if success and fastest and np.array_equal(success.shown.actions, fastest.shown.actions):
        both = {"fastest and best-paid success": fastest}
        return {**both, **{NAMES[role]: it for role, it in group.items() if role == "failure"}}
    is_told = bool(next(iter(group.values())).place.success)
    return {NAMES[role] if is_told or role != "failure" else "paid most": it for role, it in group.items()}


def _table(shown: Shown) -> Grid:
    """The behaviours in numbers, a column each; no row in which nothing is told."""
    first = next(iter(shown.values()))
    measures = dict.fromkeys(name for it in shown.values() for name in it.shown.measures)
    elsewhere = dict.fromkeys(name for it in shown.values() for name in it.elsewhere)
    rows: dict[str, Callable[[Certificate], str]] = {
        "paid": lambda it: number(it.paid),
        f"paid, discounted by {first.place.gamma:g}": lambda it: number(it.discounted),
        "steps": lambda it: f"{len(it.shown.paid):,}",
        "outcome": lambda it: it.outcome,
        "steps in success": lambda it: f"{it.shown.success.mean():.0%}",
        **{f"{name}, last": partial(_last, name=name) for name in measures},
        **{f"paid in {name}": partial(_elsewhere, name=name) for name in elsewhere},
        "its policy, where chance decides": lambda it: rating_text(it.rating) if it.rating else "",
        "found by": lambda it: it.found["made_by"],
    }
    told = [(name, *map(tell, shown.values())) for name, tell in rows.items()]
    return Grid(("", *shown), [row for row in told if any(row[1:])], [])


def _elsewhere(it: Certificate, name: str) -> str:
    return number(it.elsewhere.get(name, np.nan))


def _last(it: Certificate, name: str) -> str:
    values = it.shown.measures.get(name)
    return "n/a" if values is None or np.isnan(values[-1]) else number(float(values[-1]))


def _figures(shown: Shown) -> Iterator[tuple[str, str]]:
    """What each chart shows, and its SVG: pay over time, some measures over time, and pay under noise.

    A chart has a line of each behaviour, and a dot at its end or at each of its points.
    """
    names = dict.fromkeys(name for it in shown.values() for name in it.shown.measures)
    measured = {name: {title: it.shown.measures.get(name, NONE) for title, it in shown.items()} for name in names}
    told = {name: np.concatenate([*values.values()]) for name, values in measured.items()}
    count = {name: len(np.unique(values[np.isfinite(values)])) for name, values in told.items()}
    drawn = [name for name in names if count[name] > 2] or [name for name in names if count[name] == 2]  # or flags
    paid = {title: sums_so_far(it.shown.paid) for title, it in shown.items()}
    charts = list[tuple[Any, ...]]()
    for title, curves in (("Paid so far", paid), *((name, measured[name]) for name in drawn[:MEASURES])):
        points = {name: select_points(np.nan_to_num(values)) for name, values in curves.items()}
        lines = [
            (name, (at + int(curves is not paid)).tolist(), curves[name][at].tolist()) for name, at in points.items()
        ]
        charts.append((title, f"{title} at each step", "step", visible(title), lines, slice(-1, None)))
    if any(it.noise for it in shown.values()):
        across = "noise of actions, as a share of half their range"
        lines = [
            (name, [row["noise"] for row in it.noise], [row["paid"] for row in it.noise]) for name, it in shown.items()
        ]
        charts.append(
            ("Paid while actions are disturbed", "Pay over the noise of actions", across, "paid", lines, slice(None))
        )
    for heading, said, across, upwards, lines, dotted in charts:
        marks: list[Line | Dots] = []
        for name, x, y in lines:
            role = shown[name].role
            if x:
                marks.append(Line(x, y, COLOURS[role], name, dash=DASHES[role], in_legend=True))
            if x and np.isfinite(y[-1]):
                marks.append(Dots(x[dotted], y[dotted], COLOURS[role], (name,) * len(x[dotted])))
        yield heading, draw_chart(chart_of(marks, across, upwards), said)


def _films(shown: Shown) -> dict[str, Any] | None:
    """The films of one reward, on one clock; None if there are none."""
    found = [(title, it.role, it.film) for title, it in shown.items() if it.film is not None]
    if not found:
        return None
    reasons = dict.fromkeys(film.reason for *_, film in found if film.reason)
    drawn = [it for it in found if it[-1].strip]
    return {
        "reasons": list(reasons),
        "last": max((film.steps[-1] for *_, film in drawn), default=0),
        "sides": [
            {
                "title": title,
                "colour": COLOURS[role],
                "steps": ",".join(map(str, film.steps)),
                "count": len(film.steps),
                "size": film.size,
                "picture": f"data:image/webp;base64,{base64.b64encode(film.strip).decode()}",
            }
            for title, role, film in drawn
        ],
    }


def _show(group: Mapping[Role, Certificate], scene: Scene) -> Show | None:
    """The behaviours of an arm as a replay shows them."""
    sizes = {"qpos": len(scene.joints), "target": 3}
    shown = {
        title: it
        for title, it in _distinct(group).items()
        if it.shown.drawn and all(it.shown.drawn[name].shape[1] == size for name, size in sizes.items())
    }
    if not shown:
        return None
    sides = list[Side]()
    for title, it in shown.items():
        of, drawn, count = it.shown, it.shown.drawn, len(it.shown.paid)
        steps = np.unique(np.linspace(0, count, min(FRAMES, count + 1)).round().astype(np.int64))
        episode = Episode(
            steps,
            drawn["qpos"][steps],
            drawn["target"][steps],
            drawn["distance"][steps, 0],
            sums_so_far(of.paid)[steps],
            "reached" if of.success[-1] else "ground" if _last(it, "ground") == "1" else "time-out",
            {},
        )
        sides.append(Side(title, (of.start,), scene, (episode,), float(drawn["time"][1, 0])))
    first = next(iter(shown.values()))
    told = f"{first.place.reward.label}, start {first.shown.start}"
    return Show(first.place.reward.label, (1,), tuple(sides), told=told)
