"""A player that speaks Unity's protocol, for each test its own; the tests need the extra ``unity``."""

import psutil
import pytest

from harness.registry.allowed import PROGRAMS, allow_programs

MARK = "HARNESS_TEST_OF_PLAYERS"
"""The environment variable with the folder of the test that started a process."""


@pytest.fixture(autouse=True)
def nothing_allowed(monkeypatch):
    """As where nobody named a program."""
    monkeypatch.setenv(PROGRAMS, "")


@pytest.fixture
def player(tmp_path, monkeypatch):
    """Writes a player with options, which the user named; no process of it may be left."""
    try:
        import harness_plugins.unity_player.connection  # noqa: F401
    except (ImportError, TypeError):  # not installed, or protobuf is too new: make unity
        pytest.skip("mlagents-envs and its protobuf are not installed here")
    from harness_plugins.kit.unity_player import write_unity_player

    monkeypatch.setenv(MARK, str(tmp_path))

    def write(*options, name="player"):
        path = write_unity_player(tmp_path / name, options)
        allow_programs([str(path)])
        return path

    yield write
    assert players_of(tmp_path) == []


def players_of(folder):
    """Players that a test started, by the mark that they inherit, and what guards them."""
    found = []
    for process in psutil.process_iter():
        try:
            words = process.cmdline()
            plays = "harness_plugins.kit.unity_player" in words or any(word.endswith("guard.py") for word in words)
            if plays and process.environ().get(MARK) == str(folder) and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process.pid)
        except psutil.Error:
            continue
    return found


@pytest.fixture
def start(player):
    """Starts a player with options, and returns envs of it; all are closed at the end."""
    from harness_plugins.environments.unity import Unity

    made = []

    def begin(*options, count=1, patience=10.0, **parameters):
        envs = Unity(file=str(player(*options)), patience=patience, **parameters).make_together(count)
        made.extend(envs)
        return envs[0] if count == 1 else envs

    yield begin
    for env in made:
        env.close()
