"""The locks in requirements/ fit pyproject.toml, constraints.txt and what is installed; no index is asked."""

import re
import sysconfig
import tomllib
from dataclasses import dataclass, replace
from functools import cache
from importlib import metadata
from itertools import product

import pytest
from packaging.markers import Marker, default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

from tests.project import ROOT

SYSTEMS = [
    {"os_name": "posix", "sys_platform": "linux", "platform_system": "Linux", "platform_machine": "x86_64"},
    {"os_name": "posix", "sys_platform": "linux", "platform_system": "Linux", "platform_machine": "aarch64"},
    {"os_name": "posix", "sys_platform": "darwin", "platform_system": "Darwin", "platform_machine": "arm64"},
    {"os_name": "nt", "sys_platform": "win32", "platform_system": "Windows", "platform_machine": "AMD64"},
]
PLATFORMS = [
    {**system, "python_version": python, "python_full_version": f"{python}.0"}
    for system, python in product(SYSTEMS, ("3.11", "3.14"))
]
PACKAGE = re.compile(
    r"(?P<name>\S+?)==(?P<version>\S+)(?: ; (?P<marker>.+?))?(?P<hashes>( +--hash=sha256:[0-9a-f]{64})+)"
)


@dataclass(frozen=True)
class Package:
    """One package of a lock."""

    version: Version
    marker: Marker | None
    hashes: frozenset[str]

    def stands_on(self, platform):
        """Whether pip installs it there."""
        return self.marker is None or self.marker.evaluate(platform)


@dataclass(frozen=True)
class Files:
    """What a lock is made from, and the lock."""

    lock: str
    project: dict
    extras: list[str]
    pins: str


def read_lock(text):
    """The packages of a lock by name, and the lines that are no package with a version and hashes, or a second one."""
    packages, strange = {}, []
    for line in re.sub(r"\\\n", "", re.sub(r"^ *#.*\n?", "", text, flags=re.MULTILINE)).splitlines():
        if not line.strip():
            continue
        found = PACKAGE.fullmatch(line.strip())
        if not found or found["name"] in packages:
            strange.append(line[:60])
            continue
        marker = Marker(found["marker"]) if found["marker"] else None
        packages[found["name"]] = Package(Version(found["version"]), marker, frozenset(found["hashes"].split()))
    return packages, strange


def read_requirements(text):
    """The requirements of a file by name, without its comments."""
    lines = [line.partition("#")[0].strip() for line in text.splitlines()]
    return {canonicalize_name(Requirement(line).name): Requirement(line) for line in lines if line}


@cache
def needs_of(name):
    """What an installed package says that it needs; nothing where it is not installed, as another platform's are."""
    found = _installed(name)
    return [] if found is None else [Requirement(line) for line in found.requires or []]


def version_of(name):
    """The installed version without its build, as the +cpu of torch is; None if there is none."""
    found = _installed(name)
    return None if found is None else Version(Version(found.version).public)


def _installed(name):
    """A package where pip installs; Ray brings some of its own, and puts them on Python's path when it is imported."""
    places = [sysconfig.get_path("purelib"), sysconfig.get_path("platlib")]
    return next(iter(metadata.distributions(name=name, path=places)), None)


def needed_on(platform, project, extras):
    """What has to be there on a platform: who asks for it and how, by name, without what torch's build decides."""
    groups = project["project"]["optional-dependencies"] | project["dependency-groups"]
    lines = [*project["project"]["dependencies"], *project["build-system"]["requires"]]
    lines += [line for extra in extras for line in groups[extra]]
    left_out = read_requirements((ROOT / "requirements/cuda.txt").read_text())
    to_visit, needed = [("pyproject.toml", Requirement(line), "") for line in lines], {}
    visited = set()
    while to_visit:
        asker, requirement, extra = to_visit.pop()
        name = canonicalize_name(requirement.name)
        holds = requirement.marker is None or requirement.marker.evaluate({**platform, "extra": extra})
        if not holds or name in left_out:
            continue
        needed.setdefault(name, set()).add((asker, requirement))
        for wanted in {"", *requirement.extras} - {wanted for seen, wanted in visited if seen == name}:
            visited.add((name, wanted))
            to_visit += [(name, need, wanted) for need in needs_of(name)]
    return needed


def find_faults(files):
    """What is wrong with a lock, in one sentence each."""
    lock, strange = read_lock(files.lock)
    pins = read_requirements(files.pins)
    faults = {f"no exact version with hashes, or a second one: {line}" for line in strange}
    for platform in PLATFORMS:
        needed = needed_on(platform, files.project, files.extras)
        there = {name for name, package in lock.items() if package.stands_on(platform)}
        faults |= {f"{name} is missing" for name in needed.keys() - there - {"torch"}}
        faults |= {f"nobody needs {name}" for name in there - needed.keys()}
        for name in needed.keys() & there:
            faults |= {
                f"{asker} needs {requirement}"
                for asker, requirement in needed[name]
                if not requirement.specifier.contains(lock[name].version, prereleases=True)
            }
    faults |= {
        f"constraints.txt has {pin}"
        for name, pin in pins.items()
        if name in lock and not pin.specifier.contains(lock[name].version, prereleases=True)
    }
    faults |= {
        f"{version_of(name)} of {name} is installed"
        for name, package in lock.items()
        if package.stands_on(default_environment()) and version_of(name) != package.version
    }
    return sorted(faults)


def _files(lock, kind):
    """The committed ones, of the extras and groups that the Makefile names."""
    makefile = (ROOT / "Makefile").read_text()
    return Files(
        lock=(ROOT / "requirements" / lock).read_text(),
        project=tomllib.loads((ROOT / "pyproject.toml").read_text()),
        extras=" ".join(re.findall(rf"^{kind}_(?:EXTRAS|GROUPS) := (.*)$", makefile, re.MULTILINE)).split(),
        pins=(ROOT / "constraints.txt").read_text(),
    )


@pytest.fixture(scope="module")
def dev():
    """What make dev installs."""
    return _files("dev.txt", "DEV")


@pytest.fixture(scope="module")
def run():
    """What make install installs."""
    return _files("run.txt", "RUN")


def _with_dependency(files, line):
    """The same project with one more dependency."""
    table = files.project["project"]
    return replace(
        files, project={**files.project, "project": {**table, "dependencies": [*table["dependencies"], line]}}
    )


def _without(files, name):
    """The same lock less a package."""
    lock, count = re.subn(rf"^{name}==.*\n(?: +--hash.*\n)+", "", files.lock, flags=re.MULTILINE)
    assert count == 1
    return replace(files, lock=lock)


def test_lock_of_all_extras_is_current(dev):
    """It has all that is needed in versions that fit, nothing else, and what is installed is just that: make dev."""
    assert find_faults(dev) == []


def test_lock_of_users_is_current(run):
    """The same of the fewer extras of make install."""
    assert find_faults(run) == []


def test_locks_agree(run, dev):
    """What users install, they install as tests saw it: each package of the small lock stands so in the large one."""
    small, large = (read_lock(files.lock)[0] for files in (run, dev))
    assert {name: (large[name].version, large[name].hashes) for name in small} == {
        name: (package.version, package.hashes) for name, package in small.items()
    }


def test_pins_are_of_locked_packages(dev):
    """A line of constraints.txt that pins nothing is a mistake; torch stands outside, in the pinned version."""
    assert read_requirements(dev.pins).keys() - read_lock(dev.lock)[0].keys() == {"torch"}
    assert read_requirements(dev.pins)["torch"].specifier.contains(version_of("torch"))


def test_dependabot_leaves_the_pins_alone(dev):
    """Who takes one up looks at the results first."""
    ignored = re.findall(r"dependency-name: (\S+)", (ROOT / ".github/dependabot.yml").read_text())
    assert set(ignored) == read_requirements(dev.pins).keys()


def test_another_version_is_found(dev):
    """The lock has another one than is installed."""
    mutant = replace(dev, lock=re.sub(r"^jinja2==\S+", "jinja2==3.99", dev.lock, flags=re.MULTILINE))
    assert find_faults(mutant) == [f"{version_of('jinja2')} of jinja2 is installed"]


@pytest.mark.parametrize("name", ["jinja2", "sympy", "colorama", "setuptools"])
def test_missing_package_is_found(dev, name):
    """One that the project names, one that only torch needs, one of Windows alone, and what builds the project."""
    assert find_faults(_without(dev, name)) == [f"{name} is missing"]


def test_new_dependency_is_found(dev):
    """One that no lock has yet."""
    assert find_faults(_with_dependency(dev, "flask>=3")) == ["flask is missing"]


def test_dependency_of_another_platform_is_found(dev):
    """It would be missed only there."""
    assert find_faults(_with_dependency(dev, "pywin32; sys_platform == 'win32'")) == ["pywin32 is missing"]


def test_new_extra_is_found(dev):
    """One that make installs and the lock was not made for."""
    faults = find_faults(replace(dev, extras=[*dev.extras, "peers"]))
    assert faults == ["gymnasium-robotics is missing", "panda-gym is missing"]


def test_narrower_range_is_found(dev):
    """Of the project, which the locked version does not fit."""
    assert find_faults(_with_dependency(dev, "rich>=99")) == ["pyproject.toml needs rich>=99"]


def test_needless_package_is_found(dev):
    """One that stayed when the last who needed it went."""
    mutant = replace(dev, lock=dev.lock + f"left-over==1.0 ; sys_platform == 'win32' --hash=sha256:{'0' * 64}\n")
    assert find_faults(mutant) == ["nobody needs left-over"]


def test_missing_marker_is_found(dev):
    """A package of Windows alone that everybody would install."""
    mutant = replace(dev, lock=re.sub(r"^(colorama==\S+) ; [^\\]*", r"\1 ", dev.lock, flags=re.MULTILINE))
    assert find_faults(mutant) == ["None of colorama is installed", "nobody needs colorama"]


def test_missing_hashes_are_found(dev):
    """Otherwise pip refuses the lock, when somebody installs it."""
    mutant = replace(dev, lock=re.sub(r"^(jinja2==\S+).*\n(?: +--hash.*\n)+", r"\1\n", dev.lock, flags=re.MULTILINE))
    assert find_faults(mutant) == [
        "jinja2 is missing",
        f"no exact version with hashes, or a second one: jinja2=={version_of('jinja2')}",
    ]


def test_second_version_is_found(dev):
    """One package, one version, for every Python."""
    assert len(find_faults(replace(dev, lock=dev.lock + f"jinja2==3.0 --hash=sha256:{'0' * 64}\n"))) == 1


def test_other_pin_is_found(dev):
    """constraints.txt and the lock name two versions."""
    mutant = replace(dev, pins=dev.pins.replace("rich==", "rich==99."))
    assert [fault.partition("==")[0] for fault in find_faults(mutant)] == ["constraints.txt has rich"]
