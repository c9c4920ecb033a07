"""The how-to pages whose programs measure or train: with less work they do what the pages say."""

import os
import runpy
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from harness import load_results
from harness.env.vector_env import ReachVectorEnv
from harness.policy import load_policy
from tests.docs.pages import ROOT, blocks_of

STEP = "benchmark(env.step, env.action_space.sample())"
TWICE = "benchmark(lambda action: (env.step(action), env.step(action)), env.action_space.sample())"


def _blocks(page, language):
    return [it.text for it in blocks_of(page, (ROOT / "docs" / page).read_text()) if it.language == language]


def test_a_package_that_became_slower_is_noticed(pytester, monkeypatch):
    """By the commands of the page: twice the work fails. The same work passes, on a busy machine not at once."""
    monkeypatch.delenv("PYTEST_XDIST_WORKER", raising=False)  # beside other workers pytest-benchmark measures nothing
    [program] = _blocks("how-to/timings.md", "python")
    keep, compare = (shlex.split(it)[1:] for it in _blocks("how-to/timings.md", ""))

    def became_slower(arguments, step=STEP):
        (pytester.path / "test_speed.py").write_text(program.replace(STEP, step))
        ran = pytester.runpytest_inprocess(*arguments, "--benchmark-max-time=0.5")
        is_slower = "test_step" in ran.stdout.str() and "PerformanceRegression" in ran.stderr.str()
        assert is_slower == (ran.ret != 0)
        return is_slower

    assert not became_slower(keep)
    assert not all(became_slower(compare) for _ in range(4))
    assert became_slower(compare, TWICE)


@pytest.fixture
def search(toys, tmp_path, monkeypatch):
    """Do so many trials by the program of the page, with few steps; what its names hold in the end."""
    pytest.importorskip("optuna")
    monkeypatch.chdir(tmp_path)
    [program] = _blocks("how-to/tune.md", "python")
    for long, short in (("10_000, [1000, 1001], 100", "60, [1000], 4"), (", out=", ", executor='here', out=")):
        assert long in program
        program = program.replace(long, short)
    program = program.replace('out="tuned"', 'seeds=1, steps=60, evaluation_episodes=2, out="tuned"')

    def do(trials):
        Path("page.py").write_text(program.replace("EPISODES = 20,", f"EPISODES = {trials},"))
        return runpy.run_path("page.py")

    return do


def test_a_search_goes_on_with_other_draws_for_both_rewards(search):
    """Each reward gets as many trials, and no setting twice; both choices are compared under both."""
    search(2)
    told = search(3)
    storage = told["JournalStorage"](told["journal"].JournalFileBackend("tuning.log"))
    for reward in ("baseline", "arp"):
        trials = told["optuna"].load_study(study_name=reward, storage=storage).trials
        assert len({it.params["gamma"] for it in trials}) == len(trials) == 3
    assert {it.reward.name for it in told["results"].done_cells} == {"baseline", "arp"}


def test_settings_are_chosen_by_episodes_that_nothing_else_uses(search, monkeypatch):
    """What a report judges by is not among them."""
    reset, seeds = ReachVectorEnv.reset, list[Any]()

    def noted(env, *, seed=None, **given):
        seeds.append(seed)
        return reset(env, seed=seed, **given)

    monkeypatch.setattr(ReachVectorEnv, "reset", noted)
    told = search(1)
    before = len(seeds)
    told["success"](next(map(load_policy, Path("tuning").glob("*/cells/*/policy"))))
    assert seeds[before:] == [20_230_705]
    assert seeds[:before].count(20_230_705) == 2  # of a trial for each reward


def test_the_jobs_of_an_array_make_one_experiment(tmp_path):
    """Each job does one seed; merged, they are the experiment."""
    [script] = _blocks("executors.md", "bash")
    merge = next(it for it in _blocks("executors.md", "") if "merge" in it)
    (tmp_path / "array.sh").write_text(script)
    (tmp_path / "experiment.toml").write_text(
        'sim = "kinematic"\nalgo = "random"\nreward = "arp"\nseeds = 2\nsteps = 60\nevaluation_episodes = 2\n'
    )
    with_harness = {**os.environ, "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])}
    for job in "01":
        told = with_harness | {"SLURM_ARRAY_TASK_ID": job}
        subprocess.run(["bash", "array.sh"], cwd=tmp_path, env=told, check=True, capture_output=True)
    subprocess.run(["bash", "-ec", merge], cwd=tmp_path, env=with_harness, check=True, capture_output=True)
    assert {(cell.reward.name, cell.seed) for cell in load_results(tmp_path / "all").done_cells} == {
        (reward, seed) for reward in ("baseline", "arp") for seed in (0, 1)
    }
