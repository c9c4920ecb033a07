"""Building blocks for authors of executors: they do a job in this process, or in processes of this machine.

An executor for another machine sends `Job.to_json` there, calls `run_jobs` there with that one job, and passes on the
events.
"""

from collections.abc import Iterator, Sequence

from harness.executor import Event, Job, OnEvent
from harness.experiment.run_cell import TrainCell, run_cell
from harness.experiment.workers.order import Order, Report
from harness.experiment.workers.workers import Pool
from harness.record.cell import Manifest


def order_of(job: Job) -> Order:
    """The order that tells a worker process to do the job."""
    return Order(job.folder, TrainCell(job.cell, job.options), job.options.limits, job.options.fresh)


def run_job(job: Job, report: Report = lambda word: None) -> Manifest:
    """Do a job in this process, and leave its folder.

    If a plugin raises an error, the cell counts as failed. If a plugin crashes or hangs, this process does too, and the
    job's limits are not enforced. `run_jobs` protects against both.

    Args:
        job: What to do.
        report: Called with each report of progress.

    Returns:
        The manifest in the folder.
    """
    return run_cell(job.cell, job.folder, report, job.options)


def run_jobs(jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
    """Do jobs in processes of this machine, within their limits; see `harness.executor.Executor.run`.

    Args:
        jobs: What to do.
        at_once: The most that run at a time.
        on_event: Called with each event, in the caller's thread.
    """
    with Pool() as pool:
        for event in events_of(jobs, at_once, pool):
            on_event(event)


def events_of(jobs: Sequence[Job], at_once: int, pool: Pool) -> Iterator[Event]:
    """Do jobs in the processes of a pool, and yield each event when it happens.

    The pool may do other jobs before and after. If the caller stops iterating, the cells run on until the pool ends.
    """
    cells = {job.folder: job.cell for job in jobs}
    for news in pool.run([order_of(job) for job in jobs], at_once):
        yield Event(news.kind, cells[news.folder], news.steps, news.reason, scalars=news.scalars)
