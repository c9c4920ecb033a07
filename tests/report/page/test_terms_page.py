"""Terms, and a reward that stands alone, on the page."""

import re

import pytest

from harness import load_results
from harness.report import Report, write_html
from tests.report.conftest import words_of
from tests.results.gentle import GENTLE, run_gentle

pytest.importorskip("jinja2")


def _page(folder, **given):
    """The page, and its visible words."""
    run = run_gentle(folder, reward=["gentle"], **given)
    write_html(Report(load_results(run, plugins=[folder / GENTLE])), folder / "page.html")
    page = (folder / "page.html").read_text()
    return page, words_of(page)


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    """A reward with terms beside one without."""
    return _page(tmp_path_factory.mktemp("compared"))


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """The same reward, and nothing to compare it with."""
    return _page(tmp_path_factory.mktemp("alone"), baseline="none")


def test_each_term_has_a_row(compared):
    """Below what is learned, above the number."""
    page, words = compared
    assert '<a href="#terms">Terms</a>' in page
    headings = (
        "Success rate while learning",
        "What each term paid: gentle",
        "an episode start end evaluation with baseline",
    )
    places = [words.index(it) for it in headings]
    assert places == sorted(places)
    assert all(f'<th scope="row">{term}</th>' in page for term in ("reach", "effort", "dock"))


def test_a_term_that_never_pays_is_on_the_first_screen(compared):
    """Before anything else is told of what the robot does."""
    page, words = compared
    assert "gentle: <code>dock</code> never paid in 900 steps." in page
    assert words.index("never paid in 900 steps") < words.index("Behaviour of the trained policies")


def test_what_was_asked_of_a_reward_alone_comes_first(alone):
    """Then how much was trained, and what it came to."""
    page, words = alone
    assert "<h1>What did gentle pay for?</h1>" in page
    headings = (
        "What did gentle pay for?",
        "3 trainings, 300 steps each",
        "Over the trainings: the pay of an episode from",
    )
    places = [words.index(it) for it in headings]
    assert places == sorted(places)


def test_pay_stands_beside_behaviour(alone):
    """Both over the training, in figures of one row."""
    page, _ = alone
    panels = page[page.index('<div class="panels">') :]
    assert panels.index("Success rate while learning") < panels.index("Return, as paid while learning")


def test_nothing_is_called_better_or_worse(alone):
    """Nor compared."""
    _, words = alone
    assert not [it for it in ("better", "worse", "HELPS", "HURTS", "CANNOT TELL") if it in words]


def test_no_link_leads_nowhere(alone, compared):
    """Each has its place on the page."""
    for page, _ in (alone, compared):
        links = {it for it in re.findall(r'href="#([^"]+)"', page) if not it.startswith("replay-")}  # made by a script
        assert links <= set(re.findall(r'id="([^"]+)"', page))


@pytest.mark.slow
@pytest.mark.parametrize(("width", "scheme"), [(1440, "light"), (390, "dark")])
def test_the_pages_fit_and_keep_nobody_out(alone, compared, fits, tmp_path, width, scheme):
    """In a browser: they complain of nothing, nothing is wider than the window, axe finds nothing serious."""
    for name, (text, _) in (("alone", alone), ("compared", compared)):
        (tmp_path / f"{name}.html").write_text(text)
        fits(tmp_path / f"{name}.html", width, scheme)
