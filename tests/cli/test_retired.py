"""Old names: they work, say the new one, and no help shows them."""

import re

import pytest

from harness.cli.retired import TRACKERS

OLD = ("repair", *(f"--{name}" for name in TRACKERS))


def test_repair_is_verify_with_repair(harness, finished):
    """The same on standard output, and one line on standard error."""
    folder = finished(seeds=1)
    old = harness("repair", folder)
    assert old[:2] == harness("verify", folder, "--repair")[:2]
    assert old.err.startswith("harness: harness repair is now harness verify --repair. ")
    assert old.err.count("\n") == 1


@pytest.mark.parametrize("name", TRACKERS)
def test_flag_of_a_tracker_is_tracker(harness, quick, monkeypatch, name):
    """It asks for the same tracker, which is missing here, after a line that says the new form."""
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    old, new = harness("run", *quick, f"--{name}"), harness("run", *quick, "--tracker", name)
    line = f"harness: --{name} is now --tracker {name}. The old form works in this version only\n"
    assert (old.status, old.err) == (2, line + new.err)
    assert name in new.err


@pytest.mark.parametrize("asked", [("--all",), ("run", "--help"), ("run", "--help-all")])
def test_no_help_shows_old_names(harness, asked):
    """Neither as a command nor as an option."""
    shown = re.findall(r"^  (\S+)", harness(*asked).out, re.MULTILINE)
    assert not {*shown} & {*OLD}
