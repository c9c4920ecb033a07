"""Logs that anybody left, given to ``harness report`` and ``harness eta``: sorted, told, compared or refused."""

import csv
import json

import numpy as np
import pytest

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
        rng, told = np.random.default_rng(1), {}
        for reward, share in (("base", base), ("prop", prop)):
            for seed in range(seeds):
                success = rng.random(episodes) < np.clip(share + rng.normal(0, 0.04), 0, 1)
                lengths = rng.integers(20, 40, episodes)
                path = tmp_path / reward / f"{seed}.monitor.csv"
                write_monitor(path, rng.normal(size=episodes), lengths, success, started=1e9 + 1e5 * seed)
                told[reward, seed] = np.stack([success, np.cumsum(lengths)])
        return told

    return write


def last_fifth(told):
    """Success in the episodes that ended in the last fifth of the shortest training."""
    shortest = min(ends[-1] for _, ends in told.values())
    return {
        key: success[(ends > round(0.8 * shortest)) & (ends <= shortest)].mean()
        for key, (success, ends) in told.items()
    }


def chance(values):
    """How often shuffled names give a difference as large, of 20,000 times."""
    base, prop = ([value for (name, _), value in values.items() if name == reward] for reward in ("base", "prop"))
    rng, both = np.random.default_rng(0), np.array([*base, *prop])
    seen = abs(np.mean(prop) - np.mean(base))
    drawn = np.array([rng.permutation(both) for _ in range(20_000)])
    shuffled = drawn[:, : len(base)].mean(axis=1) - drawn[:, len(base) :].mean(axis=1)
    return float((np.abs(shuffled) >= seen - 1e-12).mean())


@pytest.mark.parametrize(("base", "prop", "answer"), [(0.4, 0.7, "helps"), (0.7, 0.4, "hurts")])
def test_forty_monitor_files_are_answered(harness, monitors, base, prop, answer):
    """Success by seed is what the test computes itself, and chance alone gives such a difference as rarely."""
    expected = last_fifth(monitors(base, prop, seeds=20, episodes=1_000))
    data = harness("report . --json").json
    trainings = {(it["trained_by"], it["seed"]): it["parts"]["in its last fifth"] for it in data["trainings"]}
    assert {key: it["behaviour"]["success"] for key, it in trainings.items()} == pytest.approx(expected)
    assert chance(expected) < 0.001
    (found,) = data["combinations"]
    assert found["headline"]["answer"] == answer
    assert found["test"]["p"] < 0.001
    assert data["notes"][0].startswith(
        "40 trainings of 2 rewards: `base` 20, `prop` 20; the baseline is `base`; success"
    )


def test_no_difference_is_no_verdict(harness, monitors):
    """Equal shares of success: chance gives such a difference often, and nothing is called better."""
    expected = last_fifth(monitors(0.5, 0.5))
    (found,) = harness("report . --json").json["combinations"]
    assert chance(expected) > 0.05
    assert found["headline"]["answer"] == "cannot tell"


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


def test_returns_alone_give_no_verdict(harness, tmp_path):
    """Two rewards on two scales: no number compares them, and the flags that would help are named."""
    for reward in ("base", "prop"):
        for seed in range(3):
            write_monitor(tmp_path / reward / f"{seed}.monitor.csv", np.arange(9.0) + seed + len(reward), [10] * 9)
    answer = harness("eta --baseline 'base/*' --proposed 'prop/*'")
    out = " ".join(answer.out.split())
    assert answer.status == 0
    assert "only returns are told, and returns of two rewards are not comparable. --labels FILE" in out
    assert "CANNOT TELL" in out
    assert "times that with" not in out
    assert "The verdict rests" not in out


def test_labels_from_outside_decide(harness, tmp_path):
    """A person watched the policies: what they say of each training is tested like any success."""
    lines = ["run,success"]
    for reward in ("base", "prop"):
        for seed in range(5):
            write_monitor(tmp_path / reward / f"{seed}.monitor.csv", np.arange(9.0) + seed + ord(reward[0]), [10] * 9)
            lines.append(f"{reward}/{seed},{int(reward == 'prop')}")
    (tmp_path / "labels.csv").write_text("\n".join(lines))
    (found,) = harness("report . --labels labels.csv --json").json["combinations"]
    (change,) = [it for it in found["behaviour"] if it["manner"] == "in evaluations"]
    assert (found["headline"]["answer"], change["baseline"], change["proposed"]) == ("helps", 0.0, 1.0)


def test_labels_of_episodes_may_lie_among_the_logs(harness, tmp_path):
    """A table of runs, episodes and success looks like a log; it is the one that was named as labels."""
    lines = ["run,episode,success"]
    for reward in ("base", "prop"):
        for seed in range(4):
            write_monitor(tmp_path / reward / f"{seed}.monitor.csv", np.arange(10.0) + seed + ord(reward[0]), [10] * 10)
            lines += [f"{reward}/{seed},{number},{int(reward == 'prop' and number > 4)}" for number in range(10)]
    (tmp_path / "labels.csv").write_text("\n".join(lines))
    data = harness("report . --labels labels.csv --json").json
    shares = [it["parts"]["over the training"]["behaviour"]["success"] for it in data["trainings"]]
    assert shares == [0.0] * 4 + [0.5] * 4


def test_lengths_decide_if_the_user_says_which_are_better(harness, tmp_path):
    """A shorter episode reaches its target sooner: half as long is better."""
    for reward, length in (("base", 40), ("prop", 20)):
        for seed in range(5):
            write_monitor(tmp_path / reward / f"{seed}.monitor.csv", np.arange(40.0) + seed, [length + seed] * 40)
    (found,) = harness("report . --measure length:better=lower --json").json["combinations"]
    assert (found["headline"]["answer"], found["headline"]["decided_by"]) == ("helps", "length")


def test_tables_of_episodes_are_read_as_episodes(harness, tmp_path):
    """A column ``reward`` with a row for each episode: 5 seeds of each, and no index of steps."""
    for reward, level in (("episode-base", -20), ("episode-prop", -12)):
        for seed in range(5):
            rows = [f"{number},{level + number / 20 + seed / 7:.6f},200" for number in range(100)]
            (tmp_path / reward).mkdir(exist_ok=True)
            (tmp_path / reward / f"{seed}.csv").write_text("\n".join(["episode,reward,length", *rows]) + "\n")
    answer = harness("eta --baseline 'episode-base/*' --proposed 'episode-prop/*' --json")
    data = answer.json
    assert data["notes"][0].startswith("10 trainings of 2 rewards: `base` 5, `prop` 5")
    assert data["steps"] == 100 * 200
    (one,) = [it for it in data["trainings"] if (it["trained_by"], it["seed"]) == ("base", 2)]
    assert one["parts"]["over the training"]["returns"]["base"] == pytest.approx(-20 + 4.95 / 2 + 2 / 7, abs=1e-6)
    assert any(line.startswith(NO_STEPS) for line in data["notes"])


def test_an_exported_chart_holds_several_trainings(harness, tmp_path):
    """Columns of W&B's export are sorted by the names of their runs, and said to be sampled.

    A value stands in the middle between its point and the one before: from 0 at 0.5 to 245 at 4,850, on lines.
    """
    runs = [f"{reward}-seed{seed}" for reward in ("base", "prop") for seed in range(3)]
    head = ["Step", *(f"{run} - charts/episodic_return{end}" for run in runs for end in ("", "__MIN", "__MAX"))]
    rows = [[100 * step, *(step * (number + 1) for number in range(6) for _ in range(3))] for step in range(50)]
    with (tmp_path / "wandb_export.csv").open("w", newline="") as file:
        csv.writer(file, quoting=csv.QUOTE_ALL).writerows([head, *rows])
    data = harness("eta wandb_export.csv --json").json
    means = {(it["trained_by"], it["seed"]): it["parts"]["over the training"] for it in data["trainings"]}
    assert means.keys() == {(reward, seed) for reward in ("base", "prop") for seed in range(3)}
    assert means["prop", 1]["returns"]["prop"] == pytest.approx(123.75, abs=1e-3)
    assert any("samples a curve" in line for line in data["notes"])
    assert any("means of returns" in line for line in data["notes"])


def test_copies_of_one_table_of_progress_are_one_training(harness, tmp_path):
    """Three files with the same rows: it is told, and what is left is shown alone."""
    for number in range(3):
        rows = [f"{step},{step},{4000 * step}" for step in range(50)]
        head = "env_runners/episode_return_mean,training_iteration,num_env_steps_sampled_lifetime"
        (tmp_path / f"progress{number}.csv").write_text("\n".join([head, *rows]) + "\n")
    data = harness("eta . --json").json
    assert data["notes"][0].startswith("1 training of 1 reward")
    assert sum("the training counts once" in line for line in data["notes"]) == 2


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
