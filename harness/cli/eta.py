"""``harness eta``: two groups of recorded runs compared, or all recorded trainings of a folder."""

import glob
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from harness.cli.datasets import names_dataset
from harness.cli.flags import eta as flags
from harness.cli.flags.shared import AsJson, CurveKind, PluginFiles
from harness.cli.output import say, say_json
from harness.cli.recordings import refuse_flags
from harness.cli.results_shown import show_results
from harness.errors import UsageError
from harness.text import command_text

if TYPE_CHECKING:
    from harness.score.compare import ComparedRuns

MOST_VISITED = 10_000
"""Files of a folder that are looked at for CSV files."""
NUMBERED = re.compile(r"[-_ .]*(seed|run)?[-_ .]*\d*$", re.IGNORECASE)
"""How names of the files of one group differ."""


def eta(
    context: typer.Context,
    folder: flags.TrainingsFolder = None,
    baseline: flags.BaselineRuns = None,
    proposed: flags.ProposedRuns = None,
    curve: CurveKind = "accumulated",
    with_events: flags.WithEvents = False,
    baseline_reward: flags.BaselineReward = None,
    proposed_reward: flags.ProposedReward = None,
    plugin: PluginFiles = None,
    as_json: AsJson = False,
    plot: flags.PlotFile = None,
) -> int:
    """Compare recorded trainings, such as anybody's CSV files.

    A file has a column 'reward' and a row for each environment step, or is a trace of this harness. If the files have
    distances too, each eta is split into ruler and behaviour. All runs are cut to the steps of the shortest. Put
    patterns in quotes. --baseline and --proposed may be given several times. In a FOLDER of recorded trainings, each
    reward that a policy was trained with is compared with every other one.
    """
    groups = {"--baseline": baseline, "--proposed": proposed}
    loose = [*([] if folder is None or not any(groups.values()) else [str(folder)]), *context.args]
    if loose:
        raise UsageError(f"'{loose[0]}' belongs to no flag: quote the pattern, as in --baseline 'base/*.csv'")
    if plot is not None and plot.suffix.lower() != ".html":
        raise UsageError(f"--plot writes .html, not '{plot}'")
    if folder is not None:
        refuse_flags(
            {
                "--with-events": with_events, "--baseline-reward": baseline_reward,
                "--proposed-reward": proposed_reward, "--plugin": plugin,
            }
        )  # fmt: skip
        _require_trainings(folder)
        from harness.results import load_results

        results = load_results(folder, curve)
        everything = command_text("harness", "report", folder, "--details")
        return show_results(results, everything, as_json=as_json, html=plot, details=True)
    if baseline is None or proposed is None:
        missing = next(flag for flag, given in groups.items() if given is None)
        raise UsageError(
            f"Missing option '{missing}'; or name a folder of recorded trainings. Examples: harness eta --help"
        )
    from harness.registry.given import read_given
    from harness.registry.registry import load_registry
    from harness.score.compare import compare_logs
    from harness.score.open_steps import match_steps

    registry = load_registry(given=read_given(plugin))
    comparison = compare_logs(
        match_steps(baseline, registry),
        match_steps(proposed, registry),
        registry,
        kind=curve,
        with_events=with_events,
        baseline_reward=baseline_reward,
        proposed_reward=proposed_reward,
    )
    _show(comparison, plot, as_json)
    return 0


def _require_trainings(folder: Path) -> None:
    """Check that a folder is one of trainings, as far as the name of another command or flag would fit better.

    Raises:
        UsageError: It is a data set, a file, or a folder of CSV files alone; says what to type.
    """
    from harness.cli.recordings import holds_recordings
    from harness.record.store import Store

    if names_dataset(folder):
        audit = command_text("harness", "audit", str(folder))
        raise UsageError(f"'{folder}' is a data set, which holds no trainings to compare: {audit} judges its rewards")
    if folder.is_file():
        raise UsageError(f"'{folder}' is a file: {command_text(*_command([glob.escape(str(folder))]))}")
    if not folder.is_dir() or Store.is_experiment(folder) or holds_recordings([folder]):
        return
    patterns = _patterns_in(folder)
    if patterns:
        raise UsageError(f"'{folder}' holds CSV files: {command_text(*_command(patterns))}")


def _command(patterns: list[str]) -> tuple[str, ...]:
    """The command that compares groups of files; what is called a baseline is the baseline."""
    named = [pattern for pattern in patterns if "base" in pattern.lower()]
    ordered = [*named[:1], *(pattern for pattern in patterns if pattern not in named), *named[1:], "OTHER/*.csv"]
    return ("harness", "eta", "--baseline", ordered[0], "--proposed", ordered[1])


def _patterns_in(folder: Path) -> list[str]:
    """Patterns of groups of CSV files: one for each folder that has some, or for each beginning of names in one."""
    found: dict[str, set[str]] = {}
    visited = 0
    for place, inner, names in os.walk(folder):
        inner.sort()
        visited += len(names)
        stems = {NUMBERED.sub("", name[:-4]) for name in names if name.lower().endswith(".csv")}
        if stems:
            found[place] = stems
        if visited > MOST_VISITED:
            break
    if len(found) != 1:
        return [os.path.join(glob.escape(place), "*.csv") for place in found]
    ((place, stems),) = found.items()
    several = sorted(stems) if len(stems) == 2 and all(stems) else [""]
    return [os.path.join(glob.escape(place), f"{glob.escape(stem)}*.csv") for stem in several]


def _show(comparison: "ComparedRuns", plot: Path | None, as_json: bool) -> None:
    if plot is not None:
        from harness.report.page.eta import write_eta_page

        write_eta_page(comparison, plot)
        say(f"Figure: {plot}", err=True)
    if as_json:
        say_json(comparison.to_json())
    else:
        from harness.cli.terminal import show
        from harness.report.tables.eta import eta_table

        show(eta_table(comparison))
