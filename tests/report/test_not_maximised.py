"""A reward that pays random actions more than its own policies is said not to have been maximised, wherever one reads.

The toy pays for large actions. Its policies have not learned, and act near 0.
"""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from harness import load_registry, load_results
from harness.eta import Ruling
from harness.executor import CellOptions
from harness.experiment.plan import check_experiment, expand
from harness.experiment.run_cell import run_cell
from harness.record import read_recording
from harness.registry import read_given
from harness.report import FactsTable, Report, report_text, write_html
from harness_plugins.committed import write_summary
from tests.report.conftest import printed, squeezed
from tests.stores import create_store

SWING = Path(__file__).parents[1] / "experiment" / "environments" / "swing.py"
TOLD = "large was not maximised: it pays random actions more than the policies of all 5 trainings"


@pytest.fixture(scope="module", name="results")
def _results(tmp_path_factory):
    return _done(tmp_path_factory.mktemp("swing"), seeds=5)


def _done(folder, **keys):
    """Trainings that are over before the first update."""
    given = read_given([SWING])
    algo = "sac-fast:net_arch=4,learning_starts=16,batch_size=4"
    asked = {"task": "swing", "algo": algo, "steps": 16, "evaluation_episodes": 40, **keys}
    plan = expand(check_experiment(asked), load_registry(given=given))
    store = create_store(folder / "out", plan)
    for cell in plan.cells:
        assert run_cell(cell, store.cell_folder(cell), lambda word: None, CellOptions(plugins=given)).status == "done"
    return load_results(store.folder, plugins=[SWING])


def test_what_is_paid_is_what_was_recorded(results):
    """By the reward that trained, in the evaluations; beside the mean over the episodes of random actions."""
    (comparison,) = results.combinations
    large, small = comparison.measured.paid
    path, *_ = results.folder.glob("cells/*/random")
    assert large.at_random == pytest.approx(float(read_recording(path)["reward/large"].sum()) / 40)
    assert (large.reward, large.trained) == ("large", (0.0,) * 5)
    assert (small.reward, small.at_random) == ("small", -large.at_random)


def test_json_says_it(results):
    """With the numbers behind it."""
    (comparison,) = json.loads(report_text(Report(results)))["combinations"]
    assert [told.startswith(TOLD) for told in comparison["not_maximised"]] == [True]
    assert [it["below"] for it in comparison["paid_at_random"]] == [5, 0]


@pytest.mark.parametrize("facts", ["short", "full"])
def test_the_terminal_says_it(results, facts):
    """At a glance, and with all details."""
    assert squeezed(printed(FactsTable(getattr(Report(results), facts)))).count(TOLD) == 1


def test_page_and_summary_say_it(results, tmp_path):
    """Beside the answer."""
    write_html(Report(results), tmp_path / "report.html")
    assert TOLD in squeezed((tmp_path / "report.html").read_text())
    write_summary(results, tmp_path / "summary")
    assert TOLD in (tmp_path / "summary" / "summary.md").read_text()


def test_nothing_is_claimed_while_trainings_are_to_come(results):
    """Who looks again and again would find something."""
    (comparison,) = results.combinations
    assert replace(comparison, answer=replace(comparison.answer, ruling=Ruling(missing="2"))).not_maximised == ()
