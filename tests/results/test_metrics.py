"""Metrics that fail cost their own values; those that are chosen stand alone."""

import json

import pyarrow.parquet as pq
import pytest

from harness import load_registry, load_results
from harness.errors import PluginError, UsageError
from harness.record import Manifest
from harness.report import Report, behaviour_grids, report_text
from harness.results.metrics import load_metrics, measure, measure_of
from harness_plugins.committed.tables import write_cells
from tests.registered import REGISTRY
from tests.results.folders import only

HOOKS = """
import harness

@harness.hookimpl
def register_metrics(register):
    register("raises", f"{__name__}_code:Raises", summary="raises")
    register("leaves", f"{__name__}_code:Leaves", summary="wants to end the process")
    register("nan", f"{__name__}_code:Nan", summary="is no number")
    register("text", f"{__name__}_code:Text", summary="is text")
    register("vague", f"{__name__}_code:Vague", summary="does not say what is better")
    register("loose", f"{__name__}_code:Loose", summary="has no bounds")
    register("half", f"{__name__}_code:Half", summary="is not called as a metric")
    register("gone", f"{__name__}_code:Gone", summary="is not there")
    register("far", f"{__name__}_code:Nan", summary="needs a library", requires=["no_such_library"])
"""
CODE = """
from dataclasses import dataclass

@dataclass(frozen=True)
class Raises:
    unit = ""
    better = "higher"
    def __call__(self, trace):
        return {}["no_such"]

class Leaves(Raises):
    def __call__(self, trace):
        raise SystemExit(3)

class Nan(Raises):
    def __call__(self, trace):
        return float("nan")

class Text(Raises):
    def __call__(self, trace):
        return "much"

class Vague(Raises):
    better = "more"

class Loose(Raises):
    bounds = 1.0, 0.0

class Half(Raises):
    def __call__(self):
        return 1.0
"""
REASONS = {
    "raises": "KeyError: 'no_such'",
    "leaves": "SystemExit: 3",
    "nan": "it returned nan",
    "text": "TypeError: ",
    "vague": "its 'better' is 'more': allowed are higher and lower",
    "loose": "its 'bounds' are (1.0, 0.0): allowed are two numbers, the lower one first",
    "half": "Metric 'half' of package odd 1.0 cannot be called as it has to be: __call__ takes 1 argument beside self",
    "gone": "Plugin 'odd' (odd 1.0): ",
    "far": "Metric 'far' needs no_such_library: pip install no_such_library",
}


@pytest.fixture
def odd(install):
    """All metrics, and some that fail in every way."""
    install("odd", HOOKS, code=CODE)
    return load_registry()


@pytest.fixture
def results(odd, both, made):
    """One seed of two rewards."""
    return made(both(1), lambda cell: {"distances": [1.0, 0.5, 0.25]}, plugins=odd)


def test_each_failing_metric_says_why(results):
    """And no other is touched."""
    told = results.not_measured
    assert set(told) == set(REASONS)
    for name, reason in REASONS.items():
        assert reason in told[name]
    measured = results.measured(results.done_cells[0])
    assert measured.own["success_rate"] == 1.0
    assert {measured.own[name] for name in REASONS} == {None}


def test_change_has_the_reason(results):
    """In JSON, strictly; one that is only not defined has none."""
    behaviour = json.loads(report_text(Report(results)))["combinations"][0]["behaviour"]
    reasons = {it["name"]: it["reason"] for it in behaviour if it["manner"] == "deterministic"}
    assert reasons["raises"] == "KeyError: 'no_such'"
    assert reasons["success_rate"] == ""


def test_row_shows_the_reason(results):
    """In table and page, in place of the values."""
    (grid, *_) = behaviour_grids(only(results))
    rows = {row[0]: row for row in grid.rows}
    assert rows["raises"][1] == "n/a (KeyError: 'no_such')"
    assert rows["success rate"][1] == "100.0%"
    assert len(rows["half"][1]) <= 70


def test_tables_have_nothing_and_the_reason(results):
    """In results.parquet, and in cells.csv of a summary."""
    row = pq.read_table(results.write_table()).to_pylist()[0]
    assert (row["raises"], row["success_rate"]) == (None, 1.0)
    head, first, *_ = write_cells(results).splitlines()
    assert head.endswith(",not_measured")
    assert all("raises: KeyError: 'no_such'" in told for told in (row["not_measured"], first))


def test_chosen_metrics_stand_beside_those_that_decide(results, odd):
    """By their labels; nothing else fails then."""
    chosen = load_results(results.folder, metrics=["smoothness,work"], registry=odd)
    assert list(chosen.metrics) == ["success_rate", "time_to_target", "smoothness", "work"]
    assert chosen.not_measured == {}
    assert only(chosen).headline.robot


def test_chosen_metric_that_is_broken_is_an_error(odd):
    """It was asked for."""
    with pytest.raises(PluginError, match="Metric 'half' of package odd"):
        load_metrics(odd, ["half"])
    with pytest.raises(UsageError, match="Did you mean 'work'"):
        load_metrics(odd, "wrok")


def test_interrupt_is_no_failure_of_a_metric():
    """Whoever presses Ctrl-C means it."""

    def interrupted(trace):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        measure({"a": interrupted}, None)


def test_error_of_the_task_is_told_by_its_name_and_unit(make_cell):
    """Of metrics that say that they measure it; others, and other tasks, keep their own."""
    metrics = load_metrics(REGISTRY, ["final_distance", "work"])
    tilt = Manifest(make_cell(), status="done", error="tilt", unit="rad")
    plain = Manifest(make_cell(), status="done")
    told = {(name, it.error): measure_of(name, metrics[name], "d", 9, it) for name in metrics for it in (tilt, plain)}
    assert (told["final_distance", "tilt"].title, told["final_distance", "tilt"].unit) == ("final tilt", "rad")
    assert (told["final_distance", ""].title, told["final_distance", ""].unit) == ("", "m")
    assert told["work", "tilt"] == told["work", ""]
