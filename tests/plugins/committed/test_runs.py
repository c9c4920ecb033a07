"""The curves of single runs, kept to be drawn again."""

import numpy as np
import pytest

from harness.report.figures.panel import panels_of
from harness.report.figures.points import FEWEST
from harness_plugins.committed.tables import OF_ALL_RUNS, panels_in, read_runs, write_runs


def kept(results):
    """The panels of the only combination, and those that its file gives."""
    (combination,) = results.combinations
    return panels_of(combination), panels_in(read_runs(write_runs([combination])), combination, "accumulated")


def test_panels_are_those_that_were_kept(build):
    """Every run, their mean, their marks."""
    before, after = kept(build(seeds=3))
    for one, other in zip(before, after, strict=True):
        assert (one.role, one.reward, one.seeds, one.marks) == (other.role, other.reward, other.seeds, other.marks)
        for run, again in zip([*one.runs, one.mean], [*other.runs, other.mean], strict=True):
            np.testing.assert_array_equal(run.steps, again.steps)
            np.testing.assert_allclose(run.values, again.values, rtol=1e-6)


def test_runs_that_are_not_there_have_no_panel(build):
    """Of another experiment's file."""
    (combination,) = build(seeds=2).combinations
    assert panels_in({}, combination, "accumulated") is None


def test_a_curve_that_two_comparisons_share_stands_once(build):
    """The baseline's."""
    results = build(proposed={"arp": (9, 30), "relative": (9, 30)}, seeds=2)
    trained = [key.trained_with for key in read_runs(write_runs(results.combinations))]
    assert {name: trained.count(name) for name in trained} == {"baseline": 3, "arp": 3, "relative": 3}


@pytest.mark.parametrize("seeds", [1, 30])
def test_many_runs_have_few_points_each(build, seeds):
    """All together as many as a figure holds."""
    (combination,) = build(seeds=seeds, baseline=(2_000, 2_000), proposed={"arp": (2_000, 2_000)}).combinations
    runs = [it for key, it in read_runs(write_runs([combination])).items() if " " not in key.seeds]
    assert min(len(it.steps) for it in runs) >= FEWEST
    assert sum(len(it.steps) for it in runs) <= OF_ALL_RUNS


def test_no_finished_pair_no_rows(build):
    """The file is there."""
    (combination,) = build(seeds=1, ended={("arp", 0): ("failed", "it broke")}).combinations
    assert read_runs(write_runs([combination])) == {}
