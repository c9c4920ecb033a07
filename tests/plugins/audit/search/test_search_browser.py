"""The page of a search as a browser shows it: nothing overflows, nobody is kept out, and films play."""

from dataclasses import replace

import pytest

from harness import load_robot
from harness.scene.scene import scene_of
from harness_plugins.audit import cheats_page
from harness_plugins.audit.search.replay import certify
from tests.plugins.audit.search.certified import RUNS_ON, Line, drawn_of, film_of, finding_of, place_of
from tests.report.conftest import barriers, driver, launch, show

__all__ = ["barriers", "driver", "launch", "show"]
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def addresses(tmp_path_factory):
    """A page with films of an environment, and one with an arm."""
    folder = tmp_path_factory.mktemp("pages")
    made = certify(finding_of(Line()), place_of(), Line, RUNS_ON, seed=4, budget=400)[0]
    films = [replace(it, film=film_of((0, 7, len(it.shown.paid)))) for it in made]
    arms = [replace(it, shown=replace(it.shown, drawn=drawn_of(len(it.shown.paid)))) for it in made]
    (folder / "films.html").write_text(cheats_page(films))
    (folder / "arm.html").write_text(cheats_page(arms, scene_of(load_robot("fd100"))))
    return {name: (folder / f"{name}.html").as_uri() for name in ("films", "arm")}


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("name", ["films", "arm"])
def test_it_fits_and_keeps_nobody_out(show, barriers, addresses, name, width, scheme):
    """Nothing is asked for, nothing is complained of, and axe finds no barrier."""
    page = show(addresses[name], width, scheme)
    assert page.complaints == []
    assert page.requests == [it for it in page.requests if it == addresses[name] or it.startswith(("data:", "blob:"))]
    assert page.evaluate("document.documentElement.scrollWidth") == width
    assert barriers(page) == []


def test_the_film_plays_to_its_end(show, addresses):
    """By the button, and every picture ends with its last one."""
    page = show(addresses["films"])
    page.get_by_role("button", name="Play").click()
    page.locator("output:text-is('20')").wait_for(timeout=20_000)
    places = page.evaluate("[...document.querySelectorAll('.picture')].map((it) => it.style.backgroundPositionX)")
    assert places == ["100%"] * len(places)
    assert page.get_by_role("button", name="Play").count() == 1


def test_the_slider_shows_a_step(show, addresses):
    """The picture that was taken last before it."""
    page = show(addresses["films"])
    page.locator(".films input").fill("8")
    assert page.evaluate("document.querySelector('.picture').style.backgroundPositionX") == "50%"
