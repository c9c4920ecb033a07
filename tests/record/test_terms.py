"""What is agreed on before the first training."""

import json

import pytest

from harness.record import Terms


@pytest.mark.parametrize(
    "terms",
    [
        Terms(),
        Terms(averaged=5),
        Terms((4, 8), 3, 0.05, race=True, averaged=5),
        Terms(grown=(6, 12), joined=("arp", "dense")),
    ],
)
def test_terms_survive_their_file(terms):
    """As JSON and back."""
    assert Terms.from_json(json.loads(json.dumps(terms.to_json()))) == terms


def test_a_plan_without_terms_has_those_of_version_0_1():
    """One checkpoint, all seeds at once."""
    assert Terms.from_json({}) == Terms()


def test_what_a_later_version_adds_is_left_out():
    """Its files can be read."""
    assert Terms.from_json({"looks": [4], "weather": "fine"}) == Terms((4,))
