"""The examples of docs/your-environment.md and docs/recording.md: each is run as it stands, with fewer steps."""

import os
import re
import runpy
import subprocess
import sys
from typing import Any

import gymnasium
import pytest

from harness.cli.app import main
from harness.record import read_recording
from tests.project import ROOT, page_of

DOCS = ROOT / "docs"
PAGE = "".join(page_of(name) for name in ("your-environment", "recording"))
EXAMPLES = re.findall(r"^```python\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
STEPS = 64
VERDICT = "from harness import RecordRewards, evaluate_policy"


def _run(folder, monkeypatch, needle, **told):
    """Run the one example that holds `needle`, in `folder`; rollouts of PPO are as short as its training.

    `told` is what a reader is told to write in place of a word.
    """
    (example,) = [text for text in EXAMPLES if needle in text]
    for word, other in told.items():
        example = example.replace(word, other)
    short = example.replace("20_000", str(STEPS)).replace('PPO("MlpPolicy", env,', 'PPO("MlpPolicy", env, n_steps=64,')
    monkeypatch.chdir(folder)
    short = short.replace("range(6)", "range(2)").replace('"evaluation", ', '"evaluation", episodes=1, ')
    (folder / "example.py").write_text(short.replace("n_steps=512", "n_steps=16"))
    return runpy.run_path("example.py")


def _recorded(folder, path):
    training = read_recording(folder / path)
    assert (training.facts.failures, training.facts.paid_otherwise, training.facts.closed) == ((), "", True)
    return training


def test_every_example_is_run():
    """None is forgotten here."""
    assert len(EXAMPLES) == 9


def test_first_example_is_short():
    """A training is recorded in few lines."""
    assert len([line for line in EXAMPLES[1].splitlines() if line.strip()]) <= 17


def test_training_is_shown_by_two_lines(tmp_path, monkeypatch):
    """A callback records what a wrapper would."""
    pytest.importorskip("stable_baselines3")
    _run(tmp_path, monkeypatch, "WatchCallback", **{'"Pendulum-v1", seed=0': '"Pendulum-v1", n_steps=64, seed=0'})
    assert len(_recorded(tmp_path, "runs/seen")["step"]) == STEPS


def test_first_training_is_recorded_and_read(tmp_path, monkeypatch, capsys):
    """By stable-baselines3; the next example reads it."""
    pytest.importorskip("stable_baselines3")
    _run(tmp_path, monkeypatch, 'runs/own-0",\n')
    training = _recorded(tmp_path, "runs/own-0")
    assert len(training) == STEPS
    assert training.facts.rewards == ("upright", "own")
    assert "return float(next_observation[0])" in training.facts.sources["reward/upright"].text
    _run(tmp_path, monkeypatch, "print(training.facts.rewards")
    assert capsys.readouterr().out.startswith("('upright', 'own') own 0\n")
    duckdb = pytest.importorskip("duckdb")
    (query,) = re.findall(r'duckdb -c "([^"]*)"', PAGE)
    (row,) = duckdb.sql(query).fetchall()
    assert row == pytest.approx((0, *(training[f"reward/{name}"].sum() for name in ("own", "upright"))))


def test_verdict_takes_15_lines():
    """With the installation and the report."""
    (example,) = [text for text in EXAMPLES if VERDICT in text]
    assert len([line for line in example.splitlines() if line.strip()]) + 2 <= 15


def test_report_on_both_rewards(tmp_path, monkeypatch, capsys):
    """Trainings too short for an episode, two seeds: the evaluations tell, and what they cannot is said."""
    pytest.importorskip("stable_baselines3")
    _run(tmp_path, monkeypatch, VERDICT)
    done = capsys.readouterr().out.splitlines()
    assert len(done) == 4
    assert all(line.startswith("runs/") and line.endswith(" is done") for line in done)
    _run(tmp_path, monkeypatch, VERDICT)
    assert capsys.readouterr().out == ""  # what is finished is not done again
    for trained_with in ("own", "calm"):
        for seed in range(2):
            training = _recorded(tmp_path, f"runs/{trained_with}-{seed}")
            assert (training.facts.trained_with, training.facts.seed, len(training)) == (trained_with, seed, STEPS)
    capsys.readouterr()
    with pytest.raises(SystemExit, match="0"):
        main(["report", "runs", "--details"])
    told = " ".join(capsys.readouterr().out.split())
    assert "rests on evaluations of the final policies, 1 episode or more of each seed" in told
    assert "over the training: n/a: own in 'runs/own-0': no episode ended" in told


@pytest.mark.filterwarnings("error")
def test_normalisation_stands_on_its_side(tmp_path, monkeypatch):
    """Nothing has to be told of it, and the pay is recorded as it is."""
    _run(tmp_path, monkeypatch, "NormalizeReward(harness")
    training, evaluation = (_recorded(tmp_path, path) for path in ("runs/normal", "runs/normal/evaluation"))
    assert (training.facts.pay, training.facts.notes, evaluation.facts.notes) == (True, (), ())
    assert (len(training), evaluation.facts.episodes_asked) == (1, 2)


def test_memory_is_recorded(tmp_path, monkeypatch):
    """What it pays in an episode comes to its highest cosine above -1."""
    _run(tmp_path, monkeypatch, "class Progress")
    assert 0 < _recorded(tmp_path, "runs/memory")["reward/progress"].sum() <= 2


def test_four_envs_of_stable_baselines3_are_recorded(tmp_path, monkeypatch):
    """As one training."""
    pytest.importorskip("stable_baselines3")
    _run(tmp_path, monkeypatch, "DummyVecEnv([")
    training = _recorded(tmp_path, "runs/four")
    assert (training.facts.num_envs, len(training), training.facts.seed) == (4, STEPS, 0)
    assert sorted(set(training["env"].tolist())) == [0, 1, 2, 3]


def test_training_of_sbx_is_recorded(tmp_path, monkeypatch):
    """By the first example, with the two words that the page names; where sbx is installed."""
    pytest.importorskip("sbx")
    assert "write `from sbx import SAC`, and `SAC` for `PPO`" in " ".join(PAGE.split())
    _run(tmp_path, monkeypatch, 'runs/own-0",\n', stable_baselines3="sbx", PPO="SAC")
    assert len(_recorded(tmp_path, "runs/own-0")) == STEPS


def test_batch_is_recorded(tmp_path, monkeypatch):
    """By both kinds of functions."""
    _run(tmp_path, monkeypatch, "RecordVectorRewards(")
    training = _recorded(tmp_path, "runs/batch")
    assert len(training) == STEPS
    assert (training["reward/calm"] <= 0).all()


def test_env_of_rllib_is_recorded(tmp_path, monkeypatch):
    """What RLlib is given makes an env that records under its worker's number."""

    class Context(dict[str, Any]):
        worker_index = 2

    names = _run(tmp_path, monkeypatch, "make_recorded")
    for context in (names["env_config"], Context(names["env_config"])):
        env = names["make_recorded"](context)
        assert isinstance(env, gymnasium.Env)
        env.reset(seed=0)
        env.step(env.action_space.sample())
        env.close()
    assert len(_recorded(tmp_path, "runs/rllib")) == 2


@pytest.mark.slow
def test_rllib_trains(tmp_path):
    """With an env of the page, where RLlib is installed."""
    pytest.importorskip("ray.rllib", exc_type=ImportError)
    (example,) = [text for text in EXAMPLES if "make_recorded" in text]
    script = example + (
        "from ray.rllib.algorithms.ppo import PPOConfig\nfrom ray.tune import register_env\n"
        "register_env('recorded', make_recorded)\n"
        "config = PPOConfig().environment('recorded', env_config=env_config).env_runners(num_env_runners=1)\n"
        "algorithm = config.training(train_batch_size=200, minibatch_size=100).build_algo()\n"
        "algorithm.train()\nalgorithm.stop()\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True, cwd=tmp_path, env={**os.environ, "RAY_DEDUP_LOGS": "0"})
    assert len(read_recording(tmp_path / "runs" / "rllib")) >= 200
