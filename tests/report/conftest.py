"""Small experiment folders, written without training anything: every reward in them is what its reward really pays."""

import functools
import re
import shutil
from collections.abc import Mapping
from dataclasses import replace
from html import unescape
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from rich.console import Console

from harness import load_results
from harness.errors import UsageError
from harness.executor import Cell
from harness.experiment.plan import Plan
from harness.log import trace_of
from harness.record import COLUMN, EVALUATION, RANDOM, SCALARS, TRACE, Manifest, TraceWriter
from harness.record.trace import FLAGS, INTEGERS
from harness.registry import Choice, choose
from harness.score.compare import compare_logs
from harness.score.open_steps import match_steps
from harness.score.scorer import pay_log
from tests.registered import REGISTRY
from tests.stores import create_store

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
WEBGL = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
NO_WEBGL = ["--disable-webgl", "--disable-3d-apis"]
GRAVE = ("serious", "critical")

BASELINE = "baseline"
ENVIRONMENT = {
    "versions": {"python": "3.11.7", "numpy": "2.4.0"},
    "machine": {"system": "Linux", "cpu": "a processor", "cpu_flags": ["avx", "fma"], "cores": 2},
    "commit": "0123456789abcdef",
    "command": "harness run --sim mujoco --algo sac",
    "sources": {"rewards": "f" * 64},
}
REACHED = (8, 9, 10)
"""Steps of the episodes of an evaluation that reach the target."""


STEPS = 40
"""Of a training, if no run is longer."""
DIP_AND_CLIMB = (9, 30)
"""A run is (dip, climb, scale): its baseline rewards are 0, then `dip` times -scale, then `climb` (1 + 0.1 seed) scale.

The mean accumulated baseline reward over seeds 0 to 2 is negative from step 1 to step 17, then positive."""


@pytest.fixture(scope="session")
def build(tmp_path_factory):
    """Writes a new experiment's folder and opens it; see `build_results`.

    What was asked for before is copied, together with what the first report kept: each test has a folder of its own.
    """
    written = {}

    def build_anew_or_copy(**given):
        folder = tmp_path_factory.mktemp("experiment")
        if "reached" in given:  # functions, which have no name to be known by
            return build_results(folder, **given)
        asked = repr(sorted(given.items()))
        if asked not in written:
            results = build_results(tmp_path_factory.mktemp("written"), **given)
            _ = results.combinations  # which keeps what it computes in the folder
            written[asked] = results.folder
        return load_results(shutil.copytree(written[asked], folder, dirs_exist_ok=True))

    return build_anew_or_copy


OLD, NEW = "9340a572" + "0" * 56, "f96dd784" + "0" * 56
NO_PAIR = {"seeds": 1, "ended": {("arp", 0): ("failed", "it broke")}}
"""Of results in which no seed is done under both rewards."""
MIXTURE = "1 of 6 cells was made by another sac (9340a572; the others f96dd784): they are not the same algorithm"


@pytest.fixture
def mixed(build):
    """Three seeds of two rewards; the algorithm was edited after the first training."""
    results = build(environment={**ENVIRONMENT, "sources": {"algorithms": NEW}})
    first = results.manifests[0]
    edited = replace(first, environment={**ENVIRONMENT, "sources": {"algorithms": OLD}})
    edited.write(results.store.cell_folder(first.cell))
    return load_results(results.folder)


def printed(shown, width=80, **console):
    """What goes to a terminal of that width: as into a pipe, unless `console` says otherwise."""
    output = StringIO()
    Console(file=output, width=width, **console).print(shown)
    return output.getvalue()


def squeezed(text):
    """The text with its line breaks undone."""
    return " ".join(text.split())


def words_of(page):
    """The visible words of a page's text."""
    return squeezed(unescape(re.sub(r"(?s)<(style|script).*?</\1>|<[^>]*>", " ", page)))


@pytest.fixture
def one(build):
    """The only comparison of an experiment as it is without further wishes."""
    return build().combinations[0]


def build_results(
    folder,
    *,
    baseline=DIP_AND_CLIMB,
    proposed: Mapping = {"arp": DIP_AND_CLIMB},
    seeds=3,
    simulators=("mujoco",),
    ended: Mapping = {},
    environment=ENVIRONMENT,
    reached: Mapping = {},
    engines: Mapping = {},
    a_a=False,
    deterministic=True,
    learned: Mapping = {},
):
    """An experiment of `seeds` runs per reward.

    Args:
        folder: To write.
        baseline: How the runs went that the baseline taught.
        proposed: The same for each proposed reward, by label; one that is not installed is left as a name.
        seeds: How many.
        simulators: Labels.
        ended: How the cell of a (reward, seed) ended, with the reason, where it is not done.
        environment: Of every cell that ran.
        reached: By reward and seed, steps of the evaluation episodes that reach the target, of four in all; by reward
            and simulator where it is not the same in all.
        engines: Of simulators whose cells record theirs.
        a_a: Whether the baseline is compared with itself too, trained again with as many other seeds.
        deterministic: How the policies were evaluated.
        learned: By environment steps, how many episodes of an evaluation during training reached the target, of four;
            one more under the proposed rewards.
    """
    runs = {BASELINE: baseline, **proposed}
    longest = max(run[0] + run[1] for run in runs.values())
    manner = {"deterministic": deterministic, "evaluate_every": min(learned, default=0), "steps": max(longest, STEPS)}
    cells = [_cell(sim, reward, seed, **manner) for seed in range(seeds) for sim in simulators for reward in runs]
    control = {seed: seed + seeds for seed in range(seeds)} if a_a else {}
    cells += [_cell(sim, BASELINE, seed, **manner) for seed in control.values() for sim in simulators]
    store = create_store(folder, Plan(BASELINE, tuple(cells), (), {"seeds": seeds}, control))
    for cell in cells:
        label = cell.reward.label
        status, reason = ended.get((label, cell.seed), ("done", ""))
        if status == "done":
            simulator = cell.simulator.label
            evaluation = reached.get((label, simulator), reached.get(label, lambda seed: REACHED))
            recorded = {**environment, "engine": engines[simulator]} if simulator in engines else environment
            for steps, count in learned.items():
                _write_learned(store, cell, steps, count + (label != BASELINE))
            _write_done(store, cell, _distances(runs[label], cell.seed), evaluation(cell.seed), recorded)
        elif status != "pending":
            store.record(cell, status, reason)
    return load_results(folder)


def _cell(simulator, reward, seed, **manner):
    sim, task, algorithm = (Choice(name, (), name) for name in (simulator, "fd100-reach", "sac"))
    return Cell(sim, "fd100", task, algorithm, _reward(reward), seed, evaluation_episodes=4, **manner)


def _reward(label):
    """The reward of that label; if there is none, a choice that no registry knows."""
    try:
        return choose(REGISTRY, "rewards", label)
    except UsageError:
        return Choice(label, (), label)


def _write_done(store, cell, distances, reached, environment):
    folder = store.cell_folder(cell)
    folder.mkdir(parents=True, exist_ok=True)
    _write_trace(folder / TRACE, [_episode(distances, "truncated")], cell.reward)
    evaluated = _evaluation(reached)
    for rows in evaluated:  # no two policies hold the joint at the same angle
        rows[:, len(SCALARS)] = cell.seed + len(cell.reward.label) / 100.0
    _write_trace(folder / EVALUATION, evaluated, cell.reward)
    _write_trace(folder / RANDOM, [_episode(np.full(steps, 0.9), "ground") for steps in (20, 30, 40, 50)])
    started = "2026-01-01T00:00:00+00:00"
    Manifest(cell, status="done", started=started, seconds=12.5, environment=environment).write(folder)


def _write_learned(store, cell, steps, reached):
    """An evaluation during training."""
    folder = store.cell_folder(cell) / "evaluations"
    folder.mkdir(parents=True, exist_ok=True)
    _write_trace(folder / f"{steps}.parquet", _evaluation([9] * reached), cell.reward)


def _evaluation(reached):
    """Four episodes, of which some reach the target after these steps."""
    missed = [_episode(_approach(20), "truncated") for _ in range(4 - len(reached))]
    return [*(_episode(_approach(steps), "reached") for steps in reached), *missed]


def _distances(run, seed):
    """The arm goes away from its target, then comes nearer than it began and stays there, (1 + dip + climb,)."""
    dip, climb, *scale = run
    return (scale[0] if scale else 1.0) * np.array([2.0] + dip * [3.0] + climb * [1.0 - 0.1 * seed])


def _approach(steps):
    """Straight to the target, (steps + 1,)."""
    return np.linspace(1.0, 0.04, steps + 1)


def _episode(distances, end):
    """Rows of an episode, the columns that follow from its distances filled in."""
    rows = np.zeros((len(distances), len(SCALARS) + 2))
    best = np.minimum.accumulate(distances)
    filled = {
        "step": np.arange(len(distances)),
        "begin_distance": distances[0],
        "previous_best": np.concatenate([best[:1], best[:-1]]),
        "distance": distances,
        "end_effector_x": -distances,
    }
    for name, values in filled.items():
        rows[:, COLUMN[name]] = values
    rows[:, COLUMN["delta_distance"]] = distances - rows[:, COLUMN["previous_best"]]
    rows[-1, COLUMN[end]] = 1.0
    rows[-1, COLUMN["terminated"]] = float(end != "truncated")
    return rows


def _write_trace(path, episodes, paid=None):
    """A trace of these episodes, its rewards as `paid` pays them; one that nobody knows pays as the baseline."""
    for number, rows in enumerate(episodes):
        rows[:, COLUMN["episode"]] = number
    rows = np.concatenate(episodes)
    if paid is not None:
        known = paid if paid.params or paid.name == BASELINE else _reward(BASELINE)
        rows[:, COLUMN["reward"]] = pay_log(known.build(REGISTRY, "rewards"), _trace(rows)).total
    path.write_bytes(_parquet(rows.tobytes(), rows.shape))


@functools.lru_cache(maxsize=512)
def _parquet(rows, shape):
    """The content of a trace's file, written once: most experiments here have the same runs."""
    with TemporaryDirectory() as folder:
        with TraceWriter(Path(folder) / TRACE, dof=1, action_size=1) as writer:
            writer.append(np.frombuffer(rows).reshape(shape))
        return (Path(folder) / TRACE).read_bytes()


def _trace(rows):
    """The rows as a trace in memory, whole numbers and flags among them as such."""
    types = {**dict.fromkeys(SCALARS, float), **dict.fromkeys(INTEGERS, int), **dict.fromkeys(FLAGS, bool)}
    return trace_of({name: rows[:, COLUMN[name]].astype(types[name]) for name in SCALARS})


HEADER = "t,beginDistance,prevBest,distance,delta_distance,reward"
RECORDED = {
    "base": ("0,1,1,1,0,0", "1,1,1,2,1,-1", "2,1,0.5,0.5,-0.5,0.5", "3,1,0.5,0.5,0,0.5", "4,1,0.25,0.25,-0.25,0.75"),
    "k2": (
        *("0,1,1,1,0,0", "1,1,1,1.5,0.5,-0.5", "2,1,0.5,0.5,-0.5,0.75", "3,1,0.25,0.25,-0.25,1.125"),
        "4,1,0.125,0.125,-0.125,1.3125",
    ),
}
"""Paid by the baseline, and by ARP with k2 = 1.5."""


@pytest.fixture
def compare(tmp_path):
    """Compares two groups of two recorded runs each, of which the last `columns` columns are recorded."""

    def compare_files(columns=6, **flags):
        groups = []
        for name, rows in RECORDED.items():
            (tmp_path / name).mkdir(exist_ok=True)
            for number in range(2):
                lines = [",".join(line.split(",")[-columns:]) for line in (HEADER, *rows)]
                (tmp_path / name / f"{number}.csv").write_text("\n".join(lines) + "\n")
            groups.append(match_steps(str(tmp_path / name / "*.csv")))
        return compare_logs(groups[0], groups[1], REGISTRY, **flags)

    return compare_files


@pytest.fixture(scope="module")
def driver():
    """Playwright, where it and a Chromium are installed."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is missing: pip install playwright")
    if BROWSER is None:
        pytest.skip("there is no chromium, chromium-browser or google-chrome: apt-get install chromium")
    with playwright.sync_playwright() as driver:
        yield driver


@pytest.fixture(scope="module")
def launch(driver):
    """Starts the browser with some flags, once for the same flags."""
    started = {}

    def start(*flags):
        if flags not in started:
            started[flags] = driver.chromium.launch(executable_path=BROWSER, args=["--no-sandbox", *flags])
        return started[flags]

    yield start
    for browser in started.values():
        browser.close()


@pytest.fixture
def show(launch):
    """Opens an address; what the browser complained of and asked for are the page's ``complaints`` and ``requests``."""
    contexts = []

    def open_page(address, width=1440, scheme="light", flags=tuple(WEBGL)):
        context = launch(*flags).new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
        contexts.append(context)
        page = context.new_page()
        page.complaints, page.requests = [], []
        page.on("console", lambda message: page.complaints.append(message.text))
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.on("request", lambda request: page.requests.append(request.url))
        page.goto(address)
        return page

    yield open_page
    for context in contexts:
        context.close()


@pytest.fixture
def barriers():
    """What axe finds on a page that keeps people out, serious or critical: the rule and the places."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="pip install axe-playwright-python").Axe()

    def find(page):
        found = [it for it in axe.run(page).response["violations"] if it["impact"] in GRAVE]
        return [f"{it['id']}: {node['html'][:200]}: {node['failureSummary']}" for it in found for node in it["nodes"]]

    return find


@pytest.fixture
def fits(show, barriers):
    """A page, unfolded in a browser, complains of nothing, is no wider than its window, and axe finds nothing."""

    def fits(path, width, scheme):
        page = show(path.as_uri(), width, scheme)
        page.evaluate("for (const part of document.querySelectorAll('details')) part.open = true")
        assert page.complaints == []
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        assert barriers(page) == []

    return fits
