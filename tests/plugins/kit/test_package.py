"""Packages of new plugins: what is in them, and how they are written."""

import ast
import importlib
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from harness.hookspecs import WORDS
from harness_plugins.kit import check_contract
from harness_plugins.kit.new_plugin import (
    PluginName,
    command_to_try,
    kinds,
    package_files,
    write_package,
)
from tests.project import ROOT
from tests.refusals import refused

MOST_LINES = 15
"""Of a reward of one's own."""


def name_of(kind):
    """A name that no module and no plugin has."""
    return PluginName(f"zz-{kind}")


@pytest.fixture
def load(tmp_path, monkeypatch):
    """Write the package of a kind and import what it registers, as the harness would."""

    def load_target(kind):
        name = name_of(kind)
        write_package(package_files(kind, name), tmp_path / name.text)
        monkeypatch.syspath_prepend(tmp_path / name.text)
        told = []
        plugin = importlib.import_module(f"{name.module}.plugin")
        (hook,) = [hook for name, hook in vars(plugin).items() if name.startswith("register_")]
        hook(lambda name, target, **_: told.append((name, target)))
        ((registered, target),) = told
        assert registered == name.text
        module, attribute = target.split(":")
        return getattr(importlib.import_module(module), attribute)

    yield load_target
    for module in [module for module in sys.modules if module.startswith("zz_")]:
        del sys.modules[module]  # the next test's stands in another folder


def test_every_kind_has_a_template():
    """What the harness has a hook for can be begun by one command; a section is begun with its command.

    The page on robots shows a description format in full. A screen has one method.
    """
    assert kinds() == sorted({*WORDS.values()} - {"section", "description", "screen"})


@pytest.mark.parametrize("kind", kinds())
def test_package_is_complete(kind):
    """Its code compiles, its pyproject.toml names the entry point, nothing is left to fill in."""
    name = name_of(kind)
    files = package_files(kind, name)
    assert {"pyproject.toml", "README.md", ".gitignore", ".github/workflows/test.yml"} < files.keys()
    assert {f"zz_{kind}/{kind}.py", f"zz_{kind}/plugin.py", f"tests/test_{kind}.py"} < files.keys()
    for path, text in files.items():
        assert "$" not in text, path
        if path.endswith(".py"):
            ast.parse(text)
    project = tomllib.loads(files["pyproject.toml"])
    assert project["project"]["entry-points"]["harness"] == {name.text: f"{name.module}.plugin"}
    assert command_to_try(kind, name).startswith("harness ")
    assert command_to_try(kind, name) in files["README.md"]


def test_code_is_clean(tmp_path):
    """Nothing to say for ruff, with its own settings: the formatter, and the rules that this project has."""
    rules = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["ruff"]["lint"]
    select, ignore = ",".join(rules["select"]), ",".join(rules["ignore"])
    own = ("--select", select, "--ignore", ignore, "--config", "lint.pydocstyle.convention='google'")
    ruff = [shutil.which("ruff", path=str(Path(sys.executable).parent)) or "ruff"]
    for kind in kinds():
        folder = tmp_path / f"zz-{kind}"
        write_package(package_files(kind, name_of(kind)), folder)
        for arguments in (("check", *own), ("format", "--diff")):
            command = [*ruff, *arguments, "--isolated", "--no-cache", "."]
            ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
            assert ended.returncode == 0, ended.stdout + ended.stderr


@pytest.mark.parametrize("kind", ["reward", "metric", "task"])
def test_code_keeps_its_contract(load, kind):
    """As it is written, before its author changes anything."""
    check_contract(kind, load(kind)())


def test_reward_has_few_lines_of_ones_own():
    """What an author of a reward has to write: the class, without its imports, docstrings and comments."""
    tree = ast.parse(package_files("reward", name_of("reward"))["zz_reward/reward.py"])
    (own,) = [node for node in tree.body if isinstance(node, ast.ClassDef)]
    assert 0 < len([line for line in ast.unparse(_without_docstrings(own)).splitlines() if line.strip()]) <= MOST_LINES


def _without_docstrings(node):
    for inner in ast.walk(node):
        if isinstance(inner, ast.ClassDef | ast.FunctionDef) and ast.get_docstring(inner):
            inner.body = inner.body[1:]
    return node


def test_folder_that_is_there_is_left_alone(tmp_path):
    """Whatever is in it, and even if it is a link to nowhere."""
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine").write_text("mine")
    (tmp_path / "link").symlink_to("nowhere")
    for folder in ("full", "link"):
        with refused("is there already, and nothing is written over"):
            write_package({"a": "b"}, tmp_path / folder)
    assert (tmp_path / "full" / "mine").read_text() == "mine"
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["full", "link", "mine"]


def test_nothing_is_left_half_written(tmp_path):
    """The second file cannot be written: the first is not there either."""
    with pytest.raises(OSError, match=r"Is a directory|Not a directory|File exists"):
        write_package({"a": "a folder is wanted here", "a/b": ""}, tmp_path / "new")
    assert not list(tmp_path.iterdir())


def test_folder_to_hold_it_has_to_be_there(tmp_path):
    """A slip of the finger makes no folders."""
    with refused("is no folder"):
        write_package({"a": "b"}, tmp_path / "nowhere" / "new")


def test_unknown_kind_is_answered_by_the_nearest():
    """With the list of all."""
    with refused(r"No kind of plugin 'rewards'.*Did you mean 'reward'"):
        package_files("rewards", name_of("reward"))


def test_name_that_its_code_uses_is_refused():
    """A reward called `carry` would be a class `Carry`, which its code imports."""
    with refused("would make 'Carry' mean two things"):
        package_files("reward", PluginName("carry"))
