"""Which reward paid a recording: told from its rows, to the digits that they have."""

import random
from importlib.metadata import entry_points

import numpy as np
import pytest

from harness.errors import UsageError
from harness.hookspecs import PROJECT
from harness.registry import Choice, load_registry
from harness.score import compare_logs, guess_reward
from harness.score.open_steps import open_steps

HEADER = "t,beginDistance,prevBest,distance,delta_distance,reward"


@pytest.fixture
def registry():
    """The built-in plugins."""
    return load_registry()


def arp(k1, k2):
    """What ARP pays for beginDistance, best distance before the step, and distance."""
    return lambda begin, before, distance: -k1 * (distance - before) if distance > before else k2 * (begin - distance)


def write_run(path, pay, seed=0, rows=400, program="K2", reach=0.5):
    """Episodes of an arm that moves at random, in the words of either program, 7 digits a number."""
    rng, lines, step = random.Random(seed), [HEADER], 0
    begin = before = 1.110047
    for _ in range(400):
        if step == 0:
            before, distance, reward = begin, begin, 0.0
        else:
            distance = begin * (1.0 - reach) + begin * reach * 1.4 * rng.random() if rng.random() < 0.4 else distance
            reward = pay(begin, before, distance)
        after = min(before, distance)
        numbers = (begin, after, distance, distance - before, reward)
        if program == "base line":
            numbers = (begin, before, distance, reward if step == 0 else None, reward)
        texts = ["" if number is None else f"{number:.7g}".upper() for number in numbers]
        lines.append(",".join([str(step) if program == "K2" else "", *texts]))
        before = after
        step = 0 if rng.random() < 0.05 else step + 1
    path.write_text("\n".join(lines) + "\n")
    return open_steps(path)


@pytest.mark.parametrize("program", ["base line", "K2"])
@pytest.mark.parametrize(
    ("pay", "choice"),
    [
        (arp(1.0, 1.0), "baseline"),
        (arp(1.0, 1.5), "arp:k1=1,k2=1.5"),
        (arp(1.0, 2.0), "arp:k1=1,k2=2"),
        (arp(0.25, 1.11), "arp:k1=0.25,k2=1.11"),
        (arp(30.0, 12.5), "arp:k1=30,k2=12.5"),
        (lambda begin, before, distance: -distance, "dense"),
    ],
    ids=["baseline", "K2 = 1.5", "K2 = 2", "both gains", "large gains", "dense"],
)
@pytest.mark.parametrize("reach", [0.9, 0.05])
def test_the_reward_is_told_from_its_rows(tmp_path, registry, program, pay, choice, reach):
    """In either program's files, whatever the gains, and also if the arm hardly came closer."""
    recording = write_run(tmp_path / "run.csv", pay, program=program, reach=reach)
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
    recording = write_run(tmp_path / "run.csv", arp(1.0, 1.5))
    assert not misfit(recording, "arp:k2=1.500000001", registry)
    assert "arp:k2=1.501 pays" in misfit(recording, "arp:k2=1.501", registry)


def test_a_sign_that_printing_cut_is_forgiven_once_in_a_while(tmp_path, registry):
    """Two distances that print alike may have differed: the row is paid as one step away, the run is still told."""
    path = tmp_path / "run.csv"
    write_run(path, arp(1.0, 1.0), program="base line")
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
    recording = write_run(tmp_path / "run.csv", pay)
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
    told = misfit(write_run(tmp_path / "run.csv", arp(1.0, 1.0)), "arpp", registry)
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
    recording = write_run(tmp_path / "run.csv", lambda begin, before, distance: -distance)
    assert guess_reward(recording, registry).choice == "dense"
