"""`harness check` on every kind of bad plugin, as a user calls it: it always ends in a verdict and a summary."""

import json
import subprocess
import sys
import time
from typing import Any, NamedTuple

import psutil
import pytest

MINUTE = 60
REWARD = """
import ctypes, os, signal, sys, time
from dataclasses import dataclass

KEPT = []
{top}

@dataclass(frozen=True)
class Odd:
    def initial_carry(self, begin_distance):
        return ()

    def __call__(self, carry, sample):
        {call}
        return carry, -sample.distance
"""
ENVIRONMENT = """
from dataclasses import dataclass

import gymnasium


class _Effort:
    def reset(self):
        self.sum = 0.0

    def __call__(self, observation, action, next_observation, info):
        self.sum += float(abs(action[0]))
        return self.sum


@dataclass(frozen=True)
class Odd:
    lower_is_better = frozenset({"effort"})

    def make(self):
        return gymnasium.make("Pendulum-v1")

    def rewards(self, env):
        return {"own": "own"}

    def behaviour(self, env):
        return {"effort": _Effort()}
"""
LOST = {
    "exit": ("", "sys.exit()"),
    "exit with status 0": ("", "os._exit(0)"),
    "crash": ("", "ctypes.string_at(0)"),
    "import exits": ("sys.exit(0)", ""),
    "import exits at once": ("os._exit(0)", ""),
    "import crashes": ("ctypes.string_at(0)", ""),
    "leak": ("", "KEPT.append(sample)"),
}
"""What a reward does when it is imported, and whenever it is called."""
SILENT = {
    "hang": ("", "time.sleep(1e6)"),
    "deaf": ("signal.signal(signal.SIGTERM, signal.SIG_IGN)", "time.sleep(1e6)"),
    "spin": ("", "exec('while True: pass')"),
    "import hangs": ("time.sleep(1e6)", ""),
}


class Checked(NamedTuple):
    """What the command left."""

    status: int
    told: dict[str, Any]
    seconds: float

    @property
    def errors(self):
        """The names of the checks that failed."""
        return [check["check"] for check in self.told["checks"] if check["verdict"] == "error"]


@pytest.fixture
def check(tmp_path):
    """Checks the plugin of a source, with ``--json``; no process of it may be left."""

    def run(source):
        (tmp_path / "odd.py").write_text(source)
        command = [sys.executable, "-m", "harness", "check", "odd", "--plugin", "odd.py", "--json"]
        begun = time.monotonic()
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=3 * MINUTE)
        seconds = time.monotonic() - begun
        assert [process for process in psutil.process_iter() if _is_in(process, tmp_path)] == []
        return Checked(done.returncode, json.loads(done.stdout), seconds)

    return run


def _is_in(process, folder):
    try:
        return process.cwd() == str(folder) and process.status() != psutil.STATUS_ZOMBIE
    except psutil.Error:
        return False


def _require_verdict(checked):
    assert checked.status == 1
    assert checked.errors
    assert checked.told["errors"] == len(checked.errors)
    assert checked.seconds < MINUTE


@pytest.mark.parametrize("name", LOST)
def test_reward_that_ends_its_process_gets_a_verdict(check, name):
    """Status 1, and what happened in every check that failed."""
    top, call = LOST[name]
    _require_verdict(check(REWARD.format(top=top, call=call or "pass")))


@pytest.mark.slow
@pytest.mark.parametrize("name", SILENT)
def test_reward_that_never_answers_gets_a_verdict(check, name):
    """Within a minute."""
    top, call = SILENT[name]
    _require_verdict(check(REWARD.format(top=top, call=call or "pass")))


@pytest.mark.parametrize("step", [37, 77])
def test_number_that_is_lost_late_in_an_episode_is_found(check, step):
    """By a check of a whole horizon."""
    late = f"sample.distance.__array_namespace__().where(sample.step == {step}, float('nan'), -sample.distance)"
    checked = check(REWARD.format(top="", call="pass").replace("-sample.distance", late))
    assert checked.errors == ["reward-finite"]
    _require_verdict(checked)


def test_measure_that_begins_anew_in_each_episode_passes(check):
    """As the page of environments shows it: `reset` is called before the first step."""
    checked = check(ENVIRONMENT)
    assert (checked.status, checked.errors) == (0, [])
