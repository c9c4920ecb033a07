"""The page for a repository."""

import re

from harness_plugins.committed.records import write_summary
from tests.report.conftest import MIXTURE


def page(summarise, **given):
    """The text of the page."""
    return (summarise(**given) / "summary.md").read_text()


def test_table_has_what_the_report_says(build, tmp_path):
    """Both etas with their intervals, the split, the success rates, the seeds."""
    results = build()
    write_summary(results, tmp_path / "mine")
    line = next(line for line in (tmp_path / "mine" / "summary.md").read_text().split("\n") if line.startswith("| 1 |"))
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    assert cells == [
        *("1", "mujoco · sac · fd100 · fd100-reach", "arp against baseline", "CANNOT TELL"),
        *("0.843 [0.823, 0.863]", "0.843 x 1.00", "1.89 [1.77, 2.02]", "1.89 x 1.00"),
        *("75.0%", "75.0%", "0.0%", "3", ""),
    ]


def test_both_answers_stand_under_the_table(summarise):
    """The robot first, then the number, then what to keep in mind."""
    text = page(summarise)
    told = (
        "**The robot: CANNOT TELL.** Success +0.0 points",
        "The number: I_N with arp is 0.843 ",
        "* eta_N noise",
    )
    places = [text.index(part) for part in told]
    assert places == sorted(places)


def test_every_grid_is_a_table_with_its_title(summarise):
    """Behaviour in every manner, along the budget, both etas, their split and its paths."""
    text = page(summarise, learned={10: 1})
    for title in (
        "Behaviour of the trained policies, deterministic, 4 episodes per seed",
        "Behaviour while training, 1 episode or more per seed",
        "Behaviour while learning",
        "Along the budget of training, deterministic",
        "eta = proposed / baseline",
        "eta = ruler x behaviour",
        "ruler x behaviour, on each path",
    ):
        assert re.search(rf"\n\n{re.escape(title)}\n\n\|  \| ", text), title


def test_tables_of_markdown_are_whole(summarise):
    """Every row has as many cells as its heading."""
    for table in re.findall(r"(?:^\|.*\n)+", page(summarise, learned={10: 1}), re.MULTILINE):
        assert len({line.count("|") - line.count("\\|") for line in table.splitlines()}) == 1


def test_reason_of_what_is_missing_is_told(summarise):
    """An eta that is not defined says why."""
    text = page(summarise, baseline=(39, 0))
    assert "* eta_P n/a: I_P of the baseline is 0: its mean accumulated reward is never positive" in text


def test_failures_show(summarise):
    """In the table, and each with its reason; what Markdown would take for its own is escaped."""
    text = page(summarise, ended={("arp", 0): ("failed", "it | *broke* <b>"), ("arp", 1): ("pending", "not run yet")})
    assert "| 3 / 1 | 1 failed, 1 pending of 6 cells |" in text
    assert "* failed: mujoco · sac · arp · seed 0: it \\| \\*broke\\* \\<b\\>" in text
    assert "* 1 pending: not run yet" in text


def test_nothing_finished_is_said(summarise):
    """In words."""
    text = page(summarise, seeds=1, ended={("arp", 0): ("failed", "it broke")})
    assert "No combination is finished: no seed is done under both of its rewards." in text
    assert "**The robot: CANNOT TELL.** Nothing to compare: no training with arp is done." in text
    assert "eta = " not in text.split("## 1.")[1]


def test_cost_and_machine_are_told(summarise):
    """Time, versions, CPU and commit; no command and no folder of the machine."""
    text = page(summarise)
    assert "6 cells, 75.0 s in all; 12.5 s from the start of the first, 2026-01-01 00:00:00 UTC" in text
    for fact in ("| commit | 0123456789abcdef | all |", "| cpu | a processor | all |", "| numpy | 2.4.0 | all |"):
        assert fact in text
    assert "harness run --sim mujoco" not in text
    assert "harness run experiment.toml" in text


def test_folder_of_several_experiments_is_told(summarise):
    """The file beside the page is the newest of them."""
    assert "repeats it: the newest, where several were run in one folder." in page(summarise)


def test_system_is_left_out(summarise):
    """The kernel of the machine."""
    assert "| system |" not in page(summarise)


def test_nothing_ran_is_said(summarise):
    """An experiment that waits has taken nothing."""
    waiting = {(reward, 0): ("pending", "not run yet") for reward in ("baseline", "arp")}
    assert "No cell has run." in page(summarise, seeds=1, ended=waiting)


def test_every_picture_is_there(summarise):
    """And every figure is shown."""
    folder = summarise(simulators=("mujoco", "pybullet"), learned={10: 1})
    shown = set(re.findall(r"!\[[^\]]+\]\((.+)\)", (folder / "summary.md").read_text()))
    assert shown == {f"figures/{path.name}" for path in (folder / "figures").iterdir()}


def test_a_stranger_s_text_is_no_link(summarise):
    """No picture that is fetched, no hidden character, no entity; units in brackets stay."""
    evil = "![a](http://b/c.png) [d][e] [f]: g &lt; \u202e \x1b[2J [m]"
    text = page(summarise, ended={("arp", 0): ("failed", evil)})
    assert "![a\\](http://b/c.png) [d\\][e] [f\\]: g \\&lt; \\\\u202e \\\\x1b[2J [m]" in text


def test_mixture_is_marked(mixed, tmp_path):
    """Above both answers."""
    write_summary(mixed, tmp_path / "mine")
    text = (tmp_path / "mine" / "summary.md").read_text()
    assert text.index(f"**{MIXTURE}.**") < text.index("**The robot:")
