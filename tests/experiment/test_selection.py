"""Some of a plan's cells, by name."""

import pytest

from harness.experiment.experiment import select
from harness.registry import Choice
from tests.refusals import refused


@pytest.fixture
def cells(make_cell):
    """Two algorithms, two rewards, three seeds."""
    algorithms = [Choice("sac", (), "sac"), Choice("ppo", (("gamma", 0.9),), "ppo:gamma=0.9")]
    rewards = [Choice("baseline", (), "baseline"), Choice("arp", (), "arp")]
    return [
        make_cell(algorithm=algorithm, reward=reward, seed=seed)
        for algorithm in algorithms
        for reward in rewards
        for seed in range(3)
    ]


def test_words_of_one_kind_are_alternatives_and_kinds_narrow(cells, subtests):
    """As ``--only`` takes them."""
    for text, count in [
        ("sac", 6),
        ("sac,ppo", 12),
        ("ppo:gamma=0.9", 6),
        ("arp,seed=1", 2),
        ("seed=0,seed=2,sac", 4),
        ("ideal", 12),
    ]:
        with subtests.test(text=text):
            assert len(select(cells, text)) == count


def test_a_cell_may_be_named_by_its_id(cells):
    """As ``harness status`` and the folders name it."""
    assert select(cells, cells[4].id) == (cells[4],)


def test_the_order_of_the_plan_stays(cells):
    """Whatever the order of the words."""
    assert select(cells, "seed=1,seed=0,sac") == tuple(cells[i] for i in (0, 1, 3, 4))


def test_a_short_name_means_the_algorithm(cells):
    """With parameters too."""
    short = {"p": "ppo"}
    assert select(cells, "p,seed=0", short) == select(cells, "ppo,seed=0")
    assert select(cells, "p:gamma=0.9", short) == select(cells, "ppo:gamma=0.9")
    with refused("has 'p'"):
        select(cells, "p")


def test_a_word_that_names_nothing_is_refused(cells):
    """The message says what there is."""
    with refused(r"has 'td3'\. Allowed are ideal, sac, ppo:gamma=0\.9, baseline, arp, seed=0"):
        select(cells, "sac,td3")


@pytest.mark.parametrize("text", ["", " ", ","])
def test_no_word_is_refused(cells, text):
    """It would be all cells, which nobody asks for so."""
    with refused("Allowed are"):
        select(cells, text)
