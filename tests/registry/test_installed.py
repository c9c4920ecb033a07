"""The entry points of what is installed."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from harness.registry import installed as module
from harness.registry.installed import installed


@pytest.fixture
def add(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Path]:
    """Install a package with one entry point of the group `seen`, in a folder that is searched from the start."""
    monkeypatch.syspath_prepend(tmp_path)

    def add_package(name: str) -> Path:
        folder = tmp_path / f"{name}-1.0.dist-info"
        folder.mkdir()
        (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        (folder / "entry_points.txt").write_text(f"[seen]\n{name} = {name}\n[other]\n{name} = other\n")
        return folder

    return add_package


def _names() -> list[str]:
    return sorted(point.name for point in installed("seen"))


def test_entry_points_of_a_group_are_found(add: Callable[[str], Path]):
    """With the distribution that they are of; another group's are not."""
    assert installed("seen") == ()
    add("first")
    (found,) = installed("seen")
    assert (found.name, found.value, found.dist.name) == ("first", "first", "first")


def test_what_is_installed_meanwhile_is_found(add: Callable[[str], Path]):
    """And what was removed is not: a notebook lives long."""
    first = add("first")
    assert _names() == ["first"]
    add("second")
    assert _names() == ["first", "second"]
    shutil.rmtree(first)
    assert _names() == ["second"]


def test_who_searches_elsewhere_finds_what_is_there(add: Callable[[str], Path], monkeypatch: pytest.MonkeyPatch):
    """A folder that Python no longer searches counts no more."""
    add("first")
    assert _names() == ["first"]
    monkeypatch.setattr("sys.path", [])
    assert _names() == []


def test_distributions_are_read_once(add: Callable[[str], Path], monkeypatch: pytest.MonkeyPatch):
    """As long as nothing changes: there may be hundreds."""
    add("first")
    asked: list[str] = []
    monkeypatch.setattr(module, "entry_points", lambda group: asked.append(group) or ())
    for _ in range(3):
        installed("seen")
    assert asked == ["seen"]
