"""One reward alone: what it paid for."""

import json

import numpy as np
import pytest

from harness import load_results
from harness.record import read_trace
from tests.results.gentle import GENTLE, run_gentle


@pytest.fixture(name="results", scope="module")
def _results(tmp_path_factory):
    ran = run_gentle(tmp_path_factory.mktemp("alone"), reward=["gentle"], baseline="none")
    return load_results(ran, plugins=[ran.parent / GENTLE])


def test_pay_at_the_start_is_that_of_the_first_tenth_of_the_episodes(results):
    """Worked out apart, from the traces."""
    means = []
    for cell in results.done_cells:
        trace = read_trace(results.store.cell_folder(cell) / "trace.parquet")
        ended = sorted(trace.episodes, key=lambda rows: rows[-1])
        first = ended[: max(1, round(0.1 * len(ended)))]
        means.append(np.mean([trace["reward"][rows].sum() for rows in first]))
    assert results.alone[0].paid.start.value == pytest.approx(np.mean(means), rel=1e-12)


def test_measures_have_every_stage(results):
    """What decides in a comparison comes first; random actions stand beside it."""
    first, second = results.alone[0].behaviour[:2]
    assert (first.measure.name, second.measure.name) == ("success_rate", "time_to_target")
    told = (second.start.value, second.end.value, second.evaluation.value, second.random)
    assert all(value is not None and value > 0.0 for value in told)


def test_json_has_all_of_it(results):
    """Plain data, without a number that JSON does not have."""
    told = json.loads(json.dumps(results.alone[0].to_json(), allow_nan=False))
    assert set(told) >= {"reward", "seeds", "return", "behaviour", "learning"}
    assert len(told["learning"]["success_rate"]) == 20
