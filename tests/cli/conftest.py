"""Calls the command line in this process, with the toy package installed."""

import json
import shlex
import shutil
import sys
from dataclasses import replace
from typing import NamedTuple

import pytest

from harness.cli import main
from harness.payoff import rollout
from harness.registry.sources import description
from harness_plugins.audit import Cheats
from harness_plugins.audit.search import find

SCREENED = find.Search(Cheats().steps, Cheats().starts)


@pytest.fixture(scope="package", autouse=True)
def scripted_policies_act_once():
    """Of a robot and a task, and not for every report: what they do follows from these alone."""
    known, record = {}, rollout.record_rollouts

    def recall(simulator, robot, task, episodes, noise=0.0):
        asked = (description(simulator), robot.digest, description(task), episodes, noise)
        if asked not in known:
            known[asked] = record(simulator, robot, task, episodes, noise)
        return known[asked]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rollout, "record_rollouts", recall)
        yield


@pytest.fixture(scope="package", autouse=True)
def screens_search_for_a_moment():
    """Whatever ``--screen`` looks for: what it finds then is tested with the screen."""
    find_in = find.find_in

    def find_quickly(world, asked, *given, **named):
        return find_in(world, replace(asked, budget=1_000, starts=1) if asked == SCREENED else asked, *given, **named)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(find, "find_in", find_quickly)
        yield


class Answer(NamedTuple):
    """What a command left."""

    status: int
    out: str
    err: str

    @property
    def json(self):
        """What it printed for programs."""
        return json.loads(self.out)


@pytest.fixture
def harness(toys, tmp_path, monkeypatch, capsys):
    """Run `harness` in an empty folder: the line that one types, and arguments that stand behind it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")

    def call(line="", *arguments):
        with pytest.raises(SystemExit) as stopped:
            main([*shlex.split(line), *map(str, arguments)])
        out, err = capsys.readouterr()
        return Answer(stopped.value.code, out, err)

    return call


@pytest.fixture
def refused(harness, tmp_path):
    """Type a line that cannot be done, as `harness` does: what is said of it, in one line. Nothing is changed."""

    def contents():
        found = (it for it in tmp_path.rglob("*") if "derived" not in it.parts)  # what a report reads is kept there
        return {str(it): it.read_bytes() if it.is_file() else b"" for it in found}

    def call(line, *arguments):
        before = contents()
        answer = harness(line, *arguments)
        assert (answer.status, answer.out, answer.err[:9], answer.err.count("\n")) == (2, "", "harness: ", 1)
        assert contents() == before
        return " ".join(answer.err.split())

    return call


QUICK = ("--sim", "ideal", "--algo", "wander", "--steps", "12", "--evaluation-episodes", "2", "--executor", "here")


@pytest.fixture
def quick():
    """Flags of a run that takes a moment: an ideal arm that acts at random."""
    return QUICK


@pytest.fixture(scope="session")
def typed():
    """What the lines of `trained` answered."""
    return {}


@pytest.fixture
def trained(harness, tmp_path, tmp_path_factory, typed):
    """What a line answers that leaves the folder `mine`: it is typed once in a session, and the folder is copied."""

    def copy(line, *arguments):
        whole = shlex.join([line, *map(str, arguments)])
        kept = tmp_path_factory.getbasetemp() / "trained" / str([*typed, whole].index(whole))
        if whole not in typed:
            typed[whole] = harness(line, *arguments)
            kept.parent.mkdir(exist_ok=True)
            shutil.move(tmp_path / "mine", kept)
        shutil.copytree(kept, tmp_path / "mine")
        return typed[whole]

    return copy


@pytest.fixture
def finished(trained):
    """Get a finished experiment of some seeds per reward as the folder `mine`."""

    def copy(seeds):
        assert trained(f"run --reward arp --seeds {seeds} --out mine", *QUICK).status == 0
        return "mine"

    return copy


@pytest.fixture
def experiment(finished):
    """A finished experiment of a seed per reward."""
    return finished(seeds=1)


@pytest.fixture
def rendering(monkeypatch):
    """Let the doctor try to render by the program `true` or `false`, which end at once, and not by Python.

    It takes seconds, and is tested with the simulator.
    """
    return lambda program: monkeypatch.setattr(sys, "executable", shutil.which(program))
