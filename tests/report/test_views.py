"""One fact, one number, one word: terminal, page, summary and records say of a comparison what the JSON says."""

import json
import re
from dataclasses import replace
from html import unescape
from importlib import import_module
from statistics import median

import numpy as np
import pyarrow.parquet as pq
import pytest

from harness import load_results
from harness.record import read_recording
from harness.report import FactsTable, Report, report_text, write_html
from harness_plugins.audit import audit_dataset, audit_recordings
from harness_plugins.audit.dataset.page import write_dataset_page
from harness_plugins.committed import committed_table, write_summary
from tests.laws import writers
from tests.record.dataset.written import episode, write_minari
from tests.registered import REGISTRY
from tests.report.conftest import printed
from tests.results.in_looks import CHOOSING, folder_in_looks
from tests.results.recordings.conftest import record

THREE = {"arp": (9, 30), "relative": (30, 9), "arp:k2=2": (9, 30)}
HELPED = {"baseline": lambda seed: (), "arp": lambda seed: (5, 6, 7, 8)[: 3 + seed % 2]}
HURT = {
    "baseline": HELPED["arp"],
    "arp": lambda seed: (8,) * (seed == 0),
    "relative": lambda seed: (8, 9)[: 1 + seed % 3],
}
AHEAD = {"arp": lambda seed: (5, 6, 7, 8), "baseline": lambda seed: (7, 8, 9)}
ARMS = {
    "nothing differs": {},
    "one seed": {"seeds": 1},
    "helps": {"seeds": 7, "reached": HELPED},
    "hurts": {"seeds": 8, "reached": HURT},
    "ahead so far": {"seeds": 6, "reached": AHEAD},
    "neither learns": {"seeds": 5, "reached": {"baseline": lambda seed: (), "arp": lambda seed: ()}},
    "three rewards": {"seeds": 6, "proposed": THREE, "reached": HURT},
    "trainings failed": {"seeds": 4, "ended": {("arp", 1): ("failed", "it broke"), ("arp", 2): ("failed", "it broke")}},
    "so far": {"ended": {("arp", 2): ("pending", "")}},
    "no pair": {"seeds": 1, "ended": {("arp", 0): ("failed", "it broke")}},
    "two places": {"seeds": 5, "simulators": ("mujoco", "pybullet"), "reached": HELPED},
    "eight places": {"simulators": tuple(f"engine-{at}" for at in range(8))},
    "null control": {"a_a": True},
    "evaluated on the way": {"learned": {10: 1, 20: 2}},
    "stochastic": {"deterministic": False, "reached": AHEAD, "seeds": 4},
    "no index": {"baseline": (39, 0)},
    "no reward that pays": {"proposed": {"gone": (9, 30)}},
    "large": {"baseline": (9, 30, 1e4), "proposed": {"arp": (9, 30, 1e5)}},
}
AGENTS = {
    "better arms": (("plain", 0.5), ("thrice", 0.95)),
    "paid below nothing": (("loss", 0.5), ("plain", 0.9)),
    "alone": (("plain", 0.9),),
}
CHOSEN = {
    "a race that is over": ([0.9] * 4 + [0.8, 0.9, 0.8, 0.9], [0.3] * 4, [0.1, 0.0, 0.1, 0.0]),
    "a race that goes on": ([0.9] * 4, [0.3] * 4, []),
}
LOGS = {"logs of Monitor": (0.2, 0.9), "logs of progress.csv": (0.7, 0.6)}
"""The share of successes of the baseline, and of the other reward."""
SITUATIONS = (*ARMS, *AGENTS, *CHOSEN, *LOGS)
PAYS = {"plain": lambda arms: arms + 1.0, "thrice": lambda a: 3.0 * a + 6.0, "loss": lambda arm: arm - 2.0}


@pytest.fixture
def situation(build, make_cell, make_plan, tmp_path):
    """Results by the name of their situation."""

    def make(name):
        if name in ARMS:
            return build(**ARMS[name])
        if name in AGENTS:
            for reward, most in AGENTS[name]:
                for seed in range(5):
                    arms = np.linspace(0.0, most, 30) + 0.01 * seed
                    record(tmp_path / f"runs/{reward}-{seed}", reward, seed, arms, pays=PAYS)
            return load_results(tmp_path / "runs")
        if name in LOGS:
            for reward, most in zip(("baseline", "new"), LOGS[name], strict=True):
                for seed in range(6):
                    _write_log(name, tmp_path / "logs", reward, seed, most)
            return load_results(tmp_path / "logs")
        folder = folder_in_looks(CHOOSING, make_cell, make_plan, REGISTRY, tmp_path / "race")
        for reward, shares in zip(("dense", "arp", "baseline"), CHOSEN[name], strict=True):
            folder.train(reward, shares)
        return folder.results

    return make


def _write_log(name, folder, reward, seed, most):
    """A training as another library logs it: so many of its last episodes succeed."""
    share = np.linspace(0.0, most, 40) + 0.02 * seed / 6
    if name == "logs of Monitor":
        done = np.arange(40) % 10 < 10 * share
        writers.monitor(folder / f"{reward}_{seed}.monitor.csv", writers.paid(share), np.full(40, 25), done, 1e9 + seed)
    else:
        writers.progress(
            folder / f"{reward}_{seed}" / "progress.csv",
            np.arange(1, 41) * 1000,
            share,
            **{"rollout/ep_len_mean": [25] * 40},
        )


class Views:
    """Everything that is said of results, and by comparison what stands where."""

    def __init__(self, results, folder):
        """Show them in every way."""
        write_html(Report(results), folder / "page.html")
        self.json = json.loads(report_text(Report(results)))
        self.texts = {
            "terminal": printed(FactsTable(Report(results).short), 400),
            "details": printed(FactsTable(Report(results).full), 400),
            "page": (folder / "page.html").read_text(),
        }
        if results.is_experiment:
            write_summary(results, folder / "records")
            self.texts["summary"] = (folder / "records" / "summary.md").read_text()
            self.texts["records"] = printed(committed_table(folder / "records"), 400)

    def facts(self):
        """Of each comparison, by key, its text or its number."""
        for it in self.json["combinations"]:
            first = [of for of in it["behaviour"] if of["name"] == it["deciding"][0]]
            (change,) = [of for of in first if of["manner"] == it["decided_in"]] or [{}]
            pays = next((of for name, of in it["returns"].items() if name == it["decided_in"]), {}).get("returns", [])
            own = {of["trained_by"]: of["value"] for of in pays if of["paid_by"] == of["trained_by"]}
            yield {
                "answer": it["headline"]["answer"].upper(),
                **{side: change.get(side) for side in ("baseline", "proposed")},
                "p": change.get("p_corrected"),
                **{f"pay {side}": own.get(side) for side in ("baseline", "proposed")},
                **{name: it[name]["eta"]["value"] for name in ("eta_N", "eta_P")},
                "weak": [name for name in ("eta_N", "eta_P") if "near zero" in it[name]["eta"]["note"]],
            }

    def shown(self):
        """By view and comparison, by key, every text that stands for it."""
        count = len(self.json["combinations"])
        yield "terminal", self._overview("terminal", count)
        yield "details", list(map(_block, re.split(r"\nThe (?:robot|agent): ", self.texts["details"])[1:]))
        chunks = re.split(r'<div id="combination-\d+" class="comparison">', self.texts["page"])[1:]
        places = list(map(int, re.findall(r'<div id="combination-(\d+)" class="comparison">', self.texts["page"])))
        of_place = {
            place: {**_forest(self.texts["page"]), **_card(it)} for place, it in zip(places, chunks, strict=True)
        }
        of_place |= {place: {**of_place[place], **_forest(it)} for place, it in zip(places, chunks, strict=True)}
        yield "page", [of_place[place + 1] for place in range(count)]
        yield "matrix", [_entry(row) for row in re.findall(r"<tr data-answer=.*?</tr>", self.texts["page"], re.DOTALL)]
        if "summary" in self.texts:
            yield "summary", list(map(_section, re.split(r"\n## \d+\. ", self.texts["summary"])[1:]))
            yield "records", self._overview("records", count)

    def _overview(self, view, count):
        rows, etas = [], []
        for headings, of in _tables(self.texts[view]):
            is_overview = headings[:1] in (["the robot"], ["the agent"])
            measure = headings[2] if is_overview else ""
            names = ["answer", "decider", "sides", *headings[3:]] if is_overview else headings
            told = [dict(zip(names, cells, strict=False)) for _, cells in of]
            rows += [{**_sides(it), "measure": measure} for it in told] if is_overview else []
            etas += told if headings[:1] == ["eta_N"] else []
        return [{**row, **(etas[at] if len(etas) == count else {})} for at, row in enumerate(rows)]


def _tables(text):
    """Of each table that a terminal shows, the headings and the rows: a name, then the values."""
    lines = text.splitlines()
    for at, line in enumerate(lines):
        if line.startswith("───"):
            rows = lines[
                at + 1 : next((end for end in range(at + 1, len(lines)) if not lines[end].strip()), len(lines))
            ]
            cells = [re.split(r" {2,}", row.strip()) for row in rows]
            yield re.split(r" {2,}", lines[at - 1].strip()), [(row[0], row[1:]) for row in cells if row]


def _sides(row):
    """The values of both rewards by themselves."""
    both = {"baseline": row["sides"].partition(" -> ")[0], "proposed": row["sides"]}
    both["proposed"] = row["sides"].partition(" -> ")[2] or row["sides"]
    percent = "%" * row["sides"].endswith("%")
    pay = row.get("pay of an episode", "").partition(" -> ")
    etas = {name: row[name] for name in ("eta_N", "eta_P") if name in row}
    sides = {side: it if it.endswith("%") else f"{it}{percent}" for side, it in both.items()}
    return {
        "answer": row["answer"],
        **sides,
        **({"pay baseline": pay[0], "pay proposed": pay[2]} if pay[2] else {}),
        **etas,
    }


def _block(text):
    """Of what the terminal says of one comparison with all details."""
    found = {"answer": text.partition("\n")[0].strip()}
    told = re.search(r"An episode is paid (\S+) with .+? and (\S+) with", text)
    found |= {"pay proposed": told[1], "pay baseline": told[2]} if told else {}
    for headings, rows in _tables(text):
        found = {**_row(headings, dict(rows)), **found}
    return found


def _row(headings, rows):
    if headings[:3] == ["baseline", "proposed", "difference"] and "p" in headings and rows:
        first = dict(zip(headings, next(iter(rows.values())), strict=False))
        return {side: first[side] for side in ("baseline", "proposed", "p") if side in first}
    if headings[:1] == ["ratio"]:
        return {name: rows[name][0] for name in ("eta_N", "eta_P") if name in rows}
    return {}


def _section(text):
    """Of what the summary says of one comparison."""
    answer, sentence = re.search(r"\*\*The (?:robot|agent): (.+?)\.\*\* (.*)", text).groups()
    found = {"answer": answer, "sentence": sentence}
    for table in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE):
        lines = [[cell.strip() for cell in line.strip().strip("|").split(" | ")] for line in table.splitlines()]
        headings, rows = lines[0][1:], {line[0]: [cell.replace("\\", "") for cell in line[1:]] for line in lines[2:]}
        found = {**_row(headings, rows), **found}
    return found


def _card(page):
    """Of the first screen's card, or of the line that opens."""
    badge = re.search(r'<b class="badge [\w-]+">(.*?)</b>', page)
    found = {"answer": badge[1]}
    pay = re.search(r'class="pay">An episode is paid (\S+) with .+? and (\S+) with', page)
    found |= {"pay proposed": _plain(pay[1]), "pay baseline": _plain(pay[2])} if pay else {}
    return found


def _forest(page):
    """Of the measure that decides, in the first table of behaviour."""
    table = page.partition('<div class="grid wide">')[2].partition("</table>")[0]
    told = re.findall(r'<td class="number" data-label="(baseline|proposed|p)">(.*?)</td>', table)
    return {key: _plain(text) for key, text in reversed(told[:3])}


def _entry(row):
    """Of a line in the table of all comparisons."""
    cells = {key: _plain(text) for key, text in re.findall(r'data-label="([^"]*)">(.*?)</td>', row)}
    sides = next(text for key, text in cells.items() if re.fullmatch(r"success.*|behaviour", key))
    told = {key: text for key, text in cells.items() if key in ("pay of an episode", "eta_N", "eta_P")}
    both = {key: text.replace("->", " -> ") for key, text in {**told, "sides": sides}.items()}
    return _sides({"answer": re.search(r'class="badge [\w-]+">(.*?)</b>', row)[1], **both})


def _plain(text):
    """A text without tags, signs of print and blanks."""
    bare = unescape(re.sub(r"(?s)<(style|script).*?</\1>|<[^>]*>", "", text)).replace("\\", "")
    signs = {"−": "-", "→": "->", "×": "x", "≤": "<=", "≥": ">=", "ηN": "eta_N", "ηP": "eta_P"}
    for sign, plain in signs.items():
        bare = bare.replace(sign, plain)
    return "".join(bare.split())


def agrees(text, value):
    """Whether a text is the value: a word itself, a number rounded to the digits that stand there."""
    if isinstance(value, str) or value is None:
        return text == (value or "n/a")
    if text.startswith("<"):
        return value < float(text[1:])
    digits = re.match(r"[-+.\d,]+(?:e[-+]?\d+)?", text)[0]
    seen = float(digits.replace(",", ""))
    size, decimals = value * 100 ** ("%" in text), len(digits.partition("e")[0].partition(".")[2])
    exponent = int(digits.partition("e")[2] or 0)
    whole = len(digits.replace(",", "").lstrip("-+")) if not decimals and not exponent else 0
    step = 10.0 ** (exponent - decimals) if not whole or abs(size) < 1e3 else 10.0 ** max(0, whole - 3)
    return abs(seen - size) <= 0.5 * step + 1e-9 * abs(size)


def disagreements(views):
    """Every text that is not what the JSON says, with its view, its comparison and its key."""
    facts = list(views.facts())
    for view, shown in views.shown():
        assert len(shown) in (0, len(facts)), (view, len(shown))
        for at, (fact, told) in enumerate(zip(facts, shown, strict=False)):
            for key, text in told.items():
                plain = text.strip(" *")
                is_weak = plain == "near zero" and key in fact["weak"]
                if key in fact and not is_weak and not agrees(plain, fact[key]):
                    yield view, at, key, text, fact[key]


def sentences(views):
    """What has to stand in all views, word by word; of single comparisons where each view tells them."""
    said, data = {}, views.json
    for it in data["combinations"]:
        said |= {it["headline"]["behaviour"]: ("details", "page", "summary")}
        said |= dict.fromkeys(it["not_maximised"], ("terminal", "details", "page", "summary"))
    for it in data["over_places"]:
        said |= {it["behaviour"]: ("terminal", "details", "summary", "records")}
    if data["choosing"] and "told" in data["choosing"]:
        said |= {data["choosing"]["told"]: ("terminal", "page", "summary", "records")}
    for it in data["combinations"] if len(data["combinations"]) == 1 else []:
        said |= {it["headline"]["behaviour"]: ("terminal", "details", "page", "summary", "records")}
    return said


@pytest.mark.parametrize("name", SITUATIONS)
def test_every_view_says_the_same(situation, tmp_path, name):
    """The same number and the same word for the same key; and the same sentences."""
    views = Views(situation(name), tmp_path)
    assert list(disagreements(views)) == []
    texts = {view: _plain(text) for view, text in views.texts.items()}
    for sentence, where in sentences(views).items():
        assert [view for view in where if view in texts and _plain(sentence) not in texts[view]] == [], sentence


@pytest.mark.parametrize("name", AGENTS)
def test_a_caption_is_true_of_its_numbers(situation, tmp_path, name):
    """Computed again from the recordings: the mean over trainings of the episodes that ended in a twentieth of it."""
    write_html(Report(situation(name)), tmp_path / "page.html")
    page = unescape((tmp_path / "page.html").read_text()).replace("\u202f", "").replace("−", "-")
    panels = re.findall(r"<h4>([^<]*) while learning</h4>.*?<figcaption>(.*?)</figcaption>", page, re.DOTALL)
    assert len(panels) >= 2
    for heading, caption in panels:
        column = f"reward/{heading.split()[-1]}" if heading.startswith("Return") else f"behaviour/{heading.lower()}"
        assert "of the episodes of the training that ended in one of 20 equal parts of its steps" in caption
        told = re.findall(r"(\w+) (\S+) after (\d+) steps, (\S+) after (\d+) steps", caption)
        assert len(told) == len(AGENTS[name])
        for reward, first, begin, last, end in told:
            assert agrees(first, _ended_by(tmp_path / "runs", reward, column, int(begin)))
            assert agrees(last, _ended_by(tmp_path / "runs", reward, column, int(end)))


def _ended_by(folder, reward, column, end):
    """The mean over trainings of the episodes that ended in the twentieth of the steps up to that one."""
    means = []
    for seed in range(5):
        log = read_recording(folder / f"{reward}-{seed}")
        begin = max(cut for cut in (-(-len(log) * part // 20) for part in range(20)) if cut < end)
        starts = np.flatnonzero(log["step"] == 0)
        ends = np.append(starts[1:], len(log))
        there = [slice(*of) for of in zip(starts, ends, strict=True) if begin < of[1] <= end]
        values = [log[column][of].sum() if column.startswith("reward") else log[column][of][-1] for of in there]
        means.append(np.mean(values))
    return float(np.mean(means))


DRAWN = ("nothing differs", "one seed", "helps", "hurts", "ahead so far", "neither learns", "no index", "large")


@pytest.mark.parametrize("name", [*DRAWN, "stochastic", "evaluated on the way"])
def test_a_caption_of_curves_is_true_of_the_traces(situation, tmp_path, name):
    """Computed again from what each step paid: where the mean of the running sums turns negative, and where back."""
    results = situation(name)
    write_html(Report(results), tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    captions = re.findall(
        r"<h4>(?:Baseline|Proposed): (\w+)</h4>.*?<figcaption>First negative step: (\S+)\. Cross-over step: (\S+)\.<",
        page,
        re.DOTALL,
    )
    assert {reward for reward, *_ in captions} == {"baseline", "arp"}
    for reward, first, crossover in captions:
        folders = [results.folder / "cells" / it.id for it in results.done_cells if it.reward.label == reward]
        mean = np.mean([pq.read_table(it / "trace.parquet")["reward"].to_numpy().cumsum() for it in folders], axis=0)
        begin = next((at for at, value in enumerate(mean) if value < 0.0), None)
        end = next((at for at, value in enumerate(mean) if begin is not None and at > begin and value >= 0.0), None)
        assert [first, crossover] == ["never" if it is None else str(it) for it in (begin, end)]


def _by_medians(comparison):
    """The same with what another mean says of the proposed reward."""
    changes = [replace(it, proposed=median(it.values[1])) for it in comparison.measured.changes if it.values[1]]
    return replace(comparison, measured=replace(comparison.measured, changes=tuple(changes)))


def _with_other_numbers(facts):
    """The same facts with another number in each row that has one."""
    return [
        replace(
            fact,
            grids=tuple(
                replace(grid, rows=[tuple(re.sub(r"\d(?=\.|%| %)", "7", it) for it in row) for row in grid.rows])
                for grid in fact.grids
            ),
        )
        for fact in facts
    ]


FACTS, PAGE, COMMITTED = "harness.report.facts", "harness.report.page", "harness_plugins.committed"


@pytest.mark.parametrize(
    ("target", "mutant"),
    [
        (f"{FACTS}.overview_row", lambda of: lambda name, it, *more: of(name, _by_medians(it), *more)),
        (f"{FACTS}.behaviour_grids", lambda of: lambda it: of(_by_medians(it))),
        (f"{FACTS}.word_of", lambda of: lambda answer: "HURTS"),
        (f"{FACTS}.index_rows", lambda of: lambda *given: [(row[0], "1.01", *row[2:]) for row in of(*given)]),
        (f"{PAGE}.answer.word_of", lambda of: lambda answer: "HURTS"),
        (f"{PAGE}.answer.overview_rows", lambda of: lambda found: of(list(map(_by_medians, found)))),
        (f"{COMMITTED}.markdown._told", lambda of: lambda facts: of(_with_other_numbers(facts))),
        (f"{COMMITTED}.read.FactsTable", lambda of: lambda facts: of(_with_other_numbers(facts))),
        (f"{__name__}.FactsTable", lambda of: lambda facts: of(_with_other_numbers(facts))),
    ],
)
def test_a_view_that_computes_by_itself_is_caught(situation, tmp_path, monkeypatch, target, mutant):
    """Another mean, another word, another ratio: of two rewards, so that the table of all is there."""
    results = situation("three rewards")
    module, _, name = target.rpartition(".")
    monkeypatch.setattr(target, mutant(getattr(import_module(module), name)))
    assert list(disagreements(Views(results, tmp_path)))


def _audit_of_data(folder):
    """Of a data set whose successes a reward pays more, and of one that pays steps alone."""
    episodes = [episode(9, number, number % 2 == 1) for number in range(16)]
    for number, one in enumerate(episodes):
        one["observations"][:, 0] += 2.0 * (number % 2) * (number > 2)
    name = f"minari:{write_minari(folder / 'd', episodes)}"
    rewards = {"near": lambda o, a, n, i: float(n[0]), "far": lambda o, a, n, i: float(n[1] - n[0])}
    found = audit_dataset(name, rewards)
    write_dataset_page(found, folder / "page.html")
    return found


def _audit_of_recordings(folder):
    """Of trainings that recorded what two rewards pay."""
    pays = {"plain": lambda arm: arm, "square": lambda arm: (arm - 0.3) ** 2}
    for seed in range(4):
        record(folder / f"runs/{seed}", "plain", seed, np.linspace(0.0, 0.9 + 0.01 * seed, 10), pays=pays)
    return audit_recordings(folder / "runs")


AUDITS = {"a data set": _audit_of_data, "recorded trainings": _audit_of_recordings}
DISTANCES = {"distance by steps": "steps", "distance by episodes": "returns", "opposite order": "discordant"}


def told_by_audit(found, folder):
    """Every text that a view shows of an audit, with what the JSON has for it: the view, the text, the value."""
    data, views = found.to_json(), {"terminal": " ".join(str(found).split())}
    if (folder / "page.html").is_file():
        views["page"] = " ".join(_plain_words((folder / "page.html").read_text()).split())
        for it in data["rewards"]:
            success, name, word = it["success"], it["reward"], "([A-Z][A-Z ]+)"
            number, wrong = r"([\d.]+) \[([\d.]+), ([\d.]+)\]", r".*?anked wrongly:? ([\d,]+) of ([\d,]+) pairs"
            values = [
                *(success[key] for key in ("answer", "value", "low", "high")),
                it["wrong_pairs"],
                success["pairs"],
            ]
            sentence = rf"{name} {word}: a success is paid more than a failure with a chance of {number}{wrong}"
            row, lead = rf"{name} {word} {number}", rf"{word} {name} A success .*?(\d+ ?%)\."
            for view, pattern, known in (
                ("terminal", sentence, values),
                ("page", row, values[:4]),
                ("page", f"{lead}{wrong}", [*values[:2], *values[4:]]),
            ):
                yield from ((view, *pair) for pair in zip(re.search(pattern, views[view]).groups(), known, strict=True))
    for pair in data["pairs"]:
        both = f"{pair['rewards'][0]} and {pair['rewards'][1]}"
        rows = {"terminal": "".join(rf".*?{it} (\S+)" for it in DISTANCES), "page": r" ([\d.]+%?)(?: \[.*?\])?" * 3}
        for view, text in views.items():
            shown = re.search(f"{both}{rows[view]}", text).groups()
            known = [pair[key]["mean"] for key in DISTANCES.values()]
            yield from ((view, *it) for it in zip(shown, known, strict=True))


def _plain_words(page):
    """The text of a page, its blanks kept."""
    return unescape(re.sub(r"(?s)<(style|script|title).*?</\1>|<[^>]*>", " ", page)).replace("\u202f", "")


@pytest.mark.parametrize("name", AUDITS)
def test_every_view_of_an_audit_says_the_same(tmp_path, name):
    """The same word and the same numbers on the terminal, the page and in the JSON."""
    told = list(told_by_audit(AUDITS[name](tmp_path), tmp_path))
    assert [it for it in told if not agrees(it[1], it[2])] == []
    assert len(told) == {"a data set": 2 * 14 + 2 * 3, "recorded trainings": 3}[name]


DATA = "harness_plugins.audit.dataset"


@pytest.mark.parametrize(
    ("target", "mutant"),
    [
        (f"{DATA}.dataset_audit.auc_text", lambda of: lambda auc: "0.123 [0.100, 0.200]"),
        (f"{DATA}.page.auc_text", lambda of: lambda auc: "0.123 [0.100, 0.200]"),
        (f"{DATA}.page._lead", lambda of: lambda auc: "A success is paid more: 12 %."),
        (f"{DATA}.page.answers_of", lambda of: lambda *given: [("ranked wrongly", "1 of 2 pairs")]),
        (f"{DATA}.page.distance_text", lambda of: lambda mean: "0.123"),
        ("harness_plugins.audit.recorded.pair_grid.share_text", lambda of: lambda mean: "12.3%"),
    ],
)
def test_a_view_of_an_audit_that_computes_by_itself_is_caught(tmp_path, monkeypatch, target, mutant):
    """Another chance, another count, another distance."""
    module, _, name = target.rpartition(".")
    monkeypatch.setattr(target, mutant(getattr(import_module(module), name)))
    assert [it for it in told_by_audit(_audit_of_data(tmp_path), tmp_path) if not agrees(it[1], it[2])]
