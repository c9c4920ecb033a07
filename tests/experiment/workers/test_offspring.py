"""All processes that a process started."""

import os
import subprocess
import sys
import time

import psutil

from harness.experiment.workers.workers import Offspring

PARENT = """
import subprocess, sys
child = subprocess.Popen(["sleep", "1000"], start_new_session=True, stdout=subprocess.DEVNULL)
print(child.pid, flush=True)
"""


def lives(pid):
    """Whether it is a process that has not ended."""
    try:
        return psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


def test_grandchild_is_ended_after_its_parent_has_left():
    """It has the mark that its parent inherited, also in a session of its own."""
    offspring = Offspring()
    env = {**os.environ, **offspring.environment}
    told = subprocess.run([sys.executable, "-c", PARENT], env=env, stdout=subprocess.PIPE, check=True, text=True)
    grandchild = int(told.stdout)
    assert lives(grandchild)
    offspring.kill()
    assert not lives(grandchild)


def test_processes_of_others_are_left_alone():
    """Another mark, or none."""
    other = Offspring()
    with (
        subprocess.Popen(["sleep", "1000"], env={**os.environ, **other.environment}) as marked,
        subprocess.Popen(["sleep", "1000"]) as bare,
    ):
        Offspring().kill()
        assert [marked.poll(), bare.poll()] == [None, None]
        marked.kill()
        bare.kill()


def test_nothing_to_end_takes_no_time():
    """The processes of this machine are looked through once."""
    begun = time.monotonic()
    Offspring().kill()
    assert time.monotonic() - begun < 1.0
