"""What the pages show can be typed: each command, each TOML file, each piece of Python.

Commands are executed where that takes a moment, in a folder with a finished experiment; what trains, with `--dry-run`.
The others are parsed, which finds a flag that is gone. `ways.py` says which these are, and why.
"""

import itertools
import re
import runpy
import shutil
import tomllib
from dataclasses import fields
from pathlib import Path

import pytest
import typer
from typer.exceptions import TyperException

from harness import load_registry
from harness.cli import main
from harness.cli.app import build_app
from harness.experiment.plan import Experiment, check_experiment, expand
from harness_plugins.kit.new_plugin import PluginName, package_files
from tests.docs.pages import ROOT, Command, blocks, blocks_of, commands_of
from tests.docs.ways import HELD, NEEDS, NOT_RUN, SKIPPED

BLOCKS = list(blocks())
COMMANDS = list({it.text: it for block in BLOCKS for it in commands_of(block)}.values())
PATTERNS = [it for it in COMMANDS if it.is_pattern]
TYPED = [it for it in COMMANDS if not it.is_pattern]
TOML = [block for block in BLOCKS if block.language == "toml"]
PYTHON = [block for block in BLOCKS if block.language == "python"]
FOLDERS = re.compile(r"(?:DIR|before|after|one|two|all|my-results|my-first|first|chosen|results/[\w/-]+)")
"""What the pages call the folder of an experiment."""
DRY = ("run", "choose")
"""Commands that train; they are called with `--dry-run`."""
STARTS = re.compile(r"harness\.run\(|\.learn\(")
"""Python that trains."""
MEASURES = ("height", "success")
"""First functions of files that measure behaviour; the files of rewards have the names of theirs."""
KEYS = {field.name for field in fields(Experiment)}
"""Of an experiment file."""
SHORTER = (("steps=5_000", "steps=64"), ("steps=500", "steps=64"), ("20_000", "64"))


def _ids(given):
    return [it.place for it in given]


def reason_not_to_run(command):
    """Why a command is only parsed; nothing where it is executed."""
    if command.words[0] in NOT_RUN:
        return NOT_RUN[command.words[0]]
    if re.fullmatch(r"harness new-plugin \w+ my-\w+", command.text):
        return ""
    return next((why for pattern, why in NEEDS.items() if re.search(pattern, command.text)), "")


EXECUTED = [it for it in TYPED if not reason_not_to_run(it)]
PARSED = [it for it in TYPED if reason_not_to_run(it) and it.words[0] != "my-command"]  # it is a plugin's


@pytest.fixture(scope="module")
def known():
    """Every command by its name."""
    app, registry = build_app(), load_registry()
    for name in registry.names("commands"):  # with their own flags, which the command line reads when they are called
        app.command(name)(registry.get("commands", name).load())
    return typer.main.get_command(app).commands


@pytest.fixture
def folder(recorded, tmp_path, monkeypatch):
    """Where a reader types: a finished experiment, an experiment file, a robot, a reward in a file.

    How long trainings would take is not measured: tests of that are elsewhere, and each takes ten seconds.
    """
    monkeypatch.setattr("harness.experiment.foresee.measure_kinds", lambda cells, *_: dict.fromkeys(cells, "not here"))
    shutil.copy(ROOT / "experiments" / "first.toml", tmp_path / "experiment.toml")
    (tmp_path / "experiments").symlink_to(ROOT / "experiments")
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "reference").symlink_to(ROOT / "results" / "reference")
    for path, text in package_files("robot", PluginName("my-robot")).items():
        if "/arm/" in path:
            (tmp_path / "arm").mkdir(exist_ok=True)
            (tmp_path / "arm" / Path(path).name).write_text(text)
    (own,) = (it for it in BLOCKS if it.page == "docs/how-to/own-reward.md" and "def gentle" in it.text)
    (tmp_path / "gentle.py").write_text(own.text)
    (whole,) = (it for it in BLOCKS if it.page == "docs/writing/reward.md" and "class MyReward" in it.text)
    (tmp_path / "my_reward.py").write_text(whole.text)
    (metric,) = (it for it in BLOCKS if it.page == "docs/how-to/own-metric.md" and "class LowestPoint" in it.text)
    (tmp_path / "my_metric.py").write_text(metric.text)
    for page, of_page in (("reward-files", "rewards"), ("language-model-rewards", "candidates")):
        (tmp_path / of_page).mkdir()
        for block in (it for it in BLOCKS if it.page == f"docs/how-to/{page}.md" and it.language == "python"):
            first = re.findall(r"def (\w+)", block.text)[0]
            name = "behaviour" if first in MEASURES else first
            (tmp_path / of_page / f"{name}.py").write_text(block.text)
    still = "def still(step):\n    return -abs(float(step.observation[2]))\n"  # the page asks a model for ten
    (tmp_path / "candidates" / "still.py").write_text(still)
    (tmp_path / "my_package").mkdir()
    shutil.copy(ROOT / "examples/reward-plugin/cautious_reward/reward.py", tmp_path / "my_package" / "cautious.py")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _names_what_is_there(command, known):
    name, flags = re.findall(r"[\w-]+", command.text)[1], re.findall(r"--[a-z][\w-]*", command.text)
    there = {flag for it in known[name].params for flag in (*it.opts, *it.secondary_opts)}
    assert set(flags) <= there | {"--help"}


def _type(command, known):
    name, *arguments = command.words
    known[name].make_context(name, arguments)


def test_pattern_names_a_command_and_its_flags(known, subtests):
    """What stands in brackets may be left out, and is there."""
    for command in PATTERNS:
        with subtests.test(command=command):
            _names_what_is_there(command, known)


def test_command_can_be_typed(known, subtests):
    """It is not run, for the reason that `ways.py` gives."""
    for command in PARSED:
        with subtests.test(command=command):
            _type(command, known)


@pytest.mark.parametrize("command", EXECUTED, ids=_ids(EXECUTED))
def test_command_is_executed(command, folder, recorded, capsys):
    """It ends with status 0."""
    words = [*command.words]
    for number, word in enumerate(words[1:], 1):
        is_made = words[number - 1] in {"--out", "--summary", "--into", "--html", "--plot"}
        if FOLDERS.fullmatch(word) and not is_made and not (folder / word).exists() and words[0] not in DRY:
            shutil.copytree(recorded.folder, folder / word)
    if "base/" in command.text:
        _record_csv_files(recorded.folder)
    with pytest.raises(SystemExit) as stopped:
        main([*words, *["--dry-run"] * (words[0] in DRY and "--dry-run" not in words)])
    out, err = capsys.readouterr()
    if stopped.value.code and "pip install" in err:
        pytest.skip(err.strip())
    assert stopped.value.code == 0, f"{command.text}\n{out}{err}"


def _record_csv_files(folder):
    """Into `base` and `k2` here: the trainings of an experiment under its two rewards."""
    with pytest.raises(SystemExit):
        main(["export", str(folder), "--csv", "--out", "exported"])
    for reward, name in (("baseline", "base"), ("arp", "k2")):
        (path,) = Path("exported").glob(f"*/{reward}")
        path.rename(name)


@pytest.mark.parametrize("block", TOML, ids=_ids(TOML))
def test_toml_can_be_read(block, toys):
    """An experiment is expanded to its cells."""
    data = tomllib.loads(block.text)
    if data.keys() <= KEYS and "sim" in data:
        assert expand(check_experiment(data, block.place), toys).cells
    assert data


PAGES_OF_PYTHON = [
    (page, list(its))
    for page, its in itertools.groupby(PYTHON, lambda it: it.page)
    if not any(page.startswith(it) for it in HELD)
]


@pytest.mark.parametrize(
    "its",
    [
        pytest.param(its, id=page, marks=[pytest.mark.slow] if any(STARTS.search(it.text) for it in its) else [])
        for page, its in PAGES_OF_PYTHON
    ],
)
def test_python_of_a_page_is_executed(its, folder, monkeypatch):
    """One block after the other, as who follows the page types them; what trains does so in fewer steps."""
    monkeypatch.syspath_prepend(folder)  # `my_package`, which some pages call the reader's
    script = "\n".join(it.text for it in its if not any(part in it.text for part in SKIPPED))
    for long, short in SHORTER:
        script = script.replace(long, short)
    (folder / "page.py").write_text(script)
    runpy.run_path("page.py")


def test_every_snippet_is_accounted_for(capsys):
    """The count is told; no reason stands for a snippet that is gone."""
    skipped = [it for it in PYTHON if any(part in it.text for part in SKIPPED)]
    held = [it for it in PYTHON if any(it.page.startswith(page) for page in HELD)]
    with capsys.disabled():
        typer.echo(
            f"\nsnippets: {len(EXECUTED)} commands executed, {len(PARSED)} parsed, {len(PATTERNS)} patterns compared; "
            f"{len(TOML)} TOML files read; of {len(PYTHON)} blocks of Python {len(held)} in other tests, "
            f"{len(skipped)} skipped, {len(PYTHON) - len(held) - len(skipped)} executed"
        )
    assert len(EXECUTED) > 50
    texts = "\n".join(it.text for it in TYPED)
    assert [pattern for pattern in NEEDS if not re.search(pattern, texts)] == []
    assert [name for name in NOT_RUN if f"harness {name}" not in texts] == []
    assert [part for part in SKIPPED if not any(part in it.text for it in PYTHON)] == []
    assert [page for page in HELD if not any(it.page.startswith(page) for it in PYTHON)] == []


def test_commands_are_found():
    """Behind a prompt, before a remark, over two lines, two in a line; not what harness prints."""
    text = (
        "```\n$ harness describe  all\nfirst$  harness demo   # quick\nharness eta --baseline 'a  b' \\\n"
        "   --proposed c\nharness: no\nharness watch DIR; harness video DIR\n```\n```python\nharness x\n```\n"
    )
    found = [it.text for block in blocks_of("page", text) for it in commands_of(block)]
    assert found == [
        "harness describe",
        "harness demo",
        "harness eta --baseline 'a  b' --proposed c",
        "harness watch DIR",
        "harness video DIR",
    ]


@pytest.mark.parametrize(
    "text", ["harness run --simulator mujoco", "harness run --seeds", "harness status", "harness status DIR --jsn"]
)
def test_command_that_is_wrong_cannot_be_typed(text, known):
    """The mutants: a flag that is not there, and a value or an argument that is missing."""
    with pytest.raises(TyperException):
        _type(Command("page:1", text), known)


def test_pattern_of_a_flag_that_is_gone_is_found(known):
    """The mutant."""
    with pytest.raises(AssertionError):
        _names_what_is_there(Command("page:1", "harness run [--sims NAME]"), known)


def test_command_that_fails_is_found(folder, recorded, capsys):
    """The mutant: it can be typed, and ends with status 2."""
    with pytest.raises(AssertionError, match="No name 'arpp'"):
        test_command_is_executed(Command("page:1", "harness describe arpp"), folder, recorded, capsys)
