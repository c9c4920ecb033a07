"""Both words keep what they promise, in simulated experiments whose truth is known.

``pytest -m slow -s tests/eta/verdict/test_promises.py`` prints what was measured. The table of
docs/what-statistics-promise.md is read here, and each of its numbers is computed again.
"""

import re

import numpy as np
import pytest
from numpy.random import default_rng

from harness.eta import Looks, Question, rule, rule_in_looks
from harness.eta.verdict.looks import ONE_PLACE, SEVERAL_PLACES, luck_in
from harness.eta.verdict.ruling import LATER, better_in, opposed_in, rule_places
from tests.eta.scenarios import LEVEL, is_kept
from tests.eta.verdict.kinds import ENDS, KINDS, Kind, failing, question_of, spread
from tests.project import ROOT

PAGE = ROOT / "docs/what-statistics-promise.md"
BELL = KINDS["bell curve"]
BETTER = spread(0.45, 0.18)
TABLE = {
    "nothing: both rewards are the same": (BELL, 0.0, 1),
    "means are equal, and one reward fails in one training of ten": (KINDS["steady, 1 in 10 fails"], 0.0, 1),
    "+20 points": (Kind(BETTER, BETTER), 0.2, 1),
    "+30 points": (Kind(BETTER, BETTER), 0.3, 1),
    "+20 points in each of four places": (Kind(BETTER, BETTER), 0.2, 4),
    "steady at 80 and at 90 %": (Kind(spread(0.8, 0.02), spread(0.9, 0.02)), 0.0, 1),
}
SEEDS = (5, 10, 20)


def is_plain(question, confidence=1.0 - LEVEL):
    """Whether any measure's bound leaves out 0."""
    return any(question.leaning(at, confidence) for at in range(question.values.shape[3]))


def shares(kind, effect, seeds, places, experiments):
    """How often a plain word is said, and how often that or one of these trainings alone."""
    rng = default_rng([seeds, places])
    found = [rule([question_of(kind, rng, seeds, places, 3, effect)])[0] for _ in range(experiments)]
    return np.mean([it.is_decided for it in found]), np.mean([it.is_decided or it.is_ahead for it in found])


def rows_of(page):
    """The rows of the table: name, then for each number of trainings how often plain, then at least so far."""
    for name, *cells in re.findall(r"^\| (.+?) \| (\d?\.\d\d .+?) \| (\d?\.\d\d .+?) \|$", page.read_text(), re.M):
        yield name, [[float(it) for it in cell.split(" / ")] for cell in cells]


def test_the_page_has_every_row():
    """So that none is left out below."""
    assert [name for name, _ in rows_of(PAGE)] == [*TABLE]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "told"), list(rows_of(PAGE)))
def test_the_table_of_the_page_is_what_is_measured(name, told):
    """Within three standard errors, and the rounding."""
    kind, effect, places = TABLE[name]
    experiments = 1000 if places == 1 else 300
    for at, seeds in enumerate(SEEDS):
        found = shares(kind, effect, seeds, places, experiments)
        print(f"{name}, {seeds} trainings: plain {found[0]:.3f}, so far or better {found[1]:.3f}")  # noqa: T201
        for measured, of_page in zip(found, told, strict=True):
            wide = 3.0 * (2.0 * max(measured * (1.0 - measured), 0.004) / experiments) ** 0.5
            assert abs(measured - of_page[at]) <= wide + 0.005


def test_a_few_experiments_claim_little():
    """A gross mistake shows at once: labels dealt anew alone were wrong in half of them."""
    rng = default_rng(0)
    kind = KINDS["steady, 1 in 10 fails"]
    assert not any(is_plain(question_of(kind, rng, seeds, 1, 3)) for seeds in (5, 10, 20) for _ in range(40))


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("places", [1, 4])
def test_a_plain_word_is_seldom_false_where_means_are_equal(name, places):
    """In 5.5 % of the experiments at most, one training of each reward or none unseen; 6 % at four places."""
    experiments = 1000 if places == 1 else 200
    for seeds in (3, 5, 10, 20, 40):
        rng = default_rng([seeds, places])
        wrong = np.mean([is_plain(question_of(KINDS[name], rng, seeds, places, 3)) for _ in range(experiments)])
        assert is_kept(f"{name}, {seeds} trainings, {places} places", wrong, 0.055, experiments)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["bell curve", "learns or not, 1 in 2", "steady, all or nothing .5", "beta (.5, .5)"])
@pytest.mark.parametrize(
    ("seeds", "places"), [((5, 10, 15, 20), 1), (ONE_PLACE, 1), (tuple(range(4, 25)), 1), (SEVERAL_PLACES, 4)]
)
def test_looks_keep_it(name, seeds, places):
    """From the second look on at 98 %: in 6 % at most over all looks."""
    experiments, rng, wrong = 400, default_rng(len(seeds)), 0
    for _ in range(experiments):
        whole = question_of(KINDS[name], rng, seeds[-1], places, 1)
        row = np.arange(seeds[-1])[:, None] < np.array(seeds)
        levels = [LEVEL, *[LATER] * (len(seeds) - 1)]
        there = (whole.among(np.repeat(of[:, None], places, 1)) for of in row.T)
        wrong += any(is_plain(it, 1.0 - level) for it, level in zip(there, levels, strict=True))
    assert is_kept(f"{name}, looks at {seeds}, {places} places", wrong / experiments, 0.06, experiments)


@pytest.mark.slow
@pytest.mark.parametrize(("effect", "power", "most"), [(0.2, 0.90, 25), (0.3, 0.98, 18)])
def test_until_decided_finds_effects(effect, power, most):
    """So often by 32 trainings of each reward, with so many on average."""
    experiments, rng, looks, ends = 300, default_rng(1), Looks(ONE_PLACE), []
    at = np.searchsorted(ONE_PLACE, np.arange(ONE_PLACE[-1]), side="right")[:, None]
    for _ in range(experiments):
        question = question_of(Kind(BETTER, BETTER), rng, ONE_PLACE[-1], 1, 3, effect)
        ends.append(rule_in_looks(question, at, looks, len(ONE_PLACE)))
    found, used = np.mean([it.is_decided for it in ends]), np.mean([ONE_PLACE[it.look] for it in ends])
    print(f"+{100 * effect:.0f} points: {found:.3f} with {used:.1f}")  # noqa: T201
    assert found >= power - 0.05
    assert used <= most


@pytest.mark.slow
@pytest.mark.parametrize(("rewards", "offered"), [(1, 0), (4, 0), (1, 10)])
@pytest.mark.parametrize("name", ["bell curve", "learns or not, 1 in 2", "1 in 10 fails"])
def test_so_far_is_seldom_said_where_rewards_are_the_same(name, rewards, offered):
    """Of several rewards, and of a measure that was chosen from eleven for looking best: in 5.5 % at most."""
    experiments, rng, wrong = 400, default_rng([rewards, offered]), 0
    for _ in range(experiments):
        of = [question_of(KINDS[name], rng, 10, 1, 3 if rewards > 1 else 1) for _ in range(rewards)]
        if offered:
            whole = np.concatenate([question_of(KINDS[name], rng, 10).values for _ in range(offered + 1)], axis=3)
            t = np.abs(Question.of(whole).statistics()[0])
            order = [int(t.argmax()), *(at for at in range(offered + 1) if at != t.argmax())]
            of = [Question.of(whole[..., order], np.tile(ENDS[:1], (1, offered + 1, 1)))]
        wrong += any(it.is_decided or it.is_ahead for it in rule(of, offered=[offered] * len(of)))
    assert is_kept(f"{name}, {rewards} rewards, {offered} offered", wrong / experiments, 0.055, experiments)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["steady, 1 in 10 fails", "steady, all or nothing .8", "beta (.5, .5)"])
def test_single_places_and_counts_of_places_are_seldom_false(name):
    """Better in two of four places: no more than two are counted, and none is opposed."""
    experiments, rng, wrong = 200, default_rng(3), 0
    for _ in range(experiments):
        values = question_of(KINDS[name], rng, 10, 4).values.copy()
        values[0, :, :2] *= 0.4
        question = Question.of(values, np.tile(ENDS[:1], (4, 1, 1)))
        (whole,) = rule([question])
        wrong += better_in(question, whole) > 2 or opposed_in(whole, rule_places(question, whole)) > 0
    assert is_kept(f"{name}: places", wrong / experiments, LEVEL, experiments)


@pytest.mark.slow
@pytest.mark.parametrize("seeds", [3, 5, 10, 20])
@pytest.mark.parametrize("name", KINDS)
def test_printed_intervals_hold_the_difference(name, seeds):
    """In 95 % of the experiments at least; where means are equal that is 0."""
    experiments, rng = 600, default_rng(seeds)
    bounds = [question_of(KINDS[name], rng, seeds, 1, 2) for _ in range(experiments)]
    for measure in (0, 1):
        held = np.mean([low <= 0.0 <= high for low, high in (it.bounds(measure, 0.95) for it in bounds)])
        assert is_kept(f"{name}, {seeds} trainings: outside", 1.0 - held, LEVEL, experiments)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.05, 0.1, 0.2])
def test_small_differences_are_seldom_said_falsely(share):
    """A reward that fails so often beside one that never does, the margin being what that costs."""
    experiments, rng = 1000, default_rng(5)
    for seeds in (5, 10, 20, 40, 64):
        kind = Kind(failing(0.0, 1.0), failing(share, 1.0))
        bounds = [question_of(kind, rng, seeds).bounds(0, 0.90) for _ in range(experiments)]
        wrong = np.mean([-share < low and high < share for low, high in bounds])
        assert is_kept(f"{share} fail, {seeds} trainings: said to be less", wrong, LEVEL, experiments)


@pytest.mark.parametrize(
    ("seeds", "luck"), [((4,), 0.05), ((4, 5), 0.07), ((5, 10), 0.083), ((5, 10, 15, 20), 0.126), ((4, 8, 16), 0.113)]
)
def test_the_chance_of_luck_at_several_looks_is_that_of_a_random_walk(seeds, luck):
    """Armitage, McPherson and Rowe's table has .083 and .126 for two and four equal steps."""
    assert luck_in(seeds) == pytest.approx(luck, abs=0.001)
