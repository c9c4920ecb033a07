import numpy as np
import pyarrow.parquet as pq
import pytest

from harness import load_registry
from harness.env.vector_env import ReachVectorEnv
from harness.record import TraceWriter
from harness.registry import choose, read_given
from harness.score.open_steps import open_steps
from harness.score.rescore import rescore
from harness.task import ReachTask
from harness_plugins.kit import IdealSimulator
from harness_plugins.kit.trainings import NegativeDistance
from tests.refusals import refused
from tests.registered import FD100

HEADER = "t,beginDistance,prevBest,distance,delta_distance,reward"
ROWS = [
    "0,1.0,1.0,1.0,0,0",
    "1,1.0,0.8,0.8,-0.2,0.3",
    "2,1.0,0.8,0.9,0.1,-0.1",
    "0,2.0,2.0,2.0,0,0",
    "1,2.0,1.5,1.5,-0.5,0.75",
]
LATE = """
def late(step):
    return -abs(step.action).sum(-1) if (step.step > 3.5).any() else -step.distance
"""


@pytest.fixture
def recorded(tmp_path):
    """A file of two short episodes, paid by arp with k2 = 1.5."""
    path = tmp_path / "run.csv"
    path.write_text("\n".join([HEADER, *ROWS]) + "\n")
    return open_steps(path)


def score(log, into, *rewards, plugin=None):
    """Pay a run by rewards, one of which may stand in a file."""
    registry = load_registry(given=read_given(plugin and [plugin]))
    return rescore(log, [choose(registry, "rewards", name) for name in rewards], into, registry)


def test_each_reward_gets_a_column(recorded, tmp_path):
    """What it would have paid, start rows nothing; scoring once more adds one, and the recording stays as it is."""
    before, path = recorded.facts.path.read_bytes(), tmp_path / "s.parquet"
    score(recorded, path, "baseline", "arp")
    score(recorded, path, "arp:k2=2")
    table = pq.read_table(path).to_pydict()
    assert table.keys() == {"baseline", "arp", "arp:k2=2"}
    np.testing.assert_allclose(table["baseline"], [0, 0.2, -0.1, 0, 0.5], rtol=1e-12)
    np.testing.assert_allclose(table["arp"], [0, 0.3, -0.1, 0, 0.75], rtol=1e-12)
    assert recorded.facts.path.read_bytes() == before


@pytest.mark.parametrize(
    ("lines", "place", "told"),
    [
        ([HEADER, *ROWS[:3]], "s.parquet", "belongs to another one"),
        (["reward", "1", "2"], "new.parquet", "records no distances"),
        ([HEADER, *ROWS], "run.csv/s.parquet", "cannot be written"),
    ],
    ids=["scores of another recording", "rewards alone", "a folder that is a file"],
)
def test_what_cannot_be_scored_is_told(recorded, tmp_path, lines, place, told):
    """In one line, and nothing is overwritten."""
    score(recorded, tmp_path / "s.parquet", "arp")
    other = tmp_path / "other.csv"
    other.write_text("\n".join(lines) + "\n")
    with refused(told):
        score(open_steps(other), tmp_path / place, "arp")


def test_what_a_run_does_not_have_is_said_with_what_to_do(recorded, tmp_path):
    """Joint speeds are recorded where a reward reads them."""
    swift = tmp_path / "swift.py"
    swift.write_text("def swift(step):\n    return -(step.qvel**2).sum(-1)\n")
    failed = score(recorded, tmp_path / "s.parquet", "swift", plugin=swift)
    assert failed["swift"].startswith("The recorded run has no 'qvel'. It has: begin_distance, ")
    assert failed["swift"].endswith(
        "qvel is recorded where a reward of the experiment reads it: train in a new folder beside this one"
    )


def test_a_field_that_is_read_in_some_steps_alone_is_found(tmp_path):
    """Made-up steps do not show it: the reward is called again with all that the run has."""
    late = tmp_path / "late.py"
    late.write_text(LATE)
    path = tmp_path / "trace.parquet"
    with TraceWriter(path, 6, 6) as recorder:
        env = ReachVectorEnv(IdealSimulator(), FD100, ReachTask(horizon=9), NegativeDistance(), recorder=recorder)
        env.reset(seed=0)
        for _ in range(9):
            env.step(np.full((1, 6), 0.5, np.float32))
    assert score(open_steps(path), tmp_path / "s.parquet", "late", plugin=late) == {}
    np.testing.assert_allclose(pq.read_table(tmp_path / "s.parquet")["late"].to_numpy()[1:], -3.0)
