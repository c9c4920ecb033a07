"""The default run: does it learn, and how long does it take?"""

import pytest

import harness

pytestmark = pytest.mark.bench


def test_the_default_run_learns_within_five_minutes(tmp_path, benchmark):
    """Baseline and ARP, 3 seeds of 10,000 steps: success at least 0.6 under both, below 0.1 at random, in 5 minutes."""
    results = benchmark.pedantic(lambda: harness.run(sim="mujoco", algo="sac", out=tmp_path / "run"), rounds=1)
    success = results.combinations[0].to_json()["success"]
    print(f"\n  success {success}, {benchmark.stats.stats.max:.0f} s")  # noqa: T201
    assert not results.failed
    assert success["baseline"] >= 0.6
    assert success["proposed"] >= 0.6
    assert success["random"] < 0.1
    assert benchmark.stats.stats.max < 300
