"""What a trial is worth."""

from pathlib import Path

import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest
from hypothesis import given, strategies as st

from harness.record.folder import EVALUATION
from harness.record.trace import read_trace
from harness.registry.registry import Registry
from harness_plugins.tune.outcomes import ValidatePolicy
from harness_plugins.tune.trial import Outcome, mean_outcome, outcome_of, score

DISTANCES = st.floats(0.0, 1e6)


@given(st.integers(1, 400), st.data(), DISTANCES, DISTANCES)
def test_one_success_more_outweighs_any_distance(episodes, data, near, far):
    """Success comes first, whatever the distances."""
    successes = data.draw(st.integers(0, episodes - 1))
    less, more = Outcome(successes / episodes, near), Outcome((successes + 1) / episodes, far)
    assert score(less, episodes) < score(more, episodes)


def test_equal_success_is_told_apart_by_the_final_distance():
    """Above all where no trial ever succeeds."""
    assert score(Outcome(0.0, 0.5), 100) > score(Outcome(0.0, 0.6), 100)


def test_every_cell_counts_as_much_as_the_next():
    """The mean over rewards and seeds."""
    assert mean_outcome([Outcome(0.0, 1.0), Outcome(1.0, 0.5)]) == Outcome(0.5, 0.75)


REWARDS = ["reward", "reward_ground", "reward_target", "reward_step"]


@pytest.fixture
def recorded(toys: Registry, make_cell, tmp_path: Path) -> Path:
    """The trace of a validation."""
    from harness.experiment.run_cell import run_cell

    run_cell(make_cell(), tmp_path / "cell", lambda steps: None)
    ValidatePolicy(tmp_path / "cell", 8).do(tmp_path / "validation", lambda steps: None)
    return tmp_path / "validation" / EVALUATION


def _pay_otherwise(path: Path) -> None:
    """Write the trace again with every reward a thousand times as large, plus one."""
    table = pq.read_table(path)
    for name in REWARDS:
        index = table.schema.get_field_index(name)
        table = table.set_column(index, name, pc.add(pc.multiply(table.column(name), 1000.0), 1.0))
    pq.write_table(table, path)


def _judge(path: Path, registry: Registry) -> Outcome:
    metrics = [registry.get("metrics", name).load()() for name in ("success_rate", "final_distance")]
    return outcome_of(read_trace(path), *metrics)


def _judge_by_return(path: Path) -> float:
    """The mutant: what a tuner must not do."""
    return float(read_trace(path)["reward"].sum())


def test_outcome_does_not_see_what_a_reward_pays(toys, recorded):
    """Another scale of the reward leaves the outcome as it is; a tuner that took the return would be moved."""
    before, before_mutant = _judge(recorded, toys), _judge_by_return(recorded)
    _pay_otherwise(recorded)
    assert _judge(recorded, toys) == before
    assert _judge_by_return(recorded) != before_mutant
