"""A term that is the sum of the others is told at every door through which terms come."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.reward.terms import paid_twice

TWICE = """
def twice(step):
    near, effort = -step.distance, -0.1 * (step.action**2).sum(-1)
    return {"near": near, "effort": effort, "all": near + effort}
"""
OF_STEPS = """
def twice(step):
    near, effort = -abs(float(step.observation[2])), -0.1 * float(step.action[0]) ** 2
    return {"near": near, "effort": effort, "all": near + effort}


def calm(step):
    return {"near": -abs(float(step.observation[2])), "effort": -0.1 * float(step.action[0]) ** 2}
"""
RECORD = """
import gymnasium, harness
from twice import twice, calm
rewards = {"own": "own", "twice": twice, "calm": calm}
env = harness.RecordRewards(gymnasium.make("Pendulum-v1"), "runs/own-0", trained_with="own", rewards=rewards)
env.reset(seed=0)
for _ in range(400):
    if env.step(env.action_space.sample())[3]:
        env.reset()
env.close()
"""
ENV = "--executor here --seeds 1 --evaluation-episodes 1 --algo random --task Pendulum-v1 --reward twice"
ARM = "run --sim kinematic --algo random --reward twice --baseline none --seeds 1 --evaluation-episodes 1 --out mine"
DOORS = {
    "run of an arm": (TWICE, f"{ARM} --steps 30 --plugin twice.py --executor here"),
    "run of an environment": (OF_STEPS, f"run {ENV} --steps 230 --plugin twice.py --out mine"),
    "audit of an arm's reward": (TWICE, "audit --reward twice --plugin twice.py --episodes 6 --budget 0"),
    "audit of an environment's reward": (
        OF_STEPS.partition("def calm")[0],
        "audit Pendulum-v1 --reward twice --plugin twice.py --budget 1000",
    ),
}


@pytest.mark.parametrize("door", DOORS)
def test_a_sum_of_other_terms_is_told(harness, tmp_path, door):
    """By name, in the terminal."""
    source, line = DOORS[door]
    (tmp_path / "twice.py").write_text(source)
    answer = harness(line)
    told = " ".join(f"{answer.out} {answer.err}".split())
    assert "he term 'all' is the sum of all others in all " in told


def test_a_recorder_and_the_report_of_it_tell_it(harness, tmp_path, monkeypatch):
    """Of the one of two rewards that has it: while steps are taken, and in the report."""
    (tmp_path / "twice.py").write_text(OF_STEPS)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.warns(match="reward 'twice': the term 'all' is the sum of all others in all 256 steps") as warned:
        exec(compile(RECORD, "record.py", "exec"), {})
    assert len(warned) == 1
    assert "reward 'twice': the term 'all' is the sum" in " ".join(harness("report runs").out.split())


@given(st.lists(st.tuples(st.floats(-9, 9), st.floats(-9, 9)), min_size=2, max_size=30), st.booleans())
def test_only_a_sum_in_every_step_is_one(rows, is_broken):
    """The mutant is one step that is off; what never changes, and what pays nothing, is no sum."""
    a, b = (np.array(it) for it in zip(*rows, strict=True))
    total = a + b
    if is_broken:
        total = total + np.eye(len(a))[0]
    found = paid_twice({"a": a, "b": b, "none": 0.0 * a, "sum": total})
    if found == "sum":
        assert np.allclose(total, a + b, rtol=1e-4, atol=1e-6)
    elif not found:
        assert is_broken or np.ptp(total) == 0.0 or not (total.any() and a.any() and b.any())
    assert paid_twice({"alive": np.ones(5), "healthy": np.ones(5)}) == ""
