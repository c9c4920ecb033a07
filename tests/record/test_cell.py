"""One cell of the matrix: its id is its content."""

import json
from collections.abc import Callable
from dataclasses import FrozenInstanceError, fields
from typing import Any

import pytest
from hypothesis import given, strategies as st

from harness.record.cell import BROUGHT, Cell
from harness.registry.choice import Choice

CHANGED: dict[str, Any] = {
    "simulator": Choice("other", (), "other"),
    "robot": "./my_arm",
    "task": Choice("fd100-reach", (("horizon", 6),), "fd100-reach:horizon=6"),
    "algorithm": Choice("wander", (("width", 8.0),), "wander:width=8"),
    "reward": Choice("arp", (), "arp"),
    "seed": 1,
    "steps": 13,
    "evaluation_episodes": 3,
    "evaluate_every": 4,
    "deterministic": False,
    "evaluation_horizon": 500,
}


def test_every_field_is_tried_below():
    """A field added to a cell has to be added to its id, unless cells that differ in it are the same."""
    assert set(CHANGED) == {field.name for field in fields(Cell) if field.compare}


def test_what_is_recorded_beside_changes_no_id(make_cell: Callable[..., Cell]):
    """It changes nothing of the training, and goes the way through JSON."""
    cell = make_cell(records=("qvel",))
    assert (cell, cell.id) == (make_cell(), make_cell().id)
    assert "records" not in make_cell().to_json()
    assert Cell.from_json(json.loads(json.dumps(cell.to_json()))).records == ("qvel",)


def test_id_differs_for_every_field(make_cell: Callable[..., Cell], subtests: pytest.Subtests):
    """Two cells that differ in one thing have different ids."""
    for name, value in CHANGED.items():
        with subtests.test(name=name):
            assert make_cell(**{name: value}).id != make_cell().id


@pytest.mark.parametrize("name", ["simulator", "task", "algorithm", "reward"])
def test_id_differs_for_every_parameter(make_cell: Callable[..., Cell], name: str):
    """A parameter decides the id, whatever the label says."""
    one, other = (make_cell(**{name: Choice("x", (("k", value),), "x")}) for value in (1.0, 1.0000001))
    assert one.id != other.id


def test_id_is_a_folder_name(make_cell: Callable[..., Cell]):
    """Sixteen hexadecimal digits."""
    assert len(make_cell().id) == 16
    assert set(make_cell().id) <= set("0123456789abcdef")


def test_id_is_the_same_tomorrow(make_cell: Callable[..., Cell]):
    """The id of a known cell is written down here: results of earlier versions are found again."""
    assert make_cell().id == "1b16a12bbbf2b963"


@pytest.mark.parametrize("name", ["evaluate_every", "deterministic", "evaluation_horizon"])
def test_later_fields_are_left_out_at_their_defaults(make_cell: Callable[..., Cell], name: str):
    """A cell of a version that did not have them is the same cell, with the same id."""
    assert name not in make_cell().to_json()
    assert make_cell(**{name: CHANGED[name]}).to_json()[name] == CHANGED[name]


def test_cell_survives_json(make_cell: Callable[..., Cell]):
    """Written as JSON text and read again it is equal and has the same id, also after its id was asked for."""
    for cell in (make_cell(), make_cell(**CHANGED)):
        assert len(cell.id) == 16
        again = Cell.from_json(json.loads(json.dumps(cell.to_json())))
        assert again == cell
        assert again.id == cell.id


@given(st.dictionaries(st.text(), st.floats(allow_nan=False, allow_infinity=False) | st.text() | st.booleans()))
def test_id_survives_json_with_any_parameters(params: dict[str, Any]):
    """Numbers come back to the last bit, so the id does too."""
    choice = Choice("x", tuple(params.items()), "x")
    cell = Cell(choice, "fd100", choice, choice, choice, 0, 10, 2)
    assert Cell.from_json(json.loads(json.dumps(cell.to_json()))).id == cell.id


def test_id_does_not_depend_on_the_order_of_the_keys(make_cell: Callable[..., Cell]):
    """JSON objects have no order."""
    data = make_cell().to_json()
    assert Cell.from_json(dict(reversed(data.items()))).id == make_cell().id


def test_cell_cannot_be_changed(make_cell: Callable[..., Cell]):
    """A cell is what it was made as."""
    with pytest.raises(FrozenInstanceError):
        make_cell().seed = 3


def test_title_is_for_people(make_cell: Callable[..., Cell]):
    """The combination and the seed, in one line."""
    assert make_cell().title == "ideal · wander · baseline · seed 0"


IN_ENVIRONMENT = Choice("walk", (), "walk")


def test_people_are_told_the_discount_in_an_environment(make_cell: Callable[..., Cell], subtests: pytest.Subtests):
    """Beside the algorithm, as one would type it, where the algorithm has a discount that its label leaves out."""
    rows = [
        ({"gamma": 0.8}, "ppo", "ppo:gamma=0.8"),
        ({"gamma": 0.8, "depth": 2}, "ppo:depth=2", "ppo:depth=2,gamma=0.8"),
        ({"gamma": 0.99}, "ppo:gamma=0.99", "ppo:gamma=0.99"),
        ({"depth": 2}, "ppo:depth=2", "ppo:depth=2"),
        ({"gamma": "x\ny"}, "ppo", "ppo"),
        ({"gamma": True}, "ppo", "ppo"),
    ]
    for params, label, told in rows:
        with subtests.test(params=params, label=label, told=told):
            algorithm = Choice("ppo", tuple(params.items()), label)
            assert make_cell(algorithm=algorithm).learner == label
            cell = make_cell(algorithm=algorithm, simulator=BROUGHT.simulator, task=IN_ENVIRONMENT)
            assert cell.learner == told
            assert cell.title == f"walk · {told} · baseline · seed 0"
            assert cell.to_json()["algorithm"]["label"] == label
