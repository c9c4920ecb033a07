import re

import numpy as np
import pytest

from harness import load_results
from harness.report import Report, write_html
from tests.report.conftest import words_of
from tests.results.recordings.conftest import PAYS, record

pytest.importorskip("jinja2")
ROBOT_WORDS = ("robot", "simulator", "FD100", "end effector", "ground", "shaped", "Fig.")


def pages(folder, rewards, **facts):
    """A page on so many rewards, and its visible words."""
    pays = {**PAYS, "loss": lambda arm: arm - 2.0, "tiny": lambda arm: arm / 1e3}
    for reward in list(pays)[:rewards]:
        for seed in range(3):
            arms = np.linspace(0.0, 1.0, 10) + 0.01 * seed
            record(folder / f"{reward}-{seed}", reward, seed, arms, pays=pays, **facts)
    write_html(Report(load_results(folder)), folder / "page.html")
    page = (folder / "page.html").read_text()
    return page, words_of(page)


@pytest.fixture(scope="module")
def of_two(tmp_path_factory):
    """Two rewards: one comparison."""
    return pages(tmp_path_factory.mktemp("two"), 2)


@pytest.fixture(scope="module")
def of_four(tmp_path_factory):
    """Four: three comparisons."""
    return pages(tmp_path_factory.mktemp("four"), 4)


def test_no_word_is_of_a_robot(of_two, of_four):
    """The page is that of an experiment, told of any agent."""
    for _, words in (of_two, of_four):
        assert not [word for word in ROBOT_WORDS if word in words]
        assert "What the agent does" in words or "the agent" in words


def test_the_order_is_that_of_an_arm(of_two):
    """Behaviour, learning, the number: its table, how it splits, then the curves."""
    _, words = of_two
    headings = (
        "Behaviour in its last fifth",
        "Success while learning",
        "The number The pay of an episode",
        "Pay of an episode, in its last fifth",
        "Accumulated reward",
    )
    places = [words.index(heading) for heading in headings]
    assert places == sorted(places)


def test_every_measure_and_every_ruler_has_a_learning_curve(of_two):
    """The rewards that taught nobody are rulers too."""
    page, _ = of_two
    for name in ("Success", "Arm", "Return paid by plain", "Return paid by loss"):
        assert f"<h4>{name} while learning</h4>" in page


def test_several_rewards_have_a_row_each(of_four):
    """Each but the first, with which all are compared."""
    page, _ = of_four
    assert page.count("<tr data-answer=") == 3


def test_every_training_paid_by_every_reward_is_open(of_four):
    """However many there are."""
    _, words = of_four
    assert "return in its last fifth, scored by plain thrice loss tiny" in words


def test_nothing_is_loaded(of_two):
    """All links lead to places on the page, and there is no section without content."""
    page, _ = of_two
    assert all(link.startswith("#") for link in re.findall(r'href="([^"]*)"', page))
    assert 'id="repeat"' not in page


def test_what_is_missing_is_told(tmp_path):
    """Below the recordings."""
    record(tmp_path / "short", "plain", 9, [0.1])
    _, words = pages(tmp_path, 2)
    assert "short' is missing: it ends after 5 steps, and another one of plain after" in words


def test_names_are_text(tmp_path):
    """A reward may be called anything."""
    odd = "<b>&amp;[red]"
    pays = {odd: PAYS["plain"], "thrice": PAYS["thrice"]}
    for reward in pays:
        record(tmp_path / str(len(reward)), reward, 0, [0.1, 0.2], pays=pays)
    write_html(Report(load_results(tmp_path)), tmp_path / "page.html")
    assert odd not in (tmp_path / "page.html").read_text().replace("&lt;b&gt;&amp;amp;[red]", "")


@pytest.mark.slow
@pytest.mark.parametrize(("width", "scheme"), [(1440, "light"), (390, "dark")])
def test_the_page_fits_and_keeps_nobody_out(of_four, fits, tmp_path, width, scheme):
    """In a browser: it complains of nothing, nothing is wider than the window, axe finds nothing serious."""
    (tmp_path / "page.html").write_text(of_four[0])
    fits(tmp_path / "page.html", width, scheme)


def test_equal_trainings_and_rescaled_rewards_are_told(of_two):
    """In plain words."""
    _, words = of_two
    assert "The trainings by plain and thrice are equal bit for bit, with seeds 0, 1 and 2" in words
    assert "thrice is 3 x plain + 3, in all 300 steps, for which plain paid 30 different numbers." in words
