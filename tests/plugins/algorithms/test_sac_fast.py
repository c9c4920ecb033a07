"""The lean SAC: what it shares with `sac`, and that it needs nothing but numpy."""

import subprocess
import sys
from dataclasses import fields

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from harness.algorithm import Progress
from harness_plugins.algorithms.sac import Sac
from harness_plugins.algorithms.sac_fast import SacFast
from harness_plugins.kit.algorithms import the_return_rises
from harness_plugins.kit.trainings import WatchedEnv, train


def test_settings_are_those_of_sac():
    """By name and by default: one can stand for the other in an experiment file."""
    assert [(field.name, field.default) for field in fields(SacFast)] == [
        (field.name, field.default) for field in fields(Sac)
    ]


def test_entropy_coefficient_is_read(subtests):
    """What is learned from where, and what is fixed."""
    for given, learns, first in [
        ("auto", True, 1.0),
        ("auto_0.3", True, 0.3),
        ("auto_.01", True, 0.01),
        ("auto_12.5", True, 12.5),
        ("0.2", False, 0.2),
        ("0", False, 0.0),
    ]:
        with subtests.test(given=given):
            settings = SacFast(ent_coef=given)
            assert (settings.learns_coefficient, settings.first_coefficient) == (learns, first)


def test_other_coefficients_are_refused(subtests):
    """Before anything runs: one learned by its logarithm cannot start at 0."""
    for given in ["auto_", "auto_0", "auto_0.0", "auto_0.1.2", "auto_.1.2", "-1", "much"]:
        with subtests.test(given=given), pytest.raises(ValueError, match="ent_coef"):
            SacFast(ent_coef=given)


@pytest.mark.parametrize("settings", [{"activation": "tanh"}, {"num_envs": 4, "gradient_steps": -1}])
def test_return_rises(settings):
    """On the easy task, in whatever form; with the defaults it is tested with the contract."""
    the_return_rises(SacFast(**settings))


def test_without_entropy_it_learns_too():
    """A coefficient of 0 has a logarithm that no number is, and is never asked for it."""
    policy = train(SacFast(ent_coef="0", net_arch=(8,), batch_size=16), 150).policy
    assert np.isfinite(policy.weights["mean.weight"]).all()  # type: ignore[attr-defined]


def test_threads_are_left_as_they_were():
    """One for the training, what there was for whoever comes after."""
    inside = []

    class Asking(Progress):
        def __call__(self, steps):
            inside.extend(pool["num_threads"] for pool in threadpool_info())

    env = WatchedEnv(1)
    with threadpool_limits(2):
        SacFast(net_arch=(8,), batch_size=16).train(env, 20, 0, Asking())
        after = [pool["num_threads"] for pool in threadpool_info()]
    assert set(inside) == {1}
    assert max(after) == 2


def test_no_library_of_learning_is_imported():
    """Neither torch nor stable-baselines3: it works where they are not installed."""
    code = (
        "import sys; from harness_plugins.kit.trainings import train;"
        "from harness_plugins.algorithms.sac_fast import SacFast;"
        "train(SacFast(net_arch=(8,), batch_size=16), 120);"
        "assert not {'torch', 'stable_baselines3', 'jax', 'scipy'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
