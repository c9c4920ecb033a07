"""An audit, as a terminal shows it."""

from dataclasses import asdict
from io import StringIO

import pytest
from rich.console import Console

from harness.text import number
from harness_plugins.audit import audit_reward, audit_table
from tests.payoff.conftest import ARP, BASELINE, Paying, potential


@pytest.fixture(scope="module")
def audited(rollouts):
    """A reward beside the baseline."""
    return lambda reward, *names: audit_reward(reward, BASELINE, rollouts, 0.95, *names)


@pytest.fixture(scope="module")
def found(audited):
    """ARP beside the baseline."""
    return audited(ARP, ("arp", "baseline"), "no engine")


@pytest.fixture(scope="module")
def with_terms(audited):
    """Three terms, one of which never pays."""

    def of_steps(step):
        effort = -0.01 * (step.action**2).sum(-1)
        return {"reach": -step.distance, "effort": effort, "dock": 1.0 * (step.distance < -1.0)}

    return audited(Paying(of_steps))


def printed(found, width=80):
    """The lines that go to a terminal of that width."""
    output = StringIO()
    Console(file=output, width=width).print(audit_table(found))
    return [line.rstrip() for line in output.getvalue().splitlines()]


def said(found, width=100):
    """The same as words."""
    return " ".join(" ".join(printed(found, width)).split())


@pytest.mark.parametrize("width", [60, 80])
def test_every_policy_and_number_is_whole(found, width):
    """Also in a narrow terminal."""
    lines = printed(found, width)
    assert "…" not in "".join(lines)
    for payoff in found.scripts.finishing.payoffs:
        (line,) = (line for line in lines if line.startswith(f"{payoff.policy} ") and line.endswith("%"))
        assert all(number(asdict(payoff)[name]) in line for name in ("total", "shaped", "total_discounted"))


def test_both_distances_have_a_line_each(found):
    """With the value, and what it is."""
    lines, forms = printed(found), found.pairs[0].forms
    assert "baseline and arp" in lines
    for name in ("EPIC", "DARD"):
        assert any(line.startswith(f"{name} distance         {forms[name].value:.3f}  ") for line in lines)
    assert forms["EPIC"] != forms["DARD"]


def test_what_has_no_distance_says_so(audited):
    """Shaping alone is at no distance from the baseline, in any form."""
    told = "EPIC, DARD, STARC     n/a    one of the two is nothing but an offset and shaping by a potential"
    assert told in printed(audited(potential(0.95)), 120)


def test_labels_are_no_markup(audited):
    """They may hold brackets."""
    lines = printed(audited(ARP, ("[bold]arp[/bold]", "[b]")))
    assert lines[0].startswith("[bold]arp[/bold]")
    assert "[b] and [bold]arp[/bold]" in lines


def test_a_reward_that_is_another_but_for_its_scale_is_told(audited, found):
    """The table of another reward does not speak of it, nor of what it has not."""
    text = said(audited(BASELINE, ("twin", "baseline")))
    assert "twin pays the same as baseline, in all " in text
    assert "Event terms are the task's, and stay as they are." in text
    other = said(found)
    assert not [it for it in ("Event terms", "each term") if it in other]


@pytest.mark.parametrize("width", [60, 80])
def test_each_term_has_a_row(with_terms, width):
    """With what it paid each policy, in the order of the first table."""
    lines, payoffs = printed(with_terms, width), with_terms.scripts.finishing.payoffs
    head = lines.index("What each term paid in an episode, without discount:") + 2
    assert lines[head].split() == ["term", *(payoff.policy for payoff in payoffs)]
    for row, term in enumerate(("reach", "effort", "dock"), head + 2):
        assert lines[row].split() == [term, *(number(payoff.terms[term]) for payoff in payoffs)]


def test_what_terms_did_not_do_and_what_cannot_be_asked_is_said(with_terms):
    """A term that never paid, with the number of steps; the field that is read, once, and no property is answered."""
    text, lines = said(with_terms), "\n".join(printed(with_terms, 100))
    assert f"The term 'dock' never paid in {with_terms.scripts.finishing.steps:,} steps." in text
    assert "'effort' never" not in text
    assert text.count("not asked: it reads action, which made-up distances do not have") == 1
    assert "potential-based             n/a" not in lines
    for name in ("bounded", "scale-free", "potential-based", "all distances times 2"):
        assert name in text
    for name in ("EPIC", "DARD", "STARC"):
        assert f"{name} distance {with_terms.pairs[0].forms[name].value:.3f}" in text
