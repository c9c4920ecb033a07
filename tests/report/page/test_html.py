import base64
import csv
import gzip
import re
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from harness import load_results
from harness.report import SPLIT, Report, describe_split, question, scales_text, typeset, write_html
from harness.report.page.html import PROMISE
from harness.report.page.page import to_html
from tests.refusals import refused
from tests.report.conftest import MIXTURE, NO_PAIR
from tests.report.page.test_answer import HELPED

LOADING = {"src", "srcset", "href", "data", "action", "poster", "background"}


class Page(HTMLParser):
    """A page taken apart: what it loads or links, its figures and its visible text."""

    def __init__(self, text):
        super().__init__()
        self.raw = text
        self.links, self.tags, self.names, self.figures, self.words = [], [], [], [], []
        self._inside = ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        """Note what the element is and where it points."""
        self.tags.append(tag)
        self.names += [value for name, value in attributes if name == "id"]
        self.links += [value for name, value in attributes if name in LOADING]
        if tag == "svg" and (label := dict(attributes).get("aria-label")):
            self.figures.append(label)
        self._inside = tag if tag in ("script", "style") else ""

    def handle_endtag(self, tag):
        """Text is visible again."""
        self._inside = ""

    def handle_data(self, data):
        """Keep visible words."""
        if not self._inside:
            self.words += data.split()

    @property
    def ids(self):
        """The places that have a name."""
        return set(self.names)

    @property
    def text(self):
        """The visible words, single spaces between them."""
        return " ".join(self.words)

    @property
    def main(self):
        """The same below the bar with the links."""
        return self.text.partition("Repeat it ")[2]


@pytest.fixture
def write(tmp_path):
    """Writes the report of some results and takes it apart."""

    def write_and_read(results):
        write_html(Report(results), tmp_path / "report.html")
        return Page((tmp_path / "report.html").read_text())

    return write_and_read


def test_page_loads_nothing(build, write):
    """No element loads anything, the only links lead to places on the page, and the policy allows nothing else."""
    page = write(build(simulators=("mujoco", "pybullet")))
    assert all(link.startswith("#") for link in page.links)
    assert not {"link", "img", "iframe", "object", "embed"} & set(page.tags)
    assert "default-src 'none'; script-src 'unsafe-inline'" in page.raw


def test_title_is_the_question(build, write):
    """The heading asks what the report answers, naming the proposed rewards."""
    results = build(seeds=1, proposed=dict.fromkeys(("arp", "arp:k2=2", "relative"), (0, 39)))
    assert "arp, arp:k2=2 and relative" in question(results)
    assert write(results).text.count(question(results)) == 2  # <title> and <h1>


def test_names_and_reasons_are_escaped(build, write):
    """What looks like HTML is shown, not interpreted."""
    reason = "KeyError: <script>alert(1)</script>"
    page = write(build(proposed={"arp<u>bold</u>": (0, 39)}, ended={("arp<u>bold</u>", 1): ("failed", reason)}))
    assert "arp<u>bold</u>" in page.text
    assert reason in page.text
    assert "u" not in page.tags
    assert page.tags.count("script") == write(build()).tags.count("script")


def test_crossover_is_marked(build, write):
    """Both panels mark the cross-over of their mean curve, and the text says it too."""
    page = write(build())
    for step in (18, 15):  # of the baseline, and of arp
        assert page.text.count(f"cross-over: step {step}") == 2  # above the panel, and under the pointer
        assert page.text.count(f"Cross-over step: {step}.") == 1


def test_answer_comes_first(build, write):
    """The question, the answer in a sentence, then behaviour, learning, the number, and how to repeat it."""
    results = build(learned={10: 1, 20: 2})
    (combination,) = results.combinations
    text = write(results).main
    told = [
        "or only the numbers bigger?",
        "arp Success",
        "CANNOT TELL",
        combination.lead,
        "What the robot does",
        "success rate ↑",
    ]
    parts = [
        *told,
        "Learning Success rate",
        "The number The pay of an episode",
        "The whole matrix",
        "Cells 6 cells",
        "Repeat it This",
    ]
    places = [text.index(" ".join(typeset(part).split())) for part in parts]
    assert places == sorted(places)


def test_first_screen_has_no_bracket_but_for_the_differences(build, write):
    """Their intervals stand before the answer; other numbers in brackets stand in tables and in what is folded."""
    first = write(build(seeds=6, learned={10: 1, 20: 2})).raw.partition("<main")[2].partition("What the robot does")[0]
    assert "CANNOT TELL" in first
    seen, rest = re.search(r'<p class="seen">.*</p>', first), re.sub(r'<p class="seen">.*</p>', "", first)
    assert re.search(r"\(−\d", seen[0])
    assert not re.search(r"[\[(][−\d]", rest)


def test_answer_in_full_is_folded(build, write):
    """The sentences, what was compared, and that eta is no measure of behaviour."""
    results = build()
    (combination,) = results.combinations
    text = write(results).text.partition("The answer in full")[2]
    compared = "3 seeds (0, 1, 2) compared, 40 training steps per run"
    for part in (combination.headline.robot, "arp against baseline", compared, scales_text("robot")):
        assert " ".join(Page(to_html(part)).words) in text


@pytest.mark.parametrize("simulators", [("mujoco",), ("mujoco", "pybullet", "kinematic")])
def test_every_place_has_a_name_of_its_own(build, write, simulators):
    """And every link within the page leads to one of them, or into the replay."""
    page = write(build(simulators=simulators, learned={10: 1}))
    assert len(page.names) == len(set(page.names))
    assert {link.removeprefix("#") for link in page.links if not link.startswith("#replay-")} <= page.ids


def test_decided_answers_come_first(build, write):
    """Each with a line that opens."""
    reached = {"arp": lambda seed: (8,), "relative": lambda seed: (5, 6, 7, 8), "baseline": lambda seed: (8,)}
    results = build(seeds=6, proposed={"arp": (9, 30), "relative": (9, 30)}, reached=reached)
    text = write(results).main
    assert text.index("HELPS") < text.index("CANNOT TELL")


def test_split_is_drawn_told_and_explained(build, write):
    """eta_N and eta_P have a figure each, with the same in words, and a sentence says what the parts are."""
    results = build()
    page = write(results)
    ratios = [label for label in page.figures if label.startswith("Ratios on a logarithmic axis.")]
    assert [name for label in ratios for name in ("eta_N", "eta_P") if f"{name} = ruler" in label] == ["eta_N", "eta_P"]
    told = [describe_split(*named) for named in results.combinations[0].number.splits.items()]
    assert all(" ".join(Page(to_html(it)).words) in page.text for it in told)
    assert page.text.count(" ".join(Page(to_html(SPLIT)).words)) == 1


def test_what_cannot_be_scored_is_not_drawn(build, write):
    """A reward whose plugin is gone leaves the curves, and the reason instead of the split."""
    page = write(build(proposed={"gone": (9, 30)}))
    assert not any(label.startswith("Ratios") for label in page.figures)
    assert "No reward 'gone'" in page.text


def test_both_paths_are_shown(build, write):
    """Each with its ruler and behaviour, below the split that is their mean."""
    text = write(build(baseline=(9, 12), proposed={"arp": (1, 20)})).text
    assert re.search(r"η P on proposed runs \d.* η P on baseline's runs \d", text)


def test_other_measures_of_behaviour_are_folded(build, write):
    """The manner that decides stands open, the training itself does not."""
    page = write(build())
    opened, folded = (
        page.text.index("deterministic, 4 episodes"),
        page.text.index("Behaviour while training, 1 episode"),
    )
    assert opened < page.text.index("Behaviour of the same trainings, measured otherwise") < folded


def test_answer_along_the_budget_is_shown(build, write):
    """Where policies were evaluated while they learned."""
    text = write(build(learned={10: 1, 20: 2})).text
    assert "after 10 steps 25.0 % 50.0 % " in text
    assert re.search(r"after 40 steps 75\.0 % 75\.0 % \S+ \S+ pp cannot tell", text)


@pytest.mark.parametrize(
    ("reached", "badge"),
    [((5, 6, 7, 8), "helps"), ((), "hurts"), ((8, 9), "cannot-tell")],
)
def test_badge_has_the_answer(build, write, reached, badge):
    """In a colour of its own, never by the colour alone."""
    results = build(
        seeds=6, baseline=(9, 12), reached={"baseline": lambda seed: (8, 9), "arp": lambda seed: reached[:4]}
    )
    told = badge.upper().replace("-", " ")
    assert f'<b class="badge {badge}">{told}</b>' in write(results).raw


def test_one_seed_has_a_page(build, write):
    """One seed gives ratios and figures without intervals."""
    page = write(build(seeds=1))
    assert len(page.figures) == 12
    assert "η N , η P : one seed" in page.text


def test_failed_cell_has_its_reason(build, write):
    """The table of cells says how each ended and why."""
    page = write(build(ended={("arp", 1): ("failed", "SimulationDiverged: qpos is not finite")}))
    assert "failed mujoco sac arp 1 40 0.0 SimulationDiverged: qpos is not finite" in page.text


def test_no_finished_pair_is_said(build, write):
    """Without a finished pair the page says so and draws nothing: neither a heading nor a link leads to nothing.

    A filter is for many rows.
    """
    results = build(**NO_PAIR)
    page = write(results)
    assert results.combinations[0].number.eta_n.note in page.text
    assert page.figures == []
    assert not {"learning", "number", "see"} & page.ids
    assert "form" not in page.tags


def test_skipped_experiment_has_a_page(build, write):
    """An experiment whose combinations were all skipped still has a page with the reasons."""
    results = build(seeds=1, ended={(reward, 0): ("skipped", "sac cannot") for reward in ("baseline", "arp")})
    page = write(results)
    assert question(results) in page.text
    assert "No cell has run" in page.text
    assert page.text.count("sac cannot") == 3  # of each cell, and once of both


def test_overview_links_to_each_combination(build, write):
    """Several combinations get an overview that leads to each; a single one needs none."""
    assert not any("combination" in link for link in write(build()).links)
    page = write(build(simulators=("mujoco", "pybullet", "kinematic")))
    assert page.links.count("#combination-1") == page.links.count("#combination-2") == 3  # index, map and table
    assert {"combination-1", "combination-2"} <= page.ids
    assert page.text.count("CANNOT TELL 3 of 3") == 1
    assert page.text.count("CANNOT TELL") == 11  # over all places; of the group; in the table; twice in each section


def test_null_control_is_no_question(build, write):
    """The baseline against itself has a section, marked as A/A, and is not asked about."""
    results = build(a_a=True)
    assert "baseline" not in question(results)
    text = write(results).text
    assert "baseline against baseline, trained again with other seeds (A/A" in text


def test_null_control_fills_no_part_of_a_reward_that_is_not_trained(build, write):
    """Each part of the page is of the reward that stands there in full; the control is a line that opens."""
    pending = {("arp", seed): ("pending", "") for seed in range(3)}
    assert {"does", "number"} <= write(build(a_a=True)).ids
    page = write(build(a_a=True, ended=pending))
    assert "number" not in page.ids
    assert "#number" not in page.links


def test_failed_write_leaves_the_old_page(build, tmp_path, monkeypatch):
    """When writing fails, the old page is whole, nothing else is left, and the error is one line."""
    path = tmp_path / "pages" / "report.html"
    path.parent.mkdir()
    path.write_text("old")

    def refuse(source, target):
        raise OSError(28, "No space left on device")

    results = build()
    monkeypatch.setattr("os.replace", refuse)
    with refused(r"report\.html' cannot be written: No space left on device"):
        write_html(Report(results), path)
    assert [file.name for file in path.parent.iterdir()] == ["report.html"]
    assert path.read_text() == "old"


def test_missing_library_names_the_extra(build, tmp_path, monkeypatch):
    """Without the optional libraries the error says what to install, and nothing is written."""
    results = build()
    monkeypatch.setitem(sys.modules, "jinja2", None)
    with refused(r"pip install 'fd100-harness\[report\]'"):
        write_html(Report(results), tmp_path / "report.html")
    assert not (tmp_path / "report.html").exists()


def test_import_is_light():
    """Importing the report does not load jinja2."""
    code = "import sys, harness.report.page.html; sys.exit('jinja2' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_learning_is_drawn_where_it_was_recorded(build, write):
    """With a caption in words; of the training itself where policies were evaluated at the end alone."""
    page = write(build(learned={10: 1, 20: 2}))
    assert re.search(r"random actions baseline 25\.0 % after 10 steps, 75\.0 % after 40 steps;", page.text)
    assert any(label.startswith("Over environment steps. Success rate while learning.") for label in page.figures)
    trained = write(build()).text
    assert "Return, as paid while learning" in trained
    assert "Each point is of the episodes of the training that ended in one of 20 equal parts of its steps" in trained


def test_paths_of_the_end_effector_are_folded(build, write):
    """Both rewards' at the end of the section, with captions in words."""
    page = write(build())
    assert page.text.count("Seed 0: 3 of the first 4 evaluation episodes reach the target.") == 4  # two projections
    folded = page.text.index("Paths of the end effector")
    assert folded < page.text.index("seen from above") < page.text.index("seen from the side")
    assert page.text.count("missed reached missed: its end start target") == 4


def test_returns_under_every_reward_are_shown(build, write):
    """A section of its own, with a table per simulator."""
    page = write(build(simulators=("mujoco", "pybullet")))
    assert "returns" in page.ids
    assert page.text.count("evaluation return, scored by baseline arp") == 2


def test_mixture_is_marked(mixed, write):
    """Above what was found: a comparison of two versions of an algorithm is none of rewards."""
    text = write(mixed).main
    assert text.index(f"{MIXTURE}.") < text.index("What the robot does")


def test_a_plan_that_is_not_trained_to_its_end_promises_nothing(build, write):
    """The page says so before any answer, has no word of better or worse, and names the way to look on."""
    text = write(build(seeds=6, reached=HELPED, ended={("arp", 5): ("pending", "")})).text
    assert text.index("Interim: 1 training is missing.") < text.index("INTERIM")
    assert PROMISE not in text
    assert "harness run --until decided plans for looks on the way." in text
    assert "HELPS" not in text
    assert PROMISE in write(build(seeds=6, reached=HELPED)).text


def test_rewards_that_came_later_are_told_before_the_answers(build, write):
    """For an answer that stood before may have changed."""
    results = build()
    replace(results.plan, terms=replace(results.plan.terms, joined=("arp",))).write(results.folder)
    text = write(load_results(results.folder)).main
    assert text.index("arp came later") < text.index("What the robot does")


def test_advice_stands_as_a_command(build, write):
    """Where more seeds would tell."""
    results = build()
    (combination,) = results.combinations
    combination.__dict__["headline"] = replace(combination.headline, seeds_to_decide=(8, 20))
    assert f"fewest trainings: harness run {results.folder / 'experiment.toml'}" in write(results).text


def test_file_inside_a_page_comes_back(build, write):
    """The same at any time of day: a row per comparison, whose numbers can be read back, and no stranger's formula."""
    results = build(proposed={"=1+Ω₁": (9, 30)}, ended={("=1+Ω₁", 2): ("failed", "it broke")})
    packed = base64.b64decode(re.search(r'name="comparisons.csv".*? data-content="([^"]*)"', write(results).raw)[1])
    assert packed[4:8] == b"\0\0\0\0"
    (row,) = csv.DictReader(gzip.decompress(packed).decode().splitlines())
    assert (row["proposed"], row["answer"], row["seeds"]) == ("'=1+Ω₁", "interim", "2")
    assert float(row["eta_N"]) == results.combinations[0].number.eta_n.value
    assert (row["baseline_trainings"], row["proposed_trainings"]) == ("3", "2")
