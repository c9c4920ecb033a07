"""Every check of description formats has a broken reader that fails it."""

import itertools
from dataclasses import dataclass
from pathlib import Path

import pytest

from harness.errors import SchemaError, UsageError
from harness.registry.allowed import PROGRAMS
from harness.robot.description import Description
from harness_plugins.kit import DESCRIPTION_CHECKS, check_description_format, descriptions, violations

FIRST = "chain"
LAST = "end"


class Chain:
    """Reads lines with the names of joints, each 0.3 m above the one before."""

    def recognises(self, path, head):
        return head.startswith(FIRST.encode())

    def read(self, path, arguments, packages):
        first, *names, last = path.read_text().split()
        if arguments or (first, last) != (FIRST, LAST):
            raise UsageError(f"{path}: no chain of joints, or {sorted(arguments)}, which it does not take")
        return self.describe(names)

    def describe(self, names):
        links = ["base", *(f"{name}_link" for name in names)]
        joints = "".join(
            f'<joint name="{name}" type="continuous"><origin xyz="0 0 0.3"/><axis xyz="0 {y} {1 - y}"/>'
            f'<limit velocity="1"/><parent link="{links[place]}"/><child link="{links[place + 1]}"/></joint>'
            for place, (name, y) in enumerate(zip(names, itertools.cycle((0, 1)), strict=False))
        )
        urdf = f'<robot name="chain">{"".join(f"<link name={name!r}/>" for name in links)}{joints}</robot>'
        return Description(urdf, tip=links[-1], home={names[0]: 0.5}, home_origin="the chain's own")

    def write_example(self, folder):
        path = folder / "arm.chain"
        path.write_text(f"{FIRST} one two three {LAST}")
        return path


@dataclass(frozen=True)
class Sound(Chain):
    """Keeps the contract."""


@dataclass
class Thawed(Chain):
    """Is not frozen."""


@dataclass(frozen=True)
class SetUpWithASet(Chain):
    """Has a setting that JSON does not have."""

    names: frozenset[str] = frozenset({"a"})


@dataclass(frozen=True)
class KnowsNothing(Chain):
    """Does not recognise its own files."""

    def recognises(self, path, head):
        return False


@dataclass(frozen=True)
class TakesAll(Chain):
    """Recognises a URDF too."""

    def recognises(self, path, head):
        return True


@dataclass(frozen=True)
class MakesNoUrdf(Chain):
    """Gives another text."""

    def describe(self, names):
        return Description(" ".join(names))


@dataclass(frozen=True)
class StandsStill(Chain):
    """Gives a URDF in which nothing moves."""

    def describe(self, names):
        return Description('<robot name="chain"><link name="base"/></robot>')


@dataclass(frozen=True)
class NamesNoLink(Chain):
    """Has a tip that is nowhere."""

    def describe(self, names):
        return Description(super().describe(names).urdf, tip="tool")


@dataclass(frozen=True)
class RestsElsewhere(Chain):
    """Has a resting pose of other joints."""

    def describe(self, names):
        return Description(super().describe(names).urdf, home={"wrist": 0.0}, home_origin="the chain's own")


@dataclass(frozen=True)
class SaysNoOrigin(Chain):
    """Does not say where its resting pose stands."""

    def describe(self, names):
        return Description(super().describe(names).urdf, home={names[0]: 0.0})


COUNT = itertools.count()


@dataclass(frozen=True)
class Counts(Chain):
    """Gives another robot each time."""

    def describe(self, names):
        return super().describe([f"{name}{next(COUNT)}" for name in names])


@dataclass(frozen=True)
class TakesDamage(Chain):
    """Reads on where a file ends early."""

    def read(self, path, arguments, packages):
        if arguments:
            raise UsageError("none")
        return self.describe(["one", "two", "three"])


@dataclass(frozen=True)
class BlamesTheFile(Chain):
    """Refuses damage with another error."""

    def read(self, path, arguments, packages):
        try:
            return super().read(path, arguments, packages)
        except UsageError as error:
            raise SchemaError(str(error)) from error


@dataclass(frozen=True)
class TakesAnyArgument(Chain):
    """Lets slips through."""

    def read(self, path, arguments, packages):
        return super().read(path, {}, packages)


@dataclass(frozen=True)
class Writes(Chain):
    """Leaves a file beside the arm."""

    def read(self, path, arguments, packages):
        (path.parent / "arm.urdf").write_text("")
        return super().read(path, arguments, packages)


MUTANTS = {
    Thawed: descriptions.settings_are_frozen,
    SetUpWithASet: descriptions.settings_survive_json,
    KnowsNothing: descriptions.its_own_files_are_recognised,
    TakesAll: descriptions.its_own_files_are_recognised,
    MakesNoUrdf: descriptions.a_urdf_comes_of_it,
    StandsStill: descriptions.a_urdf_comes_of_it,
    NamesNoLink: descriptions.names_are_those_of_the_urdf,
    RestsElsewhere: descriptions.names_are_those_of_the_urdf,
    SaysNoOrigin: descriptions.names_are_those_of_the_urdf,
    Counts: descriptions.reading_twice_is_the_same,
    TakesDamage: descriptions.damage_is_refused,
    BlamesTheFile: descriptions.damage_is_refused,
    TakesAnyArgument: descriptions.unknown_arguments_are_refused,
    Writes: descriptions.nothing_is_written,
}


@pytest.fixture(autouse=True)
def programs(monkeypatch: pytest.MonkeyPatch):
    """What the kit lets be read is forgotten."""
    monkeypatch.setenv(PROGRAMS, "")


def test_a_sound_format_keeps_the_contract():
    """What the broken ones are made of."""
    check_description_format(Sound())


@pytest.mark.parametrize("broken", MUTANTS, ids=lambda broken: broken.__name__)
def test_broken_format_fails_its_check(tmp_path: Path, broken: type[Chain]):
    """By name."""
    failed = set()
    for check in DESCRIPTION_CHECKS:
        (own := tmp_path / check.name).mkdir()
        failed |= {each.check for each in violations([check], broken(), own)}
    assert MUTANTS[broken].name in failed
