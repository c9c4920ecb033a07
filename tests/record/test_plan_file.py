"""What was asked for, read back or put together."""

import json

import pytest

from harness.errors import SchemaError, UsageError
from harness.record import EXPERIMENT, PLAN, Store
from harness.record.plan_file import StoredPlan, plan_from_cells
from harness.registry import Choice
from tests.cli.forging import nested

ARP = Choice("arp", (("k1", 1.0), ("k2", 2.0)), "arp:k2=2")


def test_plan_is_read_as_it_was_written(make_cell, tmp_path):
    """Every field."""
    plan = StoredPlan("baseline", True, {0: 2}, (make_cell(), make_cell(seed=2)), {"seeds": [0]})
    plan.write(tmp_path)
    assert vars(Store(tmp_path).read_plan()) == vars(plan)
    assert (tmp_path / EXPERIMENT).read_text() == "seeds = [\n    0,\n]\n"


UNWRITABLE = [{"sim": nested(900)}, {"sim": None}, {"sim": ["a", "\ud800"]}]
WRONG = {
    "baseline": [3],
    "a_a": ["yes"],
    "control": [[[0]], [[0, -1]]],
    "cells": [None, [{}], [3]],
    "more": [1],
    "experiment": [[], {"sim": nested(50)}, {"sim": None}],
    "the file": UNWRITABLE[::2],  # nested without end, or half a character: it is no JSON that anybody reads
    "terms.looks": [{"looks": looks} for looks in ([10_001], [2, 2], [3, 2])],  # a billion seeds would take long
}


@pytest.mark.parametrize("key", WRONG)
def test_plan_of_another_form_is_refused(make_cell, tmp_path, subtests, key):
    """The line names the file and the key."""
    for value in WRONG[key]:
        data = {
            "baseline": "baseline",
            "a_a": False,
            "cells": [make_cell().to_json()],
            "experiment" if key == "the file" else key.split(".")[0]: value,
        }
        (tmp_path / PLAN).write_text(json.dumps(data))
        told = rf"plan\.json is no readable plan: ValueError: {key}"
        with subtests.test(value=value), pytest.raises(SchemaError, match=told):
            Store(tmp_path).read_plan()


@pytest.mark.parametrize("told", UNWRITABLE, ids=["deep", "null", "half"])
def test_an_experiment_that_cannot_be_written_is_refused(make_cell, tmp_path, told):
    """Before: a run would end there after the training."""
    with pytest.raises(UsageError, match=r"cannot hold what is asked for"):
        StoredPlan("baseline", False, {}, (make_cell(),), told).write(tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_cell_that_is_listed_twice_counts_once(make_cell, tmp_path):
    """In its first place."""
    cells = [make_cell(seed=1), make_cell(), make_cell(seed=1)]
    data = {"baseline": "baseline", "a_a": False, "cells": [cell.to_json() for cell in cells]}
    (tmp_path / PLAN).write_text(json.dumps(data))
    assert Store(tmp_path).read_plan().cells == (cells[0], cells[1])


def test_more_cells_than_can_be_read_are_refused(make_cell, monkeypatch):
    """A folder grows up to there."""
    monkeypatch.setattr("harness.record.file_forms.MOST_CELLS", 2)
    plan = StoredPlan("baseline", False, {}, (make_cell(), make_cell(seed=1)))
    assert len(plan.with_cells_of([make_cell()]).cells) == 2
    with pytest.raises(UsageError, match="1 cells that are there and those that are asked for are 3, 2 are allowed"):
        plan.with_cells_of([make_cell(seed=2)])


def test_control_is_put_together_from_the_experiment(make_cell, tmp_path):
    """The file says whether the baseline is compared with itself, and the seeds say with which."""
    (tmp_path / EXPERIMENT).write_text(
        'baseline = {name = "baseline"}\nreward = [{name = "baseline"}]\nseeds = [0, 1]\n'
    )
    cells = [make_cell(seed=seed) for seed in range(4)]
    plan = plan_from_cells(tmp_path, cells, "damaged")
    assert (plan.baseline, plan.a_a, plan.control) == ("baseline", True, {0: 2, 1: 3})


def test_baseline_is_found_by_its_parameters(make_cell, tmp_path):
    """Two rewards of one name are told apart; where it is unknown nothing is guessed: the line says what there is."""
    cells = [make_cell(reward=Choice("arp", (("k1", 1.0), ("k2", 1.5)), "arp")), make_cell(reward=ARP)]
    with pytest.raises(
        SchemaError, match=r"^damaged\. The cells have the rewards arp, arp:k2=2, and experiment\.toml does"
    ):
        plan_from_cells(tmp_path, cells, "damaged")
    (tmp_path / EXPERIMENT).write_text('baseline = {name = "arp", k1 = 1.0, k2 = 2.0}\n')
    assert plan_from_cells(tmp_path, cells, "damaged").baseline == "arp:k2=2"
