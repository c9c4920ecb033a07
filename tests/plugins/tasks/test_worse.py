"""The FD100's task under worse conditions."""

import pytest

from harness.registry import choose
from harness_plugins.tasks.worse import ClutteredReach, DelayedReach, NoisyReach, VariedReach
from tests.registered import REGISTRY


@pytest.mark.parametrize("name", ["noisy-reach", "delayed-reach", "cluttered-reach", "varied-reach"])
def test_what_a_preset_is_about_belongs_to_its_identity(name):
    """A later version with another default makes other cells; what it leaves at nothing is left out."""
    choice = choose(REGISTRY, "tasks", name)
    built = choice.build(REGISTRY, "tasks")
    plain = choose(REGISTRY, "tasks", "fd100-reach").build(REGISTRY, "tasks")
    own = {field for field in plain.later if getattr(built, field) != getattr(plain, field)}
    assert own
    assert own <= set(choice.to_json()["params"])
    assert not (set(plain.later) - own) & set(choice.to_json()["params"])


def test_the_plain_task_is_the_same_cell_as_ever():
    """None of the new parameters is in it."""
    choice = choose(REGISTRY, "tasks", "fd100-reach")
    assert not set(choice.to_json()["params"]) & set(choice.build(REGISTRY, "tasks").later)


@pytest.mark.parametrize("task", [NoisyReach(), DelayedReach(), ClutteredReach(), VariedReach()])
def test_presets_change_something(task):
    """Or they would be the plain task by another name."""
    assert not task.are_plain
