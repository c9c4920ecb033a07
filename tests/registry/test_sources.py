"""The files that a plugin is made of."""

from hashlib import sha256
from pathlib import Path

import pytest

from harness.registry.sources import source_files, source_hash
from harness_plugins import fast_sac, soft_actor_critic
from harness_plugins.algorithms import sac_fast
from harness_plugins.algorithms.sac_fast import SacFast
from harness_plugins.rewards import arp
from harness_plugins.rewards.arp import Arp


def test_a_class_of_one_file_is_that_file():
    """Its hash is that of the file."""
    assert source_files(Arp) == [Path(arp.__file__)]
    assert source_hash(Arp) == sha256(Path(arp.__file__).read_bytes()).hexdigest()


def test_a_derived_class_is_made_of_its_bases_too():
    """Its own file first, Python's own files not at all."""
    files = source_files(SacFast)
    assert files[:2] == [Path(sac_fast.__file__), Path(soft_actor_critic.__file__)]
    assert all("harness" in str(file) or "plugins" in str(file) for file in files)


def test_packages_that_it_names_are_part_of_it():
    """Every module in them."""
    folder = Path(fast_sac.__file__).parent
    assert set(folder.glob("*.py")) <= set(source_files(SacFast))


def test_hash_changes_with_a_module_of_its_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A learner that was changed can be told, though the file of the class was not."""
    (tmp_path / "learners").mkdir()
    for name in ("__init__", "learner"):
        (tmp_path / "learners" / f"{name}.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)

    class Plugin(Arp):
        sources = ("learners",)

    before = source_hash(Plugin)
    (tmp_path / "learners" / "learner.py").write_text("changed = True\n")
    assert source_hash(Plugin) != before


def test_a_module_that_is_not_there_is_not_hashed():
    """An optional part that is not installed is no error."""

    class Plugin(Arp):
        sources = ("no_such_module_anywhere",)

    assert Path(arp.__file__) in source_files(Plugin)
