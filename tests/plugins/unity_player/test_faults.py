"""Mistakes of a program: each ends in one line that says what Unity sent, and leaves nothing behind."""

import re
import socket

import numpy as np
import pytest

from harness_plugins.unity_player.messages import UnityError
from tests.refusals import refused

FROM_THE_START = {
    "crash": r"the player ended \(exit status 3; its last line: NullReferenceException",
    "hang": r"it has said nothing for 4 s\. In Unity, Behavior Type has to be Default",
    "silent": r"it has said nothing for 4 s",
    "old-version": r"speaks version 0\.15\.0 of ML-Agents' protocol, and 1\.5\.0 is understood",
    "doubled": r"agent 0 of the behaviour 'Arm\?team=0' is twice in one message",
    "nan": r"agent 0 of the behaviour .* observes nan at place 2",
    "nan-reward": r"agent 0 of the behaviour .* is paid nan",
    "image": r"sensor VectorSensor .* has the shape \(8, 8, 3\), an image: take the camera",
    "both-actions": r"5 continuous actions and 1 discrete branches",
}
LATER = {
    "crash": FROM_THE_START["crash"],
    "hang": FROM_THE_START["hang"],
    "doubled": r"is twice in one message",
    "nan": r"observes nan at place 2",
    "nan-reward": r"is paid nan",
    "wrong-id": r"agent 999 of the behaviour .* ended, and none of this number has asked: there are 0",
    "shorter": r"observes 18 numbers, and 19 numbers before",
    "another-spec": r"introduces the behaviour .* again, with other observations or actions",
}


def stand_still(env):
    """Some steps."""
    for _ in range(6):
        env.step(np.zeros(5, np.float32))


@pytest.mark.parametrize("fault", FROM_THE_START)
def test_a_fault_at_the_start_refuses_the_program(start, fault):
    """A usage error that names the program."""
    patience = 4.0 if fault in ("hang", "silent") else 10.0
    with refused(FROM_THE_START[fault]) as told:
        start("--fault", fault, patience=patience)
    assert re.match(r"Unity \(.*player\): [^\n]+$", str(told.value))


@pytest.mark.parametrize("fault", LATER)
def test_a_fault_later_ends_the_training(start, fault):
    """In the step in which it happens."""
    env = start("--fault", fault, "--fault-after", "3", patience=4.0 if fault == "hang" else 10.0)
    env.reset()
    with pytest.raises(UnityError, match=LATER[fault]) as told:
        stand_still(env)
    assert "\n" not in str(told.value)


def test_an_agent_that_is_gone_is_missed(start):
    """The others go on asking."""
    env = start("--agents", "2", "--fault", "gone", "--fault-after", "3", patience=4.0)
    env.reset()
    with pytest.raises(UnityError, match=r"agent 0 of the behaviour .* has asked nothing for 4 s"):
        stand_still(env)


def test_a_port_that_is_taken_is_refused(start):
    """Another run waits there for the editor."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with refused(rf"port={port} is taken on this machine.*--jobs 1"):
            start(port=port)
