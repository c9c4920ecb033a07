"""What is declared decides what belongs; what is not there is a gap."""

from pathlib import Path

import pytest

from harness.errors import SchemaError
from harness_plugins.datasets.dataset import take_census

PLACE = Path("d")


def test_what_is_as_declared_has_no_note():
    """What is as declared has no note."""
    found = take_census(PLACE, {0: 3, 1: 4}, partial=False, episodes=2, steps=7, listed=(0, 1), lengths={0: 3, 1: 4})
    assert found == ({0, 1}, [])


def test_metadata_that_declares_nothing_takes_all():
    """Metadata that declares nothing takes all."""
    assert take_census(PLACE, {4: 3, 9: 1}, partial=False)[0] == {4, 9}


def test_episodes_beside_the_list_are_left_out_and_told():
    """Episodes beside the list are left out and told."""
    found = take_census(PLACE, {0: 3, 1: 3}, partial=False, episodes=1, steps=3, listed=(1,))
    assert found == ({1}, ["Left out, since the metadata does not list them: 1 episode (0)"])


def test_an_episode_that_is_declared_without_a_step_is_told():
    """An episode that is declared without a step is told."""
    found = take_census(PLACE, {0: 3}, partial=False, episodes=2, steps=3, listed=(0, 1), lengths={0: 3, 1: 0})
    assert found[1] == ["Left out, since they have no step: 1 episode (1)"]


def test_a_gap_is_refused(subtests):
    """A gap is refused, or told where a part is enough."""
    for declared, told in [
        ({"listed": (0, 1, 2)}, r"1 episode \(2\) declared and not there"),
        ({"episodes": 3}, "3 episodes declared, 2 there"),
        ({"episodes": 1}, "1 episodes declared, 2 there"),
        ({"steps": 8}, "8 steps declared, 7 there"),
        ({"lengths": {1: 5}}, "episode 1 has 4 steps, 5 are declared"),
        ({"episodes": 3, "listed": (0, 1)}, "3 episodes declared, 2 listed"),
    ]:
        with subtests.test(declared=declared, told=told):
            found = {0: 3, 1: 4}
            if declared.get("episodes") == 1:
                found = {4: 3, 5: 4}
            with pytest.raises(SchemaError, match=f"{told}.*--partial"):
                take_census(PLACE, found, partial=False, **declared)
            assert take_census(PLACE, found, partial=True, **declared)[1]
