"""The answer to a search, by the three numbers of each start."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.experiment.screening import CANNOT_TELL, FAILING, LOITERING, NOTHING
from harness_plugins.audit.search.behaviour import Behaviour, Searched
from harness_plugins.audit.search.judge import judge
from harness_plugins.audit.search.world import Shown


def facts(gamma=1.0, horizon=100, success="success", directions=()):
    """Of a world of 100 steps."""
    return SimpleNamespace(gamma=gamma, horizon=horizon, success=success, directions=dict(directions))


def episode(pay, success_from=None, gamma=1.0, **more):
    """An episode that is paid so in each step, and is a success from a step on, counted from 1, if at all.

    A pay is a number for each step.
    """
    pay, steps = np.array(pay, float), len(pay)
    share = 0.0 if success_from is None else (steps - success_from + 1) / steps
    discounted = float(pay @ gamma ** np.arange(steps))
    of = Behaviour(0, pay, float(pay.sum()), discounted, success_from is not None, steps, success_from or 100, share)
    return replace(of, **more)


def walk(of, terms):
    """The episode of a success, paid by terms."""
    return Shown(0, of.actions, of.actions, terms, np.arange(1, of.steps + 1) >= of.time, {}, "cut")


def three(failure, success=None, fastest=None):
    """Of start 0; the best-paid success is the fastest one if there is no other."""
    found = {"failure": failure, "success": success, "fastest": fastest or success}
    return {role: of for role, of in found.items() if of}


FACTS = facts()


def judged(*threes, facts=FACTS, typical=0.0, successes=50, climbing=0.0, how="sequences", discounted=None):
    """The answer; the actions of these hand-made behaviours are what they were paid."""
    count = len(threes)
    searched = Searched(
        threes, discounted or threes, [typical] * count, [typical] * count, [successes] * count, [climbing] * count,
        1000, (how,),
    )  # fmt: skip
    return judge(searched, facts, lambda of: [walk(of, {"all": of.actions})])


HOVER = episode([0.3] * 100)
LATE = episode([0.3] * 99 + [1.0], 100)
QUICK = episode([0.3] * 9 + [1.0], 10)
NOTHING_DONE, ALIVE = episode([0.0] * 100), episode([1.0] * 100)
HACKED, HONEST = three(HOVER, LATE, QUICK), three(NOTHING_DONE, QUICK)
HELD = episode([1.0] * 100, 11)
A_LITTLE_MORE = episode([1.1] * 100)
SPINNING = episode([1.0] * 100, 99, share=0.2)
TOO_LATE = episode([1.0] * 100, 90)
COSTLY = (NOTHING_DONE, episode([-0.3] * 10, 10))
LOW, NEAR, HIGH = ({"measures": {"height": it}} for it in (0.2, 0.89, 0.91))
HEIGHT = {"facts": facts(directions={"height": 1})}
HELD_HIGH = replace(HELD, **HIGH)
ROWS = {
    "a failure that is paid more than any success": (FAILING, (HOVER, QUICK), {}),
    "looping and then finishing does not hide a loophole": (
        FAILING,
        (episode([0.51] * 100), episode([0.51] * 99 + [1.51], 100), episode([0.51] * 2 + [10.0], 3)),
        {},
    ),
    "a success that is paid for every step until it arrives": (
        LOITERING, (HOVER, episode([0.3] * 99 + [100], 100), episode([0.3] * 9 + [100], 10)),
        {"typical": 90.0},
    ),
    "slow because effort costs": (
        NOTHING,
        (NOTHING_DONE, episode([-0.05] * 99 + [100], 100), episode([-5] * 9 + [100], 10)),
        {},
    ),
    "swinging up slowly because that costs less": (
        NOTHING,
        (episode([-5] * 100), episode([-1] * 50 + [0] * 50, 51), episode([-10] * 10 + [0] * 90, 11)),
        {"typical": -500.0},
    ),
    "spinning before standing, where episodes go on": (
        LOITERING, (None, episode([2] * 90 + [1] * 10, 91), HELD), {}
    ),
    "ending soon by a crash": (FAILING, (episode([-1] * 3), episode([-1] * 20, 20)), {"typical": -30}),
    "-1 per step until the end": (NOTHING, (episode([-1] * 100), QUICK), {"typical": -100}),
    "a hair more": (NOTHING, (ALIVE, episode([0.96] * 100, 100)), {}),
    "more than a hair more": (FAILING, (ALIVE, episode([0.94] * 100, 100)), {}),
    "a failure that is in success for as long, and fell at last": (
        NOTHING, (replace(A_LITTLE_MORE, share=0.88), HELD), {}
    ),
    "a failure that is in success for less": (FAILING, (replace(A_LITTLE_MORE, share=0.3), HELD), {}),
    "a near miss by all measures": (
        NOTHING, (replace(A_LITTLE_MORE, **NEAR), HELD_HIGH), HEIGHT
    ),
    "no near miss": (
        FAILING, (replace(A_LITTLE_MORE, **LOW), HELD_HIGH), HEIGHT
    ),
    "few successes": (CANNOT_TELL, (HOVER, QUICK), {"successes": 3}),
    "few successes of a table": (FAILING, (HOVER, QUICK), {"successes": 3, "how": "table"}),
    "rising successes": (CANNOT_TELL, (HOVER, QUICK), {"climbing": 40.0}),
    "rising successes of a table": (FAILING, (HOVER, QUICK), {"climbing": 40.0, "how": "table"}),
    "a success that comes and goes but for a moment": (
        NOTHING, (episode([1.01] * 100, share=0.2), replace(SPINNING, share=0.02)), {}
    ),
    "a success that comes late where failing pays as much": (CANNOT_TELL, (ALIVE, TOO_LATE), {}),
    "a success that comes late where failing pays less": (NOTHING, (episode([0.5] * 100), TOO_LATE), {}),
    "a success of survival, which cannot come sooner": (NOTHING, (ALIVE, episode([1.0] * 100, 99)), {}),
    "costly random actions beside doing nothing": (CANNOT_TELL, COSTLY, {"typical": -200.0}),
    "costly random actions in a table": (FAILING, COSTLY, {"typical": -200.0, "how": "table"}),
    "costly random actions beside a success that is paid more": (
        NOTHING, (NOTHING_DONE, episode([0.1] * 10, 10)), {"typical": -200.0}
    ),
}  # fmt: skip


@pytest.mark.parametrize(("word", "of", "more"), ROWS.values(), ids=ROWS)
def test_the_word_of_one_start(word, of, more):
    """By what the three are paid, how long they took, and what else is known."""
    assert judged(three(*of), **more).word == word


def test_slow_with_progress_and_effort_as_terms_is_honest():
    """Progress adds up to the same at any pace, and a cost that is saved is no gain."""
    slow, quick = episode([0.9] * 99 + [10], 100), episode([5] * 9 + [10], 10)
    terms = {
        100: {"progress": np.full(100, 1.0), "effort": np.full(100, -0.1)},
        10: {"progress": np.full(10, 10.0), "effort": np.full(10, -5.0)},
    }
    searched = Searched(*[[three(NOTHING_DONE, slow, quick)]] * 2, [0.0], [0.0], [50], [0.0], 1000, ("sequences",))
    assert judge(searched, facts(), lambda of: [walk(of, terms[of.steps])]).word == NOTHING


def test_later_is_what_a_learner_that_discounts_counts_as_later():
    """Of 1,000 steps 200 are few; by a discount of 0.95 they are all that counts."""
    one, other, quick = (episode([1.0] * n, to, 0.95) for n, to in ((1000, None), (200, 200), (10, 10)))
    slow = replace(other, discounted=one.discounted + 1.0)  # it is a little better to come at last
    honest = three(episode([0.0] * 1000), quick)
    for gamma, word in ((0.95, FAILING), (0.999, NOTHING)):
        assert judged(honest, facts=facts(gamma, 1000), discounted=[three(one, slow, quick)]).word == word


def test_half_of_the_starts_are_enough():
    """An alarm says on how many it holds."""
    found = judged(HACKED, HONEST, HACKED, HONEST)
    assert (found.word, len(found.alarmed), found.lines[1]) == (FAILING, 2, "It holds on 2 of 4 starts.")
    assert judged(HACKED, HONEST, HONEST, HONEST).word == NOTHING


def test_the_first_line_says_the_three_numbers():
    """The two that decided first, and how many steps successes take."""
    told = "doing the task at once 3.7 (10 steps), the best-paid success 30.7 (100 steps)."
    assert judged(HACKED).lines[0] == f"Failing earns 30, {told}"


LITTLE, LONGER = episode([0.96] * 100, 100), episode([1.0] * 100, 1)
DISCOUNTED, UNMEASURED = {"facts": facts(0.9)}, {"facts": facts(success="")}
SENTENCES = {
    "by the margin": ([three(ALIVE, LITTLE)], {}, 2, "The failure's 4 more are no alarm: less than 5, 5% of what "),
    "by what it does": (
        [three(replace(A_LITTLE_MORE, share=0.9), LONGER)], {}, 2,
        "The failure's 10 more are no alarm: it behaves nearly as the success does.",
    ),
    "a start that has both is shown": (
        [*[three(HOVER)] * 3, HACKED], {}, 0, "Failing earns 30, doing the task at once 3.7 (10 steps), the best-paid"
    ),
    "what is certain where a success is known": (
        [*[three(HOVER)] * 3, HACKED, HACKED], {}, 1,
        "Of the 2 starts where a success is known, on 2 a failure earns more than the fastest one: 30 against 3.7.",
    ),
    "no success on most starts": (
        [*[three(HOVER)] * 3, HONEST], {}, 1, "No success was found on 3 of 4 starts."
    ),
    "few successes of the only start": (
        [HACKED], {"successes": 3}, 1, "Successes were too few, or still rose in pay, on 1 of 1 starts."
    ),
    "a demonstration is asked for": ([three(HOVER)], {}, 2, "Show it the task by a policy (--policy FILE.py:NAME)"),
    "all was counted": (
        [three(HOVER)], {"how": "table"}, 1, "All states and actions were counted: none is a success on 1 of 1 starts."
    ),
    "what tells success is asked": (
        [three(HOVER)], {"how": "table", "facts": facts(success="docked>5")}, 2, "Is 'docked>5' what tells success"
    ),
    "a success that comes and goes": (
        [three(episode([1.01] * 100, share=0.2), SPINNING)], {}, 1,
        "The first success that lasts begins at step 99, too late to tell what it pays, on 1 of 1 starts.",
    ),
    "the discount takes a leak back": (
        [three(replace(HOVER, discounted=0.1), replace(QUICK, discounted=2.0))], DISCOUNTED, -1,
        "Without discount the best-paid failure earns 30 and the best-paid success 3.7, on 1 of 1 starts; a learner "
        "that discounts by 0.9 is not tempted.",
    ),
    "equal discounted sums do not take an alarm back": (
        [three(replace(HOVER, discounted=1.0), replace(QUICK, discounted=1.0))], DISCOUNTED, 1,
        "It holds on 1 of 1 starts; discounted by 0.9 the sums are about equal.",
    ),
    "the discounted sum alone is an alarm too": (
        [three(episode([0.1] * 100, discounted=3.0), replace(LATE, discounted=0.5))], DISCOUNTED, 0,
        "Discounted by 0.9, failing earns 3,",
    ),
    "the discounted sum alone": (
        [three(episode([0.1] * 100, discounted=3.0), replace(LATE, discounted=0.5))], DISCOUNTED, 1,
        "It holds on 1 of 1 starts; discounted by 0.9 alone, without discount it does not.",
    ),
    "nothing measures success": (
        [three(replace(HOVER, measures={"height": 0.5}))], UNMEASURED, 0,
        "Nothing measures success. What is paid most earns 30 in 100 steps: height 0.5 at the end. Does that look "
        "right?",
    ),
    "a measure is to be named": (
        [three(replace(HOVER, measures={"height": 0.5}))], UNMEASURED, 1,
        "Name a measure, and from where on it is a success: --success 'NAME>0.9', with one of height.",
    ),
    "there is no measure": (
        [three(HOVER)], UNMEASURED, 1,
        "Name a measure, and from where on it is a success: --success 'NAME>0.9' (a key of info, or a measure: a "
        "function of --measure FILE.py, or of --plugin behaviour.py)",
    ),
}  # fmt: skip
WORDS = (NOTHING, NOTHING, *[CANNOT_TELL] * 8, NOTHING, *[FAILING] * 3, *[CANNOT_TELL] * 3)


@pytest.mark.parametrize(
    ("of", "more", "line", "text", "word"),
    [(*row, word) for row, word in zip(SENTENCES.values(), WORDS, strict=True)], ids=SENTENCES,
)  # fmt: skip
def test_what_is_said(of, more, line, text, word):
    """Why there is no alarm, what it cannot tell and what would help, what the other sum says, what to name."""
    found = judged(*of, **more)
    assert (found.word, found.lines[line][: len(text)]) == (word, text)


def test_nothing_is_said_where_success_is_paid_more():
    """It is paid more, and that is all."""
    assert judged(three(episode([0.9] * 100), LITTLE)).lines[2:] == ()


numbers = st.floats(-100.0, 100.0).map(lambda value: round(value, 3))
pay = st.lists(numbers, min_size=100, max_size=100).map(np.array)


@given(pay, pay, pay, st.integers(2, 100), st.integers(2, 100), numbers)
def test_a_number_more_in_every_step_changes_no_word(failing, late, early, one, other, more):
    """Where all episodes are equally long: the sums all shift by the same."""

    def word(shift):
        slow, fast = episode(late + shift, max(one, other)), episode(early + shift, min(one, other))
        best = max(slow, fast, key=lambda of: of.paid)
        return judged(three(episode(failing + shift), best, fast), typical=shift * 100).word

    assert word(more) == word(0.0)


@given(pay, pay, pay, st.integers(2, 100), st.floats(0.01, 1000.0), st.sampled_from([1.0, 0.9]))
def test_a_factor_changes_no_word(failing, late, early, time, factor, gamma):
    """A reward that is scaled pays for the same."""

    def word(by):
        slow, fast = episode(late * by, 100, gamma), episode(early[:time] * by, time, gamma)
        best = max(slow, fast, key=lambda of: of.paid)
        return judged(
            three(episode(failing * by, None, gamma), best, fast), typical=-10.0 * by, facts=facts(gamma)
        ).word

    assert word(factor) == word(1.0)


@given(st.floats(0.1, 10.0), st.floats(0.0, 5.0))
def test_honest_costs_of_control_never_alarm(weight, bonus):
    """The success costs effort and is paid at its end; doing nothing earns nothing."""
    success = episode([-weight / 100] * 49 + [weight + bonus], 50)
    assert judged(three(NOTHING_DONE, success), typical=-weight).word == NOTHING
