"""What the logs of RL Baselines3 Zoo tell of their training."""

from collections import OrderedDict

import numpy as np
import pytest
import yaml

from harness_plugins.logs.evaluations import Evaluations
from harness_plugins.logs.table import Table
from harness_plugins.zoo_settings import ZooSettings, zoo_settings


def trained(folder, args, config):
    """A folder of the zoo, whose two files PyYAML writes as the zoo's own code has it do; its Monitor file."""
    inner = folder / "CartPole-v1"
    inner.mkdir()
    for name, told in (("args.yml", args), ("config.yml", config)):
        with (inner / name).open("w") as file:
            yaml.dump(OrderedDict(sorted(told.items())), file)
    path = folder / "0.monitor.csv"
    path.write_text('#{"t_start": 1.5, "env_id": "CartPole-v1"}\nr,l,t\n9.0,9,0.5\n8.0,8,1.0\n')
    return path


class EnvironmentName(str):
    """The zoo's own class of ids, which PyYAML writes with its tag."""


ARGS = {
    "algo": "ppo",
    "env": EnvironmentName("CartPole-v1"),
    "n_timesteps": -1,
    "seed": 3344556677,
    "device": "auto",
    "hyperparams": None,
    "gym_packages": [],
    "env_kwargs": {"seed": 5},
}


def test_monitor_and_evaluations_tell_the_seed_the_algorithm_and_the_budget(tmp_path):
    """The budget from the tuned settings where none was typed."""
    path = trained(tmp_path, ARGS, {"n_envs": 8, "n_timesteps": 100000.0, "policy": "MlpPolicy"})
    np.savez(tmp_path / "evaluations.npz", timesteps=[5], results=[[1.0, 2.0]])
    for [log] in (Table().read(path), Evaluations().read(tmp_path / "evaluations.npz")):
        facts = log.facts
        assert (facts.env, facts.algorithm, facts.seed) == ("CartPole-v1", "ppo", 3344556677)
        assert facts.asked == 100_000


def test_a_budget_that_was_typed_goes_before_the_tuned_one(tmp_path):
    """As the zoo has it."""
    assert zoo_settings(trained(tmp_path, {**ARGS, "n_timesteps": 5000}, {"n_timesteps": 100000.0})).asked == 5000


@pytest.mark.parametrize("text", ["", "seed: 1", "- - - seed\n    - one\n", "\x00", "- - - seed\n    - nan\n"])
def test_files_that_say_nothing_give_nothing(tmp_path, text):
    """But the environment, whose name the folder has."""
    path = trained(tmp_path, ARGS, {})
    (tmp_path / "CartPole-v1" / "args.yml").write_text(text)
    assert zoo_settings(path) == ZooSettings("CartPole-v1")


def test_two_trainings_in_one_folder_give_nothing(tmp_path):
    """Nobody knows whose log it is."""
    path = trained(tmp_path, ARGS, {})
    (tmp_path / "Other-v1").mkdir()
    (tmp_path / "Other-v1" / "args.yml").write_text("- - - seed\n    - 7\n")
    assert zoo_settings(path) == ZooSettings()
    assert zoo_settings(path, "Other-v1").seed == 7
    assert zoo_settings(tmp_path / "missing" / "x.csv") == ZooSettings()
