"""How the end of a process is told."""

import signal

import numpy as np
import pytest

from harness_plugins.kit.inspection import ending
from harness_plugins.kit.inspection.ending import ending_in_words, is_plugins_own, place_in, split_output

DUMP = f"""Fatal Python error: Segmentation fault

Current thread 0x00007f (most recent call first):
  File "{signal.__file__}", line 47 in signal
  File "/home/me/odd.py", line 17 in __call__

Thread 0x00008e (most recent call first):
  File "/home/me/other.py", line 5 in wait
"""


@pytest.mark.parametrize(
    ("status", "words"),
    [
        (0, "the plugin ended the process: exit status 0"),
        (3, "the plugin ended the process: exit status 3"),
        (-signal.SIGSEGV, "a segmentation fault (SIGSEGV) ended the process"),
        (-signal.SIGKILL, "the process was killed (SIGKILL)"),
        (-signal.SIGUSR1, "the signal SIGUSR1 ended the process"),
        (-250, "signal 250 ended the process"),
    ],
)
def test_each_end_has_its_words(status, words):
    """Who ended it, and how."""
    assert ending_in_words(status).startswith(words)


def test_dump_is_told_apart_from_what_was_printed():
    """A plugin may have printed before it crashed."""
    assert split_output(f"hello\n{DUMP}") == ("hello\n", DUMP)
    assert split_output("hello\n") == ("hello\n", "")


def test_place_is_the_last_own_call_of_the_thread_that_crashed():
    """Python's modules are left out, and so are other threads."""
    assert place_in(DUMP) == "odd.py, line 17"
    assert not place_in("nothing of the kind")


def test_library_of_a_plugin_is_its_own():
    """Python's modules are not, nor are the harness's."""
    assert is_plugins_own(np.__file__)
    assert not is_plugins_own(signal.__file__)
    assert not is_plugins_own(ending.__file__)
    assert not is_plugins_own("<frozen runpy>")
