"""Timings side by side: what is compared takes turns in one run, and every bound is a ratio.

Under ``-m bench`` (make bench) the bounds hold. Elsewhere each timing runs once, on little work and without its bound,
so that one that no longer works is seen at once. The ratios of a run are written to the file that the environment
variable ``BENCH_RECORD`` names, if it names one.
"""

import json
import os
import resource
import statistics
from pathlib import Path

import numpy as np
import pytest
from numpy.random import default_rng

import harness
from harness.record import TraceWriter

RATIOS = pytest.StashKey[dict[str, dict[str, float]]]()
"""What a run measured: by the name of a timing its ratio and its bound."""


def pytest_configure(config):
    """Begin with nothing."""
    config.stash[RATIOS] = {}


def pytest_sessionfinish(session):
    """Write down what was measured."""
    if path := os.environ.get("BENCH_RECORD"):
        Path(path).write_text(json.dumps(session.config.stash[RATIOS], indent=1) + "\n")


@pytest.fixture(scope="session")
def is_timed(request):
    """Whether the bounds hold."""
    option = request.config.getoption
    return option("markexpr") == "bench" and not option("benchmark_disable")


@pytest.fixture(scope="session")
def amount(is_timed):
    """How much work to do: `full` where bounds hold, `little` elsewhere."""
    return lambda full, little: full if is_timed else little


def cpu_seconds(function):
    """How long one call had a core, here and in the processes that it started and that have ended, [s]."""
    start = _cpu_time()
    function()
    return _cpu_time() - start


def _cpu_time():
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(it.ru_utime + it.ru_stime for it in used)


@pytest.fixture
def require_ratio(request, is_timed):
    """Hold a ratio to its bound where bounds hold. It is printed, with `told` behind it, and written down."""

    def require(ratio, at_least, told="", what=""):
        test = f"{request.path.stem}: {request.node.name}" + (f", {what}" if what else "")
        name = test.replace("test_", "").replace("_", " ").replace("[", ", ").replace("]", "")
        print(f"\n  ratio {ratio:.3f}, at least {at_least:.3f} {told}")  # noqa: T201
        if is_timed:
            request.config.stash[RATIOS][name] = {"ratio": ratio, "at_least": at_least}
            assert ratio >= at_least

    return require


@pytest.fixture
def require_speed(request, is_timed, require_ratio):
    """Hold `candidate` to at least so many times the speed of `reference`; both do the same work.

    Times are CPU times: what else the machine does hardly changes them. Both take turns, so that a slow moment meets
    both; what counts is the median of the turns' ratios. It and both median times are printed, and stand in the
    benchmark's extra info.
    """

    def require(reference, candidate, at_least, rounds=9):
        if not is_timed:
            reference()
            candidate()
            return
        benchmark, before, after = request.getfixturevalue("benchmark"), list[float](), list[float]()
        benchmark.pedantic(
            lambda: after.append(cpu_seconds(candidate)),
            setup=lambda: before.append(cpu_seconds(reference)),
            rounds=rounds,
            warmup_rounds=1,
        )
        pairs = list(zip(before[1:], after[1:], strict=True))  # the first were the warm-up's
        ratio = statistics.median(first / second for first, second in pairs)
        medians = [statistics.median(column) for column in zip(*pairs, strict=True)]
        benchmark.extra_info.update(ratio=ratio, at_least=at_least, reference_s=medians[0], candidate_s=medians[1])
        require_ratio(ratio, at_least, "(reference {:.4g} s, candidate {:.4g} s)".format(*medians))

    return require


@pytest.fixture
def recorded_env(tmp_path, step_through, amount):
    """Makes an env that writes its trace, and a function that takes so many steps in it from the same beginning."""

    def make(simulator, steps):
        env = harness.make_env(simulator)
        env.recorder = TraceWriter(tmp_path / "trace.parquet", env.robot.dof, env.robot.dof)
        actions = default_rng(0).uniform(-1.0, 1.0, (amount(steps, 10), 1, 6)).astype(np.float32)

        def through_the_env():
            env.reset(seed=0)
            step_through(env, actions)

        return env, through_the_env

    return make


@pytest.fixture(scope="session")
def step_through():
    """Give an env actions, one after another; all of its envs have to take each."""

    def step(env, actions):
        before = env.environment_steps
        for action in actions:
            env.step(action)
        assert env.environment_steps - before == len(actions) * env.num_envs > 0

    return step
