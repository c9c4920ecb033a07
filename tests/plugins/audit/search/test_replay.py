"""A behaviour is certified if it repeats, and its certificate is refused at the step that differs."""

from dataclasses import replace

import numpy as np
import pytest

from harness_plugins.audit.search.replay import certify, replay
from tests.plugins.audit.search.certified import RUNS_ON, Line, certificate_of, finding_of, place_of


def certified(world, make):
    """What is certified of a finding."""
    return certify(finding_of(world), place_of(), make, RUNS_ON, seed=4, budget=400)


def test_each_behaviour_gets_its_certificate():
    """With its own noise, and what it is paid elsewhere."""
    made, refused = certified(Line(), Line)
    assert [it.role for it in made] == ["failure", "success", "fastest"]
    assert refused == []
    assert [len(it.noise) for it in made] == [3, 3, 3]
    assert made[0].elsewhere == {"other": -2.7}
    assert made[1].elsewhere == {}
    assert [made[0].found[it] for it in ("seed", "budget", "made_by")] == [4, 400, "script"]


def test_what_does_not_repeat_is_not_certified():
    """An episode that begins where the one before ended; the reason is told."""
    made, refused = certified(Line(), lambda: Line(leaks=True))
    assert made == []
    assert len(refused) == 3
    assert refused[0].startswith("near, failure: not certified. Played again, number 1 of paid.terms.near was ")


def test_the_same_is_said_with_its_pay():
    """And how long it was."""
    found = replay(certificate_of(), Line())
    assert not found.is_refused
    assert found.lines[0] == "the same: -3.81 in 20 steps, no success"


def test_a_changed_reward_is_refused_at_its_step():
    """At the first one, and its term is named."""
    found = replay(certificate_of(), Line(scale=1.5), ["The source of the reward is another one."])
    assert found.is_refused
    assert str(found.difference) == "number 1 of paid.terms.near was -0.77, and is -1.155 here"
    assert found.lines[1] == "The source of the reward is another one."


def test_the_last_bit_of_one_step_is_enough():
    """Bit for bit, not nearly."""
    then = certificate_of().shown
    paid = then.paid.copy()
    paid[7] = np.nextafter(paid[7], 1.0)
    found = replay(certificate_of(shown=replace(then, paid=paid)), Line()).difference
    assert (found.field, found.number) == ("paid.steps", 8)


def test_nobody_knows_why():
    """If all that is recorded is as it was."""
    assert replay(certificate_of(), Line(scale=2.0)).lines[1].startswith("Nothing that is recorded has changed")


@pytest.mark.parametrize(
    ("changed", "what"),
    [
        ({"success": np.arange(20) > 11}, "number 13 of behaviour.success was 0, and is 1 here"),
        ({"ended": "terminated"}, "number 1 of behaviour.ended was 'truncated', and is 'terminated' here"),
        ({"paid": np.zeros(0)}, "number 1 of paid.steps was -0.78, and is nothing here"),
    ],
)
def test_other_behaviour_differs_too(changed, what):
    """Success, the end and the length, with the same pay."""

    class Other(Line):
        """Shows that."""

        def show(self, start, actions):
            """As the line, but for it."""
            return replace(super().show(start, actions), **changed)

    assert what == str(replay(certificate_of(), Other()).difference)


def test_another_simulator_tells_its_pay():
    """And refuses nothing."""
    found = replay(certificate_of(), Line(scale=2.0), elsewhere="other")
    assert not found.is_refused
    assert found.lines == ("in other: -7.53 in 20 steps, no success; the file says -3.81 in 20 steps, no success",)


def test_what_does_not_repeat_here_is_refused():
    """Whatever the file says."""
    found = replay(certificate_of(), Line(leaks=True))
    assert found.is_refused
    assert found.reasons == ("It does not repeat itself here.",)
