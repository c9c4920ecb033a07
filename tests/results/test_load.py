"""One function reads every folder that holds results."""

import numpy as np
import pytest

from harness import load_registry, load_results
from harness.errors import UsageError
from harness.results import Results
from harness_plugins.transfer import plan_transfers
from tests.results.recordings.conftest import PAYS, record
from tests.stores import create_store


@pytest.fixture
def loose(tmp_path):
    """Recordings by three rewards, three seeds each."""
    pays = {**PAYS, "half": lambda arm: arm / 2.0}
    for reward in pays:
        for seed in range(3):
            record(tmp_path / f"{reward}-{seed}", reward, seed, np.linspace(0.0, 1.0, 10) + 0.01 * seed, pays=pays)
    return tmp_path


def test_recordings_are_cells_of_a_plan(loose):
    """Each is done; the reward that was given first is the baseline."""
    results = load_results(loose)
    assert isinstance(results, Results)
    assert not results.is_experiment
    assert results.baseline == "plain"
    assert sorted((it.cell.reward.label, it.cell.seed) for it in results.done) == sorted(
        (reward, seed) for reward in ("plain", "thrice", "half") for seed in range(3)
    )


def test_recordings_have_comparisons_and_returns(loose):
    """Each reward against the first one, or every two; a table of returns for each manner."""
    results = load_results(loose)
    first = [("plain", "thrice"), ("plain", "half")]
    assert [(it.baseline, it.proposed) for it in results.combinations] == first
    pairs = load_results(loose, pairs=True).combinations
    assert [(it.baseline, it.proposed) for it in pairs] == [*first, ("thrice", "half")]
    assert [matrix.manner for matrix in results.returns] == ["in its last fifth", "over the training"]
    assert results.to_json()["format"] == 2


def test_recordings_have_a_row_each(loose):
    """In pandas, with what every reward paid."""
    pytest.importorskip("pandas")
    table = load_results(loose).to_pandas()
    assert len(table) == 9
    assert {"return_plain", "behaviour_success"} <= set(table.columns)


def test_recordings_beside_a_whole_experiment_are_refused(loose, make_cell, make_plan):
    """Its cells would be left out, or lose their baseline: it is named, and nothing is written."""
    create_store(loose / "arm", make_plan(make_cell()))
    before = sorted(loose.rglob("*"))
    with pytest.raises(UsageError, match=r"holds whole experiments, not only recorded trainings: .*arm"):
        load_results(loose)
    assert sorted(loose.rglob("*")) == before


def test_the_folder_around_an_experiment_is_no_folder_of_logs(tmp_path, make_cell, make_plan):
    """Its cells are logs too, but no trainings to be sorted by name: the experiment is named."""
    create_store(tmp_path / "arm", make_plan(make_cell()))
    with pytest.raises(UsageError, match=r"Name the --out folder of a run\. Experiments in it: arm$"):
        load_results(tmp_path)


def test_what_needs_an_arm_says_so(loose):
    """And what to do instead."""
    with pytest.raises(UsageError, match=r"harness transfer needs traces of an arm.*: harness report .* compares"):
        plan_transfers(load_results(loose), None, load_registry())
