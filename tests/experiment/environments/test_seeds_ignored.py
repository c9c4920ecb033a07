"""An environment that draws its starts from a generator of its own: no report claims that they were the same."""

import harness
from harness.report import beside_answer
from tests.experiment.trials.conftest import ENVS


def test_a_seed_that_is_ignored_is_told_beside_the_answer(tmp_path):
    """Each policy met episodes of its own; `test_environment_trial` says what is told before."""
    (tmp_path / "walking.py").write_text(ENVS)
    for name in ("far", "behaviour"):
        (tmp_path / f"{name}.py").write_text(f"def {name}(old, action, new, info):\n    return float(new[0] > 0)\n")
    results = harness.run(
        task="walking:start=numpy", algo="random", seeds=1, steps=16, evaluation_episodes=3, jobs=1,
        plugins=[tmp_path / "*.py"], out=tmp_path / "runs",
    )  # fmt: skip
    told = beside_answer(results.combinations[0])
    assert any(line.startswith("The policies did not meet the same starts") for line in told)
    assert any("did not meet the same starts" in note for note in results.notes)
