"""The page of a summary."""

import re
from dataclasses import replace

import pytest

from harness.eta.headline import estimate_text
from harness_plugins.committed import write_summary
from harness_plugins.committed.markdown import duration_text, effort_of
from tests.report.conftest import MIXTURE, NO_PAIR


def page(summarise, **given):
    """The text of the page."""
    return (summarise(**given) / "summary.md").read_text()


def test_table_has_what_the_report_says(build, tmp_path):
    """The line of the overview, then both etas with their intervals and parts."""
    results = build()
    write_summary(results, tmp_path / "mine")
    lines = (tmp_path / "mine" / "summary.md").read_text().split("\n")
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| arp |")]
    (pay,) = {split.ratio.eta for split in results.combinations[0].number.returns.values()}
    assert rows[0][:4] == ["arp", "CANNOT TELL", "-", "75 -\\> 75 %"]
    assert rows[0][5] == f"x {estimate_text(pay)}"
    assert rows[1] == ["arp", "0.843 [0.823, 0.863]", "0.843 x 1.00", "1.89 [1.77, 2.02]", "1.89 x 1.00"]


def test_both_answers_stand_under_the_table(summarise):
    """The robot first, then the number, then what to keep in mind."""
    text = page(summarise).partition("## 1.")[2]
    told = (
        "**The robot: CANNOT TELL.** Success +0.0 points",
        "**The note's eta_N and eta_P.** I_N with arp is 0.843 ",
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
        "The note's eta_N and eta_P: proposed / baseline",
        "The note's eta_N and eta_P: ruler x behaviour",
        "The note's eta_N and eta_P: ruler x behaviour, on each path",
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
    assert "\n\nNot done: 1 failed, 1 pending of 6 cells.\n\n" in text
    assert " failed: mujoco · sac · arp · seed 0: it \\| \\*broke\\* \\<b\\>\n\n" in text
    assert "\n\n1 pending: not run yet\n\n" in text


def test_nothing_finished_is_said(summarise):
    """In words."""
    text = page(summarise, **NO_PAIR)
    assert "**The robot: INTERIM.** Nothing to compare: no training with arp is done." in text
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
    assert text.index(MIXTURE) < text.index("**The robot:")


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({}, ["", ""]),
        (
            {("arp", 1): ("failed", "it broke"), ("baseline", 2): ("pending", ""), ("relative", 0): ("failed", "x")},
            ["1 failed, 1 pending of 6 cells"] * 2,
        ),
    ],
)
def test_what_is_not_done_is_counted(summarise, given, told):
    """Of both rewards of the combination, and of no other; nothing where all are done."""
    assert lacking(page(summarise, proposed={"arp": (9, 30), "relative": (9, 30)}, ended=given)) == told


@pytest.mark.parametrize(("seed", "told"), [(0, ["1 failed of 6 cells"] * 2), (5, ["", "1 failed of 6 cells"])])
def test_null_control_counts_both_trainings_of_the_baseline(summarise, seed, told):
    """Those with other seeds belong to it alone."""
    assert lacking(page(summarise, a_a=True, ended={("baseline", seed): ("failed", "it broke")})) == told


def lacking(text):
    """What each part on a combination says is not done."""
    parts = re.split(r"\n## \d+\. ", text)[1:]
    return ["".join(re.findall(r"\nNot done: (.*)\.\n", part)) for part in parts]


def test_seconds_are_added_and_the_span_is_from_first_to_last(build):
    """Cells that run beside one another take less together; what never ran counts as nothing."""
    first, second, third, *_ = build(seeds=2, ended={("baseline", 1): ("pending", "")}).manifests
    effort = effort_of([replace(second, started="2026-01-01T00:00:10+00:00", seconds=100.0), first, third])
    assert (effort.cells, effort.seconds, effort.span) == (2, 112.5, 110.0)


@pytest.mark.parametrize(
    ("seconds", "text"), [(12.54, "12.5 s"), (99.9, "99.9 s"), (1_500.0, "25 min"), (11_100.0, "3 h 5 min")]
)
def test_durations_are_for_people(seconds, text):
    """Seconds, minutes or hours."""
    assert duration_text(seconds) == text
