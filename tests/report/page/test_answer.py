"""The first screen: cards, and groups of many comparisons."""

import re
from dataclasses import replace

import pytest

from harness.eta.headline import Answer
from harness.report.page.answer import card_of, groups_of, pool_cards

HELPED = {"arp": lambda seed: (5, 6, 7, 8), "baseline": lambda seed: (8, 9)}


@pytest.fixture
def helped(build):
    """A comparison of six seeds that helps."""
    (combination,) = build(seeds=6, reached=HELPED).combinations
    return combination


def test_a_card_names_what_decided_first(helped):
    """With its values, a picture, and the word."""
    card = card_of(helped, "arp")
    assert (card.answer, card.badge, card.lead) == ("HELPS", "helps", helped.lead)
    assert card.rows[0].note == "decides"
    assert card.rows[0].figure.startswith("<svg")
    assert [row.note for row in card.rows[1:]] == [""] * (len(card.rows) - 1)


def test_a_card_says_how_sure_it_is(helped):
    """As a share of experiments in which the rewards do nothing."""
    told = re.search(
        r"from 6 trainings of each reward\. Luck alone would show such a difference in (\d+) of 1,000 experiments\.",
        card_of(helped, "arp").sure,
    )
    assert 0 <= int(told[1]) - 1000.0 * helped.ruling.corrected < 1.0


def test_a_card_without_an_answer_says_how_large_the_difference_can_be(build):
    """And no measure decides."""
    (combination,) = build().combinations
    card = card_of(combination, "arp")
    assert re.fullmatch(r"So far, success differs by at most \d+ points, either way\.", card.sure)
    assert {row.note for row in card.rows} == {""}


def test_a_bar_that_misses_the_line_without_an_answer_has_its_reason(helped):
    """It stands by itself; the test holds for all bars of the page."""
    whole = replace(helped, ruling=replace(helped.ruling, corrected=0.128, of_measures=(0.128,)))
    card = card_of(whole, "arp")
    assert card.answer == "CANNOT TELL"
    assert "The bar of success misses the line, " in card.sure
    assert "but by the exact test luck shows one like it in 13 of 100 experiments" in card.sure
    asked = replace(whole, ruling=replace(whole.ruling, asked=2))
    assert "but with all bars of this page luck" in card_of(asked, "arp").sure


def test_only_what_a_test_decided_is_coloured(build, helped):
    """Green or red is a claim."""
    assert 'class="dot better"' in card_of(helped, "arp").rows[0].figure
    (open_one,) = build().combinations
    assert not re.search("better|worse", "".join(row.figure for row in card_of(open_one, "arp").rows))


def test_parts_of_the_pay_have_their_colours(build):
    """Those of the ruler and of the behaviour, in words and in pictures."""
    (combination,) = build(baseline=(9, 12), proposed={"arp": (1, 20)}).combinations
    parts = card_of(combination, "arp").parts
    assert [part.kind for part in parts] == ["ruler", "behaviour"]
    assert all(f'class="bar {part.kind}"' in part.figure for part in parts)


def test_a_reward_over_several_places_has_one_card(build):
    """Where there is one place there is none."""
    several = build(seeds=6, simulators=("mujoco", "pybullet"), reached=HELPED).combinations
    (card,) = pool_cards(several)
    assert (card.name, card.answer) == ("arp", "HELPS")
    assert "over 2 places" in card.lead
    assert pool_cards(build().combinations) == []


def test_groups_are_in_the_order_of_answers(build):
    """Each comparison is in the group of its answer, and only there."""
    combinations = build(seeds=6, proposed={"arp": (9, 30), "relative": (9, 30)}, reached=HELPED).combinations
    cards = [card_of(it, it.proposed) for it in combinations]
    groups = groups_of(cards, combinations)
    order = [answer.value.upper() for answer in Answer]
    assert sorted((group["answer"] for group in groups), key=order.index) == [group["answer"] for group in groups]
    assert sorted(place for group in groups for place in group["places"]) == list(range(len(combinations)))


def test_what_cannot_be_told_is_told_once(build):
    """How many seeds would tell, over all of them."""
    combinations = build(proposed={"arp": (9, 30), "relative": (9, 30), "dense": (9, 30)}).combinations
    groups = groups_of([card_of(it, it.proposed) for it in combinations], combinations)
    told = {group["answer"]: group["told"] for group in groups}
    assert [bool(text) for answer, text in told.items()] == [answer == "CANNOT TELL" for answer in told]
    assert re.match(
        r"(Their trainings are not enough: it takes [\d,]+ to [\d,]+ of each|Nothing decides)", told["CANNOT TELL"]
    )


FAILED = {"arp": lambda seed: (), "baseline": lambda seed: (5, 6, 7, 8)}


@pytest.mark.parametrize(
    ("curves", "reached", "told"),
    [
        ({"baseline": (1, 20), "proposed": {"arp": (20, 1)}}, HELPED, "times as much, for better behaviour"),
        ({"baseline": (1, 20), "proposed": {"arp": (20, 1)}}, FAILED, "times as much, for worse behaviour"),
        ({}, {}, "times as much"),
    ],
    ids=["less for better", "more for worse", "cannot tell"],
)
def test_pay_that_goes_the_other_way_than_the_behaviour_is_told(build, curves, reached, told):
    """In a word; where nothing decided about the behaviour, there is none."""
    (combination,) = build(seeds=6, reached=reached, **curves).combinations
    assert card_of(combination, "arp").pay.endswith(told)
