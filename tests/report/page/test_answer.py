"""The first screen: cards, and groups of many comparisons."""

import re
from dataclasses import replace

import pytest

from harness.eta import Answer, Ruling
from harness.report.page.answer import card_of, groups_of, pool_cards

HELPED = {"arp": lambda seed: (5, 6, 7, 8), "baseline": lambda seed: (8, 9)}


@pytest.fixture
def helped(build):
    """A comparison of six seeds that helps."""
    (combination,) = build(seeds=6, reached=HELPED).combinations
    return combination


def test_a_card_names_what_decided_first(helped):
    """With a picture, and its badge."""
    card = card_of(helped, "arp")
    assert (card.badge, card.lead) == ("helps", helped.lead)
    assert card.rows[0].figure.startswith("<svg")


def test_every_training_is_a_dot_below_the_measure_that_decides(helped):
    """A row for either reward, both on one scale; further right is better."""
    base, mine = card_of(helped, "arp").rows[1:3]
    assert [(row.name, row.kind) for row in (base, mine)] == [("baseline", "baseline"), ("arp", "proposed")]
    places = [[float(at) for at in re.findall(r'cx="([\d.]+)"', row.figure)] for row in (base, mine)]
    assert [len(at) for at in places] == [6, 6]
    assert max(places[0]) < min(places[1])


def test_steps_that_are_the_same_have_no_interval(build):
    """Nothing is estimated there: no bar, and one value for both."""
    (combination,) = build(seeds=3).combinations
    alike = replace(combination, measured=replace(combination.measured, same_steps=True))
    assert all(change.difference == 0.0 for change in alike.decisive_changes)
    rows = [row for row in card_of(alike, "arp").rows if not row.kind]
    assert all(row.figure == "" and "->" not in row.value for row in rows)


def _ruled(comparison, ruling):
    return replace(comparison, answer=replace(comparison.answer, ruling=ruling))


def test_only_what_a_test_decided_is_coloured(helped, one):
    """Green or red is a claim."""
    assert 'class="dot better"' in card_of(helped, "arp").rows[0].figure
    assert not re.search("better|worse", "".join(row.figure for row in card_of(one, "arp").rows))


def test_parts_of_the_pay_have_their_colours(build):
    """Those of the ruler and of the behaviour, in words and in pictures."""
    (combination,) = build(baseline=(9, 12), proposed={"arp": (1, 20)}).combinations
    parts = card_of(combination, "arp").parts
    assert [part.kind for part in parts] == ["ruler", "behaviour"]
    assert all(f'class="bar {part.kind}"' in part.figure for part in parts)


def test_a_plan_that_is_not_trained_to_its_end_has_no_colour(helped):
    """No bar is better or worse, and nothing is sure."""
    card = card_of(_ruled(helped, Ruling(missing="12 trainings are missing")), "arp")
    assert (card.answer, card.badge, card.sure) == ("INTERIM", "interim", "")
    assert not re.search("better|worse", "".join(row.figure for row in card.rows))


def test_a_reward_over_several_places_has_one_card(build):
    """Where there is one place there is none."""
    (card,) = pool_cards(build(seeds=6, simulators=("mujoco", "pybullet"), reached=HELPED).combinations)
    assert (card.name, card.answer) == ("arp", "HELPS")
    assert "over 2 places" in card.lead
    assert pool_cards(build().combinations) == []


def test_groups_are_in_the_order_of_answers(build):
    """Each comparison is in the group of its answer, and only there."""
    combinations = build(seeds=6, proposed={"arp": (9, 30), "relative": (9, 30)}, reached=HELPED).combinations
    groups = groups_of([card_of(it, it.proposed) for it in combinations], combinations)
    order = [answer.value.upper() for answer in Answer]
    assert sorted((group["answer"] for group in groups), key=order.index) == [group["answer"] for group in groups]
    assert sorted(place for group in groups for place in group["places"]) == list(range(len(combinations)))


def test_what_cannot_be_told_is_told_once(build):
    """How many trainings would tell, over all of them."""
    combinations = build(proposed={"arp": (9, 30), "relative": (9, 30), "dense": (9, 30)}).combinations
    groups = groups_of([card_of(it, it.proposed) for it in combinations], combinations)
    told = {group["answer"]: group["told"] for group in groups}
    assert [bool(text) for answer, text in told.items()] == [answer == "CANNOT TELL" for answer in told]
    assert re.match(
        r"(Their trainings are not enough\. [\d,]+( to [\d,]+)? of each reward would tell, under|Nothing decides)",
        told["CANNOT TELL"],
    )


def test_pay_is_told_as_everywhere_else(build):
    """In the sentence of the comparison but for its intervals, with a bar for each part."""
    (combination,) = build(seeds=6, reached=HELPED, baseline=(1, 20), proposed={"arp": (20, 1)}).combinations
    card = card_of(combination, "arp")
    assert " [" in combination.pay_sentence
    assert card.pay == re.sub(r" \[\S+ \S+\]", "", combination.pay_sentence)
    assert [row.name for row in card.parts] == ["ruler", "behaviour"]
