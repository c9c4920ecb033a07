"""Logs that anybody left, given to ``harness report`` and ``harness eta``: sorted, told, compared or refused."""

import csv
import json

import numpy as np
import pytest
from numpy.random import default_rng

NO_STEPS = "An index of steps, I_N or I_P, needs the reward of each environment step"


def write_monitor(path, returns, lengths, success=None, *, started=1e9):
    """A file as stable-baselines3's Monitor writes it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    started += 1e5 * sum(map(ord, path.name))  # seeds one after the other
    rows = [
        [f"{pay:.6f}", int(length), number] for number, (pay, length) in enumerate(zip(returns, lengths, strict=True))
    ]
    if success is not None:
        rows = [[*row, bool(flag)] for row, flag in zip(rows, success, strict=True)]
    with path.open("w", newline="") as file:
        file.write(f"#{json.dumps({'t_start': started, 'env_id': 'Toy-v0'})}\n")
        csv.writer(file, lineterminator="\n").writerows(
            [["r", "l", "t"] + ["is_success"] * (success is not None), *rows]
        )


@pytest.fixture
def monitors(tmp_path):
    """Writes trainings of two rewards by shares of success; by reward and seed, success with the step at each end."""

    def write(base, prop, seeds=5, episodes=200):
        rng, told = default_rng(1), {}
        for reward, share in (("base", base), ("prop", prop)):
            for seed in range(seeds):
                success = rng.random(episodes) < np.clip(share + rng.normal(0, 0.04), 0, 1)
                lengths = rng.integers(20, 40, episodes)
                path = tmp_path / reward / f"{seed}.monitor.csv"
                write_monitor(path, rng.normal(size=episodes), lengths, success, started=1e9 + 1e5 * seed)
                told[reward, seed] = np.stack([success, np.cumsum(lengths)])
        return told

    return write


def test_what_was_found_comes_before_the_first_number(harness, monitors):
    """Trainings, rewards, seeds, what decides, the budget; then the answer; then why there is no eta of steps."""
    monitors(0.2, 0.8)
    answer = harness("report .")
    out = " ".join(answer.out.split())
    assert answer.status == 0
    assert out.startswith("10 trainings of 2 rewards: `base` 5, `prop` 5; the baseline is `base`; success decides.")
    places = [out.index(text) for text in ("10 trainings", "All are cut to the", "HELPS", NO_STEPS)]
    assert places == sorted(places)
    assert "eta_N" not in out


def test_eta_of_a_folder_and_of_patterns_say_the_same(harness, monitors):
    """Both sort the same files; the reward's names come from what differs."""
    monitors(0.2, 0.8)
    folder = harness("eta . --json").json
    patterns = harness("eta --baseline 'base/*' --proposed 'prop/*' --json").json
    assert folder["combinations"] == patterns["combinations"]


def test_labels_of_episodes_may_lie_among_the_logs(harness, tmp_path):
    """A table of runs, episodes and success looks like a log; it is the one that was named as labels."""
    lines = ["run,episode,success"]
    for reward in ("base", "prop"):
        for seed in range(4):
            write_monitor(tmp_path / reward / f"{seed}.monitor.csv", np.arange(10.0) + seed + ord(reward[0]), [10] * 10)
            lines += [f"{reward}/{seed},{number},{int(reward == 'prop' and number > 4)}" for number in range(10)]
    (tmp_path / "labels.csv").write_text("\n".join(lines))
    (found,) = harness("report . --labels labels.csv --json").json["combinations"]
    (change,) = [it for it in found["behaviour"] if it["manner"] == "over the training"]
    assert [set(of.values()) for of in change["trainings"].values()] == [{0.0}, {0.5}]


def test_the_page_says_how_logs_were_sorted(harness, monitors, tmp_path):
    """Before the answer, as the terminal does."""
    pytest.importorskip("jinja2", reason="needs the extra report")
    monitors(0.2, 0.8)
    assert harness("report . --html page.html").status == 0
    page = (tmp_path / "page.html").read_text()
    assert page.index("10 trainings of 2 rewards") < page.index("HELPS" if "HELPS" in page else "helps")


def test_the_command_for_all_numbers_says_how_logs_are_sorted(harness, monitors):
    """Typed again without these flags, it would sort them by itself."""
    monitors(0.2, 0.8, seeds=4)
    told = " ".join(harness("report . --sort '{reward}/{seed}' --baseline prop").out.split())
    assert "--details --sort '{reward}/{seed}' --baseline prop" in told
