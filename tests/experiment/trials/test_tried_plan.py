"""What a trial finds is refused, or left out and told; what is left is what would have been planned without it."""

import re
from dataclasses import replace

import pytest

import harness
from harness.experiment.experiment import check
from harness.experiment.plan import check_experiment
from harness.experiment.run_options import RunOptions
from harness.experiment.trials.tried_plan import try_plan
from harness.record import Terms
from tests.experiment.trials.conftest import planned
from tests.refusals import refused

GOOD, BAD = "return 1.0", "return 1 / 0"


def test_what_works_leaves_the_plan_as_it_is(lay):
    """And the registry."""
    plan, registry = planned(lay(far=GOOD))
    assert try_plan(plan, registry) == (plan, registry)


def test_rewards_of_our_own_arms_start_no_process(monkeypatch):
    """They are tested already."""
    monkeypatch.setattr("harness.experiment.trials.tried_plan.try_tasks", lambda works: pytest.fail("a process began"))
    plan, registry = planned((), task="fd100-reach", sim="kinematic", reward="arp", steps=100)
    assert try_plan(plan, registry) == (plan, registry)


def test_named_file_that_fails_is_refused(lay):
    """Before anything is written, with what it did and where."""
    plan, registry = planned(lay(far=GOOD, bad=BAD))
    with refused(r"reward 'bad' \('.*bad\.py'\) fails in step 0: ZeroDivisionError.*bad\.py, li"):
        try_plan(plan, registry)


def test_file_that_a_pattern_found_is_left_out_and_told(lay):
    """The cells of all others stay, and no recording asks it."""
    plan, registry = planned(lay(optional=True, far=GOOD, bad=BAD))
    tried, without = try_plan(plan, registry)
    assert tried.cells == tuple(cell for cell in plan.cells if cell.reward.label != "bad")
    assert {(cell.reward.label, reason.partition(":")[0]) for cell, reason in tried.skipped} == {
        ("bad", "reward 'bad' fails in step 0")
    }
    assert any(
        line.startswith("Left out, tried in an episode of random actions: reward 'bad'") for line in tried.warnings
    )
    assert [*without.functions_of("reward")] == ["far"]
    assert "bad" not in tried.resolved["reward"]
    assert not any("bad.py" in need["path"] for need in tried.resolved["plugins"])


def test_other_functions_of_its_file_stay(lay, tmp_path):
    """Only the one that fails is not asked."""
    lay()
    head = "(observation, action, next_observation, info):\n    "
    (tmp_path / "two.py").write_text(f"def one{head}return 1.0\n\ndef other{head}return 1 / 0\n")
    plan, registry = planned(lay(optional=True))
    _, without = try_plan(plan, registry)
    assert [*without.functions_of("reward")] == ["one"]


def test_choosing_goes_on_without_a_named_candidate(lay):
    """Whatever its file; it is told."""
    plan, registry = planned(lay(far=GOOD, bad=BAD))
    tried, _ = try_plan(replace(plan, terms=Terms(budget=9)), registry)
    assert {cell.reward.label for cell in tried.cells} == {"own", "far"}


@pytest.mark.parametrize(
    ("keys", "files", "told"),
    [
        ({"baseline": "bad"}, {"bad": BAD, "far": GOOD}, "reward 'bad'"),
        ({"task": "walking:tells=success"}, {"far": GOOD}, "Did you mean 'is_success'?"),
        ({}, {"bad": BAD}, "Nothing is left to compare"),
    ],
)
def test_what_nothing_goes_on_without_is_refused_in_choosing_too(lay, keys, files, told):
    """The baseline, and what measures."""
    plan, registry = planned(lay(optional=True, **files), **keys)
    with refused(re.escape(told)):
        try_plan(replace(plan, terms=Terms(budget=9)), registry)


def test_a_run_is_checked_so_until_all_is_done(lay, tmp_path, monkeypatch):
    """Then nothing is tried again; the seven of others' figures are those of a run without what fails."""
    lay(optional=True, far=GOOD, bad=BAD)
    asked = {"task": "walking", "algo": "random", "seeds": 1, "steps": 16, "evaluation_episodes": 1}
    results = harness.run(**asked, plugins=[tmp_path / "*.py"], out=tmp_path / "runs", jobs=1)
    assert {(it.cell.reward.label, it.status) for it in results.manifests} == {
        ("own", "done"), ("far", "done"), ("bad", "skipped"),
    }  # fmt: skip
    monkeypatch.setattr("harness.experiment.experiment.try_plan", lambda *_: pytest.fail("it was tried again"))
    (tmp_path / "bad.py").unlink()
    check(check_experiment(asked), RunOptions(out=tmp_path / "runs"), lay(optional=True))
