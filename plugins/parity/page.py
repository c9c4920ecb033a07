"""A parity as a terminal shows it, and as one HTML file that opens anywhere, offline."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import degrees
from pathlib import Path
from typing import NamedTuple

from rich.console import Group, RenderableType
from rich.text import Text

from harness import Float
from harness.env.solid_probes import missing_in_words
from harness.eta.index import NOTHING
from harness.report import Axis, Chart, Grid, Line, draw_chart, linear_axis
from harness.report.figures.accumulated import select_points
from harness.report.page.page import render_page, write_page
from harness.report.tables.grid import show_grid
from harness.text import number

from .classes import CONTACT, CREEP, FAST, NEAR, SINGULAR, SLOW, SMOOTH, Told
from .difference import GRACE, SHORT, Difference, Response
from .motions import ACCELERATION, MARGIN, SPEED, Held
from .parity import Measured, Pair, Parity
from .track import POSES

MEASURES = ("tip max\n[mm]", "tip mean\n[mm]", "joint max\n[deg]", "contact\ndiffers", "contact\nlater [s]")
"""The measures of a pair."""
SIMULATOR_NOTE = (
    f"Placed: at {POSES} or more random poses, against the robot's own forward kinematics. Driven: against where the "
    "arm was told to be. Largest errors. Step: one control period of one arm, median, the simulators taking turns."
)
PAIR_NOTE = (
    f"Tip, joint: distance in smooth motion at up to {SPEED:.0%} of the speed and {ACCELERATION:.0%} of the "
    "acceleration. Contact: in dives to the ground, the share of the control periods in which only one of both sees "
    f"contact, until {GRACE} after the first contact, and how much later the second one sees it."
)
HEADINGS = ("tip max\n[mm]", "tip mean\n[mm]", "joint max\n[deg]", "turning\n[times]")
RESPONSES = ("driven tip\n[mm]", "speed\ntold", "speed\nreached", "falls\nshort", "late\n[ms]")
SMALL = 1e-4
"""A difference of the tips below this, [m], needs no explanation."""
MOSTLY = 0.5
"""A delay that explains this share of a difference is its explanation."""
BESIDE = 3.0
"""A simulator whose error is so many times the other's is the one that is off; so much more where joints turn is
told."""
NOTE = (
    "Turning: how many times larger the distance of the tips is where joints change their speed than elsewhere. "
    "Contact: from the first one on that either sees, to the end of the dive; no forces are compared."
)
NEAR_GROUND: dict[Held, str] = {
    "solids": f"solids that stand above it at home keep {100 * MARGIN:g} cm, or half of their height",
    "nothing": "parts of the arm may touch it, as no motion from this home pose is clear of it",
}
RESPONSE_NOTE = (
    "Driven tip: largest distance from where it was told to be. Speeds: the largest of a joint, as shares of its "
    f"maximum. Falls short: share of the control periods of all joints in which one is slower than told by over "
    f"{SHORT:.0%} of its largest speed, as where a drive is at its limit. Late: the delay that fits its joints best."
)


def title(parity: Parity) -> str:
    """What was compared."""
    names = [simulator.name for simulator in parity.simulators]
    return " · ".join([" / ".join(names) or "no simulator", parity.setting.robot.name])


def setting_text(parity: Parity) -> str:
    """How much of it."""
    setting = parity.setting
    parts = [f"{setting.episodes} smooth motions of {setting.steps:,} control periods of {setting.period:g} s"]
    if any(pair.contact for pair in parity.pairs):
        parts.append(f"{setting.episodes} dives to the ground")
    return ", ".join([*parts, f"seed {setting.seed}"])


def verdict(parity: Parity) -> str:
    """The largest distance of each tip to the reference's."""
    if len(parity.simulators) < 2:
        return "Nothing to compare: it takes two simulators"
    told = [f"{number(1e3 * pair.drift.max_tip_error_m)} mm ({pair.b})" for pair in reference_pairs(parity)]
    if not told:
        return f"The reference {parity.reference} failed; the others are compared with one another"
    return f"Largest distance of the tip from {parity.reference}'s: {', '.join(told)}"


def contact_text(parity: Parity) -> str:
    """In how many dives each touches the ground, and who lacks a solid; empty where all touch it in every dive."""
    dives = parity.setting.episodes
    counts: dict[int, list[str]] = {}
    for simulator in parity.simulators:
        if simulator.touched is not None:
            counts.setdefault(simulator.touched, []).append(simulator.name)
    lacking = [f"{one.name} has {missing_in_words(one.missing)}" for one in parity.simulators if one.missing]
    if not lacking and set(counts) <= {dives}:
        return ""
    told = [f"{count} of {dives} in {', '.join(names)}" for count, names in sorted(counts.items(), reverse=True)]
    parts = [f"Dives that touch the ground: {'; '.join(told)}"] * bool(told) + ["; ".join(lacking)] * bool(lacking)
    return f"{'. '.join(parts)}."


def engines_text(parity: Parity) -> str:
    """Which simulators are independent engines: those of one family are one."""
    families: dict[str | None, list[str]] = {}
    for simulator in parity.simulators:
        families.setdefault(simulator.family, []).append(simulator.name)
    without = families.pop(None, [])
    told = [f"{family} ({', '.join(names)}{': one vote' * (len(names) > 1)})" for family, names in families.items()]
    engines = f"Independent engines: {', '.join(told) or 'none'}."
    return f"{engines} No engine: {', '.join(without)}." if without else engines


def simulator_grid(parity: Parity) -> Grid:
    """Each simulator's own errors, and what it costs."""
    headings = (
        "simulator",
        *("placed tip\n[mm]", "placed joint\n[deg]", "driven tip\n[mm]", "driven joint\n[deg]", "step\n[ms]"),
    )
    rows = [_simulator_row(simulator) for simulator in parity.simulators]
    return Grid(headings, rows, [SIMULATOR_NOTE] if rows else [])


def pair_grids(parity: Parity) -> list[Grid]:
    """The others against the reference; then the others among themselves. Those without rows left out."""
    first = reference_pairs(parity)
    rest = [pair for pair in parity.pairs if pair not in first]
    grids = [
        _pair_grid(f"against {parity.reference}", [(pair.b, pair) for pair in first]),
        _pair_grid("the others", [(pair_name(pair), pair) for pair in rest]),
    ]
    *full, last = [grid for grid in grids if grid.rows] or [Grid((), [], [])]
    return [*full, replace(last, notes=[*last.notes, PAIR_NOTE])] if last.rows else []


def failures(parity: Parity) -> list[str]:
    """Who failed, and why."""
    return [f"failed: {name}: {failure.reason}" for name, failure in parity.failed.items()]


def not_installed(parity: Parity) -> list[str]:
    """Who is not there, and what to type."""
    return [f"not installed: {missing.name}: {missing.remedy}" for missing in parity.missing]


def reference_pairs(parity: Parity) -> list[Pair]:
    """Those that the reference is in."""
    return [pair for pair in parity.pairs if pair.a == parity.reference]


def pair_name(pair: Pair) -> str:
    """Both simulators; what a difference is measured from comes last."""
    return f"{pair.b} against {pair.a}"


def _simulator_row(simulator: Measured) -> tuple[str, ...]:
    return (
        simulator.name,
        number(1e3 * simulator.placement.error_m),
        number(math.degrees(simulator.placement.error_rad)),
        number(1e3 * simulator.tracking.max_tip_error_m),
        number(math.degrees(simulator.tracking.max_joint_error_rad)),
        number(1e3 * simulator.seconds_per_step),
    )


def _pair_grid(heading: str, named: Sequence[tuple[str, Pair]]) -> Grid:
    notes = [f"{name}: {pair.contact_note}." for name, pair in named if pair.contact_note]
    return Grid((heading, *MEASURES), [(name, *_pair_values(pair)) for name, pair in named], notes)


def _pair_values(pair: Pair) -> tuple[str, ...]:
    drift, contact = pair.drift, pair.contact
    delay = contact.mean_delay_s if contact else None
    return (
        number(1e3 * drift.max_tip_error_m),
        number(1e3 * drift.mean_tip_error_m),
        number(math.degrees(drift.max_joint_error_rad)),
        f"{contact.disagreement:.1%}" if contact else NOTHING,
        NOTHING if delay is None else f"{delay:+.3f}" if delay else "0",
    )


def classes_text(parity: Parity) -> str:
    """What each class of motions is, and how far it goes."""
    what = {
        SLOW: f"up to {CREEP.speed:.0%} of the speed and {CREEP.acceleration:.0%} of the acceleration",
        SMOOTH: f"up to {SPEED:.0%} and {ACCELERATION:.0%}",
        FAST: "every joint at its largest speed, turning at its largest acceleration",
        SINGULAR: f"within {degrees(NEAR):.0f} degrees of a pose where the tip can hardly move in some direction",
        CONTACT: "from the first contact on in dives to the ground",
    }
    told = [f"{name}: {what[name]}{_reached(name, it)}" for name, it in parity.told.items()]
    gone = [f"{name}: {NOTHING}, {reason}" for name, reason in parity.left_out.items()]
    return f"{'; '.join([*told, *gone])}.{_near_ground(parity)}"


def class_grid(parity: Parity, pairs: list[Pair]) -> Grid:
    """How far each two are apart in each class, and what explains it; without rows where there is no pair."""
    heading = f"against {parity.reference}" if all(pair.a == parity.reference for pair in pairs) else "by class"
    rows = [
        (f"{_name(parity, pair)}: {name}", *_values(difference))
        for pair in pairs
        for name, difference in pair.differences.items()
    ]
    return Grid((heading, *HEADINGS), rows, [*explanations(parity, pairs), NOTE] if rows else [])


def response_grid(parity: Parity) -> Grid:
    """How each simulator's joints follow in each class."""
    rows = [
        (f"{simulator.name}: {name}", *_response_values(response))
        for simulator in parity.simulators
        for name, response in simulator.responses.items()
    ]
    return Grid(("simulator", *RESPONSES), rows, [RESPONSE_NOTE] if rows else [])


def explanations(parity: Parity, pairs: list[Pair]) -> list[str]:
    """A line for each difference that is worth one."""
    by_name = {simulator.name: simulator for simulator in parity.simulators}
    found = []
    for pair in pairs:
        lacking = [one for one in (by_name[pair.a], by_name[pair.b]) if one.missing]
        found += [f"{_name(parity, pair)}: {one.name} has {missing_in_words(one.missing)}." for one in lacking]
        for name, difference in pair.differences.items():
            if difference.max_tip_error_m >= SMALL and not (lacking and name == CONTACT):
                told = "; ".join(_explain(name, difference, by_name[pair.a], by_name[pair.b]))
                found.append(f"{_name(parity, pair)}, {name}: {told}.")
    return found


def _explain(name: str, difference: Difference, first: Measured, second: Measured) -> Iterator[str]:
    """Who falls short or is late, who is off, and where."""
    one, other = first.responses[name], second.responses[name]
    if abs(one.falls_short - other.falls_short) >= 0.01:
        who, short = (first.name, one) if one.falls_short > other.falls_short else (second.name, other)
        yield (
            f"{who} is slower than told in {short.falls_short:.0%} of the joints' periods, and reaches "
            f"{short.speed_reached:.0%} of their speed where {short.speed_told:.0%} is told"
        )
    if difference.explained_by_lag >= MOSTLY:
        late, before = (second, first) if difference.lag_s > 0.0 else (first, second)
        yield (
            f"{late.name} is {number(1e3 * abs(difference.lag_s))} ms behind {before.name}, which explains "
            f"{difference.explained_by_lag:.0%}"
        )
    errors = sorted([(one.tracking_error_m, first.name), (other.tracking_error_m, second.name)])
    if name != CONTACT and errors[1][0] > BESIDE * errors[0][0]:
        near, far = (number(1e3 * error) for error, _ in errors)
        yield f"{errors[1][1]} is up to {far} mm from where it is told to be, {errors[0][1]} {near} mm"
    if difference.turning is not None and difference.turning >= BESIDE and name != CONTACT:
        yield f"{difference.turning:.0f} times as far apart where joints change their speed"
    worst = difference.worst
    when = "after the first contact" if name == CONTACT else "into a motion"
    yield f"largest {number(worst.time_s)} s {when}, where {worst.joint} is told {worst.speed_told:.0%} of its speed"


def _near_ground(parity: Parity) -> str:
    """Which motions do not keep their distance from the ground; empty where all do."""
    names: dict[Held, list[str]] = {}
    for name, held in parity.near_ground.items():
        names.setdefault(held, []).append(name)
    near = [f"{', '.join(names[held])}: {what}" for held, what in NEAR_GROUND.items() if held in names]
    return f" Near the ground: {'; '.join(near)}." if near else ""


def _reached(name: str, told: Told) -> str:
    return f" (smallest singular value {number(told.singular_value)} of the reach)" if name == SINGULAR else ""


def _name(parity: Parity, pair: Pair) -> str:
    return pair.b if pair.a == parity.reference else f"{pair.b} against {pair.a}"


def _values(difference: Difference) -> tuple[str, ...]:
    return (
        number(1e3 * difference.max_tip_error_m),
        number(1e3 * difference.mean_tip_error_m),
        number(degrees(difference.max_joint_error_rad)),
        NOTHING if difference.turning is None else number(difference.turning),
    )


def _response_values(response: Response) -> tuple[str, ...]:
    return (
        number(1e3 * response.tracking_error_m),
        f"{response.speed_told:.0%}",
        f"{response.speed_reached:.0%}",
        f"{response.falls_short:.1%}",
        number(1e3 * response.lag_s),
    )


COLOURS = 7
"""The colours of the page's style sheet, ``pair-0`` and so on: apart for every kind of colour vision."""
DASHES = ("", "8 4", "2 3", "8 3 2 3", "14 4")
"""Lines of pairs may cover one another: each has its own dashes as well. Their number and the colours' share no
factor, so that all 35 combinations come."""
DECADES = 9
"""The logarithmic axis spans so many, at most: what is smaller counts for none."""
TEMPLATE = Path(__file__).parent / "parity.html.j2"
TOLD = "how far two simulators are apart over time. The tables have the largest values."


class Curve(NamedTuple):
    """What is drawn of every pair."""

    name: str
    factor: float
    """From its unit in the record to the drawn one."""
    label: str
    unit: str


TIPS = Curve("max_tip_error_m", 1e3, "distance of the tips [mm]", "mm")
JOINTS = Curve("max_joint_error_rad", math.degrees(1.0), "difference of a joint [deg]", "deg")


def draw_pairs(parity: Parity, curve: Curve) -> Chart:
    """The largest difference over all motions at each time, from the reference; without any, of all pairs."""
    lines = [line for pair, line in _lines(parity, curve) if pair in (reference_pairs(parity) or parity.pairs)]
    high = max((max(line.y) for line in lines), default=0.0) or 1.0
    return Chart(_time(lines), linear_axis(0.0, 1.04 * high, curve.label), tuple(lines))


def draw_all_pairs(parity: Parity, curve: Curve) -> Chart | None:
    """All pairs on a logarithmic axis, on which a difference of 0 has no place; None where there is no other."""
    lines = [line for _, line in _lines(parity, curve)]
    high = max((max(line.y) for line in lines), default=0.0)
    if high <= 0.0:
        return None
    least = min(value for line in lines for value in line.y if value > 0.0)
    first = max(math.floor(math.log10(least)), math.ceil(math.log10(high)) - DECADES)
    decades = range(first, math.ceil(math.log10(high)) + 1)
    ticks = tuple((10.0**decade, f"1e{decade}") for decade in decades)
    floor = 10.0**first
    drawn = [line._replace(y=[value if value >= floor else math.nan for value in line.y]) for line in lines]
    axis = Axis(floor, max(10.0 * floor, 10.0 ** decades[-1]), curve.label, ticks, is_log=True)
    return Chart(_time(lines), axis, tuple(drawn))


def _time(lines: Sequence[Line]) -> Axis:
    return linear_axis(0.0, max((line.x[-1] for line in lines), default=1.0) or 1.0, "time [s]")


def _lines(parity: Parity, curve: Curve) -> list[tuple[Pair, Line]]:
    return [
        (pair, _line(number, pair, parity.setting.period, curve.factor * pair.drift.curves[curve.name]))
        for number, pair in enumerate(parity.pairs)
    ]


def _line(number: int, pair: Pair, period: float, values: Float) -> Line:
    points = select_points(values)
    colour, dash = f"pair-{number % COLOURS}", DASHES[number % len(DASHES)]
    return Line((points * period).tolist(), values[points].tolist(), colour, pair_name(pair), dash=dash, in_legend=True)


def write_parity(parity: Parity, path: Path) -> None:
    """Write figures and tables to `path`.

    Raises:
        UsageError: A library of the extra ``report`` is missing, or `path` cannot be written.
    """
    curves = [("Tips", TIPS), ("Joints", JOINTS)] if parity.pairs else []
    everything = [(heading, draw_all_pairs(parity, curve)) for heading, curve in curves]
    grids = [grid for grid in (*pair_grids(parity), simulator_grid(parity)) if grid.rows]
    first = reference_pairs(parity) or list(parity.pairs)
    rest = [pair for pair in parity.pairs if pair not in first]
    folded = [grid for grid in (class_grid(parity, rest), response_grid(parity)) if grid.rows]
    page = render_page(
        TEMPLATE,
        "--html",
        title=title(parity),
        setting=setting_text(parity),
        verdict=verdict(parity),
        contact=contact_text(parity),
        engines=engines_text(parity),
        panels=[(heading, draw_chart(draw_pairs(parity, curve), f"{heading}: {TOLD}")) for heading, curve in curves],
        all_panels=[(heading, draw_chart(chart, f"{heading}: {TOLD}")) for heading, chart in everything if chart],
        grids=grids,
        classes=classes_text(parity) if first else "",
        by_class=class_grid(parity, first),
        by_class_too=folded if first else [],
        failures=failures(parity),
        not_installed=not_installed(parity),
    )
    write_page(page, path, "The page")


def parity_table(parity: Parity) -> RenderableType:
    """What ``harness parity`` prints: the pairs first, the reference's before the others'."""
    contact = contact_text(parity)
    parts: list[RenderableType] = [
        Text(title(parity), style="bold"),
        Text(f"{setting_text(parity)}\n"),
        Text(verdict(parity), style="bold"),
        *([Text(contact, style="bold")] if contact else []),
        Text(engines_text(parity)),
    ]
    for grid in (*pair_grids(parity), simulator_grid(parity)):
        parts += show_grid(grid)
    if parity.pairs:
        parts += [Text(), Text("By class of motions", style="bold"), Text(classes_text(parity))]
        parts += show_grid(class_grid(parity, reference_pairs(parity) or list(parity.pairs)))
    told = [*failures(parity), *not_installed(parity)]
    return Group(*parts, *([Text()] if told else []), *map(Text, told))
