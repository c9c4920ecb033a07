"""One cell of the matrix: its id is its content."""

import json
import re
from dataclasses import FrozenInstanceError, fields

import pytest
from hypothesis import given, strategies as st

from harness.executor import Cell
from harness.registry import Choice

CHANGED = {
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


def _again(cell):
    """Written as JSON text and read again."""
    return Cell.from_json(json.loads(json.dumps(cell.to_json())))


def test_what_is_recorded_beside_changes_no_id(make_cell):
    """It changes nothing of the training, and goes the way through JSON."""
    cell = make_cell(records=("qvel",))
    assert (cell, cell.id) == (make_cell(), make_cell().id)
    assert "records" not in make_cell().to_json()
    assert _again(cell).records == ("qvel",)


def test_id_differs_for_every_field(make_cell):
    """Two cells that differ in one thing have different ids: of 16 hexadecimal digits, names of folders."""
    ids = [make_cell().id, *(make_cell(**{name: value}).id for name, value in CHANGED.items())]
    assert len({*ids}) == len(ids)
    assert all(re.fullmatch("[0-9a-f]{16}", it) for it in ids)


@pytest.mark.parametrize("name", ["simulator", "task", "algorithm", "reward"])
def test_id_differs_for_every_parameter(make_cell, name):
    """A parameter decides the id, whatever the label says."""
    one, other = (make_cell(**{name: Choice("x", (("k", value),), "x")}) for value in (1.0, 1.0000001))
    assert one.id != other.id


def test_id_is_the_same_tomorrow(make_cell):
    """The id of a known cell is written down here: results of earlier versions are found again."""
    assert make_cell().id == "1b16a12bbbf2b963"


@pytest.mark.parametrize("name", ["evaluate_every", "deterministic", "evaluation_horizon"])
def test_later_fields_are_left_out_at_their_defaults(make_cell, name):
    """A cell of a version that did not have them is the same cell, with the same id."""
    assert name not in make_cell().to_json()
    assert make_cell(**{name: CHANGED[name]}).to_json()[name] == CHANGED[name]


def test_cell_survives_json(make_cell):
    """It is equal and has the same id, also after its id was asked for; JSON objects have no order."""
    for cell in (make_cell(), make_cell(**CHANGED)):
        assert (cell.id, cell) == (_again(cell).id, _again(cell))
        assert Cell.from_json(dict(reversed(cell.to_json().items()))).id == cell.id


@given(st.dictionaries(st.text(), st.floats(allow_nan=False, allow_infinity=False) | st.text() | st.booleans()))
def test_id_survives_json_with_any_parameters(params):
    """Numbers come back to the last bit, so the id does too."""
    choice = Choice("x", tuple(params.items()), "x")
    cell = Cell(choice, "fd100", choice, choice, choice, 0, 10, 2)
    assert _again(cell).id == cell.id


def test_cell_cannot_be_changed(make_cell):
    """A cell is what it was made as."""
    with pytest.raises(FrozenInstanceError):
        make_cell().seed = 3


def test_title_is_for_people(make_cell):
    """The combination and the seed, in one line."""
    assert make_cell().title == "ideal · wander · baseline · seed 0"


@pytest.mark.parametrize(
    ("params", "label", "told"),
    [
        ({"gamma": 0.8}, "ppo", "ppo:gamma=0.8"),
        ({"gamma": 0.8, "depth": 2}, "ppo:depth=2", "ppo:depth=2,gamma=0.8"),
        ({"gamma": 0.99}, "ppo:gamma=0.99", "ppo:gamma=0.99"),
        ({"depth": 2}, "ppo:depth=2", "ppo:depth=2"),
        ({"gamma": "x\ny"}, "ppo", "ppo"),
        ({"gamma": True}, "ppo", "ppo"),
    ],
)
def test_people_are_told_the_discount_in_an_environment(make_cell, params, label, told):
    """Beside the algorithm, as one would type it, where the algorithm has a discount that its label leaves out."""
    algorithm = Choice("ppo", tuple(params.items()), label)
    assert make_cell(algorithm=algorithm).learner == label
    cell = make_cell(
        algorithm=algorithm, simulator=Choice("(environment)", (), "environment"), task=Choice("walk", (), "walk")
    )
    assert (cell.learner, cell.title) == (told, f"walk · {told} · baseline · seed 0")
    assert cell.to_json()["algorithm"]["label"] == label
