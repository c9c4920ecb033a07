"""What a parity says by class of motions, as text that the terminal and the page share."""

from collections.abc import Iterator
from math import degrees

from harness.env.solid_probes import missing_in_words
from harness.eta.index import NOTHING
from harness.report.rows.ratios import Grid
from harness.text import number

from .classes import CONTACT, CREEP, FAST, NEAR, SINGULAR, SLOW, SMOOTH, Told
from .difference import SHORT, Difference, Response
from .motions import ACCELERATION, SPEED
from .parity import Measured, Pair, Parity

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
RESPONSE_NOTE = (
    "Driven tip: largest distance from where it was told to be. Speeds: the largest of a joint, as shares of its "
    f"maximum. Falls short: share of the control periods of all joints in which one is slower than told by over "
    f"{SHORT:.0%} of its largest speed, as where a drive is at its limit. Late: the delay that fits its joints best."
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
    gone = [f"{name}: {NOTHING}, such motions meet the ground" for name in (SINGULAR,) if name not in parity.told]
    return f"{'; '.join([*told, *gone])}."


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
            if difference.max_tip_m >= SMALL and not (lacking and name == CONTACT):
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


def _reached(name: str, told: Told) -> str:
    return f" (smallest singular value {number(told.singular_value)} of the reach)" if name == SINGULAR else ""


def _name(parity: Parity, pair: Pair) -> str:
    return pair.b if pair.a == parity.reference else f"{pair.b} against {pair.a}"


def _values(difference: Difference) -> tuple[str, ...]:
    return (
        number(1e3 * difference.max_tip_m),
        number(1e3 * difference.mean_tip_m),
        number(degrees(difference.max_joint_rad)),
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
