"""What the rewards of an experiment pay for, asked for its page."""

from harness.cli.output import audits_of
from tests.report.conftest import build_results


def test_every_reward_that_taught_is_asked(tmp_path):
    """Under the robot, task and label that the page knows; creeping pays more than finishing under both."""
    found = audits_of(build_results(tmp_path, seeds=1))
    assert set(found) == {("fd100", "fd100-reach", name) for name in ("baseline", "arp")}
    for payoffs in found.values():
        assert payoffs.verdict[0].startswith("Not finishing pays more than finishing: creep earns ")
        assert payoffs.verdict[1].startswith("FRAGILE: with action noise 0.05, as while it explores, creep earns")
        assert payoffs.returns["creep"] > payoffs.returns["finish"] > payoffs.returns["random"]
        assert payoffs.success["finish"] == 1.0


def test_reward_that_is_gone_says_so(tmp_path):
    """The others are asked all the same."""
    found = audits_of(build_results(tmp_path, seeds=1, proposed={"gone": (9, 30)}))
    assert found["fd100", "fd100-reach", "gone"].verdict[0].startswith("Not known: No reward 'gone'")
    assert found["fd100", "fd100-reach", "gone"].returns == {}
    assert found["fd100", "fd100-reach", "baseline"].returns


def test_reward_that_taught_nothing_is_not_asked(tmp_path):
    """There is nothing to connect it to."""
    ended = {("arp", 0): ("failed", "it broke")}
    assert set(audits_of(build_results(tmp_path, seeds=1, ended=ended))) == {("fd100", "fd100-reach", "baseline")}
