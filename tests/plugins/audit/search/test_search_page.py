"""The page of a search: behaviours beside one another, on one clock, without anything from elsewhere."""

import re
from dataclasses import replace

import numpy as np
import pytest

from harness.scene.scene import scene_of
from harness_plugins.audit import cheats_page
from harness_plugins.audit.search.film import Film
from harness_plugins.audit.search.replay import certify
from tests.plugins.audit.search.certified import (
    RUNS_ON,
    Line,
    certificate_of,
    drawn_of,
    film_of,
    finding_of,
    place_of,
    whole_certificate,
)
from tests.registered import FD100


@pytest.fixture(scope="module")
def certificates():
    """Of a failure and of a success that is the fastest one too."""
    return certify(finding_of(Line()), place_of(), Line, RUNS_ON, seed=4, budget=400)[0]


def test_the_answer_is_the_first_sentence(certificates):
    """With its three numbers, and a badge."""
    assert re.search(
        r'<span class="badge hurts">PAYS FOR FAILING, ROBUST</span> near</h2>\s*<p class="lead">Failing',
        cheats_page(certificates),
    )


def test_behaviours_that_are_one_are_shown_once(certificates):
    """The best-paid success is the fastest one here."""
    page = cheats_page(certificates)
    assert "fastest and best-paid success" in page
    assert ">best-paid success<" not in page


def test_the_charts_show_pay_measures_and_noise(certificates):
    """And no other."""
    headings = re.findall(r"<h4>([^<]*)</h4>\s*<svg", cheats_page(certificates))
    assert headings == ["Paid so far", "at", "Paid while actions are disturbed"]


def test_terms_have_a_table(certificates):
    """What each paid in all; none where there is but one."""
    assert "What each term paid" in cheats_page(certificates)
    shown = certificates[0].shown
    alone = [replace(certificates[0], shown=replace(shown, terms={"near": shown.paid}))]
    assert "What each term paid" not in cheats_page(alone)


def test_nothing_comes_from_elsewhere(certificates):
    """It opens offline, and the browser itself refuses other places."""
    page = cheats_page([replace(it, film=film_of((0, 5, 20))) for it in certificates])
    assert "default-src 'none'" in page
    assert not re.search(r"""(?:src|href)=["']?(?!#)|https?:(?!//www\.w3\.org)""", page)


def test_texts_of_strangers_are_no_markup():
    """Names, lines, measures."""
    evil = "<img src=x onerror=alert(1)>"
    made = certificate_of(place=place_of(evil))
    shown = replace(made.shown, measures={evil: np.arange(20.0)}, terms={evil: made.shown.paid, "b": made.shown.paid})
    answer = {**made.answer, "lines": [evil, evil]}
    assert "<img" not in cheats_page([replace(made, shown=shown, answer=answer)], remarks=[evil])


def test_films_share_a_clock(certificates):
    """The slider ends with the longest; each picture stands for its step."""
    films = {"failure": film_of((0, 7, 20)), "success": film_of((0, 11)), "fastest": film_of((0, 11))}
    page = cheats_page([replace(it, film=films[it.role]) for it in certificates])
    assert 'data-last="20"' in page
    assert 'data-steps="0,7,20"' in page
    assert 'data-steps="0,11"' in page


def test_a_film_that_cannot_be_drawn_says_why(certificates):
    """In a line, and there is no slider."""
    page = cheats_page([replace(it, film=Film("No screen.")) for it in certificates])
    assert page.count("No screen.") == 1
    assert 'type="range"' not in page


def test_an_arm_is_replayed(certificates):
    """As on other pages, and the film says what it shows."""
    drawn = [replace(it, shown=replace(it.shown, drawn=drawn_of(len(it.shown.paid)))) for it in certificates]
    page = cheats_page(drawn, scene_of(FD100))
    assert 'id="replay-player"' in page
    assert '"told": "near, start 3"' in page
    assert '"outcome": "reached"' in page


def test_an_arm_with_other_joints_is_not_replayed():
    """A stranger's file may hold any number of them."""
    made = whole_certificate()
    other = replace(made, shown=replace(made.shown, drawn=drawn_of(20, joints=3)))
    assert 'id="replay-player"' not in cheats_page([other], scene_of(FD100))


def test_without_a_measure_of_success_it_asks_no_role():
    """What is paid most is called so."""
    page = cheats_page([certificate_of(place=replace(place_of(), success=""))])
    assert "paid most" in page
    assert "best-paid failure" not in page.replace("</code> best-paid failure", "")


@pytest.mark.parametrize("value", [1e150, -1e150, 5e-324, 0.0])
def test_any_number_can_be_drawn(value):
    """Axes of every size."""
    made = certificate_of()
    shown = replace(made.shown, paid=np.full(20, value), measures={"at": np.linspace(0.0, value, 20)})
    assert "<svg" in cheats_page([replace(made, shown=shown)])
