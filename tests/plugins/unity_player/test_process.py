"""The process of a player."""

import os
import subprocess
import sys
import time

import psutil
import pytest

from harness_plugins.unity_player.guard import MOST
from harness_plugins.unity_player.process import PlayerProcess, find_program
from tests.refusals import refused

pytestmark = pytest.mark.skipif(os.name == "nt", reason="the programs of these tests are shell scripts")


def script(path, text):
    """A program."""
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return path


def is_alive(pid):
    """Whether a process is there and does something."""
    try:
        return bool(psutil.Process(pid).status() != psutil.STATUS_ZOMBIE)
    except psutil.NoSuchProcess:
        return False


def wait_for(condition, seconds=10.0):
    """Whether it holds within some seconds."""
    until = time.monotonic() + seconds
    while not condition() and time.monotonic() < until:
        time.sleep(0.02)
    return bool(condition())


def test_an_ending_tells_the_status_and_the_last_line(tmp_path):
    """What a player writes last says most often why it ended."""
    process = PlayerProcess(script(tmp_path / "p", "echo first; echo 'the scene is missing'; exit 3"), [])
    assert wait_for(process.ending)
    assert process.ending() == "exit status 3; its last line: the scene is missing"
    process.end()


def test_a_signal_is_told_as_such(tmp_path):
    """The system may have ended it."""
    process = PlayerProcess(script(tmp_path / "p", "kill -9 $$"), [])
    assert wait_for(process.ending)
    assert process.ending() == "signal 9"
    process.end()


def test_a_player_gets_its_arguments(tmp_path):
    """The port among them."""
    process = PlayerProcess(script(tmp_path / "p", 'echo "$@"'), ["--mlagents-port", "5"])
    assert wait_for(process.ending)
    assert process.ending().endswith("--mlagents-port 5")
    process.end()


def test_a_player_that_goes_on_is_ended_with_what_it_started(tmp_path, monkeypatch):
    """It gets some seconds, then no more."""
    monkeypatch.setattr("harness_plugins.unity_player.process.LONGEST", 0.1)
    pids = tmp_path / "pids"
    process = PlayerProcess(script(tmp_path / "p", f"sleep 600 & echo $$ $! > {pids}; wait"), [])
    assert wait_for(lambda: pids.exists() and len(pids.read_text().split()) == 2)
    process.end()
    assert wait_for(lambda: not any(is_alive(int(pid)) for pid in pids.read_text().split()))


def test_a_player_ends_with_a_killed_asker(tmp_path):
    """Whatever ends the process that started it, nothing is left."""
    pids, program = tmp_path / "pids", script(tmp_path / "p", f"echo $$ > {tmp_path / 'pids'}; sleep 600")
    code = (
        "import time; from pathlib import Path; from harness_plugins.unity_player.process import PlayerProcess;"
        f"PlayerProcess(Path({str(program)!r}), []); time.sleep(600)"
    )
    asker = subprocess.Popen([sys.executable, "-c", code])
    assert wait_for(lambda: pids.exists() and pids.read_text().strip(), 30.0)
    asker.kill()
    asker.wait()
    assert wait_for(lambda: not is_alive(int(pids.read_text())))


@pytest.mark.skipif(sys.platform != "linux", reason="no other system ends a process with its parent")
def test_a_player_ends_with_a_killed_guard(tmp_path):
    """Nothing stands between the two then."""
    pids = tmp_path / "pids"
    process = PlayerProcess(script(tmp_path / "p", f"echo $$ > {pids}; exec sleep 600"), [])
    assert wait_for(lambda: pids.exists() and pids.read_text().strip())
    process._guard.kill()
    assert wait_for(lambda: not is_alive(int(pids.read_text())))
    assert wait_for(process.ending)  # which the system tells of the guard a moment later
    process.end()


def test_of_much_output_the_newest_is_kept(tmp_path):
    """A player may print for days; the last line is told."""
    process = PlayerProcess(
        script(tmp_path / "p", f"head -c {20 * MOST} /dev/zero | tr '\\0' 'x'; echo; echo last"), []
    )
    assert wait_for(process.ending, 30.0)
    assert os.fstat(process._output.fileno()).st_size <= MOST
    assert process.ending() == "exit status 0; its last line: last"
    process.end()


def test_a_player_whose_child_holds_its_output_ends(tmp_path):
    """Whatever it left is not waited for."""
    process = PlayerProcess(script(tmp_path / "p", "setsid sleep 20 & echo last"), [])
    assert wait_for(process.ending)
    assert process.ending() == "exit status 0; its last line: last"
    process.end()


@pytest.mark.skipif(sys.platform != "linux", reason="names end otherwise elsewhere")
def test_a_program_is_found_without_its_ending(tmp_path):
    """Unity's builds for Linux end with .x86_64."""
    script(tmp_path / "arm.x86_64", "")
    assert find_program(str(tmp_path / "arm")) == tmp_path / "arm.x86_64"


def test_a_program_that_is_not_there_is_refused(tmp_path):
    """The path stands in the message."""
    with refused("no such program"):
        find_program(str(tmp_path / "arm"))


def test_a_program_that_may_not_be_run_is_refused(tmp_path):
    """The message says what to do."""
    (tmp_path / "arm").write_text("")
    with refused(r"chmod \+x .*arm"):
        find_program(str(tmp_path / "arm"))
