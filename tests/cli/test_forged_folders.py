"""Folders of a stranger with valid digests, through every command: nothing is moved, run or obeyed."""

import shutil

import pytest

from tests.cli.conftest import QUICK
from tests.cli.forging import CANARY, FORGED, write_canary

RUN = ("run", *QUICK, "--seeds", "1", "--out", "it")
COMMANDS = {
    "verify": ("verify", "it"),
    "repair": ("verify", "it", "--repair"),
    "status": ("status", "it"),
    "report": ("report", "it", "--html", "it/report.html"),
    "summary": ("report", "it", "--summary", "out"),
    "two folders": ("report", "it", "sound"),
    "compare": ("compare", "sound", "it"),
    "merge": ("merge", "it", "--out", "out"),
    "merge into it": ("merge", "sound", "--out", "it"),
    "run": RUN,
    "score": ("score", "it", "--all"),
    "transfer": ("transfer", "it", "--to", "stuck"),
    "csv": ("export", "it", "--csv", "--out", "out"),
}
QUICK_ONES = (
    "list: '..'",
    "link: cells",
    "hard link: study.log",
    "plan: reward",
    "experiment: deep",
    "running: '/etc'",
    "trace: gaps that it has none of",
)
OBEYED = "\x1b\x07\u202e"
SOME = {name: FORGED[name] for name in QUICK_ONES}


@pytest.fixture(scope="module")
def sound(tmp_path_factory, toy_folder):
    """An experiment that ran, with an evaluation elsewhere, a table and a page."""
    return tmp_path_factory.mktemp("sound") / "it"


@pytest.fixture
def place(harness, sound, tmp_path, transferred_here):
    """A folder for commands, with the experiment as `sound`, and a tree that nobody may touch."""
    if not sound.exists():
        assert harness(*RUN).status == 0
        shutil.move(tmp_path / "it", sound)
    shutil.copytree(sound, tmp_path / "sound")
    write_canary(tmp_path / CANARY)
    return tmp_path


def tree(folder):
    """What stands in a folder and below, byte for byte."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes() if path.is_file() else "folder"
        for path in folder.rglob("*")
    }


def _made(files):
    """What commands make again: pages, tables, lists."""
    return {it for it in files.items() if not it[0].startswith(("cells/", "transfer/"))}


def forge(place, name):
    """A new forged folder, and nothing that an earlier command wrote."""
    for left in ("it", "out"):
        shutil.rmtree(place / left, ignore_errors=True)
    shutil.copytree(place / "sound", place / "it")
    FORGED[name](place / "it")


def try_all(harness, place, name):
    """Every command over a folder of its own.

    Raises:
        AssertionError: One touched what is outside, ended as nobody foresaw, or printed what a terminal obeys.
    """
    before = {part: tree(place / part) for part in (CANARY, "sound")}
    for command, words in COMMANDS.items():
        forge(place, name)
        answer = harness(*words)
        where = f"{name}: {command}: {answer.err[-500:]}"
        assert {part: tree(place / part) for part in before} == before, where
        assert {path.name for path in place.iterdir()} <= {CANARY, "sound", "it", "out"}, where
        if name.startswith("list"):  # the lie is about names alone: every training stays
            assert before["sound"].items() - _made(before["sound"]) <= tree(place / "it").items(), where
        assert answer.status in (0, 1, 2), where
        assert "Traceback" not in answer.err, where
        assert not any(char in answer.out + answer.err for char in OBEYED), where


@pytest.mark.parametrize("name", SOME)
def test_a_folder_of_a_stranger_is_read_and_not_believed(harness, place, name):
    """One of each kind."""
    try_all(harness, place, name)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(FORGED.keys() - SOME.keys()))
def test_whatever_a_stranger_writes_moves_and_runs_nothing(harness, place, name):
    """More than a hundred lies that are read, as their digests are right."""
    try_all(harness, place, name)


def test_the_tree_outside_can_be_touched(place):
    """What is compared would change: the test sees it."""
    before = tree(place / CANARY)
    (place / CANARY / "victim").write_text("moved")
    assert tree(place / CANARY) != before
