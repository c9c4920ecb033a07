"""Has policies validated, in processes of their own: an engine that crashes costs one policy alone."""

import json
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import IO

from harness.experiment.worker_process import start_process, stop_processes, write_line
from harness.tune.validation import Order

LOG = "log.txt"


def validate_all(orders: Sequence[Order], at_once: int, folder: Path) -> None:
    """Do every order that has not ended, at most `at_once` at a time; each then has its trace or its failure.

    Args:
        orders: What to do.
        at_once: How many processes.
        folder: For the log.
    """
    waiting = [order for order in orders if not order.is_ended]
    with (folder / LOG).open("a") as log:
        while waiting:
            shares = [share for share in (waiting[index::at_once] for index in range(at_once)) if share]
            statuses = _run(shares, log)
            waiting = [order for share, status in zip(shares, statuses, strict=True) for order in _left(share, status)]


def _left(share: list[Order], status: int) -> list[Order]:
    """What a process did not come to. The first that it did not end ended it."""
    left = [order for order in share if not order.is_ended]
    if left:
        left[0].failure.write_text(f"validation: its process ended with exit status {status}")
    return left[1:]


def _run(shares: list[list[Order]], log: IO[str]) -> list[int]:
    """The exit status of a process for each share; none is left running when an exception passes."""
    processes: list[subprocess.Popen[str]] = []
    try:
        for share in shares:
            processes.append(_start(share, log))
        return [process.wait() for process in processes]
    finally:
        stop_processes(processes)


def _start(share: list[Order], log: IO[str]) -> "subprocess.Popen[str]":
    process = start_process("harness.tune.validation", stdout=log, stderr=log)
    write_line(process, json.dumps(share))
    return process
