"""The names that authors may build on: those of docs/authoring.md, and no others."""

import importlib
import inspect
import re
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import harness.authoring
from harness.authoring.face import Renamed, lazy_names

PAGE = Path(__file__).parents[2] / "docs" / "authoring.md"
TEXT = PAGE.read_text(encoding="utf-8")
MODULES = ("harness.authoring", "harness_plugins.sb3")


def _documented() -> dict[str, dict[str, str]]:
    """By module, the signature of each name that the page lists."""
    found: dict[str, dict[str, str]] = {module: {} for module in MODULES}
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


@pytest.mark.parametrize("module", MODULES)
def test_the_page_and_the_module_name_the_same(module: str):
    """A name that is added, or taken away, has to be so on both."""
    assert sorted(DOCUMENTED[module]) == importlib.import_module(module).__all__


@pytest.mark.parametrize(("module", "name"), [(m, n) for m, names in DOCUMENTED.items() for n in names])
def test_the_page_says_the_signature(module: str, name: str):
    """Every argument in order, with its default; what is a function by default is written as dots."""
    found = inspect.signature(getattr(importlib.import_module(module), name))
    told = []
    for parameter in found.parameters.values():
        stars = {parameter.VAR_KEYWORD: "**", parameter.VAR_POSITIONAL: "*"}.get(parameter.kind, "")
        default = "" if parameter.default is parameter.empty else f"={_shown(parameter.default)}"
        told.append(f"{stars}{parameter.name}{default}")
    assert DOCUMENTED[module][name] == f"({', '.join(told)})"


def _shown(default: object) -> str:
    plain = default if isinstance(default, int | float | str | None) else getattr(default, "default", ...)
    return repr(plain) if isinstance(plain, int | float | str | None) else "..."


def test_every_snippet_of_the_page_runs(tmp_path: Path):
    """One after the other, as somebody who reads from the top would type them; the last one is for pytest."""
    *snippets, _ = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    assert len(snippets) >= 15
    names = {"folder": tmp_path, "__name__": __name__}
    for snippet in snippets:
        exec(compile(snippet, str(PAGE), "exec"), names)  # the page is our own


def test_importing_them_imports_nothing_heavy():
    """Neither numpy nor torch nor a robot; names are there without having been used."""
    code = (
        "import sys, harness.authoring, harness_plugins.sb3; "
        "assert not {'numpy', 'torch', 'stable_baselines3', 'gymnasium'} & set(sys.modules); "
        "assert 'GroundContact' in harness.authoring.__all__"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("module", MODULES)
def test_no_submodule_hides_a_name(module: str):
    """Once it is imported, a submodule stands under its own name in the package."""
    face = importlib.import_module(module)
    assert not {path.stem for path in Path(face.__file__ or "").parent.glob("*.py")} & set(face.__all__)


def test_an_unknown_name_is_an_attribute_error():
    """As of any module."""
    with pytest.raises(AttributeError, match=r"'harness\.authoring' has no attribute 'reach_positon'"):
        _ = harness.authoring.reach_positon


def test_a_name_that_was_given_up_warns_and_works():
    """It says what to use, and from when on it is gone."""
    look_up = lazy_names("mine", {"loads": "json"}, {"load_text": Renamed("loads", "0.4")})
    with pytest.warns(
        DeprecationWarning, match=r"mine\.load_text is called loads now; .* goes in version 0\.4"
    ) as seen:
        assert look_up("load_text")("[1]") == [1]
    assert seen[0].filename == __file__


def test_a_name_that_stays_does_not_warn():
    """Only what was given up does."""
    look_up = lazy_names("mine", {"loads": "json"}, {"load_text": Renamed("loads", "0.4")})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert look_up("loads")("[1]") == [1]


@pytest.mark.parametrize("module", MODULES)
def test_what_a_name_became_is_public(module: str):
    """An old name leads to one that is listed, and is not listed itself."""
    face = importlib.import_module(module)
    for old, renamed in face.RENAMED.items():
        assert renamed.new in face.__all__
        assert old not in face.__all__
