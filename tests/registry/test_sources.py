"""The files that a plugin is made of."""

import sys
from hashlib import sha256
from importlib import import_module
from pathlib import Path

import pytest

from harness.registry import fingerprint, source_hash, sources
from harness.registry.sources import digest_of_modules, source_files
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


def test_hash_changes_with_a_module_of_its_package(tmp_path, monkeypatch):
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


METRIC = """
from dataclasses import dataclass
from {package}.helper import HALF

@dataclass(frozen=True)
class Metric:
    factor: float = 1.0

@dataclass(frozen=True)
class Wrapped:
    metric: Metric = Metric()
"""


@pytest.fixture(name="package")
def _package(tmp_path, monkeypatch):
    """Makes a package with a metric, whose helper has this source; each is another package with the same text."""
    monkeypatch.syspath_prepend(tmp_path)
    made = []

    def make(helper):
        name = f"measures{len(made)}"
        made.append(name)
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("")
        (tmp_path / name / "helper.py").write_text(helper)
        (tmp_path / name / "metric.py").write_text(METRIC.format(package=name))
        return import_module(f"{name}.metric")

    yield make
    for name in [name for name in sys.modules if name.partition(".")[0] in made]:
        del sys.modules[name]


def test_fingerprint_has_the_parameters():
    """The same class with another gain is another reward."""
    assert fingerprint(Arp(k2=1.5)) == fingerprint(Arp())
    assert fingerprint(Arp(k2=2.0)) != fingerprint(Arp())


def test_fingerprint_has_the_modules_that_are_imported(package, monkeypatch):
    """A helper beside the metric may have been edited, and the metric not."""
    module = package("HALF = 0.5\n")
    before = fingerprint(module.Metric())
    helper = Path(sys.modules[module.__name__.replace("metric", "helper")].__file__)
    monkeypatch.setattr(sources, "_content", lambda file: b"edited" if file == str(helper) else Path(file).read_bytes())
    assert fingerprint(module.Metric()) != before


def test_fingerprint_has_the_parts(package):
    """What another is wrapped around decides what it computes."""
    module = package("HALF = 0.5\n")
    assert fingerprint(module.Wrapped()) == fingerprint(module.Wrapped(module.Metric()))
    assert fingerprint(module.Wrapped()) != fingerprint(module.Wrapped(module.Metric(2.0)))


def test_fingerprint_of_what_holds_itself_ends(package):
    """A plugin may keep a way back to itself."""
    metric = package("HALF = 0.5\n").Metric()
    object.__setattr__(metric, "itself", metric)
    assert fingerprint(metric) == fingerprint(metric)


def test_digest_of_modules_follows_their_files(tmp_path, monkeypatch):
    """A package counts with all of its modules."""
    monkeypatch.syspath_prepend(tmp_path)
    digests = []
    for number in range(2):
        folder = tmp_path / f"code{number}"
        folder.mkdir()
        (folder / "__init__.py").write_text("")
        (folder / "part.py").write_text(f"NUMBER = {number}\n")
        digests.append(digest_of_modules([f"code{number}"]))
    assert len(set(digests)) == 2
