"""Rankings as text, in the terminal and on the page."""

from dataclasses import replace

import pytest

from harness.eta import order_rewards
from harness.report import FactsTable, Report, write_html
from harness.report.rows.ranking import ranking_facts
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


def told(task):
    """What is said of a task."""
    _, fact, _ = ranking_facts([task])
    return fact


def test_lines_say_what_it_comes_to(task):
    """Choices first, then orders, with their interval and the engines that vote."""
    assert list(told(task).lines) == [
        "Another reward chosen in another place? yes 4, no 2, not decided 0; 6 choices in all. In 4 of them the choice "
        "costs success for certain.",
        "Order of the rewards across 2 engines (MuJoCo, Bullet): tau 0.33 [0.33, 0.33].",
    ]


def test_ranks_stand_in_a_table(task):
    """A row for each reward, three columns for each place; equal ones share a rank. Below them the orders' taus."""
    table, by_eta_n, *_ = told(task).grids
    assert table.headings[1:4] == ("mujoco\nsuccess", "mujoco\neta_P", "mujoco\neta_P behaviour")
    assert [it.partition("\n")[0] for it in table.headings[1::3]] == ["mujoco", "dm_control", "pybullet"]
    rows = {name: values for name, *values in table.rows}
    assert rows["arp"][::3] == ["1. 100%", "1. 100%", "2. 50%"]
    assert rows["baseline"][1] == "2. 1"
    assert rows["tau with success"] == ["", "1.00", "1.00"] * 3
    assert by_eta_n.rows[0][3] == "n/a"


def test_choices_have_their_cost_and_answer(task):
    """A row for each way."""
    rows = told(task).grids[2].rows
    assert [row[0] for row in rows[:3]] == ["mujoco -> dm_control", "dm_control -> mujoco", "mujoco -> pybullet"]
    assert rows[2][1:3] == ("arp", "relative")
    assert rows[2][3].startswith("50.0 [")
    assert [row[4] for row in rows[:3]] == ["NO", "NO", "YES"]


def test_places_of_one_engine_are_told(task):
    """Beside their tau."""
    rows = told(task).grids[3].rows
    assert rows[0][1:] == ("1.00", "[1.00, 1.00]", "one engine (MuJoCo): no second vote")
    assert rows[1][3] == ""


def test_terminal_has_lines_and_on_request_tables(build):
    """Without several places it has nothing."""
    results = build(simulators=("mujoco", "pybullet"), reached={"arp": lambda seed: [8] * 4})
    report = Report(results)
    short, long = (printed(FactsTable(it), 160) for it in (report.short, report.full))
    assert "Another reward chosen in another place? yes 0" in short
    assert "the seeds leave every order open" in short
    assert "chosen in -> used in" not in short
    assert "chosen in -> used in" in long
    assert Report(build(seeds=1)).ranking == []


def test_page_has_a_section_where_there_is_something_to_compare(build, tmp_path):
    """With one place there is nothing to rank, and no section."""
    pages = []
    for given in ({"simulators": ("mujoco", "pybullet")}, {}, {"proposed": {"arp": (9, 30)}}):
        write_html(Report(build(**{"proposed": REWARDS, "seeds": 1, **given})), tmp_path / "page.html")
        pages.append((tmp_path / "page.html").read_text())
    assert 'id="ranking"' in pages[0]
    assert "eta_P behaviour" in pages[0].partition('id="ranking"')[2]
    assert "each of their simulators counts as an engine of its own" in pages[0]
    assert 'id="ranking"' not in pages[1]
    assert 'id="ranking"' not in pages[2]


def test_rewards_that_were_left_out_are_named(task):
    """They are not in every place."""
    assert told(replace(task, left_out=("dense",))).lines[-1] == "Not in every place, and left out: dense."


def test_places_have_what_tells_them_apart(task):
    """Simulator and algorithm where both vary; a pair says what it has in common."""
    here, there = task.places[0], task.places[2]
    both = compare_places([here, there, replace(here, algorithm="ppo")], "fd100", "fd100-reach", 1_000)
    ranks, *_, agreements = told(both).grids
    places = [it.partition("\n")[0] for it in ranks.headings[1::3]]
    assert places == ["mujoco · sac", "pybullet · sac", "mujoco · ppo"]
    assert [row[0] for row in agreements.rows] == ["mujoco / pybullet (sac)", "sac / ppo (mujoco)"]
