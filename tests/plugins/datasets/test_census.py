"""What is declared decides what belongs; what is not there is a gap."""

from pathlib import Path

import pytest

from harness.errors import SchemaError
from harness_plugins.datasets.dataset import Declared, take_census

PLACE = Path("d")


def test_what_is_as_declared_has_no_note():
    """What is as declared has no note."""
    found = take_census(PLACE, Declared(2, 7, (0, 1), {0: 3, 1: 4}), {0: 3, 1: 4}, partial=False)
    assert found == ({0, 1}, [])


def test_metadata_that_declares_nothing_takes_all():
    """Metadata that declares nothing takes all."""
    assert take_census(PLACE, Declared(), {4: 3, 9: 1}, partial=False)[0] == {4, 9}


def test_episodes_beside_the_list_are_left_out_and_told():
    """Episodes beside the list are left out and told."""
    found = take_census(PLACE, Declared(1, 3, (1,)), {0: 3, 1: 3}, partial=False)
    assert found == ({1}, ["Left out, since the metadata does not list them: 1 episode (0)"])


def test_an_episode_that_is_declared_without_a_step_is_told():
    """An episode that is declared without a step is told."""
    found = take_census(PLACE, Declared(2, 3, (0, 1), {0: 3, 1: 0}), {0: 3}, partial=False)
    assert found[1] == ["Left out, since they have no step: 1 episode (1)"]


def test_a_gap_is_refused(subtests):
    """A gap is refused, or told where a part is enough."""
    for declared, told in [
        (Declared(listed=(0, 1, 2)), r"1 episode \(2\) declared and not there"),
        (Declared(episodes=3), "3 episodes declared, 2 there"),
        (Declared(episodes=1), "1 episodes declared, 2 there"),
        (Declared(steps=8), "8 steps declared, 7 there"),
        (Declared(lengths={1: 5}), "episode 1 has 4 steps, 5 are declared"),
        (Declared(episodes=3, listed=(0, 1)), "3 episodes declared, 2 listed"),
    ]:
        with subtests.test(declared=declared, told=told):
            found = {0: 3, 5 if declared.episodes == 1 else 1: 4}
            if declared.episodes == 1:
                found = {4: 3, 5: 4}
            with pytest.raises(SchemaError, match=f"{told}.*--partial"):
                take_census(PLACE, declared, found, partial=False)
            assert take_census(PLACE, declared, found, partial=True)[1]
