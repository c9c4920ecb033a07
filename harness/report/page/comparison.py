"""One comparison as the page tells it: the answer, the behaviour, the number, what the rewards pay for."""

import base64
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from harness.eta.headline import SUCCESS, Text, format_number, percentage
from harness.record.cell import Cell
from harness.report.facts import Compared, Report
from harness.report.figures.accumulated import draw_both, panels_of
from harness.report.figures.chart import Chart
from harness.report.figures.draw import draw_chart
from harness.report.figures.learning import (
    VIEWS,
    describe_learning,
    describe_profile,
    describe_trajectories,
    draw_learning,
    draw_profile,
    draw_trajectories,
    learning_heading,
    learning_names,
)
from harness.report.figures.split import describe_split, describe_sum, draw_split, draw_strip, draw_sum
from harness.report.page.answer import Card, card_of
from harness.report.replay.section import BASELINE, PROPOSED, EpisodeLinks, Link, Still
from harness.report.rows.comparison import (
    BETWEEN,
    rewards_text,
    shown_changes,
    text_of,
)
from harness.report.rows.ratios import step_text
from harness.report.rows.returns import Audits, Story, payoff_story
from harness.results import Results
from harness.results.comparison import Comparison
from harness.results.learning import Learning
from harness.results.pairs import shown_pair
from harness.results.replay import trajectories_of
from harness.results.trainings import Alone

TIMEOUTS, OBSTACLES = "timeouts", "obstacle_hits"
LEAST = 0.08
"""A share below this is too narrow for its number."""


class Part(NamedTuple):
    """A part of a bar: one way in which episodes ended."""

    kind: str
    """``reached``, ``ground``, ``obstacle`` or ``time-out``."""
    share: float
    """Share of the episodes, in [0, 1]."""
    text: str
    """The text that is written into the bar; empty if there is no room."""


class Bar(NamedTuple):
    """One reward's episodes."""

    who: str
    reward: str
    parts: tuple[Part, ...]
    told: str
    """The same in words."""


def outcome_bars(comparison: Comparison) -> list[Bar]:
    """Bars for the baseline, the proposed reward and random actions; empty if the outcomes were not measured."""
    changes = {change.name: change for change in comparison.measured.changes_of(comparison.manner)}
    success, timeouts = changes.get(SUCCESS), changes.get(TIMEOUTS)
    if success is None or timeouts is None:
        return []
    measures = (success, timeouts, changes.get(OBSTACLES))
    sides = (
        ("Baseline", comparison.names.baseline),
        ("Proposed", comparison.names.proposed),
        ("Random", "random actions"),
    )
    shares: dict[str, list[Any]] = {who: [getattr(it, who.lower(), None) for it in measures] for who, _ in sides}
    return [_bar(who, reward, *shares[who]) for who, reward in sides if None not in shares[who][:2]]


def _bar(who: str, reward: str, reached: float, over: float, hit: float | None) -> Bar:
    """A bar. Episodes with no target reached, no obstacle touched and time left ended on the ground."""
    shares = {"reached": reached, "ground": max(0.0, 1.0 - reached - over - (hit or 0.0)), "time-out": over}
    if hit:
        shares["obstacle"] = hit
    told = ", ".join(f"{kind} {share:.1%}" for kind, share in shares.items())
    parts = (Part(kind, share, f"{share:.0%}" if share >= LEAST else "") for kind, share in shares.items())
    return Bar(who, reward, tuple(part for part in parts if part.share > 0.0), told)


class Side(NamedTuple):
    """The episode under one reward."""

    title: str
    source: str
    """The pictures side by side, as the address of an image; empty if there are none."""
    told: str
    """What the episode came to, or why there is no picture."""
    alternative: str
    """The same for those who cannot see the pictures."""
    ended: str = ""
    """The reward, and how the episode ended."""
    pictures: int = 0
    """How many pictures there are."""


class Strips(NamedTuple):
    """Both sides."""

    title: str
    sides: tuple[Side, ...]
    shares: tuple[str, ...] = ()
    """How often pairs end so, and otherwise, the most frequent way first; empty where nothing tells."""


def frames_of(results: Results, comparison: Comparison) -> Strips | None:
    """The pictures of a comparison's typical pair; None for the null control, and where an arm has a replay."""
    if not comparison.seeds or comparison.is_control or not results.in_environment:
        return None
    shown = shown_pair(results, comparison)
    if shown is None:
        return None
    cells, number, pairs = shown
    sides = [_side(results, cell, number, who) for cell, who in zip(cells, ("Baseline", "Proposed"), strict=True)]
    title = f"Episode {number + 1} of the evaluation of seed {cells[0].seed}, in pictures"
    shares = () if pairs is None else tuple(map(pairs.share, pairs.counts))
    found = tuple(side for side in sides if side is not None)
    return Strips(title, found, shares) if found else None


def _side(results: Results, cell: Cell, number: int, who: str) -> Side | None:
    found, reward = results.frames(cell, number), cell.reward.label
    title = f"{who}: {reward}"
    if found is None:
        return None
    if found.reason:
        return Side(title, "", f"No pictures: {found.reason}.", "")
    source = f"data:image/webp;base64,{base64.b64encode(found.strip).decode()}"
    told = f"{found.outcome}; {found.told}; {found.steps[-1]:,} steps"
    steps = ", ".join(f"{step:,}" for step in found.steps)
    seen, ended = f"{told}. Pictures after {steps} steps.", f"{reward}: {found.outcome}"
    return Side(title, source, seen, f"{title}: {told}", ended, len(found.steps))


SIDES = {"Baseline": BASELINE, "Proposed": PROPOSED}
"""Sides of the replay, by the names of the bars. The replay does not show random actions."""


class Panel(NamedTuple):
    """A figure with its heading and, for those who cannot see it, what it shows."""

    heading: str
    figure: str
    """HTML."""
    caption: str


@dataclass(frozen=True, eq=False)
class Section:
    """What the template shows of one comparison; what is not known is empty, and left out."""

    card: Card
    """It has the title."""
    told: Compared
    place: int = 1
    """Its number on the page."""
    still: Still | None = None
    strips: Sequence[str] = ()
    meanings: Sequence[str] = ()
    """What each measure of behaviour is, in half a sentence; empty where its plugin does not say."""
    showing: Sequence[Mapping[str, Link | None]] = ()
    outcomes: Sequence[Bar] = ()
    endings: Sequence[Sequence[Link | None]] = ()
    episodes: Sequence[tuple[str, Link]] = ()
    frames: Strips | None = None
    learning: Sequence[Panel] = ()
    splits: Sequence[Panel] = ()
    indices: Sequence[Panel] = ()
    curves: Sequence[Panel] = ()
    payoffs: Story | None = None
    profiles: Sequence[Panel] = ()
    number: bool = False
    """Whether there is something to say of it."""
    trajectories: Sequence[Panel] = ()


def comparison_section(
    report: Report, place: int, where: str, points: int, audits: Audits, links: EpisodeLinks | None
) -> Section:
    """What the template shows of a comparison.

    Args:
        report: What is said of all of them.
        place: The number of the comparison, counted from 1.
        where: Where it was trained, as far as the page does not say that for all.
        points: How many points of each run are drawn.
        audits: What the rewards pay for.
        links: To its episodes.
    """
    results, told = report.results, report.compared[place - 1]
    comparison = results.combinations[place - 1]
    bars = outcome_bars(comparison)
    changes = shown_changes(comparison, comparison.manner)
    rewards = rewards_text(comparison) if comparison.is_control else comparison.proposed
    splits, indices, curves = _split_panels(comparison), _index_panels(comparison), _curve_panels(comparison, points)
    payoffs = payoff_story(comparison, audits)
    return Section(
        card=card_of(comparison, BETWEEN.join(filter(None, (where, rewards)))),
        told=told,
        place=place,
        still=links.still if links else None,
        strips=[draw_strip(change) for change in changes],
        meanings=[_meaning(results, change.name) for change in changes],
        outcomes=bars,
        episodes=links.kinds if links else [],
        endings=_endings(links, bars),
        frames=frames_of(results, comparison),
        showing=[
            {"baseline": links.showing(BASELINE, it), "proposed": links.showing(PROPOSED, it)} if links else {}
            for it in changes
        ],
        learning=_learned(results, comparison),
        splits=splits,
        indices=indices,
        curves=curves,
        payoffs=payoffs,
        profiles=_profile_panels(comparison),
        number=bool(comparison.seeds and (splits or indices or curves or payoffs or told.numbers or told.pay)),
        trajectories=_trajectory_panels(results, comparison),
    )


def _meaning(results: Results, name: str) -> str:
    """What a measure is, as its plugin tells in ``harness describe metrics``; empty where nobody registered it."""
    metric = name.partition(":")[0]
    return results.registry.get("metrics", metric).summary if metric in results.registry.names("metrics") else ""


def alone_panels(alone: Alone) -> list[Panel]:
    """How a reward taught that nothing is compared with."""
    texts = {it.measure.name: text_of(it.measure) for it in (alone.paid, *alone.behaviour)}
    return _learning_panels(alone.learning, alone.shown, texts)


def _endings(links: EpisodeLinks | None, bars: list[Bar]) -> list[list[Link | None]]:
    """For each part of each bar, a link to an episode that ended so."""
    return [
        [links.ending(SIDES[bar.who], part.kind) if links and bar.who in SIDES else None for part in bar.parts]
        for bar in bars
    ]


def _panel(heading: str, chart: Chart, caption: str, what: str) -> Panel:
    return Panel(heading, draw_chart(chart, f"{what} {heading}. {caption}"), caption)


def _learning_panels(learning: Learning, names: Iterable[str], texts: Mapping[str, Text]) -> list[Panel]:
    """Measures, and what was paid, over the training."""
    panels = []
    for name in names:
        drawn = learning, name, texts.get(name, format_number)
        caption = describe_learning(*drawn)
        panels.append(_panel(learning_heading(name), draw_learning(*drawn), caption, "Over environment steps."))
    return panels


def _learned(results: Results, comparison: Comparison) -> list[Panel]:
    """The measure that decides, then every other that is known, and every reward."""
    learning = results.learning(comparison)
    texts = {change.name: text_of(change.measure) for change in comparison.measured.changes_of(comparison.manner)}
    return [] if learning is None else _learning_panels(learning, learning_names(learning, comparison), texts)


def _trajectory_panels(results: Results, comparison: Comparison) -> list[Panel]:
    """Where the end effector went, under each reward."""
    trajectories = trajectories_of(results, comparison)
    if trajectories is None:
        return []
    sides = (
        (f"Baseline: {comparison.baseline}", trajectories.baseline),
        (f"Proposed: {comparison.proposed}", trajectories.proposed),
    )
    drawn = draw_trajectories(trajectories)
    what = "Paths of the end effector."
    return [
        _panel(f"{heading}, {view}", chart, describe_trajectories(trajectories.seed, paths), what)
        for (heading, paths), charts in zip(sides, drawn, strict=True)
        for (*_, view), chart in zip(VIEWS, charts, strict=True)
    ]


def _profile_panels(comparison: Comparison) -> list[Panel]:
    """Which share of the seeds reaches how much success."""
    success = comparison.decisive
    if success is None or not success.seeds or text_of(success.measure) is not percentage:
        return []
    return [
        _panel(
            "Success over seeds", draw_profile(success), describe_profile(success), "Share of the seeds over success."
        )
    ]


def _split_panels(comparison: Comparison) -> list[Panel]:
    """The pay of an episode with its parts, as a ratio or else as a difference."""
    pay, what = comparison.number.pay, f"Pay of an episode, {comparison.manner}"
    if pay is None:
        return []
    chart = draw_split("pay", pay.ratio)
    if chart is not None:
        return [_panel(f"{what}: ruler x behaviour", chart, describe_split("pay", pay.ratio), LOGARITHMIC)]
    chart = draw_sum(pay.total)
    if chart is None:
        return []
    return [_panel(f"{what}: ruler + behaviour", chart, describe_sum(pay.total), "Differences.")]


def _index_panels(comparison: Comparison) -> list[Panel]:
    """The note's indices with their parts, of an arm."""
    number = comparison.number
    indices = number.index_splits if number.number_of == "indices" and number.is_split else {}
    drawn = [(name, split, draw_split(name, split)) for name, split in indices.items()]
    return [
        _panel(f"{name} = ruler x behaviour", chart, describe_split(name, split), LOGARITHMIC)
        for name, split, chart in drawn
        if chart is not None
    ]


LOGARITHMIC = "Ratios on a logarithmic axis."


def _curve_panels(comparison: Comparison, points: int) -> list[Panel]:
    """The accumulated reward of both trainings, each under its own reward."""
    panels = panels_of(comparison, points)
    if panels is None:
        return []
    what = "Accumulated reward over environment steps."
    told = "First negative step: {}. Cross-over step: {}."
    return [
        _panel(
            f"{it.role}: {it.reward}",
            chart,
            told.format(step_text(it.index.first_negative), step_text(it.index.crossover)),
            what,
        )
        for it, chart in zip(panels, draw_both(panels), strict=True)
    ]
