"""Comparisons at a glance, as text: a line for each, and what is the same in all."""

from collections.abc import Sequence
from html import escape

from harness.eta.behaviour_change import Change
from harness.eta.headline import count_seeds
from harness.eta.index import Ratio
from harness.results.comparison import Comparison
from harness.text import visible

NOTHING = "n/a"
NEAR_ZERO = "near zero"
HEADINGS = ("", "the robot", "success", "eta_N", "eta_P", "ruler")
"""The headings of `overview_row`."""
READING = (
    "success: baseline > proposed. eta: the proposed reward's number divided by the baseline's, with its 95% interval "
    "if the window is wide enough. eta_N below 1 and eta_P above 1 count as better. ruler: the part of eta_P that "
    "comes from counting the same runs differently; no robot moved differently for it."
)


def shared_text(combinations: Sequence[Comparison], *, with_seeds: bool = True) -> str:
    """What is the same in all combinations, of which there must be at least one."""
    varying = varying_kinds(combinations)
    told = [label for kind, label in combinations[0].group.labels.items() if kind not in varying]
    rewards, baselines = ({getattr(it, name) for it in combinations} for name in ("proposed", "baseline"))
    if varying and len(rewards) == 1:
        told += rewards
    told += [f"against {baseline}" for baseline in baselines]
    if "steps" not in varying:
        told.append(f"{combinations[0].group.steps:,} steps")
    seeds = {it.seeds for it in combinations} if with_seeds else set()
    return " · ".join([*told, *(count_seeds(len(them)) for them in seeds)] if len(seeds) == 1 else told)


def line_names(combinations: Sequence[Comparison]) -> list[str]:
    """A name for each combination: what differs between the groups, and the reward if there are several."""
    varying, rewards = varying_kinds(combinations), {it.proposed for it in combinations}
    with_reward = not varying or len(rewards) > 1
    return [
        " · ".join([*([group_name(it, varying)] if varying else []), *([it.names.proposed] if with_reward else [])])
        for it in combinations
    ]


def varying_kinds(combinations: Sequence[Comparison]) -> list[str]:
    """Kinds of labels that differ between groups, and ``steps`` if the trainings are not equally long."""
    kinds = [kind for kind in combinations[0].group.labels if len({it.group.labels[kind] for it in combinations}) > 1]
    return [*kinds, *(["steps"] if len({it.group.steps for it in combinations}) > 1 else [])]


def group_name(combination: Comparison, varying: Sequence[str]) -> str:
    """The name of a combination's group: its labels of the kinds that differ."""
    told = {**combination.group.labels, "steps": f"{combination.group.steps:,} steps"}
    return " · ".join(told[kind] for kind in varying)


def overview_row(name: str, combination: Comparison, with_intervals: bool) -> tuple[str, ...]:
    """The values under `HEADINGS`."""
    splits = combination.splits
    etas = (splits["eta_N"].eta, splits["eta_P"].eta)
    return (
        name,
        combination.headline.answer.value.upper(),
        success_text(combination.decisive),
        *(short_value(eta) + (_interval(eta) if with_intervals else "") for eta in etas),
        short_value(splits["eta_P"].ruler),
    )


def success_text(change: Change | None) -> str:
    """Both rates as whole percentages."""
    if change is None or change.baseline is None or change.proposed is None:
        return NOTHING
    return f"{100 * change.baseline:.0f}>{100 * change.proposed:.0f}%"


def short_value(ratio: Ratio) -> str:
    """A ratio with three digits."""
    if ratio.near_zero is not None or ratio.value is None:
        return NEAR_ZERO if ratio.near_zero is not None else NOTHING
    return _digits(ratio.value, 3)


def _interval(ratio: Ratio) -> str:
    """The interval of a ratio, with two digits for each end; empty if there is none to show."""
    if ratio.near_zero is not None or ratio.low is None or ratio.high is None:
        return ""
    return f" [{_short(ratio.low)}, {_short(ratio.high)}]"


def _short(end: float) -> str:
    """Two digits, without the zero before a point."""
    text = _digits(end, 2)
    return text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) else text


def _digits(value: float, count: int) -> str:
    """A number with `count` significant digits, trailing zeros included. From a million on it has an exponent."""
    text = f"{value:#.{count}g}".rstrip(".")
    return f"{value:.0f}" if "e" in text and 1.0 <= abs(value) < 1e6 else text


def overview_html(combinations: Sequence[Comparison]) -> str:
    """A table with a row per comparison, for a notebook; empty without any."""
    if not combinations:
        return ""
    names = line_names(combinations)
    rows = [overview_row(name, it, with_intervals=True) for name, it in zip(names, combinations, strict=True)]
    lines = [_html_row("th", HEADINGS), *(_html_row("td", row) for row in rows)]
    shared = escape(visible(shared_text(combinations)))
    return f"<p><b>{shared}</b></p><table>{''.join(lines)}</table><p>{escape(READING)}</p>"


def _html_row(tag: str, texts: Sequence[str]) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(visible(text))}</{tag}>' for text in texts)}</tr>"
