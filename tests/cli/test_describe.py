import pytest


def test_the_task_is_described_as_the_tuple(harness):
    """`describe fd100-reach` has S with 18 numbers of Table I, A, T and R."""
    out = harness("describe", "fd100-reach").out
    for text in (
        "S, the state: 18 numbers",
        "A, the actions: MoveJ",
        "T, the transition",
        "R, the reward",
        "s_j6-accel",
    ):
        assert text in out


def test_overrides_show_in_the_description(harness):
    """A description is that of the parameters given."""
    assert "epsilon = 0.02 m" in harness("describe", "fd100-reach:epsilon=0.02").out


@pytest.mark.parametrize("name", ["arp", "baseline", "mujoco", "fd100", "success_rate", "processes"])
def test_whatever_is_listed_can_be_described(harness, name):
    """Every kind of name has a description."""
    answer = harness("describe", name)
    assert answer.status == 0
    assert name in answer.out


def test_the_reward_explains_the_contradiction_of_its_sources(harness):
    """Who picks ARP reads which settings were published."""
    out = harness("describe", "arp").out
    assert "k1 = 1, k2 = 2" in out
    assert "1.5" in out


def test_unknown_names_are_refused(harness):
    """A wrong name ends with status 2 and the nearest match."""
    answer = harness("describe", "fd100-reech")
    assert answer.status == 2
    assert "Did you mean 'fd100-reach'?" in answer.err
