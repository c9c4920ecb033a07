"""Every command, from a wheel without any extra, outside the checkout; every page that they make is opened."""

import json
import re
import signal
import subprocess
import urllib.request

import pytest

pytestmark = pytest.mark.slow

SHORT = ("--steps", "300", "--evaluation-episodes", "2", "--jobs", "2")
RUN = (*SHORT, "--seeds", "2")
LOOKS = ("--sim", "kinematic", "--algo", "ik", "--looks", "2,4", *SHORT)
REWARD = "def slow(observation, action, next_observation, info):\n    return -abs(float(next_observation[1]))\n"
COMMANDS = {
    "demo": ("demo", "--out", "demo"),
    "run": ("run", "--sim", "kinematic", "--algo", "ik", "--reward", "dense", *RUN, "--out", "first"),
    "run, learning": ("run", "--sim", "kinematic", "--algo", "sac-fast", "--reward", "dense", *RUN, "--out", "learned"),
    "run, an environment": (
        *("run", "--task", "gymnasium:id=CartPole-v1", "--algo", "random", "--plugin", "rewards/*.py", *RUN),
        *("--out", "carts"),
    ),
    "run, until decided": ("run", "--reward", "dense", "--until", "decided", *LOOKS, "--out", "decided"),
    "choose": (
        *("choose", "--reward", "dense,arp", "--screen", "--sim", "kinematic", "--algo", "ik", "--budget", "10"),
        *(*SHORT, "--out", "chosen"),
    ),
    "report": ("report", "first", "--html", "page.html"),
    "report, a text": ("report", "first", "--details"),
    "report, records": ("report", "first", "--summary", "records"),
    "report, an environment": ("report", "carts", "--html", "carts.html"),
    "status": ("status", "first"),
    "describe": ("describe",),
    "describe, a name": ("describe", "arp"),
    "doctor": ("doctor",),
    "audit": ("audit", "--reward", "arp", "--budget", "10000"),
    "export": ("export", "first", "--csv", "--out", "runs"),
    "eta": ("eta", "--baseline", "runs/**/baseline/*.csv", "--proposed", "runs/**/dense/*.csv", "--plot", "eta.html"),
    "score": ("score", "first", "--reward", "sparse"),
    "score, an environment": ("score", "carts", "--plugin", "later.py"),
    "transfer": ("transfer", "first", "--to", "kinematic"),
    "merge": ("merge", "first", "learned", "--out", "merged"),
    "verify": ("verify", "first"),
    "verify, repairing": ("verify", "first", "--repair"),
    "new-plugin": ("new-plugin", "reward", "my-reward"),
    "check": ("check", "arp"),
    "parity": ("parity", "--sim", "kinematic", "--reference", "kinematic", "--steps", "9", "--html", "parity.html"),
}
"""Each works without any extra; behind a comma stands what is special about it."""
NEEDS_AN_EXTRA = {
    "video": (("video", "first", "--out", "film.gif"), "pip install 'fd100-harness[video]'"),
}
"""These say in one line what to install."""
SERVES = "watch"
"""Tried by itself, since it does not end."""
PAGES = {
    "demo/report.html": "arp",
    "first/report.html": "dense",
    "learned/report.html": "dense",
    "merged/report.html": "dense",
    "carts/report.html": "slow",
    "decided/report.html": "trained until decided",
    "chosen/report.html": "How far the candidates went",
    "page.html": "dense",
    "carts.html": "slow",
    "eta.html": "eta",
    "parity.html": "kinematic",
}
"""What stands in each page that the commands make."""


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """Where a user types."""
    folder = tmp_path_factory.mktemp("user")
    (folder / "rewards").mkdir()
    (folder / "rewards" / "slow.py").write_text(REWARD)
    (folder / "later.py").write_text(REWARD.replace("slow", "later"))
    return folder


@pytest.fixture(scope="module")
def answers(core, place):
    """What every command answered, in this order."""
    return {name: core.harness(*arguments, cwd=place) for name, arguments in COMMANDS.items()}


@pytest.mark.parametrize("name", COMMANDS)
def test_command_works_without_any_extra(answers, name):
    """It ends with status 0, and nothing is missing."""
    answer = answers[name]
    assert answer.status == 0, answer.out + answer.err
    assert "Traceback" not in answer.err


@pytest.mark.parametrize("name", NEEDS_AN_EXTRA)
def test_command_says_which_extra_it_needs(core, answers, place, name):
    """In one line."""
    arguments, told = NEEDS_AN_EXTRA[name]
    status, _, err = core.harness(*arguments, cwd=place)
    assert (status, err.count("\n")) == (2, 1), err
    assert told in err


def test_every_command_is_tried(core, place):
    """Each that `harness --all` shows; the others are hidden on purpose."""
    shown = set(re.findall(r"^  ([a-z][a-z-]+)  +[A-Z]", core.harness("--all", cwd=place).out, re.MULTILINE))
    assert len(shown) == 19
    assert shown == {name.partition(",")[0] for name in (*COMMANDS, *NEEDS_AN_EXTRA)} | {SERVES}


@pytest.mark.parametrize("page", PAGES)
def test_page_is_whole(answers, place, page):
    """It has its text, and its style and its code are inside."""
    text = (place / page).read_text()
    assert PAGES[page] in text
    assert "<style" in text
    assert text.rstrip().endswith("</html>")


def test_pages_are_all_that_there_are(answers, place):
    """A command that makes another one stands in the list too."""
    assert {path.relative_to(place).as_posix() for path in place.rglob("*.html")} == set(PAGES)


def test_watch_serves_its_page(core, answers, place):
    """Of an arm, while nothing runs; it ends with the interrupt."""
    command = [core.python, "-P", "-m", "harness", "watch", "first", "--no-browser"]
    with subprocess.Popen(command, cwd=place, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr is not None
            (address,) = re.findall(r"http://\S+", process.stderr.readline())
            with urllib.request.urlopen(address, timeout=20) as answer:
                assert "<canvas" in answer.read().decode()
        finally:
            process.send_signal(signal.SIGINT)
        assert process.wait(20) in (0, 130)


def test_doctor_finds_nothing_missing(answers):
    """No file, and what is installed takes a step."""
    told = answers["doctor"].out
    assert "is missing" not in told
    assert "tried simulators, a step in each: kinematic" in told
    assert "gymnasium:id=CartPole-v1" in told


def test_json_is_json(core, answers, place):
    """And nothing else stands on standard output."""
    for folder in ("first", "carts"):
        assert json.loads(core.harness("report", folder, "--json", cwd=place).out)["cells"]
