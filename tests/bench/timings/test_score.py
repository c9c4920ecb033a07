"""How fast recorded runs are scored again."""

from dataclasses import dataclass

import numpy as np
import pytest

from harness.record.trace import Trace
from harness.registry.choice import choose
from harness.registry.registry import load_registry
from harness.score.scorer import Scorer, score_trace

pytestmark = pytest.mark.bench
ROWS, PIECE, EPISODE = 4_000_000, 65_536, 101
FLOOR = 20e6


@dataclass
class Rows:
    """Consecutive rows of one run."""

    start: np.ndarray
    begin_distance: np.ndarray
    previous_best: np.ndarray
    distance: np.ndarray


@pytest.fixture(scope="module", name="rows")
def _rows() -> Rows:
    """A long run: episodes of 100 steps after their start row, distances that go up and down."""
    rng = np.random.default_rng(0)
    episodes = rng.uniform(0.0, 1.0, (ROWS // EPISODE, EPISODE))
    begin = np.repeat(episodes[:, :1], EPISODE, axis=1)
    best = np.minimum.accumulate(episodes, axis=1)
    best = np.concatenate([begin[:, :1], best[:, :-1]], axis=1)
    start = np.zeros(episodes.shape, bool)
    start[:, 0] = True
    return Rows(*(np.ascontiguousarray(column.ravel()) for column in (start, begin, best, episodes)))


def _reward(name: str):
    registry = load_registry()
    return choose(registry, "rewards", name).build(registry, "rewards")


def _require_speed(benchmark, rows: int, work) -> None:
    benchmark.pedantic(work, rounds=7, warmup_rounds=1)
    speed = rows / benchmark.stats.stats.median
    benchmark.extra_info["rows_per_second"] = speed
    print(f"\n  {speed / 1e6:.0f} million rows per second")  # noqa: T201
    assert speed >= FLOOR


@pytest.mark.parametrize("name", ["baseline", "arp"])
def test_pieces_are_scored_at_twenty_million_rows_per_second(benchmark, rows: Rows, name: str):
    """One core, pieces of 65,536 rows, as files are read."""
    reward = _reward(name)
    columns = (rows.start, rows.begin_distance, rows.previous_best, rows.distance)
    pieces = [Rows(*(column[at : at + PIECE] for column in columns)) for at in range(0, len(rows.distance), PIECE)]

    def work() -> None:
        scorer = Scorer(reward)
        for piece in pieces:
            scorer.score(piece)

    _require_speed(benchmark, len(rows.distance), work)


@pytest.mark.parametrize("name", ["baseline", "arp"])
def test_whole_runs_are_scored_at_twenty_million_rows_per_second(benchmark, rows: Rows, name: str):
    """One core, all rows at once."""
    reward = _reward(name)
    _require_speed(benchmark, len(rows.distance), lambda: Scorer(reward).score(rows))


@pytest.mark.parametrize("name", ["baseline", "arp"])
def test_traces_are_scored_at_twenty_million_rows_per_second(benchmark, rows: Rows, name: str):
    """One core, a trace in memory, recorded in one env."""
    reward = _reward(name)
    step = np.tile(np.arange(EPISODE, dtype=np.int32), len(rows.distance) // EPISODE)
    columns = {"env": np.zeros_like(step), "step": step, "reward": rows.distance, **vars(rows)}
    _require_speed(benchmark, len(step), lambda: score_trace(reward, Trace(columns)))
