"""What a plugin may import: the names that are recorded, from the modules that one list has, and nothing else."""

import ast
import importlib
import tomllib

import pytest

import tests.compatibility.surface as recorder
from tests.compatibility.surface import PAGE, PUBLIC, RECORD, ROOT, main, surface, unexplained

CONTRACT = next(
    contract
    for contract in tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    if contract["name"] == "Plugins use the public surface alone"
)
OF_THE_CORE = {
    *("announced", "audit", "commands", "committed", "doctor", "exporters", "kit", "parity", "transfer", "video"),
    "watch",
}
"""Commands of our own, and the kit: parts of the core that stand in `plugins/`."""


def _modules_in(folder):
    return {path.stem for path in folder.iterdir() if path.suffix == ".py" or (path / "__init__.py").is_file()}


def test_names_are_those_that_were_recorded():
    """One that appears, leaves or changes its signature has a line in docs/plugins.md."""
    missing = unexplained(RECORD.read_text().splitlines(), surface(), PAGE.read_text())
    assert missing == [], "write a line for each under 'Changes', then: python -m tests.compatibility.surface"


BEFORE = ["harness.run(**given)", "harness.log.Measure", "harness.robot.forward(chain, qpos)"]


@pytest.mark.parametrize(
    ("today", "name"),
    [
        ([*BEFORE, "harness.robot.backward(chain)"], "harness.robot.backward"),
        (BEFORE[1:], "harness.run"),
        ([*BEFORE[:2], "harness.robot.forward(chain, qpos, link='')"], "harness.robot.forward"),
        ([BEFORE[0], "harness.log.Measure(unit)", BEFORE[2]], "harness.log.Measure"),
        ([*BEFORE, "harness.log.Measure.scale"], "harness.log.Measure.scale"),
    ],
    ids=["added", "removed", "another argument", "a class for an interface", "another member"],
)
def test_a_change_needs_a_line(today, name):
    """Under its heading; one that stands elsewhere on the page, or names something longer, explains nothing."""
    page = "# Plugins\n{}\n### Changes\n\n| {} | new |\n\n## Publishing\n{}\n"
    assert unexplained(BEFORE, today, page.format("", "", "")) == [name]
    assert unexplained(BEFORE, today, page.format(name, f"`{name}s`", name)) == [name]
    assert unexplained(BEFORE, today, page.format("", f"`{name}`", "")) == []
    assert unexplained(today, today, page.format("", "", "")) == []


def test_nothing_is_recorded_before_it_is_explained(tmp_path, monkeypatch):
    """The record stays, and the names are told."""
    record = tmp_path / "surface.txt"
    record.write_text("harness.gone()\n")
    monkeypatch.setattr(recorder, "RECORD", record)
    monkeypatch.setattr(recorder, "surface", lambda: [])
    with pytest.raises(SystemExit, match=r"docs/plugins\.md, Changes: write a line for harness\.gone$"):
        main()
    assert record.read_text() == "harness.gone()\n"


def test_the_list_has_every_module_that_plugins_may_import():
    """import-linter forbids all others: other flat modules, other rooms, and what is in rooms."""
    others = {f"harness.{name}" for name in _modules_in(ROOT / "harness") - {"__init__", "__main__"}} - {*PUBLIC}
    assert set(CONTRACT["forbidden_modules"]) == {"harness.*.*"} | others


def test_import_linter_holds_every_plugin():
    """But those parts of the core that stand beside them."""
    plugins = _modules_in(ROOT / "plugins") - {"__init__"} - OF_THE_CORE
    assert set(CONTRACT["source_modules"]) == {f"harness_plugins.{name}" for name in plugins}


def _imported(tree):
    """Module and name of every import that runs."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            continue
        if isinstance(node, ast.ImportFrom) and not node.level:
            yield from ((node.module, alias.name) for alias in node.names)
        yield from _imported(node)


def _private_names(sources):
    """What plugins take from a public module without its being public, as a module and a name."""
    pairs = {pair for source in sources for pair in _imported(ast.parse(source)) if pair[0] in PUBLIC}
    return sorted((module, name) for module, name in pairs if name not in importlib.import_module(module).__all__)


def _sources():
    for path in sorted((ROOT / "plugins").rglob("*.py")):
        if path.relative_to(ROOT / "plugins").with_suffix("").parts[0] not in OF_THE_CORE:
            yield path.read_text()


def test_plugins_take_public_names_alone():
    """import-linter looks at modules, not at names."""
    assert _private_names(_sources()) == []


def test_a_private_name_of_a_public_module_is_found():
    """For type checkers it may be imported: that brings nothing."""
    source = "if TYPE_CHECKING:\n    from harness.task import varies\nfrom harness.task import Task, {}\n"
    assert _private_names([source.format("choose_task")]) == [("harness.task", "choose_task")]
    assert _private_names([source.format("Targets")]) == []


@pytest.mark.parametrize("module", PUBLIC)
def test_public_names_of_a_module_are_there(module):
    """Each once."""
    names = importlib.import_module(module).__all__
    assert len(names) == len(set(names)) > 0
    assert [name for name in names if not hasattr(importlib.import_module(module), name)] == []


def test_templates_and_examples_take_public_names_alone():
    """What people copy."""
    paths = [*(ROOT / "plugins/kit/templates").rglob("*.py.template"), *(ROOT / "examples").rglob("*.py")]
    taken = {
        (module, name)
        for path in paths
        for module, name in _imported(ast.parse(path.read_text().replace("$", "")))
        if module.partition(".")[0] == "harness" and module != "harness.cli"  # its `main` is the command itself
    }
    assert len(taken) > 20
    assert [pair for pair in sorted(taken) if pair[0] not in PUBLIC] == []
    assert [pair for pair in sorted(taken) if pair[1] not in importlib.import_module(pair[0]).__all__] == []
