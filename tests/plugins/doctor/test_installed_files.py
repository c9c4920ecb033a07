"""What of an installation is missing or was changed since it was installed."""

import base64
import hashlib
import json

import pytest

from harness_plugins.doctor.doctor import file_lines

FILES = {"toys/__init__.py": "x = 1\n", "toys/page.html.j2": "<p>\n"}


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """A distribution of two files, as pip leaves it."""
    metadata = tmp_path / "toys-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: toys\nVersion: 1.0\n")
    (tmp_path / "toys").mkdir()
    rows = ["toys-1.0.dist-info/RECORD,,", "toys/__pycache__/__init__.cpython-311.pyc,,"]
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
        digest = base64.urlsafe_b64encode(hashlib.sha256(text.encode()).digest()).decode().rstrip("=")
        rows.append(f"{name},sha256={digest},{len(text)}")
    (metadata / "RECORD").write_text("\n".join(rows) + "\n")
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


def test_whole_installation_has_nothing_to_tell(installed):
    """Compiled modules do not count: Python makes them when it likes."""
    assert file_lines("toys") == []


def test_missing_and_changed_files_are_named(installed):
    """With what to do."""
    (installed / "toys/page.html.j2").unlink()
    (installed / "toys/__init__.py").write_text("x = 2\n")
    lines = file_lines("toys")
    assert [line.partition(": ")[0] for line in lines] == [
        "file toys/__init__.py is not what was installed",
        "file toys/page.html.j2 is missing",
    ]
    assert all("pip install --force-reinstall" in line for line in lines)


def test_editable_installation_has_no_files_of_its_own(installed):
    """It uses the checkout, where files come and go."""
    told = {"url": "file:///somewhere", "dir_info": {"editable": True}}
    (installed / "toys-1.0.dist-info/direct_url.json").write_text(json.dumps(told))
    (installed / "toys/page.html.j2").unlink()
    assert file_lines("toys") == []


def test_what_is_not_installed_has_none():
    """As a folder on PYTHONPATH."""
    assert file_lines("no-such-distribution") == []


def test_metadata_that_a_build_left_in_a_checkout_lists_no_installed_files(installed):
    """It names sources, which come and go too."""
    (installed / "toys-1.0.dist-info").rename(installed / "toys.egg-info")
    (installed / "toys.egg-info/METADATA").rename(installed / "toys.egg-info/PKG-INFO")
    (installed / "toys.egg-info/RECORD").unlink()
    (installed / "toys.egg-info/SOURCES.txt").write_text("toys/gone.py\n")
    assert file_lines("toys") == []
