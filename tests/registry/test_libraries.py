"""What plugins need of libraries: modules, and the least version of some."""

import pytest

from harness.registry import spec
from harness.registry.spec import distribution_of, is_installed, is_met, module_of


@pytest.fixture
def versions(monkeypatch):
    """The versions of distributions, as if these and no others were installed."""
    told = {}
    monkeypatch.setattr(spec, "version_of", lambda name: told.get(name, ""))
    return told


def test_need_is_met_by_a_module_of_that_version_or_a_newer_one(versions, subtests):
    """Versions are compared number by number."""
    rows = [
        ("json", "", True),
        ("json>=3.17", "3.17", True),
        ("json>=3.17", "3.17.0rc1", True),
        ("json>=3.17.0", "3.17", True),
        ("json>=3.9", "3.17", True),
        ("json>=3.17", "3.9.9", False),
        ("json>=4", "3.17", False),
        ("json>=1", "", False),
        ("no_such_module>=1", "2", False),
        ("no_such_module", "2", False),
    ]
    for need, version, met in rows:
        with subtests.test(need=need, version=version, met=met):
            versions["json"] = versions["no-such-module"] = version
            assert is_met(need) is met


def test_what_is_no_need_is_refused(subtests):
    """The message shows one."""
    for need in ["mujoco==3.17", "mujoco >= 3.17", "mujoco>=", "mujoco>=3.x", "3d", ""]:
        with subtests.test(need=need), pytest.raises(ValueError, match=r"such as 'mujoco>=3.17'"):
            module_of(need)


def test_module_is_found_in_its_package():
    """Without importing either."""
    assert is_installed("os.path") is False, "a module that is none of a package's files"
    assert is_installed("importlib.metadata")
    assert not is_installed("importlib.no_such_module")


def test_module_in_a_package_is_of_its_own_distribution_where_there_is_one(monkeypatch):
    """``mujoco.mjx`` comes by ``mujoco-mjx``; a module that the package brings itself is the package's."""
    monkeypatch.setattr(spec, "version_of", lambda name: {"mujoco": "3.17", "mujoco-mjx": "3.17"}.get(name, ""))
    assert distribution_of("mujoco.mjx") == "mujoco-mjx"
    assert distribution_of("mujoco.rollout") == "mujoco"
