import json

import numpy as np
import pytest

from tests.results.recordings.conftest import record

ARMS = np.linspace(0.0, 1.0, 10)


@pytest.fixture
def recorded(harness, tmp_path):
    """Two rewards, three seeds, in the folder ``runs``."""
    for seed in range(3):
        for reward in ("plain", "thrice"):
            record(tmp_path / "runs" / f"{reward}-{seed}", reward, seed, ARMS + 0.01 * seed)
    return tmp_path / "runs"


def test_report_shows_the_answer_first_then_what_rewards_pay(harness, recorded):
    """A line for the comparison, both answers in sentences, and what shows more."""
    answer = harness("report runs")
    assert (answer.status, answer.err) == (0, "")
    wanted = ("CANNOT TELL", "An episode is paid", "--details")
    places = [answer.out.index(told) for told in wanted]
    assert places == sorted(places)


def test_eta_shows_all_of_it(harness, recorded):
    """As `harness report --details` does."""
    told = harness("eta runs").out
    assert told == harness("report runs --details").out
    for part in ("of it ruler", "of it behaviour", "pay, in its last fifth", "eta_P", "Behaviour over the training"):
        assert part in told


def test_no_word_is_of_a_robot(harness, recorded):
    """The env has none."""
    combinations = harness("report runs --json").json["combinations"]
    told = harness("eta runs").out + harness("report runs").out + json.dumps(combinations)
    for word in ("robot", "simulator", "arm's", "FD100", "end effector", "target", "ground", "shaped"):
        assert word not in told


@pytest.mark.parametrize("command", ["eta", "report"])
def test_json_is_all_that_goes_to_standard_output(harness, recorded, command):
    """The same from both commands."""
    answer = harness(command, "runs", "--json")
    data = answer.json
    assert (answer.status, answer.err) == (0, "")
    assert (data["format"], len(data["combinations"])) == (2, 1)
    (comparison,) = data["combinations"]
    ratio = comparison["returns"]["over the training"]["ratio"]
    assert ratio["ruler"]["value"] * ratio["behaviour"]["value"] == pytest.approx(ratio["eta"]["value"])
    assert len(comparison["learning"]["metrics"]["success"]["baseline"]) == 20


@pytest.mark.parametrize("flags", ["report runs --html page.html", "eta runs --plot page.html"])
def test_the_page_is_written(harness, recorded, tmp_path, flags):
    """Where it is told, and the answer is printed too."""
    pytest.importorskip("jinja2")
    answer = harness(flags)
    told = "This is what harness report runs --details prints\n" * flags.startswith("eta")
    assert (answer.status, answer.err) == (0, f"Report: page.html\n{told}")
    assert "CANNOT TELL" in answer.out
    assert "Bandit-v0" in (tmp_path / "page.html").read_text()


def test_the_curve_of_the_indices_can_be_chosen(harness, recorded):
    """As of recorded runs."""
    assert harness("eta runs --curve per-step --json").json["curve"] == "per-step"


def test_a_damaged_recording_is_told(harness, recorded):
    """The rest is shown, and the exit status is 1."""
    (recorded / "plain-2" / "recording-0.json").write_text("{}")
    answer = harness("report runs")
    assert (answer.status, answer.err.count("\n")) == (1, 1)
    assert answer.err.startswith("harness: damaged: ")
    assert "INTERIM" in answer.out
    assert "report runs --details --leave-out runs/plain-2" in harness("report runs --leave-out runs/plain-2").out
    without = harness("report runs --leave-out runs/plain-2 --json")
    assert (without.status, without.json["combinations"][0]["headline"]["answer"]) == (0, "cannot tell")
    assert without.json["combinations"][0]["trained"] == {"baseline": [0, 1], "proposed": [0, 1, 2]}


def test_one_reward_alone_is_told(harness, recorded):
    """What it paid for."""
    answer = harness("report runs/plain-0")
    assert answer.status == 0
    assert answer.out.startswith("What did plain pay for? 1 training")
