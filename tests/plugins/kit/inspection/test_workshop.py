"""The process in which a plugin is tried: what is left of it, and what replaces it."""

import ctypes
import tempfile
from pathlib import Path

import psutil
import pytest

from harness_plugins.kit.inspection.finding import Asked, Finding, Outline, PlannedCheck, read_plugins
from harness_plugins.kit.inspection.inspection import Loss, open_workshop
from tests.experiment.workers.test_offspring import lives

REWARD = """
import os, subprocess, sys
from dataclasses import dataclass
from pathlib import Path

print("imported")

@dataclass(frozen=True)
class Mine:
    def initial_carry(self, begin_distance):
        return ()

    def __call__(self, carry, sample):
        {call}
        return carry, -sample.distance
"""
ANY = PlannedCheck("reward-finite-edges", "Rewards are finite.", 30.0, long=False)


@pytest.fixture
def asked(tmp_path):
    """A reward in a file that does `call` whenever it is called."""

    def ask(call):
        (tmp_path / "mine.py").write_text(REWARD.format(call=call))
        return Asked("mine", files=read_plugins([str(tmp_path / "mine.py")])[0])

    return ask


def test_process_that_was_lost_is_replaced(asked, tmp_path):
    """The check that ended it is told; the next one runs in a new process."""
    flag = tmp_path / "flag"
    with open_workshop(asked(f"Path({str(flag)!r}).exists() and os._exit(3)"), None) as workshop:
        opened = workshop.open()
        assert isinstance(opened, Outline)
        assert [finding.printed for finding in opened.findings] == ["imported\n"]
        flag.touch()
        lost = workshop.run(ANY)
        assert isinstance(lost, Loss)
        assert lost.sentence == "the plugin ended the process: exit status 3"
        flag.unlink()
        found = workshop.run(ANY)
        assert isinstance(found, Finding)
        assert found.verdict == "ok"


def test_crash_is_told_with_its_line(asked):
    """Python's stack of the crash is kept for --verbose."""
    with open_workshop(asked("__import__('ctypes').string_at(0)"), None) as workshop:
        lost = workshop.run(ANY)
    assert isinstance(lost, Loss)
    assert lost.sentence == "a segmentation fault (SIGSEGV) ended the process (mine.py, line 14)"
    assert f"{Path(ctypes.__file__).name}" in lost.story


def test_silent_check_is_ended_when_its_time_is_over(asked):
    """It has what --check-time says."""
    with open_workshop(asked("__import__('time').sleep(1e6)"), 1.0) as workshop:
        workshop.seconds = None
        workshop.open()
        workshop.seconds = 1.0
        lost = workshop.run(ANY)
    assert isinstance(lost, Loss)
    assert lost.is_silent
    assert lost.sentence == "no answer for 1 s (mine.py, line 14)"


def test_nothing_is_left(asked, tmp_path, monkeypatch):
    """No file, and no process, not even one that a plugin started in a session of its own."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    pids = tmp_path / "pids"
    start = "p = subprocess.Popen(['sleep', '1000'], start_new_session=True)"
    call = f"{start}; open({str(pids)!r}, 'a').write(f'{{p.pid}}\\n')"
    with open_workshop(asked(call), None) as workshop:
        workshop.run(ANY)
        started = [int(pid) for pid in pids.read_text().split()]
        assert started
        assert all(psutil.pid_exists(pid) for pid in started)
    assert not any(lives(pid) for pid in started)
    assert list((tmp_path / "temporary").iterdir()) == []
