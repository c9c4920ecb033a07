"""The folder that jobs are unpickled from: it is the user's, and nobody else writes there."""

import os
import stat
from pathlib import Path

import pytest

from harness_plugins.slurm_array.cluster import private_folder
from tests.refusals import refused

WHERE = Path("fd100-harness/jobs")


@pytest.fixture(autouse=True)
def state(tmp_path, monkeypatch):
    """A folder in place of the user's own."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path / "state"


def test_the_folder_is_made_for_the_user_alone(state):
    """Whatever the umask."""
    before = os.umask(0)
    try:
        made = private_folder()
    finally:
        os.umask(before)
    assert made == state / WHERE
    assert stat.S_IMODE(made.stat().st_mode) == 0o700


def test_without_a_variable_it_is_under_the_home_folder(tmp_path, monkeypatch):
    """Which the nodes of a cluster share."""
    monkeypatch.delenv("XDG_STATE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert private_folder() == tmp_path / ".local/state" / WHERE


def test_a_relative_variable_is_ignored(tmp_path, monkeypatch):
    """As the XDG standard says; jobs run in other folders."""
    monkeypatch.setenv("XDG_STATE_HOME", "state")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert private_folder() == tmp_path / ".local/state" / WHERE


@pytest.mark.parametrize("mode", [0o770, 0o707, 0o755, 0o710])
def test_a_folder_that_is_open_to_others_is_refused(mode):
    """One line says what to type."""
    private_folder().chmod(mode)
    with refused(r"is open to others\. .*: chmod 700 it"):
        private_folder()


def test_a_folder_of_another_user_is_refused(monkeypatch):
    """Its owner may write there whatever its mode."""
    private_folder()
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    with refused("is another user's"):
        private_folder()


def test_a_link_is_refused(state, tmp_path):
    """It may lead into a folder of others, and may be changed to do so."""
    private_folder().rmdir()
    (tmp_path / "elsewhere").mkdir(mode=0o700)
    (state / WHERE).symlink_to(tmp_path / "elsewhere")
    with refused("is a link"):
        private_folder()


def test_a_folder_whose_place_everybody_can_take_is_refused(state):
    """Renamed, and another one put there."""
    private_folder()
    state.chmod(0o777)
    with refused("state is open to everybody"):
        private_folder()


def test_a_folder_under_that_for_temporary_files_is_taken(state):
    """Everybody writes there, but renames only what is theirs."""
    private_folder()
    state.chmod(0o1777)
    assert private_folder() == state / WHERE


def test_a_folder_that_cannot_be_made_is_refused(state):
    """One line says what to set."""
    state.write_text("")
    with refused("Set XDG_STATE_HOME to a folder of yours that all nodes see"):
        private_folder()
