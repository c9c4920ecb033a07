"""How large the map is that a reader needs: no figure grows."""

import pytest

from tests.architecture import source
from tests.architecture.__main__ import above, lowered, main, read_bounds
from tests.architecture.entered import COMMANDS, LEAST, enter, measured_by_running
from tests.architecture.source import floors, import_graph


def test_no_figure_is_above_its_bound(capsys):
    """Those that need nothing run; the table has each beside its bound."""
    status, table = main([]), capsys.readouterr().out
    assert status == 0, table
    assert len(table.splitlines()) == 1 + len(source.measured())


@pytest.mark.parametrize(
    "command", [pytest.param(name, marks=[pytest.mark.slow] * name.startswith("run")) for name in COMMANDS]
)
def test_no_command_enters_more_files(command, tmp_path):
    """Nor does one go back to files more often."""
    figures = measured_by_running(tmp_path, [command])
    assert min(figures.values()) > 10  # the files are ours, and they were seen
    assert above(figures, read_bounds()) == []


def test_every_bound_is_of_a_figure():
    """A figure that is measured no longer has none."""
    runs = {f"{kind}, {command}" for command in COMMANDS for kind in ("files entered", *HOPS)}
    assert set(read_bounds()) == set(source.measured()) | runs


HOPS = ("hops between files", "hops back to a file")


def test_a_figure_that_grew_or_has_no_bound_is_named():
    """One that fell is not; bounds fall with it, and never rise."""
    bounds = {"grew": 1, "fell": 5, "stays": 2}
    figures = {"grew": 2, "fell": 3, "stays": 2, "new": 1}
    assert above(figures, bounds) == ["grew: 2, and the bound is 1", "new: 1, and the bound is missing"]
    assert lowered(figures, bounds).splitlines()[1:] == ['"grew" = 1', '"fell" = 3', '"stays" = 2', '"new" = 1']


def test_imports_are_those_of_modules_and_of_names_in_them():
    """A package is imported where a name of it is; relative ones too; those in functions do not count."""
    texts = {
        "p": "",
        "p_a": "from . import b, name\nimport p.c\ndef f():\n    import p.d\n",
        "p_b": "from .c import x\nfrom typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from p.d import y\n",
        "p_c": "try:\n    import json, p.d\nexcept ImportError:\n    pass\n",
        "p_d": "",
    }
    graph = import_graph({name.replace("_", "."): (text, name == "p") for name, text in texts.items()})
    assert graph == {"p": set(), "p.a": {"p", "p.b", "p.c"}, "p.b": {"p.c"}, "p.c": {"p.d"}, "p.d": set()}


def test_floors_are_the_modules_of_the_longest_chain():
    """Not the number of modules, nor that of a module's imports."""
    assert floors({"a": {"b", "c", "d"}, "b": {"d"}, "c": {"d"}, "d": set()}) == 3


def test_a_fork_is_counted_outside_the_worlds(tmp_path, monkeypatch):
    """By file and line."""
    for name in ("harness/results/kind.py", "harness/experiment/arm_world.py", "plugins/own.py"):
        (path := tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        path.write_text("x = 1\nif simulator == NO_SIMULATOR:\n    pass\nNO_SIMULATORS = 3\n")
    monkeypatch.setattr(source, "ROOT", tmp_path)
    assert source.forks() == [("harness/results/kind.py", 2), ("plugins/own.py", 2)]


@pytest.fixture
def own(tmp_path):
    """Files that call one another, and a folder for what they enter."""
    (tmp_path / "ours").mkdir()
    texts = {
        "first": "import functools, second\ndef main():\n    second.f(deep)\n    second.f(int)\ndef deep(): return 1\n",
        "second": "import third\n@third.decorate\ndef f(g):\n    return [third.h(g) for _ in range(3)]\n",
        "third": "def decorate(f): return f\ndef h(g): return list(map(lambda _: g(), 'ab'))\n",
        "never": "class C:\n    x = [1 for _ in 'a']\ndef f(): pass\n",
    }
    for name, text in texts.items():
        (tmp_path / "ours" / f"{name}.py").write_text(text)
    return tmp_path


RUN = "import sys; sys.path.insert(0, 'ours'); import first, never; first.main()"


OTHERS = {
    "arm": (("--sim", "kinematic"), ("harness/experiment/environments/", "harness/recorder/")),
    "environment": (
        ("--task", "gymnasium:id=Pendulum-v1", "--baseline", "none", "--reward", "own"),
        ("harness/robot/", "harness/motion/", "harness/scene/", "harness/env/", "harness/conditions/"),
    ),
}
"""By kind of world: flags of a run, and the folders that only the other kind needs."""


@pytest.mark.parametrize("kind", OTHERS)
def test_a_run_loads_nothing_that_only_the_other_world_needs(kind, tmp_path):
    """Neither when it is planned, nor where it trains, nor for its report; it loads what its own world needs."""
    flags, others = OTHERS[kind]
    loaded = enter(["-m", "harness", "run", *flags, "--algo", "random", *LEAST, "--out", "out"], tmp_path).loaded
    assert [file for file in sorted(loaded) if file.startswith(others)] == []
    (own,) = (its for other, (_, its) in OTHERS.items() if other != kind)
    assert all(any(file.startswith(folder) for file in loaded) for folder in own[:2])


def test_files_are_entered_by_calls_of_functions(own):
    """What runs at import is no call; each pair of files counts once; a way back leads to a file that was entered."""
    entered = enter(["-c", RUN], own, [own / "ours"])
    first, second, third = (f"ours/{name}.py" for name in ("first", "second", "third"))
    assert entered.files == {first, second, third}
    assert entered.hops == {(first, second), (second, third), (third, first)}
    assert entered.back == {(third, first)}
    assert entered.loaded == {first, second, third, "ours/never.py"}


def test_processes_that_a_command_starts_count(own):
    """Their files are united with its own."""
    start = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {RUN!r}], check=True)"
    assert len(enter(["-c", start], own, [own / "ours"]).files) == 3


def test_a_command_that_fails_is_told(own):
    """With what it said: what it entered until then would be too few files."""
    with pytest.raises(RuntimeError, match="no such luck"):
        enter(["-c", "raise SystemExit('no such luck')"], own, [own / "ours"])
