"""A cell's trace by the door of all logs: names, and facts of its manifest."""

import numpy as np

from harness.executor import Cell
from harness.log import episode_facts, open_logs
from harness.record import RANDOM, SCALARS, TRACE, EpisodeFacts, Manifest, TraceWriter, read_trace
from harness.record.cell_log import CellLog
from harness.record.trace import terms_of
from harness.registry import Choice
from tests.registered import REGISTRY

FACTS = EpisodeFacts(horizon=2, control_period=0.1)
CELL = Cell(
    Choice("kinematic", (), "kinematic"), "fd100", Choice("unity-reach", (), "unity-reach"), Choice("ppo", (), "ppo"),
    Choice("arp", (("k2", 1.5),), "arp:k2=1.5"), seed=7, steps=500, evaluation_episodes=3,
)  # fmt: skip


def test_example_has_two_episodes(tmp_path):
    """Without a manifest nobody says which reward paid it."""
    path = CellLog().write_example(tmp_path)
    (log,) = open_logs(path, REGISTRY)
    assert (log.rewards, len(log.episodes), log.facts.unit) == (("recorded",), 2, "step")
    np.testing.assert_array_equal(log["reward/recorded"], [0.0, 0.25, 0.5] * 2)
    np.testing.assert_array_equal(log["start"], [True, False, False] * 2)
    np.testing.assert_array_equal(log["time"], [0, 1, 2, 2, 3, 4])


def test_time_counts_on_over_pieces(tmp_path):
    """Rows come in tables of 65,536."""
    rows = np.zeros((70_000, len(SCALARS) + 4))
    rows[:, SCALARS.index("step")] = np.arange(70_000)
    with TraceWriter(tmp_path / TRACE, 2, 2) as writer:
        writer.append(rows)
    assert [CellLog().recognises(it, b"PAR1") for it in sorted(tmp_path.iterdir())] == [False, True]  # its second part
    (log,) = CellLog().read(tmp_path / TRACE)
    assert [piece["time"][-1] for piece in log.pieces(["time"])] == [65_535, 69_999]


def test_manifest_says_what_was_trained(tmp_path):
    """The label of the reward names its column and those of its terms; evaluations train nothing."""
    CellLog().write_example(tmp_path).rename(tmp_path / RANDOM)
    with TraceWriter(tmp_path / TRACE, 2, 2, facts=FACTS, extras={"reward/near": 1, "reward/calm": 1}) as writer:
        writer.append(np.full((3, len(SCALARS) + 6), 1.0))
    Manifest(cell=CELL, status="done").write(tmp_path)
    (trained,), (at_random,) = (open_logs(tmp_path / name, REGISTRY) for name in (TRACE, RANDOM))
    facts = trained.facts
    assert (facts.trained_with, facts.env, facts.algorithm, facts.seed) == ("arp:k2=1.5", "unity-reach", "ppo", 7)
    assert (facts.asked, facts.evaluation, episode_facts(trained)) == (500, False, FACTS)
    assert (trained.rewards, trained.terms_of("arp:k2=1.5")) == (("arp:k2=1.5",), ("near", "calm"))
    assert "reward" not in trained
    facts = at_random.facts
    assert (facts.evaluation, facts.trained_with, facts.algorithm) == (True, "", "random actions")


def test_other_parquet_files_are_not_recognised(tmp_path):
    """Nor what only begins as one."""
    path = CellLog().write_example(tmp_path)
    content = path.read_bytes()
    assert CellLog().recognises(path, content[:4096])
    path.write_bytes(content[:500])
    assert not CellLog().recognises(path, content[:4096])
    assert not CellLog().recognises(tmp_path, b"")


def test_terms_of_a_trace(tmp_path):
    """By name, in their order."""
    with TraceWriter(tmp_path / TRACE, 2, 2, extras={"reward/near": 1}) as writer:
        writer.append(np.full((2, len(SCALARS) + 5), 0.5))
    assert {name: paid.tolist() for name, paid in terms_of(read_trace(tmp_path / TRACE)).items()} == {"near": [0.5] * 2}
