"""Calls the command line in this process, with the toy package installed."""

import shutil
import sys
from collections.abc import Callable, Iterator
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
def scripted_policies_act_once() -> Iterator[None]:
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
def screens_search_for_a_moment() -> Iterator[None]:
    """Whatever ``--screen`` looks for: what it finds then is tested with the screen."""
    find_in = find.find_in

    def find_quickly(world, asked, *given, **named):
        short = replace(asked, budget=1_000, starts=1) if asked == SCREENED else asked
        return find_in(world, short, *given, **named)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(find, "find_in", find_quickly)
        yield


class Answer(NamedTuple):
    """What a command left."""

    status: int
    out: str
    err: str


@pytest.fixture
def harness(toys, tmp_path, monkeypatch, capsys) -> Callable[..., Answer]:
    """Run `harness` with these arguments, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")

    def call(*arguments: object) -> Answer:
        with pytest.raises(SystemExit) as stopped:
            main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        return Answer(stopped.value.code, out, err)

    return call


QUICK = ("--sim", "ideal", "--algo", "wander", "--steps", "12", "--evaluation-episodes", "2", "--executor", "here")


@pytest.fixture
def quick() -> tuple[str, ...]:
    """Flags of a run that takes a moment: an ideal arm that acts at random."""
    return QUICK


@pytest.fixture
def finished(harness, tmp_path, tmp_path_factory) -> Callable[..., str]:
    """Get a finished experiment of some seeds per reward as the folder `mine`; it runs once, and is copied."""

    def copy(seeds: int) -> str:
        kept = tmp_path_factory.getbasetemp() / "finished" / str(seeds)
        if not kept.exists():
            kept.parent.mkdir(exist_ok=True)
            assert harness("run", *QUICK, "--reward", "arp", "--seeds", seeds, "--out", "finished").status == 0
            shutil.move(tmp_path / "finished", kept)
        shutil.copytree(kept, tmp_path / "mine")
        return "mine"

    return copy


@pytest.fixture
def rendering(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Let the doctor try to render by the program `true` or `false`, which end at once, and not by Python.

    It takes seconds, and is tested with the simulator.
    """
    return lambda program: monkeypatch.setattr(sys, "executable", shutil.which(program))
