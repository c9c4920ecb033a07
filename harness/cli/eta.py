"""``harness eta``: two groups of recorded runs compared."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from harness.errors import UsageError

if TYPE_CHECKING:
    from rich.console import RenderableType

    from harness.eta.curve import GroupCurve
    from harness.eta.decompose import Who
    from harness.report.rows import Grid
    from harness.results.combination import Combination
    from harness.score.compare import Comparison

Globs = list[str]
UNKNOWN = "an unknown reward"
PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title><script>{plotly}</script></head>
<body style="font-family: {font}; max-width: 72rem; margin: 2rem auto; padding: 0 1rem">
<h1>{title}</h1><p>{verdict}</p><div id="figure"></div>
<script>Plotly.newPlot("figure", {data}, {layout}, {{"responsive": true}});</script></body></html>
"""


def eta(
    context: typer.Context,
    baseline: Annotated[Globs, typer.Option(help="Runs of the baseline, as 'base/*.csv'.", metavar="GLOB")],
    proposed: Annotated[Globs, typer.Option(help="Runs of the proposed reward; ** means any folders.", metavar="GLOB")],
    curve: Annotated[
        Literal["accumulated", "per-step"], typer.Option(help="As published, or NOTE eq. 39-42 read literally.")
    ] = "accumulated",
    with_events: Annotated[bool, typer.Option("--with-events", help="Add the event terms to the reward.")] = False,
    baseline_reward: Annotated[
        str | None, typer.Option(help="What paid the baseline's runs. (default: found out)", metavar="NAME")
    ] = None,
    proposed_reward: Annotated[
        str | None, typer.Option(help="What paid the proposed ones. (default: found out)", metavar="NAME")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON on standard output.")] = False,
    plot: Annotated[Path | None, typer.Option(help="Draw the curves into this .html file.", metavar="FILE")] = None,
) -> None:
    """Compare recorded runs, of anybody: CSV files with a column 'reward', and traces of this project.

    With distances in the files each eta is split into ruler and behaviour. Quote the patterns; a flag may be repeated.
    """
    if context.args:
        raise UsageError(f"'{context.args[0]}' belongs to no flag: quote the pattern, as in --baseline 'base/*.csv'")
    if plot is not None and plot.suffix.lower() != ".html":
        raise UsageError(f"--plot writes .html, not '{plot}'")
    from harness.registry.registry import load_registry
    from harness.score.compare import compare_recordings
    from harness.score.open_recording import match_recordings

    comparison = compare_recordings(
        match_recordings(baseline),
        match_recordings(proposed),
        load_registry(),
        kind=curve,
        with_events=with_events,
        baseline_reward=baseline_reward,
        proposed_reward=proposed_reward,
    )
    if plot is not None:
        _write_page(comparison, plot)
        typer.echo(f"Figure: {plot}", err=True)
    if as_json:
        import json

        typer.echo(json.dumps(comparison.to_json(), indent=1, allow_nan=False))
    else:
        from rich.console import Console

        Console().print(_table(comparison))


# The table


def _table(comparison: "Comparison") -> "RenderableType":
    """The verdict first, then what it rests on, as ``harness report`` shows it."""
    from rich.console import Group
    from rich.text import Text

    from harness.report.rows import SCALES, index_grid, ratio_grid, split_grid

    combination = _combination(comparison)
    indices = index_grid(combination)
    kind = comparison.curves["baseline", "baseline"].kind
    indices = indices._replace(headings=(f"{kind} reward", *indices.headings[1:]))
    parts: list[RenderableType] = [
        Text(_title(comparison), style="bold"),
        Text(f"{_runs(comparison)}\n"),
        Text(comparison.verdict, style="bold"),
    ]
    for grid in (ratio_grid(combination), split_grid(combination), indices):
        parts += [Text(), *([_grid(grid)] if grid.rows else []), *map(Text, grid.notes)]
    return Group(*parts, Text(f"\n{SCALES}"))


def _combination(comparison: "Comparison") -> "Combination":
    """The same as a combination of an experiment, of which nothing but the runs is known."""
    from harness.registry.choice import Choice
    from harness.results.combination import Combination, Group

    unknown = Choice("recorded", (), "recorded")
    group = Group(unknown, "", unknown, unknown, comparison.decomposition.baseline.steps, 0)
    runs = tuple(range(min(comparison.runs.values())))
    baseline, proposed = (comparison.rewards[who] or UNKNOWN for who in ("baseline", "proposed"))
    return Combination(group, baseline, proposed, runs, comparison.decomposition, (), comparison.curves)


def _title(comparison: "Comparison") -> str:
    return "proposed {proposed} against {baseline}".format(
        **{who: name or UNKNOWN for who, name in comparison.rewards.items()}
    )


def _runs(comparison: "Comparison") -> str:
    """How many runs there are, and what of them is not compared."""
    parts = []
    for who, count in comparison.runs.items():
        left_out = comparison.rows_left_out[who]
        cut = f" ({_count(left_out, 'row')} behind the shortest run left out)" if left_out else ""
        parts.append(f"{who} {_count(count, 'run')}{cut}")
    return ", ".join(parts) + (", event terms included" if comparison.with_events else "")


def _count(number: int, noun: str) -> str:
    return f"{number:,} {noun}" + "s" * (number != 1)


def _grid(grid: "Grid") -> "RenderableType":
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for position, heading in enumerate(grid.headings):
        table.add_column(Text(heading), justify="right" if position else "left", no_wrap=bool(position))
    for row in grid.rows:
        table.add_row(*map(Text, row))
    return table


# The figure


def _write_page(comparison: "Comparison", path: Path) -> None:
    """Every run's curve and the means, in a page that opens anywhere, offline."""
    import html
    import json

    from harness.report.palette import BLUE, FONT, VERMILION

    try:
        from plotly.offline import get_plotlyjs
    except ImportError as error:
        raise UsageError(f"--plot needs {error.name}: pip install 'fd100-harness[report]'") from error
    colours: dict[Who, str] = {"baseline": BLUE, "proposed": VERMILION}
    lines = [line for who, colour in colours.items() for line in _lines(comparison.curves[who, who], who, colour)]
    page = PAGE.format(
        title=html.escape(_title(comparison)),
        verdict=html.escape(comparison.verdict),
        plotly=get_plotlyjs(),
        font=FONT,
        data=json.dumps(lines),
        layout=json.dumps(_layout(comparison.curves["baseline", "baseline"].kind)),
    )
    try:
        path.write_text(page, encoding="utf-8")
    except OSError as error:
        raise UsageError(f"The figure '{path}' cannot be written: {error.strerror}") from error


def _lines(curve: "GroupCurve", who: str, colour: str) -> list[dict[str, Any]]:
    from harness.report.points import select_points

    runs = curve.runs
    drawn = [(f"{who} run {number}", run, 1.0, 0.4) for number, run in enumerate(runs, 1)]
    drawn.append((f"{who}, mean of {len(runs)}", runs.mean(axis=0), 3.5, 1.0))
    lines = []
    for name, values, width, opacity in drawn:
        points = select_points(values)
        line = {"type": "scatter", "mode": "lines", "name": name, "opacity": opacity}
        line |= {"x": (points * curve.stride).tolist(), "y": values[points].tolist()}
        lines.append(line | {"line": {"color": colour, "width": width}, "showlegend": width > 1.0})
    return lines


def _layout(kind: str) -> dict[str, Any]:
    from harness.report.palette import FONT, GRID, INK

    axis = {"showline": True, "linecolor": INK, "gridcolor": GRID, "automargin": True}
    return {
        "font": {"family": FONT, "size": 13, "color": INK},
        "plot_bgcolor": "#ffffff",
        "height": 520,
        "legend": {"orientation": "h", "y": 1.1},
        "xaxis": {**axis, "title": {"text": "environment step"}, "tickformat": ",d"},
        "yaxis": {**axis, "title": {"text": f"{kind} reward"}, "zerolinecolor": "#767676"},
    }
