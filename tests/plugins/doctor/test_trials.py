"""Installed simulators and environments are tried, each in a process of its own."""

import sys
import textwrap

import pytest

from harness import load_registry
from harness_plugins.doctor import trials
from harness_plugins.doctor.trials import Example, Trial, examples, half_installed, take_a_step, try_all

PLUGIN = """
from dataclasses import dataclass

import harness


@harness.hookimpl
def register_environments(register):
    register("odd", f"{{__name__}}:Odd", summary="odd", extra="odd")


@dataclass(frozen=True)
class Odd:
    way: str = ""

    @staticmethod
    def examples():
        return {examples}

    def make(self):
        import os, signal, sys, time

        print("on standard output")
        if self.way == "raise":
            raise ValueError("no such arm")
        if self.way == "exit":
            sys.exit("never mind")
        if self.way == "leave":
            os._exit(7)
        if self.way == "crash":
            os.kill(os.getpid(), signal.SIGSEGV)
        if self.way == "hang":
            time.sleep(60)
        import gymnasium

        return gymnasium.make("CartPole-v1")

    def rewards(self, env):
        return {{"own": "own"}}

    def behaviour(self, env):
        return {{}}
"""


@pytest.fixture
def odd(install, monkeypatch):
    """Install an environment with these examples, for this process and for those that it starts."""

    def make(given):
        install("odd-env", textwrap.dedent(PLUGIN.format(examples=given)))
        monkeypatch.setenv("PYTHONPATH", sys.path[0])

    return make


def test_every_installed_simulator_is_tried():
    """And every environment: one that takes parameters with examples of them."""
    found = [(it.kind, it.name) for it in examples(load_registry()) if not it.missing]
    assert ("simulators", "kinematic") in found
    assert ("environments", "gymnasium:id=CartPole-v1") in found
    assert ("simulators", "drake") not in found or not load_registry().get("simulators", "drake").missing


@pytest.mark.parametrize(("kind", "name"), [("simulators", "kinematic"), ("environments", "gymnasium:id=CartPole-v1")])
def test_trial_takes_a_step(kind, name):
    """It raises where that fails."""
    take_a_step(kind, name)
    with pytest.raises(Exception, match="no-such"):
        take_a_step(kind, "no-such" if kind == "simulators" else "gymnasium:id=no-such-v0")


WAYS = {
    "": "",
    "raise": "ValueError: no such arm",
    "exit": "SystemExit: never mind",
    "leave": "its process ended with status 7",
    "crash": "its process was ended by SIGSEGV",
}


def test_each_way_to_fail_is_told(odd, monkeypatch):
    """In one line, whatever the library does to its process; the others are tried all the same."""
    monkeypatch.setattr(trials, "KINDS", ("environments",))
    odd(str({f"way={way}": () for way in WAYS if way} | {"way=none": ()}))
    found = {trial.name: trial.problem for trial in try_all(load_registry()) if trial.name.startswith("odd:")}
    assert found == {**{f"odd:way={way}": told for way, told in WAYS.items() if way}, "odd:way=none": ""}


def test_trial_that_hangs_is_ended(odd, monkeypatch):
    """After the limit."""
    monkeypatch.setattr(trials, "LIMIT", 0.5)
    odd(str({"way=hang": ()}))
    (told,) = [trial.problem for trial in trials.tried([Example("environments", "odd:way=hang")])]
    assert told == "it did not take a step within 0.5 s"


def test_failure_is_a_line_that_names_it():
    """Kind, name and reason."""
    trial = Trial("environments", "odd:way=exit", "SystemExit: never mind")
    assert trial.line == "environment odd:way=exit fails here: SystemExit: never mind"


def test_example_of_which_a_library_is_missing_is_not_tried(odd):
    """If some of its libraries are there, somebody meant to install it: a line says what is missing."""
    odd(str({"way=1": ("json", "no_such_lib"), "way=2": ("no_such_lib",), "way=3": ("json",)}))
    registry = load_registry()
    assert [it for it in examples(registry) if it.missing and it.name.startswith("odd:")] == [
        Example("environments", "odd:way=1", ("no_such_lib",)),
        Example("environments", "odd:way=2", ("no_such_lib",)),
    ]
    assert [line for line in half_installed(registry) if "odd" in line] == [
        "missing no_such_lib for environment 'odd:way=1': pip install 'odd-env[odd]'"
    ]
