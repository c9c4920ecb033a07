"""Everything that a report says, as plain data."""

import json

from harness.report import Report, report_text
from tests.report.conftest import NEW, OLD


def told(results):
    """The document, which is strict: no NaN, nothing that is not plain data."""
    return json.loads(report_text(Report(results)))


def test_document_has_learning_where_it_was_recorded(build):
    """Per combination; where policies were evaluated at the end alone, of the training itself."""
    (with_it,) = told(build(learned={10: 1}))["combinations"]
    (without,) = told(build())["combinations"]
    assert set(with_it["learning"]) == set(without["learning"]) == {"of", "metrics", "runs"}
    assert set(without["learning"]["metrics"]) == {"success_rate", "return, as paid"}


def test_document_has_the_returns_of_each_group(build):
    """One matrix per simulator here."""
    matrices = told(build(simulators=("mujoco", "pybullet")))["evaluation_returns"]
    assert [matrix["simulator"] for matrix in matrices] == ["mujoco", "pybullet"]


def test_document_tells_which_plugins_were_mixed(mixed, build):
    """By kind and name, how many cells each version made."""
    assert [item["mixtures"] for item in told(mixed)["combinations"]] == [
        [{"kind": "algorithms", "name": "sac", "cells": {NEW: 5, OLD: 1}}]
    ]
    assert [item["mixtures"] for item in told(build())["combinations"]] == [[]]
