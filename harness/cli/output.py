"""What commands print: lines, results, and what they write beside them."""

import logging
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from harness.cli.records import load_records
from harness.errors import UsageError
from harness.text import one_line, print_visible, visible

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from harness.payoff.rollout import Rollout
    from harness.record.cell import Cell
    from harness.registry.choice import Registry
    from harness.report.facts import Report
    from harness.report.rows.returns import Audits, Payoffs
    from harness.results import Results


def say(line: str, err: bool = False) -> None:
    """Print a line that may hold names of strangers, whole, on standard output or on standard error."""
    print_visible(line, err)


def complain(message: str) -> None:
    """Say on standard error, in one line that is not long, what went wrong."""
    print_visible(f"harness: {one_line(message)}", err=True)


def say_json(data: Any) -> None:
    """Print plain data as JSON on standard output.

    Raises:
        ValueError: It holds a number that JSON has not, NaN or infinity.
    """
    import json

    print_visible(json.dumps(data, indent=1, allow_nan=False))


@contextmanager
def libraries_visible() -> Iterator[None]:
    """While a command runs: warnings, log lines and errors of threads are shown as all else is, whoever wrote them."""
    before = warnings.showwarning, threading.excepthook
    plain = logging.lastResort.formatter if logging.lastResort is not None else None
    warnings.showwarning, threading.excepthook = _show_warning, _show_error_of_thread
    if logging.lastResort is not None:
        logging.lastResort.setFormatter(_VisibleLines())
    try:
        yield
    finally:
        warnings.showwarning, threading.excepthook = before
        if logging.lastResort is not None:
            logging.lastResort.setFormatter(plain)


class _VisibleLines(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        """Called for each line that no handler takes."""
        return visible(super().format(record), keep="\n")


def _show_warning(
    message: Warning | str, category: type[Warning], filename: str, lineno: int,
    file: TextIO | None = None, line: str | None = None,
) -> None:  # fmt: skip
    text = visible(warnings.formatwarning(message, category, filename, lineno, line), keep="\n")
    (file or sys.stderr).write(text)


def _show_error_of_thread(error: threading.ExceptHookArgs) -> None:
    if error.exc_value is not None and not isinstance(error.exc_value, SystemExit):
        complain(f"a thread ended: {one_line(error.exc_value)}")


@contextmanager
def kept_when_interrupted(kept: str, folder: Path) -> Iterator[None]:
    """If KeyboardInterrupt passes, say on standard error what is kept where, and how to go on."""
    try:
        yield
    except KeyboardInterrupt:
        say(f"harness: interrupted: {kept} in '{folder}'. The same command goes on with the rest", err=True)
        raise


def show_results(
    results: "Results",
    command: str,
    *,
    as_json: bool = False,
    html: Path | None = None,
    details: bool = False,
    summary: Path | None = None,
) -> int:
    """Write and print what is asked for; by default the overview.

    Args:
        results: What to show.
        command: The command that shows everything behind the overview.
        as_json: Whether to print JSON.
        html: Where to write the page.
        details: Whether to print everything that the overview rests on.
        summary: The folder for committed records.

    Returns:
        The exit status: 1 if something is damaged.

    Raises:
        UsageError: Something cannot be written.
    """
    from harness.report.facts import Report

    report = Report(results)
    for name, reason in results.not_measured.items():  # its values are missing, and nothing else
        complain(f"metric {name}: n/a ({reason})")
    if html is not None:
        write_page_of(report, html)
        say(f"Report: {html}", err=True)
    if summary is not None:
        load_records().write(results, summary)
        say(f"Summary: {summary}", err=True)
    if as_json:
        from harness.report.document import report_text

        say(report_text(report))
    elif details or summary is None:
        _print_tables(report, details, command)
    for line in results.damaged_recordings:
        complain(f"damaged: {line}")
    return 1 if results.damaged_recordings else 0


def write_page_of(report: "Report", html: Path) -> None:
    """Write the page.

    Raises:
        UsageError: The extra ``report`` is missing, or the page cannot be written.
    """
    from harness.files.bounded import note_made
    from harness.report.page.html import write_html

    results = report.results
    write_html(report, html, audits_of(results))
    if results.is_experiment and html.absolute().parent == results.folder.absolute():
        note_made(html)  # as the folder's SHA256SUMS tells


def _print_tables(report: "Report", details: bool, command: str) -> None:
    """The overview, or all there is."""
    from harness.report.facts import paragraphs
    from harness.report.tables.grid import FactsTable, show

    facts = report.full if details else report.short
    if not details and (report.results.combinations or report.results.alone):
        facts += paragraphs(f"All numbers behind this: {command}")
    show(FactsTable(facts))


def make_table_and_page(results: "Results", err: bool = False) -> None:
    """Write ``results.parquet`` and ``report.html``, and say where they are.

    Args:
        results: The experiment.
        err: Say it on standard error: standard output is for something else.

    Raises:
        StorageError: The folder cannot be written.
    """
    from harness.record.out_folder import storage_errors
    from harness.record.store import REPORT
    from harness.report.facts import Report

    with storage_errors(results.folder):
        results.write_table()
    say(f"Results: {results.folder}", err)
    try:
        with storage_errors(results.folder):
            if results.in_environment:  # episodes of the policies that are compared, drawn for the page
                from harness.experiment.environments.frames import draw_frames
                from harness.experiment.workers.workers import core_count

                draw_frames(results, core_count())
            write_page_of(Report(results), results.folder / REPORT)
        say(f"Report:  {results.folder / REPORT}", err)
    except UsageError as error:  # the extra is missing: the results are there all the same
        say(f"No {REPORT}: {error}", err)


EPISODES = 20
"""The episodes of each scripted policy: half a second for a robot and task, and the answer no longer changes."""
GAMMA = 0.95
"""The discount that ``harness audit`` has too."""


def audits_of(results: "Results") -> "Audits":
    """By robot, task and reward; a reward that cannot be asked says why."""
    return pays_of([manifest.cell for manifest in results.done], results.registry)


def pays_of(cells: "Sequence[Cell]", registry: "Registry") -> "Audits":
    """The same of the rewards that cells of an arm train by; others are left out."""
    asked = {
        (cell.robot, cell.task.label, cell.reward.label): cell
        for cell in cells
        if cell.task.name in registry.names("tasks")
    }
    rollouts: dict[tuple[str, str, float], tuple[Rollout, ...] | str] = {}

    def record(cell: "Cell", noise: float) -> "tuple[Rollout, ...] | str":
        place = (cell.robot, cell.task.label, noise)
        if place not in rollouts:
            rollouts[place] = _record(cell, registry, noise)
        return rollouts[place]

    return {key: _ask(cell, registry, record) for key, cell in asked.items()}


def _record(cell: "Cell", registry: "Registry", noise: float) -> "tuple[Rollout, ...] | str":
    """What the scripted policies do; or why they cannot."""
    from harness.env.ideal import IdealSimulator
    from harness.errors import reason_of
    from harness.payoff.rollout import record_rollouts
    from harness.robot.robot import load_robot

    try:
        task = cell.task.build(registry, "tasks")
        return record_rollouts(IdealSimulator(), load_robot(cell.robot, registry), task, EPISODES, noise)
    except (Exception, SystemExit) as error:  # not installed, not without an engine, or whatever a plugin raises
        return reason_of(error)


def _ask(cell: "Cell", registry: "Registry", record: "Callable[[Cell, float], tuple[Rollout, ...] | str]") -> "Payoffs":
    """What the cell's reward pays in these rollouts."""
    from harness.errors import reason_of
    from harness.payoff.rollout import NOISE, finishing_of, on_finishing, on_noise, on_terms, score_rollout
    from harness.report.rows.returns import Payoffs

    rollouts = record(cell, 0.0)
    if isinstance(rollouts, str):
        return Payoffs((f"Not known: {rollouts}",), {}, {})
    try:
        reward = cell.reward.build(registry, "rewards")
        found = finishing_of([score_rollout(reward, rollout) for rollout in rollouts], GAMMA)
        noisy = record(cell, NOISE) if found.undiscounted or found.discounted else ""
        disturbed = [score_rollout(reward, rollout) for rollout in noisy if not isinstance(rollout, str)]
        told = [on_noise(found, finishing_of(disturbed, GAMMA))] if disturbed else []
    except (Exception, SystemExit) as error:
        return Payoffs((f"Not known: {reason_of(error)}",), {}, {})
    return Payoffs(
        (on_finishing(found), *told, *on_terms(found)),
        {payoff.policy: payoff.total for payoff in found.payoffs},
        {payoff.policy: payoff.success for payoff in found.payoffs},
    )
