"""What a parity says, as text: sentences and small tables that the terminal and the page share."""

import math
from collections.abc import Sequence

from harness.env.solid_probes import missing_in_words
from harness.eta.index import NOTHING
from harness.report.rows.ratios import Grid
from harness.text import number

from .contact import GRACE
from .motions import ACCELERATION, SPEED
from .parity import Measured, Pair, Parity
from .placement import POSES

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
    full = [grid for grid in grids if grid.rows]
    if full:
        full[-1].notes.append(PAIR_NOTE)
    return full


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
