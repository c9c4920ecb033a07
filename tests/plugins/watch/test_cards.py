"""How trainings are drawn."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from harness_plugins.watch.blocks import Blocks
from harness_plugins.watch.cards import curves_of, rows_of
from harness_plugins.watch.trainings import Training
from harness_plugins.watch.watch import drawn


def blocks_of(count, pay=1.0, episodes=8, behaviour=0.5, **terms):
    """Blocks of equally many episodes, in which each term pays the same."""
    number = np.arange(1, count + 1)
    means = [pay * number, *(np.full(count, it) for it in (behaviour, *terms.values()))]
    return Blocks(tuple(terms), 100 * number, np.full(count, episodes), np.column_stack(means))


@pytest.fixture
def training():
    """One that is running."""
    return Training("toy · sac", "arp", "seed 0", "running", 400, 1_000, blocks_of(4), "", "success", True)


def axis_texts(svg):
    """What is written along the vertical axis."""
    return re.findall(r'text-anchor="end">([^<]+)', svg)


def test_behaviour_stands_beside_pay(training):
    """Each with its last value, and pay by the name of its reward."""
    card = rows_of([training])[0].cards[0]
    assert [(it.title, it.now) for it in card.figures] == [("success", "50 %"), ("pay by arp", "4")]
    assert card.progress == "400 of 1,000 steps"
    assert card.share == 40.0


def test_rewards_never_share_an_axis_of_pay(training):
    """Trainings of one reward do, so that they can be compared."""
    other = replace(training, reward="dense", blocks=blocks_of(4, pay=1_000.0))
    rows = rows_of([training, other, replace(training, name="seed 1", blocks=blocks_of(4, pay=2.0))])
    assert [(row.reward, len(row.cards)) for row in rows] == [("arp", 2), ("dense", 1)]
    pay = {
        (card.training.reward, card.training.name): axis_texts(card.figures[1].svg)
        for row in rows
        for card in row.cards
    }
    assert pay["arp", "seed 0"] == pay["arp", "seed 1"] != pay["dense", "seed 0"]


def test_terms_have_a_figure_of_their_own(training):
    """The largest six; one term alone is the pay."""
    terms = {f"t{number}": float(number) for number in range(8)}
    card = rows_of([replace(training, blocks=blocks_of(4, **terms))])[0].cards[0]
    assert card.figures[2].title == "terms of arp, 2 smaller ones left out"
    assert ">t7<" in card.figures[2].svg
    assert ">t1<" not in card.figures[2].svg
    assert len(rows_of([replace(training, blocks=blocks_of(4, t0=0.0))])[0].cards[0].figures) == 2


def test_points_are_means_of_episodes(training):
    """At most 20, each of 8 episodes at least, none left out: by hand of 100 blocks of 2 episodes."""
    curves = curves_of(replace(training, blocks=blocks_of(100, episodes=2)))
    assert len(curves.steps) == 20
    assert curves.pay == tuple(sum(range(5 * it + 1, 5 * it + 6)) / 5 for it in range(20))
    assert curves.steps[-1] == 10_000
    short = curves_of(replace(training, blocks=blocks_of(3, episodes=1)))
    assert (short.pay, short.steps) == ((2.0,), (300.0,))


def test_behaviour_that_nobody_measures_is_left_out(training):
    """Or said to be unknown, and the pay is drawn all the same."""
    assert [it.title for it in rows_of([replace(training, measure="")])[0].cards[0].figures] == ["pay by arp"]
    unknown = rows_of([replace(training, is_share=False, blocks=blocks_of(4, behaviour=math.nan))])[0].cards[0]
    assert unknown.figures[0].now == "unknown"
    assert "nan" not in unknown.figures[0].svg


def test_a_hint_is_shown(training):
    """As what reads the training says it."""
    assert "Hint:" not in drawn((training,), 0)
    assert "<b>Hint:</b> Pay rose &lt;much&gt;." in drawn((replace(training, hint="Pay rose <much>."),), 0)


@pytest.mark.parametrize("state", ["running", "stopped"])
def test_before_an_episode_has_ended_that_is_said(training, state):
    """In words."""
    card = rows_of([replace(training, blocks=None, state=state)])[0].cards[0]
    assert (card.figures, card.words) == ((), "No episode has ended yet.")


def test_a_failure_tells_its_reason(training):
    """In the place of figures."""
    card = rows_of([replace(training, blocks=None, state="failed", note="it raised ValueError")])[0].cards[0]
    assert card.words == "it raised ValueError"


def test_names_of_strangers_are_text(training):
    """In every place where they stand."""
    evil = '<script>"&\u202e'
    blocks = blocks_of(4, **{evil: 1.0, "b": 2.0})
    one = replace(training, place=evil, reward=evil, name=evil, measure=evil, note=evil, blocks=blocks)
    html = drawn((one, replace(one, state="failed", blocks=None)), 0)
    assert "<script" not in html
    assert html.count("&lt;script&gt;") >= 8


def test_a_number_that_stays_zero_has_a_plain_axis(training):
    """No power of ten stands beside a flat line."""
    [row] = rows_of([replace(training, blocks=blocks_of(4, pay=0.0))])
    [flat] = row.cards
    assert axis_texts(flat.figures[1].svg) == ["−1", "0", "1"]
