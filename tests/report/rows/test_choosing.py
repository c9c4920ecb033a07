"""Which of several rewards went furthest, as the terminal and the page show it."""

import pytest

from harness.report import FactsTable, Report, choosing_facts, question
from harness_plugins.committed import committed_table, write_summary
from tests.registered import REGISTRY
from tests.report import conftest
from tests.results.folders import fail
from tests.results.in_looks import CHOOSING, folder_in_looks


@pytest.fixture
def folder(make_cell, make_plan, tmp_path):
    """Two candidates, nothing done yet."""
    return folder_in_looks(CHOOSING, make_cell, make_plan, REGISTRY, tmp_path)


@pytest.fixture
def over(folder):
    """`dense` went furthest, and helps on new trainings."""
    folder.train("dense", [0.9] * 4 + [0.8, 0.9, 0.8, 0.9])
    folder.train("arp", [0.3] * 4)
    folder.train("baseline", [0.1, 0.0, 0.1, 0.0])
    return folder


def printed(results, *console):
    """What goes to a terminal."""
    return conftest.printed(FactsTable(Report(results).short), *console)


def test_before_anybody_left_there_is_nothing_to_tell(folder):
    """But how many candidates there are, and the question."""
    folder.train("dense", [0.9] * 4)
    results = folder.results
    assert choosing_facts(results) == []
    assert "2 of 2 candidates are left, at most 12 trainings left" in " ".join(printed(results).split())
    assert question(results) == "Which of dense and arp makes the robot behave better than baseline?"


def test_the_one_that_went_furthest_is_named_and_no_word_is_said_yet(folder):
    """Before its new trainings have ended; cells of the other one are not needed any more."""
    folder.train("dense", [0.9] * 4)
    folder.train("arp", [0.3] * 4)
    (told, *_), standing = choosing_facts(folder.results), folder.standing
    assert told.title.startswith("dense went furthest of 2 (8 trainings). New trainings of it and of baseline")
    assert {(it.reward.label, it.seed) for it in standing.next} == {
        (name, seed) for name in ("dense", "baseline") for seed in (104, 105, 106, 107)
    }
    assert (standing.most_left, {it.reward.label for it in standing.not_needed}) == (8, {"arp"})
    (comparison,) = folder.results.combinations
    assert comparison.headline.answer == "interim"


def test_the_word_is_about_new_trainings_alone(over):
    """Labels dealt anew tell it at once, the bound from more of them on."""
    told, table, _ = choosing_facts(over.results)
    (grid,) = table.grids
    assert told.title.startswith("dense went furthest of 2 (8 trainings). On 4 new trainings of each, dense ")
    assert grid.headings == ("", "success rate of 4 trainings")
    assert grid.rows == [("dense", "90.0%"), ("arp", "30.0%")]
    (comparison,) = over.results.combinations
    assert comparison.trained == ((104, 105, 106, 107),) * 2
    assert over.standing.is_over


def test_a_new_training_that_failed_counts_against_the_word(over):
    """As one in a plan of looks: at the worst end, where it speaks most against it."""
    cell = over.cells["dense"][-1]
    fail(over.store, cell, "it broke")
    (comparison,) = over.results.combinations
    assert comparison.decisive.lost == ((), (cell.seed,))
    assert over.standing.is_over
    assert over.standing.next == [cell]


@pytest.mark.parametrize("width", [60, 80, 120])
def test_the_table_fits(over, width):
    """Into a terminal of this width."""
    text = printed(over.results, width)
    assert max(map(len, text.splitlines())) <= width
    assert "dense went furthest of 2" in text


def test_a_summary_tells_of_it(over, tmp_path):
    """With its table; what a terminal says of the records begins with it."""
    write_summary(over.results, tmp_path / "told")
    page = (tmp_path / "told" / "summary.md").read_text()
    assert page.index("**dense went furthest") < page.index("**How far the candidates went.**")
    assert "| dense | 90.0% |" in page
    told = conftest.printed(committed_table(tmp_path / "told"), 200).splitlines()
    assert choosing_facts(over.results)[0].title in told[:3]
