"""How many workers there are."""

import os

import pytest

from harness.experiment.workers.workers import core_count, worker_count
from tests.refusals import refused


def test_cores_are_counted_where_the_system_does_not_say_which_may_be_used(monkeypatch):
    """MacOS and Windows have no `sched_getaffinity`: there the machine's cores count, and at least one."""
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 6)
    assert core_count() == 6
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert core_count() == 1


def test_workers_are_as_many_as_asked_for():
    """By default as many as there are cores."""
    assert worker_count(3) == 3
    assert worker_count(None) == core_count() >= 1


@pytest.mark.parametrize("jobs", [0, -2])
def test_fewer_than_one_worker_is_refused(jobs):
    """The message says what was given and what is allowed."""
    with refused(f"^jobs={jobs}: must be at least 1$"):
        worker_count(jobs)
