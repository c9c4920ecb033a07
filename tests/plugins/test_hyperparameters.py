"""Bounds of hyperparameters that several algorithms have."""

import pytest
from pydantic import TypeAdapter, ValidationError

from harness_plugins.hyperparameters import MOST_ENVS, NumEnvs


def test_so_many_envs_train_at_most():
    """All are in memory."""
    envs = TypeAdapter(NumEnvs)
    assert envs.validate_python(MOST_ENVS) == 10_000
    with pytest.raises(ValidationError):
        envs.validate_python(MOST_ENVS + 1)
