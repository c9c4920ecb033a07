"""The answer to a search, by the three numbers of each start."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness_plugins.audit.search.behaviour import Behaviour, Searched, Three
from harness_plugins.audit.search.finding import CANNOT_TELL, FAILING, LOITERING, NOTHING
from harness_plugins.audit.search.judge import Walk, judge


@dataclass(frozen=True)
class Facts:
    """Of a world of 100 steps."""

    gamma: float = 1.0
    horizon: int = 100
    success: str = "success"
    directions: dict = field(default_factory=dict)


PLAIN = Facts()


def _behaviour(pay, success_from=None, ends=True, gamma=1.0, **more):
    """An episode that is paid so in each step, and is a success from a step on, counted from 1, if at all."""
    pay = np.asarray(pay, float)
    steps = len(pay)
    time = success_from or 100
    share = 0.0 if success_from is None else (steps - success_from + 1) / steps
    of = Behaviour(
        0, pay, float(pay.sum()), float(pay @ gamma ** np.arange(steps)), success_from is not None, steps, time, share,
        **more,
    )  # fmt: skip
    assert not ends or success_from in (None, steps)
    return of


def _searched(*threes, typical=0.0, successes=50, climbing=0.0, how=("sequences",), discounted=None):
    count = len(threes)
    return Searched(
        threes, discounted or threes, [typical] * count, [typical] * count, [successes] * count, [climbing] * count,
        1000, how,
    )  # fmt: skip


def _walks(behaviour):
    """The actions of these hand-made behaviours are what they were paid."""
    return [Walk({"all": behaviour.actions}, behaviour.time)]


def _word(*threes, facts=PLAIN, **more):
    return judge(_searched(*threes, **more), facts, _walks).word


HOVER = _behaviour([0.3] * 100)
LATE = _behaviour([0.3] * 99 + [1.0], 100)
QUICK = _behaviour([0.3] * 9 + [1.0], 10)
HACKED = Three(0, HOVER, LATE, QUICK)


def test_a_failure_that_is_paid_more_than_any_success_is_an_alarm():
    """30 for hovering, 3.7 for arriving."""
    assert _word(Three(0, HOVER, QUICK, QUICK)) == FAILING


def test_looping_and_then_finishing_does_not_hide_a_loophole():
    """The best-paid success earns 52, the loop 51, the success that does the task 11."""
    loop = _behaviour([0.51] * 100)
    late = _behaviour([0.51] * 99 + [1.51], 100)
    quick = _behaviour([0.51] * 2 + [10.0], 3)
    assert late.paid > loop.paid
    assert _word(Three(0, loop, late, quick)) == FAILING


def test_a_success_that_is_paid_for_every_step_until_it_arrives_loiters():
    """No failure is paid as much, for arriving pays 100; but arriving late pays more than arriving."""
    late, quick = _behaviour([0.3] * 99 + [100.0], 100), _behaviour([0.3] * 9 + [100.0], 10)
    assert _word(Three(0, HOVER, late, quick), typical=90.0) == LOITERING


def test_slow_because_effort_costs_is_honest():
    """The slow success is paid more, and nothing of it in its spare steps."""
    slow, quick = _behaviour([-0.05] * 99 + [100.0], 100), _behaviour([-5.0] * 9 + [100.0], 10)
    assert _word(Three(0, _behaviour([0.0] * 100), slow, quick)) == NOTHING


def test_slow_with_progress_and_effort_as_terms_is_honest():
    """Progress adds up to the same at any pace, and a cost that is saved is no gain."""
    slow, quick = _behaviour([0.9] * 99 + [10.0], 100), _behaviour([5.0] * 9 + [10.0], 10)
    terms = {
        100: {"progress": np.full(100, 1.0), "effort": np.full(100, -0.1)},
        10: {"progress": np.full(10, 10.0), "effort": np.full(10, -5.0)},
    }
    found = judge(
        _searched(Three(0, _behaviour([0.0] * 100), slow, quick)), PLAIN, lambda of: [Walk(terms[of.steps], of.time)]
    )
    assert found.word == NOTHING


def test_swinging_up_slowly_because_that_costs_less_is_honest():
    """Both go on to the end; while the slow one still swings it is paid less than the one that is up."""
    slow = _behaviour([-1.0] * 50 + [0.0] * 50, 51, ends=False)
    quick = _behaviour([-10.0] * 10 + [0.0] * 90, 11, ends=False)
    assert _word(Three(0, _behaviour([-5.0] * 100), slow, quick), typical=-500.0) == NOTHING


def test_spinning_before_standing_loiters_where_episodes_go_on():
    """While it spins it is paid more than one that stands."""
    slow = _behaviour([2.0] * 90 + [1.0] * 10, 91, ends=False)
    quick = _behaviour([1.0] * 100, 11, ends=False)
    assert _word(Three(0, None, slow, quick)) == LOITERING


def test_ending_soon_by_a_crash_is_an_alarm():
    """-1 in every step, and a crash ends that."""
    assert (
        _word(Three(0, _behaviour([-1.0] * 3), _behaviour([-1.0] * 20, 20), _behaviour([-1.0] * 20, 20)), typical=-30)
        == FAILING
    )


def test_minus_one_per_step_until_the_end_is_honest():
    """A failure is paid for all its steps."""
    assert _word(Three(0, _behaviour([-1.0] * 100), QUICK, QUICK), typical=-100) == NOTHING


def test_a_hair_more_is_no_alarm():
    """By less than a twentieth of what the best earns above random actions."""
    assert (
        _word(Three(0, _behaviour([1.0] * 100), _behaviour([0.96] * 100, 100), _behaviour([0.96] * 100, 100)))
        == NOTHING
    )
    assert (
        _word(Three(0, _behaviour([1.0] * 100), _behaviour([0.94] * 100, 100), _behaviour([0.94] * 100, 100)))
        == FAILING
    )


def test_a_failure_that_is_in_success_for_as_long_is_not_worse():
    """It fell in the last step, and was paid a little more before."""
    success = _behaviour([1.0] * 100, 11, ends=False)
    failure = replace(_behaviour([1.1] * 100), share=0.88)
    assert _word(Three(0, failure, success, success)) == NOTHING
    assert _word(Three(0, replace(failure, share=0.3), success, success)) == FAILING


def test_a_near_miss_is_not_worse():
    """All measures within a twentieth of the success's, and a little more pay."""
    facts = Facts(directions={"height": 1})
    success = _behaviour([1.0] * 100, 11, ends=False, measures={"height": 0.91})
    failure = _behaviour([1.1] * 100, measures={"height": 0.89})
    assert _word(Three(0, failure, success, success), facts=facts) == NOTHING
    low = replace(failure, measures={"height": 0.2})
    assert _word(Three(0, low, success, success), facts=facts) == FAILING


def test_a_failure_that_is_paid_a_little_more_is_told_why_it_is_no_alarm():
    """By the margin, or by what it does; nothing is said where success is paid more."""

    def third(failure, success):
        return judge(_searched(Three(0, failure, success, success)), PLAIN, _walks).lines[2:]

    success = _behaviour([0.96] * 100, 100)
    (line,) = third(_behaviour([1.0] * 100), success)
    assert line.startswith("The failure's 4 more are no alarm: less than 5, 5% of what ")
    (line,) = third(replace(_behaviour([1.1] * 100), share=0.9), _behaviour([1.0] * 100, 1, ends=False))
    assert line == "The failure's 10 more are no alarm: it behaves nearly as the success does."
    assert third(_behaviour([0.9] * 100), success) == ()


def test_without_a_success_it_cannot_tell():
    """On most starts; it asks for a demonstration."""
    found = judge(_searched(*[Three(0, HOVER, None, None)] * 3, HACKED), PLAIN, _walks)
    assert found.word == CANNOT_TELL
    assert "No success was found on 3 of 4 starts" in found.lines[1]
    assert "--from FOLDER" in found.lines[2]


def test_where_all_was_counted_more_steps_are_no_help():
    """A success that cannot be reached is a matter of what tells success."""
    found = judge(_searched(Three(0, HOVER, None, None), how=("table",)), Facts(success="docked>5"), _walks)
    assert found.word == CANNOT_TELL
    assert found.lines[1:] == (
        "All states and actions were counted: none is a success on 1 of 1 starts.",
        "Is 'docked>5' what tells success (--success)?",
    )


@pytest.mark.parametrize("more", [{"successes": 3}, {"climbing": 40.0}])
def test_few_successes_or_rising_ones_cannot_tell(more):
    """What they are paid may still rise above the failure's pay; in a table it may not."""
    three = Three(0, HOVER, QUICK, QUICK)
    assert _word(three, **more) == CANNOT_TELL
    assert _word(three, **more, how=("table",)) == FAILING


def test_a_success_that_comes_and_goes_tells_nothing():
    """A pendulum that spins is up at the last step by chance: what standing pays is not known."""
    spinning = replace(_behaviour([1.0] * 100, 99, ends=False), share=0.2)
    failure = replace(_behaviour([1.01] * 100), share=0.2)
    found = judge(_searched(Three(0, failure, spinning, spinning)), PLAIN, _walks)
    assert found.word == CANNOT_TELL
    assert found.lines[1] == "No success was held for longer than the last steps on 1 of 1."
    alive = replace(spinning, share=0.02)
    assert _word(Three(0, failure, alive, alive)) == NOTHING


def test_a_success_that_comes_late_tells_nothing_where_failing_pays_as_much():
    """Sooner ones may be paid less, and a search that knows none cannot say so; one of survival cannot come sooner."""
    failure, late = _behaviour([1.0] * 100), _behaviour([1.0] * 100, 90, ends=False)
    assert _word(Three(0, failure, late, late)) == CANNOT_TELL
    assert _word(Three(0, _behaviour([0.5] * 100), late, late)) == NOTHING
    survived = _behaviour([1.0] * 100, 99, ends=False)
    assert _word(Three(0, failure, survived, survived)) == NOTHING


def test_costly_random_actions_do_not_hide_what_pays_more():
    """Effort that swamps a bonus: doing nothing is paid more than any success, by little beside what effort costs."""
    lazy, docked = _behaviour([0.0] * 100), _behaviour([-0.3] * 10, 10)
    assert _word(Three(0, lazy, docked, docked), typical=-200.0) == CANNOT_TELL
    assert _word(Three(0, lazy, docked, docked), typical=-200.0, how=("table",)) == FAILING
    cheap = _behaviour([0.1] * 10, 10)
    assert _word(Three(0, lazy, cheap, cheap), typical=-200.0) == NOTHING


def test_later_is_what_a_learner_that_discounts_counts_as_later():
    """Of 1,000 steps 200 are few; by a discount of 0.95 they are all that counts."""
    facts = Facts(gamma=0.95, horizon=1000)
    one, other, quick = (
        _behaviour(np.full(steps, 1.0), to, gamma=0.95) for steps, to in ((1000, None), (200, 200), (10, 10))
    )
    slow = replace(other, discounted=one.discounted + 1.0)  # it is a little better to come at last
    honest = Three(0, _behaviour([0.0] * 1000), quick, quick)
    assert _word(honest, facts=facts, discounted=[Three(0, one, slow, quick)]) == FAILING
    assert _word(honest, facts=replace(facts, gamma=0.999), discounted=[Three(0, one, slow, quick)]) == NOTHING


def test_half_of_the_starts_are_enough():
    """An alarm says on how many it holds."""
    honest = Three(0, _behaviour([0.0] * 100), QUICK, QUICK)
    found = judge(_searched(HACKED, honest, HACKED, honest), PLAIN, _walks)
    assert (found.word, len(found.alarmed)) == (FAILING, 2)
    assert found.lines[1] == "It holds on 2 of 4 starts."
    assert _word(HACKED, honest, honest, honest) == NOTHING


def test_the_first_line_says_the_three_numbers():
    """And how much faster the fastest is."""
    found = judge(_searched(HACKED), PLAIN, _walks)
    assert found.lines[0] == (
        "The best-paid failure earns 30, the best-paid success 30.7, the fastest success 3.7 (10 steps instead of 100)."
    )


def test_a_leak_that_the_discount_takes_back_is_none():
    """Shaping by a potential: without discount it pays for staying away, with it for arriving."""
    facts = Facts(gamma=0.9)
    failure = replace(HOVER, discounted=0.1)
    success = replace(QUICK, discounted=2.0)
    found = judge(_searched(Three(0, failure, success, success)), facts, _walks)
    assert found.word == NOTHING
    assert found.lines[-1] == (
        "Without discount the best-paid failure earns 30 and the best-paid success 3.7, on 1 of 1 starts; a learner "
        "that discounts by 0.9 is not tempted."
    )


def test_equal_discounted_sums_do_not_take_an_alarm_back():
    """They do not contradict it."""
    same = [replace(of, discounted=1.0) for of in (HOVER, QUICK)]
    found = judge(_searched(Three(0, *same, same[1])), Facts(gamma=0.9), _walks)
    assert found.word == FAILING
    assert found.lines[1] == "It holds on 1 of 1 starts; discounted by 0.9 the sums are about equal."


def test_the_discounted_sum_alone_is_an_alarm_too():
    """A success that comes too late for a learner that discounts."""
    failure, success = replace(_behaviour([0.1] * 100), discounted=3.0), replace(LATE, discounted=0.5)
    found = judge(_searched(Three(0, failure, success, success)), Facts(gamma=0.9), _walks)
    assert found.word == FAILING
    assert found.lines[0].startswith("Discounted by 0.9, the best-paid failure earns 3,")
    assert found.lines[1].endswith("; discounted by 0.9 alone, without discount it does not.")


def test_without_a_measure_of_success_it_asks():
    """It says what is paid most, and how to name a measure."""
    most = replace(HOVER, measures={"height": 0.5})
    found = judge(_searched(Three(0, most, None, None)), Facts(success=""), _walks)
    assert found.word == CANNOT_TELL
    assert found.lines == (
        "Nothing measures success. What is paid most earns 30 in 100 steps: height 0.5 at the end. Does that "
        "look right?",
        "Name a measure, and from where on it is a success: --success 'NAME>0.9', with one of height.",
    )
    none = judge(_searched(Three(0, replace(most, measures={}), None, None)), Facts(success=""), _walks)
    assert "a function of --measure FILE.py" in none.lines[1]


numbers = st.floats(-100.0, 100.0).map(lambda value: round(value, 3))
pay = st.lists(numbers, min_size=100, max_size=100)


@given(pay, pay, pay, st.integers(2, 100), st.integers(2, 100), numbers, st.sampled_from([1.0, 0.9]))
def test_a_number_more_in_every_step_changes_no_word(failing, late, early, one, other, more, gamma):
    """Where all episodes are equally long: the plain and the discounted sums all shift by the same."""

    def word(shift):
        failure, *successes = (
            _behaviour(np.array(of) + shift, time, ends=False, gamma=gamma)
            for of, time in ((failing, None), (late, max(one, other)), (early, min(one, other)))
        )
        best = max(successes, key=lambda of: of.paid)
        return judge(
            _searched(Three(0, failure, best, successes[1]), typical=shift * 100),
            Facts(gamma),
            _walks,
        ).word

    if gamma == 1.0:
        assert word(more) == word(0.0)


@given(pay, pay, pay, st.integers(2, 100), st.floats(0.01, 1000.0), st.sampled_from([1.0, 0.9]))
def test_a_factor_changes_no_word(failing, late, early, time, factor, gamma):
    """A reward that is scaled pays for the same."""

    def word(by):
        failure, slow, fast = (
            _behaviour(np.array(of) * by, time, ends=time is not None, gamma=gamma)
            for of, time in ((failing, None), (late, 100), (early[:time], time))
        )
        best = max((slow, fast), key=lambda of: of.paid)
        return judge(_searched(Three(0, failure, best, fast), typical=-10.0 * by), Facts(gamma), _walks).word

    assert word(factor) == word(1.0)


@given(st.floats(0.1, 10.0), st.floats(0.0, 5.0))
def test_honest_costs_of_control_never_alarm(weight, bonus):
    """The success costs effort and is paid at its end; doing nothing earns nothing."""
    success = _behaviour([-weight / 100] * 49 + [weight + bonus], 50)
    assert _word(Three(0, _behaviour([0.0] * 100), success, success), typical=-weight) == NOTHING
