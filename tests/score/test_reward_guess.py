"""Which reward paid a recording: told from its rows, to the digits that they have."""

from importlib.metadata import entry_points

import numpy as np
import pytest

from harness import load_registry
from harness.errors import UsageError
from harness.hookspecs import PROJECT
from harness.registry import Choice
from harness.score.compare import compare_logs, guess_reward
from harness.score.open_steps import open_steps
from tests.score.conftest import HEADER, arp, write_run


def run_of(path, pay, program="K2", pace=0.2):
    """400 rows of an arm that is paid so."""
    write_run(path, pay, 0, 400, program, pace)
    return open_steps(path)


@pytest.mark.parametrize("program", ["base line", "K2"])
@pytest.mark.parametrize(
    ("pay", "choice"),
    [
        (arp(1.0), "baseline"),
        (arp(1.5), "arp:k1=1,k2=1.5"),
        (arp(2.0), "arp:k1=1,k2=2"),
        (arp(1.11, 0.25), "arp:k1=0.25,k2=1.11"),
        (arp(12.5, 30.0), "arp:k1=30,k2=12.5"),
        (lambda begin, before, distance: -distance, "dense"),
    ],
    ids=["baseline", "K2 = 1.5", "K2 = 2", "both gains", "large gains", "dense"],
)
@pytest.mark.parametrize("pace", [0.2, 0.02])
def test_the_reward_is_told_from_its_rows(tmp_path, registry, program, pay, choice, pace):
    """In either program's files, whatever the gains, and also if the arm hardly came closer."""
    recording = run_of(tmp_path / "run.csv", pay, program, pace)
    assert guess_reward(recording, registry) == (choice, "")


def misfit(recording, text, registry):
    """Where a reward does not pay a run as recorded; empty if it does."""
    try:
        compare_logs([recording], [recording], registry, baseline_reward=text)
    except UsageError as error:
        return str(error)
    return ""


def test_digits_that_printing_cut_are_no_other_reward(tmp_path, registry):
    """A gain that differs in the fourth digit is another reward; one in the ninth is the same."""
    recording = run_of(tmp_path / "run.csv", arp(1.5))
    assert not misfit(recording, "arp:k2=1.500000001", registry)
    assert "arp:k2=1.501 pays" in misfit(recording, "arp:k2=1.501", registry)


def test_a_sign_that_printing_cut_is_forgiven_once_in_a_while(tmp_path, registry):
    """Two distances that print alike may have differed: the row is paid as one step away, the run is still told."""
    path = tmp_path / "run.csv"
    run_of(path, arp(1.0), "base line")
    odd = ",1.110047,0.5,0.5,,-1.192093E-07\n"
    text = path.read_text()
    path.write_text(text + odd)
    assert guess_reward(open_steps(path), registry).choice == "baseline"
    path.write_text(text + 10 * odd)
    assert guess_reward(open_steps(path), registry).choice is None


@pytest.mark.parametrize(
    ("pay", "reason"),
    [
        (lambda begin, before, distance: begin**2 - distance**2, "no registered reward pays what {} recorded"),
        (lambda *_: 0.0, "pays nothing in its first 400 rows"),
    ],
    ids=["not registered", "zeros"],
)
def test_a_reward_that_cannot_be_told_has_a_reason(tmp_path, registry, pay, reason):
    """There is no nearest reward: none fits, or one does; zeros are what several may pay."""
    recording = run_of(tmp_path / "run.csv", pay)
    choice, told = guess_reward(recording, registry)
    assert choice is None
    assert reason.format(recording.facts.path) in told


def test_a_file_without_distances_tells_nothing(tmp_path, registry):
    """No guess is possible, and the reason says why."""
    path = tmp_path / "run.csv"
    path.write_text("reward\n1\n")
    recording, told = open_steps(path), f"{path} has no distances to score again"
    assert guess_reward(recording, registry) == (None, told)


def test_a_misfit_names_file_line_and_both_values(tmp_path, registry):
    """What was recorded beside what the reward pays, in the first row where they differ."""
    path = tmp_path / "run.csv"
    path.write_text(f"{HEADER}\n0,1,1,1,0,0\n1,1,0.5,0.5,-0.5,0.75\n")
    told = misfit(open_steps(path), "baseline", registry)
    assert told == f"The runs were not paid by baseline: {path}, line 3: recorded 0.75, baseline pays 0.5"


def test_a_reward_that_nobody_registered_cannot_be_checked(tmp_path, registry):
    """A wrong name is the user's error, not a misfit."""
    told = misfit(run_of(tmp_path / "run.csv", arp(1.0)), "arpp", registry)
    assert told.startswith("No reward 'arpp'")


# Traces


@pytest.mark.parametrize(
    ("reward", "pays", "choice"),
    [("arp:k2=3", 3.0, "arp:k2=3"), ("sparse", 0.0, "sparse"), ("arp:k2=3", 2.5, None)],
    ids=["it pays", "it pays zeros", "it has changed"],
)
def test_a_trace_was_paid_by_what_it_declares(tmp_path, registry, write_trace, reward, pays, choice):
    """Also where several envs' rows take turns; a plugin that has changed since cannot score the run again."""
    declared = Choice(reward.partition(":")[0], (), reward)
    step, env = np.divmod(np.arange(8), 2)  # each comes 0.1 m closer per step
    begin, distance, before = 1.0 + env, 1.0 + env - 0.1 * step, 1.0 + env - 0.1 * np.maximum(0, step - 1)
    columns = {
        "env": env,
        "step": step,
        "begin_distance": begin,
        "previous_best": before,
        "distance": distance,
        "delta_distance": distance - before,
        "reward": pays * (begin - distance),
    }
    found, reason = guess_reward(open_steps(write_trace(tmp_path, columns, reward=declared)), registry)
    assert found == choice
    assert choice or reason.endswith(f"recorded; not even {reward}, which its manifest declares")


def test_a_strangers_reward_that_raises_is_not_the_one(tmp_path, write_plugin):
    """Whatever a plugin's reward does, the others are tried."""
    source = """
import harness
class Broken:
    def __init__(self):
        raise RuntimeError("broken")
@harness.hookimpl
def register_rewards(register):
    register("aa-broken", __name__ + ":Broken", summary="raises")
"""
    registry = load_registry([*entry_points(group=PROJECT), write_plugin(source, "broken-reward")])
    assert "aa-broken" in registry.names("rewards")
    recording = run_of(tmp_path / "run.csv", lambda begin, before, distance: -distance)
    assert guess_reward(recording, registry).choice == "dense"
