"""Sequential halving: how a budget is spent, who leaves, and how often the one that went furthest is good.

``pytest -m slow -s tests/eta/verdict/test_halving.py`` computes some rows of the table of
docs/how-to/language-model-rewards.md again.
"""

import re

import numpy as np
import pytest
from numpy.random import default_rng

from harness.eta import SHARE, UNBOUNDED, Question, Rung, fewest, halve, rule, schedule_of, usual
from tests.eta.scenarios import LEVEL, is_kept
from tests.eta.verdict.kinds import ENDS, spread
from tests.project import ROOT

PAGE = ROOT / "docs/how-to/language-model-rewards.md"
BUDGETS, GOOD = (20, 40, 60), 0.05
MEANS = {
    "one at 80 % among 5, the others at 50 %": lambda rng: np.array([0.8, *[0.5] * 4]),
    "one at 80 % among 10, the others at 50 %": lambda rng: np.array([0.8, *[0.5] * 9]),
    "2 between 30 and 90 %": lambda rng: rng.uniform(0.3, 0.9, 2),
    "5 between 30 and 90 %": lambda rng: rng.uniform(0.3, 0.9, 5),
    "10 between 30 and 90 %": lambda rng: rng.uniform(0.3, 0.9, 10),
    "10 of these, of which half fail in 1 training of 5": lambda rng: rng.uniform(0.3, 0.9, 10),
    "5 at 50 %, as the baseline": lambda rng: np.full(5, 0.5),
}


@pytest.mark.parametrize(
    ("candidates", "budget", "rungs", "fresh"),
    [
        (2, 12, [(2, 2)], 4),
        (2, 20, [(2, 5)], 5),
        (5, 20, [(5, 1), (2, 2)], 6),
        (5, 40, [(5, 1), (3, 2), (2, 4)], 14),
        (10, 20, [(10, 1)], 5),
        (10, 40, [(10, 1), (4, 2), (2, 4)], 11),
        (10, 60, [(10, 1), (5, 2), (3, 4), (2, 8)], 15),
    ],
)
def test_half_of_the_budget_chooses_and_the_rest_is_new(candidates, budget, rungs, fresh):
    """The better half stays, or two fifths where there is less; what choosing leaves over goes to new trainings."""
    found = schedule_of(candidates, budget, 1)
    assert ([*map(tuple, found.rungs)], found.fresh) == (rungs, fresh)
    assert budget - 2 < found.trainings(1) <= budget


def test_a_budget_is_shared_by_places():
    """Each has as much."""
    assert schedule_of(5, 80, 2) == schedule_of(5, 40, 1)
    assert usual(5, 2) == 2 * usual(5, 1) == 80


@pytest.mark.parametrize(("places", "fresh"), [(1, 4), (2, 3), (3, 2), (9, 2)])
def test_the_fewest_trainings_can_tell_something(places, fresh):
    """So far at least: if all new ones of the chosen reward end better, labels dealt anew say that it is no luck."""
    assert fewest(5, places) == places * (5 + 2 * fresh)
    values = np.zeros((2, places * fresh, places, 1))
    for place in range(places):
        own = slice(place * fresh, (place + 1) * fresh)
        values[:, :, place] = np.nan
        values[:, own, place, 0] = np.linspace(0.4, 0.5, fresh) + np.array([[0.0], [0.4]])
    assert rule([Question.of(values, np.tile(ENDS[:1], (places, 1, 1)))])[0].corrected <= LEVEL


RUNGS = (Rung(3, 1), Rung(2, 2))
WENT = {"a": np.array([[0.2, 0.9]]), "b": np.array([[0.5, 0.1]]), "c": np.array([[0.4, 0.6]])}


def halved(values, complete=2, ends=(SHARE,), rungs=RUNGS):
    """How candidates went of whom so many trainings are complete."""
    return halve(values, rungs, dict.fromkeys(values, complete), ends)


def test_the_worse_ones_leave_at_each_rung():
    """By the mean of all their trainings so far."""
    found = halved(WENT)
    assert found.means == ({"b": 0.5, "c": 0.4, "a": 0.2}, {"c": 0.5, "b": pytest.approx(0.3)})
    assert (found.left, found.furthest) == (("c",), "c")


def test_nobody_leaves_before_all_are_there():
    """A rung waits for each candidate that is left, and for no other one."""
    assert halved(WENT, 0).left == ("a", "b", "c")
    found = halve(WENT, RUNGS, {"a": 1, "b": 1, "c": 1}, [SHARE])
    assert (found.left, found.furthest) == (("b", "c"), None)
    assert halve(WENT, RUNGS, {"a": 1, "b": 2, "c": 2}, [SHARE]).furthest == "c"


@pytest.mark.parametrize(("ends", "furthest"), [(SHARE, "a"), (UNBOUNDED, "b")])
def test_a_training_without_a_value_is_the_worst_that_there_is(ends, furthest):
    """Its candidate comes last where nobody knows how bad a value can be; and is shown without a mean."""
    values = {"a": np.array([[np.nan, 0.9]]), "b": np.array([[0.3, 0.2]])}
    found = halved(values, ends=[ends], rungs=[Rung(2, 2)])
    assert found.furthest == furthest
    assert found.means[0]["a"] == (0.45 if ends == SHARE else None)


def test_places_count_alike():
    """The mean is over places first."""
    values = {"a": np.array([[1.0], [0.0]]), "b": np.array([[0.6], [0.6]])}
    assert halved(values, 1, [SHARE] * 2, [Rung(2, 1)]).furthest == "b"


def chosen(name, budget, rng):
    """Whether the reward that went furthest is the best or as good; then how its new trainings are told."""
    means = MEANS[name](rng)
    schedule = schedule_of(len(means), budget, 1)
    seeds = schedule.seeds + schedule.fresh
    failing = 0.2 * (np.arange(len(means)) % 2) if "fail" in name else np.zeros(len(means))
    values = {
        str(at): np.where(rng.random((1, seeds)) < failing[at], 0.0, spread(mean, 0.15)(rng, (1, seeds)))
        for at, mean in enumerate(means)
    }
    best = int(halve(values, schedule.rungs, dict.fromkeys(values, seeds), [SHARE]).furthest or 0)
    of_both = np.stack([spread(0.5, 0.15)(rng, (schedule.fresh,)), values[str(best)][0, schedule.seeds :]])
    told, true = rule([Question.of(of_both[..., None, None], ENDS[None, :1])])[0], (1.0 - failing) * means
    said = (told.is_decided or told.is_ahead, told.is_decided)
    return true[best] >= true.max() - GOOD, *(it and told.sign > 0 for it in said), said[0]


def rows_of(page):
    """The rows of the table: what the candidates are, then three shares for each budget."""
    for name, *cells in re.findall(r"^\| (.+?) \|" + r" (\d\.\d\d / \d\.\d\d / \d\.\d\d) \|" * 3 + "$", page, re.M):
        yield name, [[float(it) for it in cell.split(" / ")] for cell in cells]


def test_the_page_has_every_row():
    """So that none is left out below."""
    assert [name for name, _ in rows_of(PAGE.read_text())] == [*MEANS]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "told"), list(rows_of(PAGE.read_text())))
def test_the_table_of_the_page_is_what_is_measured(name, told):
    """Within three standard errors, and the rounding; a word that is false is as rare as in any experiment."""
    experiments = 250
    for budget, of_page in zip(BUDGETS, told, strict=True):
        rng = default_rng([budget, len(name)])
        *found, any_word = np.mean([chosen(name, budget, rng) for _ in range(experiments)], axis=0)
        print(f"{name}, {budget}: good {found[0]:.3f}, so far or better {found[1]:.3f}, plain {found[2]:.3f}")  # noqa: T201
        for measured, share in zip(found, of_page, strict=True):
            wide = 3.0 * (1.5 * max(measured * (1.0 - measured), 0.004) / experiments) ** 0.5
            assert abs(measured - share) <= wide + 0.005
        assert "baseline" not in name or is_kept(name, any_word, 0.055, experiments)
