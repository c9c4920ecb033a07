"""An audit, as a terminal shows it."""

from dataclasses import asdict
from io import StringIO

import pytest
from rich.console import Console

from harness.reward.forms import reward_class
from harness.text import number
from harness_plugins.audit.audit import audit_table
from harness_plugins.audit.scripts import audit_reward
from harness_plugins.rewards.arp import Arp
from harness_plugins.rewards.baseline import Baseline


@pytest.fixture(scope="module")
def found(rollouts):
    """ARP beside the baseline."""
    return audit_reward(Arp(), Baseline(), rollouts, 0.95, ("arp", "baseline"), "no engine")


def printed(found, width=80):
    """What goes to a terminal of that width."""
    output = StringIO()
    Console(file=output, width=width).print(audit_table(found))
    return output.getvalue()


@pytest.mark.parametrize("width", [60, 80])
def test_every_policy_and_number_is_whole(found, width):
    """Also in a narrow terminal."""
    text = printed(found, width)
    assert "…" not in text
    for payoff in found.scripts.finishing.payoffs:
        (line,) = (line for line in text.splitlines() if line.startswith(f"{payoff.policy} ") and line.endswith("%"))
        numbers = asdict(payoff)
        assert all(number(numbers[name]) in line for name in ("total", "shaped", "total_discounted"))


def test_both_distances_have_a_line_each(found):
    """With the value, and what it is."""
    lines, forms = printed(found).splitlines(), found.pairs[0].forms
    assert "baseline and arp" in [line.rstrip() for line in lines]
    for name in ("EPIC", "DARD"):
        assert any(line.startswith(f"{name} distance         {forms[name].mean:.3f}  ") for line in lines)
    assert forms["EPIC"] != forms["DARD"]


def test_what_has_no_distance_says_so(rollouts, toolbox):
    """Shaping alone is at no distance from the baseline, in both."""
    text = printed(audit_reward(toolbox.potential(0.95), Baseline(), rollouts, 0.95), 120)
    told = "EPIC, DARD            n/a    one of the two is nothing but an offset and shaping by a potential"
    assert told in [line.rstrip() for line in text.splitlines()]


def test_labels_are_no_markup(rollouts):
    """They may hold brackets."""
    text = printed(audit_reward(Arp(), Baseline(), rollouts, 0.95, ("[bold]arp[/bold]", "[b]")))
    assert text.startswith("[bold]arp[/bold]")
    assert "[b] and [bold]arp[/bold]" in text


def test_a_reward_that_is_another_but_for_its_scale_is_told(found, rollouts):
    """The table of another reward does not speak of it."""
    twin = audit_reward(Baseline(), Baseline(), rollouts, 0.95, ("twin", "baseline"))
    text = " ".join(printed(twin).split())
    assert "twin pays the same as baseline, in all " in text
    assert "Event terms are the task's, and stay as they are." in text
    assert "Event terms" not in printed(found)


def of_steps(step):
    """Three terms, one of which never pays."""
    effort = -0.01 * (step.action**2).sum(-1)
    return {"reach": -step.distance, "effort": effort, "dock": 1.0 * (step.distance < -1.0)}


@pytest.fixture(scope="module")
def with_terms(rollouts):
    """A function of steps beside the baseline."""
    return audit_reward(reward_class(of_steps)(), Baseline(), rollouts, 0.95)


@pytest.mark.parametrize("width", [60, 80])
def test_each_term_has_a_row(with_terms, width):
    """With what it paid each policy, in the order of the first table; a reward without terms has no such table."""
    lines = [line.rstrip() for line in printed(with_terms, width).splitlines()]
    head = lines.index("What each term paid in an episode, without discount:") + 2
    assert lines[head].split() == ["term", *(payoff.policy for payoff in with_terms.scripts.finishing.payoffs)]
    for row, term in enumerate(("reach", "effort", "dock"), head + 2):
        assert lines[row].split() == [
            term,
            *(number(payoff.terms[term]) for payoff in with_terms.scripts.finishing.payoffs),
        ]


def test_a_reward_without_terms_has_no_table_of_them(found):
    """It is printed as ever."""
    assert "each term" not in printed(found)


def test_a_term_that_never_paid_is_said(with_terms):
    """With the number of steps."""
    assert f"The term 'dock' never paid in {with_terms.scripts.finishing.steps:,} steps." in printed(with_terms)
    assert "'effort' never" not in printed(with_terms)


def test_what_cannot_be_asked_says_so_once(with_terms):
    """The field is named, and no property is answered."""
    text = printed(with_terms, 100)
    assert text.count("not asked: it reads action, which made-up distances do not have") == 1
    assert "potential-based             n/a" not in text
    for name in ("bounded", "scale-free", "potential-based", "all distances times 2"):
        assert name in text


def test_distances_of_recorded_transitions_say_so(with_terms, found):
    """EPIC, DARD and STARC have a line each, and a sentence says why; other rewards are not told of it."""
    text = " ".join(printed(with_terms, 100).split())
    for name in ("EPIC", "DARD", "STARC"):
        assert f"{name} distance {with_terms.pairs[0].forms[name].mean:.3f}" in text
    assert "computed from recorded transitions, because a reward reads action, and not distances alone" in text
    assert "recorded transitions" not in printed(found)
    assert "STARC" not in printed(found)
