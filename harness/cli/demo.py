"""``harness demo``: in a few seconds, why a larger number need not be a better robot."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from harness.cli.flags.shared import flag
from harness.cli.output import say
from harness.errors import HarnessError, UsageError
from harness.text import command_text

if TYPE_CHECKING:
    from harness.executor import Job, OnEvent
    from harness.results import Results

SEEDS, STEPS, EPISODES = 3, 200, 20
ASKED = {
    "sim": "kinematic",
    "algo": "ik",
    "task": "fd100-reach:speed=0.1",
    "reward": "arp",
    "seeds": SEEDS,
    "steps": STEPS,
    "evaluation_episodes": EPISODES,
}
BEFORE = (
    "An arm reaches for targets. Its own geometry steers it and it learns nothing, so it cannot care what it is paid. "
    "It is paid twice: by the reward 'baseline', then by the reward 'arp', which was proposed as a better one. "
    f"{SEEDS} repetitions of {STEPS} steps each; no physics engine, no learning library.\n"
)
AFTER = (
    "\nIn {same} of {all} recorded steps every joint stands at the same angle under both rewards. Yet an "
    "episode is paid {times} times as much under 'arp'. All of that is rescaling: 'arp' pays the same movements with "
    "larger numbers. The harness keeps the two apart.\n\n"
    "NO DIFFERENCE stands there because every step is the same. Where robots learn, steps differ, and a test decides: "
    "the answer can be HELPS, HURTS, NO DIFFERENCE or CANNOT TELL.\n"
)
ONWARD = """
Where to go on:
  open {page} in a browser
      its replay shows both arms side by side: they move alike
  {details}
      all that was measured here
  harness audit --reward arp
      what does this reward pay for?
  harness doctor
      what is installed, what you can run
  harness run --sim mujoco --algo sac-fast
      the same question with physics and learning, after
      pip install 'fd100-harness[mujoco]'"""


def demo(
    out: Annotated[Path | None, flag("DIR", "Leave the experiment in this folder.", "a temporary one")] = None,
) -> None:
    """Show how a number gets better while the robot does the same. Takes seconds, and needs no optional library."""
    import tempfile

    from rich.text import Text

    from harness.experiment.experiment import prepare
    from harness.experiment.plan import check_experiment
    from harness.experiment.run_options import RunOptions
    from harness.record.store import Store
    from harness.report.tables.grid import show

    folder = out or Path(tempfile.mkdtemp(prefix="harness-demo-"))
    ready = prepare(check_experiment(ASKED), RunOptions(out=folder))
    if Store.is_experiment(folder) and not {*ready.store.read_plan().cells} <= {*ready.plan.cells}:
        raise UsageError(f"--out '{folder}' holds another experiment: name a new or empty folder, or one of the demo")
    show(Text(BEFORE))
    results = replace(ready, executor=_HereAndNow()).run()
    for failed in results.failed:
        raise HarnessError(f"The demo's {failed.cell.title} failed: {failed.reason}")
    _show(results)


@dataclass(frozen=True)
class _HereAndNow:
    """Runs the cells in this process: starting others would take longer than all of the demo."""

    def run(self, jobs: Sequence["Job"], at_once: int, on_event: "OnEvent") -> None:
        from harness.executor import Event
        from harness.experiment.jobs import run_job

        for job in jobs:
            on_event(Event("started", job.cell))
            run_job(job)
            on_event(Event("ended", job.cell))


def _show(results: "Results") -> None:
    import numpy as np
    from rich.text import Text

    from harness.cli.output import make_table_and_page
    from harness.eta.headline import format_number
    from harness.record.folder import EVALUATION, TRACE
    from harness.record.store import REPORT
    from harness.record.trace import read_trace
    from harness.report.facts import Report
    from harness.report.tables.grid import FactsTable, show

    show(FactsTable(Report(results).overview))
    (comparison,) = results.combinations
    cells = {(cell.seed, cell.reward.name): results.store.cell_folder(cell) for cell in results.done_cells}
    same = recorded = 0  # steps that find every joint at the same angle under both rewards, of all
    for seed in range(SEEDS):
        for file in (TRACE, EVALUATION):
            one, other = (read_trace(cells[seed, reward] / file)["qpos"] for reward in ("baseline", "arp"))
            recorded += len(one)
            same += len(one) if np.array_equal(one, other) else 0
    pay = comparison.number.pay
    times = format_number(None if pay is None else pay.ratio.eta.value)
    show(Text(AFTER.format(same=f"{same:,}", all=f"{recorded:,}", times=times)))
    make_table_and_page(results)
    details = command_text("harness", "report", results.folder, "--details")
    say(ONWARD.format(page=command_text(results.folder / REPORT), details=details))
