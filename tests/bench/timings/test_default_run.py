"""`harness run --sim mujoco --algo sb3-sac`, beside stable-baselines3 alone that does the same trainings."""

import sys

import pytest

import harness
from harness.results import Results
from tests.bench.timings.conftest import cpu_seconds
from tests.bench.timings.processes import measure

pytestmark = pytest.mark.bench
SEEDS, STEPS = 1, 2_500
BARE = """
import sys
from harness.env.vector_env import ReachEnv
from harness_plugins.algorithms.sac import Sac
from tests.bench.timings.bare import bare_training
steps, *seeds = map(int, sys.argv[1:])
for seed in seeds:
    bare_training(Sac(), [ReachEnv()], steps, seed)()
"""
"""The trainings of one job, one after the other, without a record and without an evaluation."""


def test_the_default_run_beside_its_bare_trainings(tmp_path, amount, require_ratio):
    """Of fewer steps, and so with a larger share of evaluations and starts; both rewards, two processes each."""
    seeds, steps = amount(SEEDS, 1), amount(STEPS, 2)
    programs = amount(2, 1)
    bare = sum(measure(sys.executable, "-c", BARE, steps, *range(seeds)).cpu_seconds for _ in range(programs))
    runs = list[Results]()
    job = {"sim": "mujoco", "algo": "sb3-sac", "reward": "arp", "seeds": seeds, "steps": steps}
    took = cpu_seconds(lambda: runs.append(harness.run(**job, jobs=programs, out=tmp_path / "run")))
    assert len(runs[0].done) == 2 * seeds
    assert not runs[0].failed
    require_ratio(bare / took, 0.6, f"(bare {bare:.0f} s, run {took:.0f} s of CPU time)")
