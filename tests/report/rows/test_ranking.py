"""Rankings as text, in the terminal and on the page."""

from dataclasses import replace

import pytest

from harness.eta import order_rewards
from harness.report import FactsTable, write_html
from harness.report.facts import ranking_facts
from harness.report.rows.ranking import task_rows
from harness.results.ranking import EtaOrder, Place, compare_places
from tests.report.conftest import printed

REWARDS = {"arp": (9, 30), "relative": (9, 20)}
HERE = {"baseline": [0.0] * 12, "arp": [1.0] * 12, "relative": [0.5] * 12}
THERE = {**HERE, "arp": HERE["relative"], "relative": HERE["arp"]}
BY_ETA = EtaOrder({"arp": 1.5, "baseline": 1.0}, 1.0)
ETAS = {"eta_P": BY_ETA, "eta_P behaviour": BY_ETA, "eta_N": BY_ETA, "eta_N behaviour": EtaOrder({}, None)}


@pytest.fixture(scope="module")
def task():
    """Arp is best in MuJoCo, relative in Bullet."""
    orders = order_rewards([HERE, HERE, THERE], [100] * 3)
    engines = {"mujoco": "MuJoCo", "dm_control": "MuJoCo", "pybullet": "Bullet"}
    places = [Place(name, "sac", engines[name], order, ETAS) for name, order in zip(engines, orders, strict=True)]
    return compare_places(places, "fd100", "fd100-reach", 1_000)


def test_lines_say_what_it_comes_to(task):
    """Choices first, then orders, with their interval and the engines that vote."""
    assert task_rows(task).lines == [
        "another reward chosen in another place? yes 4, no 2, not decided 0; 6 choices in all. In 4 of them the choice "
        "costs success for certain.",
        "order of the rewards across 2 engines (MuJoCo, Bullet): tau 0.33 [0.33, 0.33].",
    ]


def test_ranks_stand_in_a_table(task):
    """A row for each reward, three columns for each place; the best stands out, equal ones share a rank."""
    table = task_rows(task).ranks[0]
    assert table.places == ["mujoco", "dm_control", "pybullet"]
    rows = dict(table.rows)
    best = rows["arp"][0]
    assert (best.place, best.value, best.is_best) == (1, "100%", True)
    assert [rank.place for rank in rows["arp"][::3]] == [1, 1, 2]
    assert rows["baseline"][1].value == "1"
    assert len(rows["baseline"]) == len(table.taus) == 9


def test_choices_have_their_cost_and_answer(task):
    """A row for each way."""
    rows = task_rows(task).choices.rows
    assert [row[0] for row in rows[:3]] == ["mujoco -> dm_control", "dm_control -> mujoco", "mujoco -> pybullet"]
    assert rows[2][1:3] == ("arp", "relative")
    assert rows[2][3].startswith("50.0 [")
    assert [row[4] for row in rows[:3]] == ["NO", "NO", "YES"]


def test_places_of_one_engine_are_told(task):
    """Beside their tau."""
    rows = task_rows(task).agreements.rows
    assert rows[0][1:] == ("1.00", "[1.00, 1.00]", "one engine (MuJoCo): no second vote")
    assert rows[1][3] == ""


def test_terminal_has_lines_and_on_request_tables(build):
    """Without several places it has nothing."""
    results = build(simulators=("mujoco", "pybullet"), reached={"arp": lambda seed: [8] * 4})
    short, long = (
        printed(FactsTable(ranking_facts(results, with_all=False)), 160),
        printed(FactsTable(ranking_facts(results, with_all=True)), 160),
    )
    assert "another reward chosen in another place? yes 0" in short
    assert "the seeds leave every order open" in short
    assert "chosen in -> used in" not in short
    assert "chosen in -> used in" in long
    assert ranking_facts(build(seeds=1), with_all=False) == []


def test_page_has_a_section_where_there_is_something_to_compare(build, tmp_path):
    """With one place there is nothing to rank, and no section."""
    pages = []
    for given in ({"simulators": ("mujoco", "pybullet")}, {}, {"proposed": {"arp": (9, 30)}}):
        write_html(build(**{"proposed": REWARDS, "seeds": 1, **given}), tmp_path / "page.html")
        pages.append((tmp_path / "page.html").read_text())
    assert 'id="ranking"' in pages[0]
    assert '<table class="ranks">' in pages[0]
    assert "each of their simulators counts as an engine of its own" in pages[0]
    assert 'id="ranking"' not in pages[1]
    assert 'id="ranking"' not in pages[2]


def test_rewards_that_were_left_out_are_named(task):
    """They are not in every place."""
    assert task_rows(replace(task, left_out=("dense",))).lines[-1] == "not in every place, and left out: dense."


def test_places_have_what_tells_them_apart(task):
    """Simulator and algorithm where both vary; a pair says what it has in common."""
    here, there = task.places[0], task.places[2]
    rows = task_rows(compare_places([here, there, replace(here, algorithm="ppo")], "fd100", "fd100-reach", 1_000))
    assert rows.ranks[0].places == ["mujoco · sac", "pybullet · sac", "mujoco · ppo"]
    assert [row[0] for row in rows.agreements.rows] == ["mujoco / pybullet (sac)", "sac / ppo (mujoco)"]
