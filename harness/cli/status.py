"""``harness status``: how far a run has come, asked from another shell."""

from typing import TYPE_CHECKING

from harness.cli.flags.shared import AsJson, ExperimentFolder
from harness.cli.output import say, say_json

if TYPE_CHECKING:
    from harness.record.cell import Cell
    from harness.record.status import Progress
    from harness.record.store import Store
    from harness.results.under_way import SoFar

KINDS = ("done", "failed", "skipped", "damaged", "running", "interrupted", "pending", "not needed")
SHOWN = ("running", "interrupted", "failed", "damaged")


def status(
    folder: ExperimentFolder,
    as_json: AsJson = False,
) -> None:
    """Say how many cells are done, what is running, and how long the rest will take. Changes nothing."""
    from harness.cli.progress import left_text
    from harness.record.status import read_status
    from harness.record.store import Store

    found, store, standing = read_status(folder), Store.open(folder), None
    if store.read_plan().terms.has_plan:  # else what reads results is not imported
        from harness.results.load import load_results
        from harness.results.results import standing_of

        standing = standing_of(load_results(folder))
    if standing is not None:
        found = found.without(standing.not_needed)
    if as_json:
        from harness.results.results import standing_to_json

        told = ((one.cell, so_far_of(one.cell, store)) for one in found.cells if one.running)
        recorded = {cell.id: it._asdict() for cell, it in told if it}
        say_json({**found.to_json(recorded), **standing_to_json(standing)})
        return
    say(f"{folder}: {'a run is using it' if found.is_in_use else 'no run is using it'}")
    if found.note:
        say(found.note)
    counts = ", ".join(f"{found.count(kind)} {kind}" for kind in KINDS if found.count(kind))
    at_most = standing is not None
    left = "" if found.seconds_left is None else f"; {left_text(found.seconds_left, at_most=at_most)}"
    say(f"{len(found.cells)} cells: {counts}{left}")
    if standing is not None:
        say(f"{standing.text[:1].upper()}{standing.text[1:]}")
    for one in found.cells:
        if one.status in SHOWN:
            say(f"{one.status}: {one.cell.title}: {_detail(one, store, found.now)}")


def so_far_of(cell: "Cell", store: "Store") -> "SoFar | None":
    """What its rows say of a cell that is running, or was."""
    from harness.results.under_way import so_far

    return so_far(cell, store)


def _detail(one: "Progress", store: "Store", now: float) -> str:
    if one.running is None:
        return one.reason
    steps = told.text if (told := so_far_of(one.cell, store)) else f"{one.running.steps:,} of {one.cell.steps:,} steps"
    if one.status == "interrupted":
        return f"{steps}; run the same command again to go on"
    speed = one.running.steps / max(one.running.told - one.running.started, 1e-3)
    return f"{steps}; {speed:.0f} steps/s, last message {now - one.running.told:.0f} s ago"
