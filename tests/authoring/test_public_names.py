"""The names that most authors build on, as docs/authoring.md explains them."""

import importlib
import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest

import harness.simulator

PAGE = Path(__file__).parents[2] / "docs" / "authoring.md"
TEXT = PAGE.read_text()
MODULES = ("harness.algorithm", "harness.executor", "harness.policy", "harness.reward", "harness.simulator")
OTHERS = ("harness.robot", "harness_plugins.sb3")


def _documented():
    """By module, the signature of each name that the page lists."""
    found = {module: {} for module in (*MODULES, *OTHERS)}
    module = ""
    for line in TEXT.splitlines():
        heading = re.fullmatch(r"## .*: `([\w.]+)`", line)
        if heading:
            module = heading[1]
        elif line.startswith("## "):
            module = ""
        name = re.fullmatch(r"### `(\w+)(\(.*\))`", line)
        if name:
            found[module][name[1]] = name[2]
    return found


DOCUMENTED = _documented()


@pytest.mark.parametrize("module", DOCUMENTED)
def test_the_page_has_public_names_alone(module):
    """One that is taken away has to leave it."""
    assert DOCUMENTED[module]
    assert set(DOCUMENTED[module]) <= set(importlib.import_module(module).__all__)


@pytest.mark.parametrize("module", [*MODULES, "harness_plugins.sb3"])
def test_the_page_has_every_building_block(module):
    """A name that is added has to be there."""
    face = importlib.import_module(module)
    rooms = ("harness.authoring", "harness_plugins.sb3")
    own = {name for name in face.__all__ if getattr(getattr(face, name), "__module__", "").startswith(rooms)}
    assert own
    assert own <= set(DOCUMENTED[module])


@pytest.mark.parametrize(("module", "name"), [(m, n) for m, names in DOCUMENTED.items() for n in names])
def test_the_page_says_the_signature(module, name):
    """Every argument in order, with its default; what is a function by default is written as dots."""
    found = inspect.signature(getattr(importlib.import_module(module), name))
    told = []
    for parameter in found.parameters.values():
        stars = {parameter.VAR_KEYWORD: "**", parameter.VAR_POSITIONAL: "*"}.get(parameter.kind, "")
        default = "" if parameter.default is parameter.empty else f"={_shown(parameter.default)}"
        told.append(f"{stars}{parameter.name}{default}")
    assert DOCUMENTED[module][name] == f"({', '.join(told)})"


def _shown(default):
    plain = default if isinstance(default, int | float | str | None) else getattr(default, "default", ...)
    return repr(plain) if isinstance(plain, int | float | str | None) else "..."


def test_every_snippet_of_the_page_runs(tmp_path):
    """One after the other, as somebody who reads from the top would type them; the last one is for pytest."""
    *snippets, _ = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    assert len(snippets) >= 15
    names = {"folder": tmp_path, "__name__": __name__}
    for snippet in snippets:
        exec(compile(snippet, str(PAGE), "exec"), names)  # the page is our own


def test_importing_them_imports_nothing_heavy():
    """No engine and no learning library; names are there without having been used."""
    code = (
        f"import sys, {', '.join((*MODULES, *OTHERS))}; "
        "assert not {'torch', 'stable_baselines3', 'gymnasium', 'mujoco', 'scipy'} & set(sys.modules); "
        "assert 'GroundContact' in harness.simulator.__all__"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("module", [*MODULES, *OTHERS])
def test_no_submodule_hides_a_name(module):
    """Once it is imported, a submodule stands under its own name in the package."""
    path = Path(importlib.import_module(module).__file__ or "")
    beside = {it.stem for it in path.parent.glob("*.py")} if path.stem == "__init__" else set()
    assert not beside & set(importlib.import_module(module).__all__)


def test_an_unknown_name_is_an_attribute_error():
    """As of any module."""
    with pytest.raises(AttributeError, match=r"'harness\.simulator' has no attribute 'servos_of'"):
        _ = harness.simulator.servos_of
