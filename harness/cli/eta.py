"""``harness eta``: two groups of recorded runs compared, or all recorded trainings of a folder."""

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from harness.cli.flags import eta as flags
from harness.cli.flags.shared import AsJson, CurveKind, PluginFiles, RecordedFolder
from harness.cli.output import say, say_json
from harness.cli.recordings import refuse_flags
from harness.cli.results_shown import show_results
from harness.errors import UsageError
from harness.text import command_text

if TYPE_CHECKING:
    from harness.score.compare import ComparedRuns


def eta(
    context: typer.Context,
    folder: RecordedFolder = None,
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

    A file has a column 'reward', or is a trace of this harness. If the files have distances too, each eta is split into
    ruler and behaviour. Put patterns in quotes. --baseline and --proposed may be given several times. In a FOLDER of
    recorded trainings, each reward that a policy was trained with is compared with every other one.
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
    from harness.score.compare import compare_recordings
    from harness.score.open_recording import match_recordings

    comparison = compare_recordings(
        match_recordings(baseline),
        match_recordings(proposed),
        load_registry(given=read_given(plugin)),
        kind=curve,
        with_events=with_events,
        baseline_reward=baseline_reward,
        proposed_reward=proposed_reward,
    )
    _show(comparison, plot, as_json)
    return 0


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
