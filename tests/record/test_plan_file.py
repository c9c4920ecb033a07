"""What was asked for, read back or put together."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from harness.errors import SchemaError, UsageError
from harness.record.cell import Cell
from harness.record.plan_file import EXPERIMENT, PLAN, StoredPlan, control_seeds, plan_from_cells, read_plan
from harness.registry.choice import Choice

ARP = Choice("arp", (("k1", 1.0), ("k2", 2.0)), "arp:k2=2")
MakeCell = Callable[..., Cell]


def test_plan_is_read_as_it_was_written(make_cell: MakeCell, tmp_path: Path):
    """Every field."""
    plan = StoredPlan("baseline", True, {0: 2}, (make_cell(), make_cell(seed=2)), {"seeds": [0]})
    plan.write(tmp_path)
    assert vars(read_plan(tmp_path)) == vars(plan)
    assert (tmp_path / EXPERIMENT).read_text() == "seeds = [\n    0,\n]\n"


def test_plan_of_another_form_is_refused(
    make_cell: MakeCell, tmp_path_factory: pytest.TempPathFactory, subtests: pytest.Subtests
):
    """The line names the file and the key."""
    rows = [
        {"baseline": 3},
        {"a_a": "yes"},
        {"control": [[0]]},
        {"control": [[0, -1]]},
        {"cells": None},
        {"cells": [{}]},
        {"cells": [3]},
        {"more": 1},
        {"experiment": []},
    ]
    for change in rows:
        with subtests.test(change=change):
            tmp_path = tmp_path_factory.mktemp("case")
            data = {"baseline": "baseline", "a_a": False, "cells": [make_cell().to_json()], **change}
            (tmp_path / PLAN).write_text(json.dumps(data))
            with pytest.raises(SchemaError, match=rf"plan\.json is no readable plan: ValueError: {next(iter(change))}"):
                read_plan(tmp_path)


def _nested(depth: int) -> object:
    value: object = 1
    for _ in range(depth):
        value = [value]
    return value


@pytest.mark.parametrize(
    "told", [{"sim": _nested(900)}, {"sim": None}, {"sim": ["a", "\ud800"]}], ids=["deep", "null", "half"]
)
def test_an_experiment_that_cannot_be_written_again_is_refused(
    make_cell: MakeCell, tmp_path: Path, told: dict[str, object]
):
    """When it is read, and before it is written: a run would end there after the training."""
    data = {"baseline": "baseline", "a_a": False, "cells": [make_cell().to_json()], "experiment": told}
    (tmp_path / PLAN).write_text(json.dumps(data))
    with pytest.raises(SchemaError, match=r"plan\.json is no readable plan: ValueError: experiment"):
        read_plan(tmp_path)
    (tmp_path / PLAN).unlink()
    with pytest.raises(UsageError, match=r"cannot hold what is asked for"):
        StoredPlan("baseline", False, {}, (make_cell(),), told).write(tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_cell_that_is_listed_twice_counts_once(make_cell: MakeCell, tmp_path: Path):
    """In its first place."""
    cells = [make_cell(seed=1), make_cell(), make_cell(seed=1)]
    data = {"baseline": "baseline", "a_a": False, "cells": [cell.to_json() for cell in cells]}
    (tmp_path / PLAN).write_text(json.dumps(data))
    assert read_plan(tmp_path).cells == (cells[0], cells[1])


def test_more_cells_than_can_be_read_are_refused(make_cell: MakeCell, monkeypatch: pytest.MonkeyPatch):
    """A folder grows up to there."""
    monkeypatch.setattr("harness.record.file_forms.MOST_CELLS", 2)
    plan = StoredPlan("baseline", False, {}, (make_cell(), make_cell(seed=1)))
    assert len(plan.with_cells_of([make_cell()]).cells) == 2
    with pytest.raises(UsageError, match="1 cells that are there and those that are asked for are 3, 2 are allowed"):
        plan.with_cells_of([make_cell(seed=2)])


@pytest.mark.parametrize("looks", [[10_001], [2, 2], [3, 2]])
def test_looks_that_no_plan_has_are_refused(make_cell: MakeCell, tmp_path: Path, looks: list[int]):
    """A billion seeds would be gone through one by one."""
    data = {"baseline": "baseline", "a_a": False, "cells": [make_cell().to_json()], "terms": {"looks": looks}}
    (tmp_path / PLAN).write_text(json.dumps(data))
    with pytest.raises(SchemaError, match="looks"):
        read_plan(tmp_path)


def test_control_is_put_together_from_the_experiment(make_cell: MakeCell, tmp_path: Path):
    """The file says whether the baseline is compared with itself, and the seeds say with which."""
    (tmp_path / EXPERIMENT).write_text(
        'baseline = {name = "baseline"}\nreward = [{name = "baseline"}]\nseeds = [0, 1]\n'
    )
    cells = [make_cell(seed=seed) for seed in range(4)]
    plan = plan_from_cells(tmp_path, cells, "damaged")
    assert (plan.baseline, plan.a_a, plan.control) == ("baseline", True, {0: 2, 1: 3})


def test_baseline_is_found_by_its_parameters(make_cell: MakeCell, tmp_path: Path):
    """Two rewards of one name are told apart."""
    (tmp_path / EXPERIMENT).write_text('baseline = {name = "arp", k1 = 1.0, k2 = 2.0}\n')
    cells = [make_cell(reward=Choice("arp", (("k1", 1.0), ("k2", 1.5)), "arp")), make_cell(reward=ARP)]
    assert plan_from_cells(tmp_path, cells, "damaged").baseline == "arp:k2=2"


def test_unknown_baseline_is_an_error(make_cell: MakeCell, tmp_path: Path):
    """Nothing is guessed: the line says what there is, two rewards of one name apart, and what to do."""
    cells = [make_cell(reward=Choice("arp", (("k1", 1.0), ("k2", 1.5)), "arp")), make_cell(reward=ARP)]
    told = r"^damaged\. The cells have the rewards arp, arp:k2=2, and experiment\.toml does"
    with pytest.raises(SchemaError, match=told):
        plan_from_cells(tmp_path, cells, "damaged")


def test_control_seeds_are_none_of_the_experiment():
    """One for each."""
    assert control_seeds([3, 7]) == {3: 11, 7: 15}
