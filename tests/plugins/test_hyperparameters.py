"""Bounds of hyperparameters that several algorithms have."""

import pytest
from pydantic import TypeAdapter, ValidationError

from harness.algorithm import IN_ENVIRONMENTS
from harness.registry.members import parameters_of
from harness_plugins.hyperparameters import MOST_ENVS, NumEnvs
from tests.registered import REGISTRY


def test_so_many_envs_train_at_most():
    """All are in memory."""
    envs = TypeAdapter(NumEnvs)
    assert envs.validate_python(MOST_ENVS) == 10_000
    with pytest.raises(ValidationError):
        envs.validate_python(MOST_ENVS + 1)


def test_every_algorithm_with_a_discount_has_the_fields_in_an_environment(subtests):
    """And declares nothing else: all other defaults are the same everywhere."""
    for name in REGISTRY.names("algorithms"):
        with subtests.test(name=name):
            target = REGISTRY.get("algorithms", name).load()
            has_discount = "gamma" in {parameter.name for parameter in parameters_of(target)}
            assert dict(getattr(target, IN_ENVIRONMENTS, {})) == ({"gamma": 0.99} if has_discount else {})
