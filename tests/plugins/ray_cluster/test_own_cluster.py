"""The Ray cluster that the executor starts for itself: who can reach it, and what it leaves."""

import ipaddress
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import psutil
import pytest
from packaging.requirements import Requirement

from tests.project import ROOT

ASK = "import sys, ray._raylet as raylet; print(raylet.GcsClient(sys.argv[1]).internal_kv_keys(b'', b'session', 10))"


@pytest.fixture(scope="module")
def ray():
    """Is an extra."""
    return pytest.importorskip("ray")


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A home folder without a token of Ray's."""
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("home")
        patch.setenv("HOME", str(folder))
        for name in ("RAY_AUTH_MODE", "RAY_AUTH_TOKEN", "RAY_AUTH_TOKEN_PATH"):
            patch.delenv(name, raising=False)
        yield folder


@pytest.fixture(scope="module")
def cluster(ray, home):
    """A cluster as the executor starts it, and where it is."""
    from harness_plugins.ray_cluster.connection import connected

    with connected("local", 1.0, {}):
        assert ray.get(ray.remote(lambda: {"pid": os.getpid()}).remote()) != {"pid": os.getpid()}
        yield ray._private.worker.global_worker.node.address_info


def _processes():
    """This one and all that it started."""
    return [psutil.Process(), *psutil.Process().children(recursive=True)]


def _ask(cluster, **token):
    """What somebody else on this machine gets who knows the cluster's address and asks for what it keeps."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("RAY_")}
    command = [sys.executable, "-c", ASK, cluster["gcs_address"]]
    return subprocess.run(
        command, env={**environment, **token}, capture_output=True, text=True, check=False, timeout=120
    )


def test_the_oldest_ray_that_may_be_installed_asks_for_a_token():
    """Before 2.52 whoever reached the cluster ran code in it."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    (needed,) = map(Requirement, extras["ray"])
    assert not any(needed.specifier.contains(version) for version in ("2.50.0", "2.51.2"))
    assert needed.specifier.contains("2.52.0")


def test_the_locked_ray_asks_for_a_token():
    """The lock may hold no older one than pyproject.toml says."""
    major, minor = re.search(r"^ray==(\d+)\.(\d+)", (ROOT / "requirements/dev.txt").read_text(), re.MULTILINE).groups()
    assert (int(major), int(minor)) >= (2, 52)


def test_every_cluster_has_another_token(ray):
    """One that leaked is worth nothing for the next."""
    from harness_plugins.ray_cluster.connection import own_cluster

    tokens = set()
    for _ in range(2):
        with own_cluster():
            tokens.add(os.environ["RAY_AUTH_TOKEN"])
    assert len(tokens) == 2
    assert all(re.fullmatch("[0-9a-f]{64}", token) for token in tokens)


def test_the_environment_is_afterwards_as_before(ray, monkeypatch):
    """What the user had set for another cluster holds again."""
    from harness_plugins.ray_cluster.connection import own_cluster

    monkeypatch.setenv("RAY_AUTH_TOKEN", "mine")
    monkeypatch.delenv("RAY_AUTH_MODE", raising=False)
    before, reached = dict(os.environ), ray._private.ray_constants.ENABLE_RAY_CLUSTER
    with own_cluster():
        assert os.environ["RAY_AUTH_TOKEN"] != "mine"
        assert not ray._private.ray_constants.ENABLE_RAY_CLUSTER
    assert dict(os.environ) == before
    assert ray._private.ray_constants.ENABLE_RAY_CLUSTER is reached


def test_a_word_against_tokens_is_for_other_clusters(ray, monkeypatch):
    """RAY_AUTH_MODE=disabled in the environment does not open ours."""
    from ray._raylet import AuthenticationMode, get_authentication_mode

    from harness_plugins.ray_cluster.connection import own_cluster

    monkeypatch.setenv("RAY_AUTH_MODE", "disabled")
    with own_cluster():
        assert get_authentication_mode() == AuthenticationMode.TOKEN
    assert get_authentication_mode() == AuthenticationMode.DISABLED


def test_nothing_is_left_of_the_folder(ray):
    """It is the user's alone as long as it is there."""
    from harness_plugins.ray_cluster.connection import own_cluster

    with own_cluster() as arguments:
        place = Path(arguments["_temp_dir"]).parent
        assert place.stat().st_mode & 0o777 == 0o700
    assert not place.exists()


@pytest.mark.slow
def test_it_listens_on_the_loopback_address_alone(cluster):
    """Each port of each process: gcs_server, raylet, agents, workers and this one."""
    heard = [(process.name(), connection.laddr.ip) for process in _processes()
             for connection in process.net_connections("inet") if connection.status == psutil.CONN_LISTEN]  # fmt: skip
    assert len(heard) >= 5
    assert [(name, ip) for name, ip in heard if not ipaddress.ip_address(ip.removeprefix("::ffff:")).is_loopback] == []


@pytest.mark.slow
@pytest.mark.parametrize("token", [{}, {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": "0" * 64}], ids=["none", "wrong"])
def test_without_its_token_nobody_is_answered(cluster, token):
    """On this machine, where others reach the loopback address."""
    asked = _ask(cluster, **token)
    assert asked.returncode
    assert "AuthenticationError" in asked.stderr


@pytest.mark.slow
def test_with_its_token_everybody_is_answered(cluster):
    """So the token alone keeps the others out."""
    asked = _ask(cluster, RAY_AUTH_MODE="token", RAY_AUTH_TOKEN=os.environ["RAY_AUTH_TOKEN"])
    assert "session_name" in asked.stdout, asked.stderr


@pytest.mark.slow
def test_its_token_is_in_no_file_and_in_no_command_line(cluster, home):
    """Others read the command lines of all processes, and Ray's own token is written for all to read."""
    token = os.environ["RAY_AUTH_TOKEN"]
    files = [path for folder in (home, Path(cluster["session_dir"])) for path in folder.rglob("*") if path.is_file()]
    assert files
    assert not [path for path in files if token.encode() in path.read_bytes()]
    assert not [process for process in _processes() if token in " ".join(process.cmdline())]


@pytest.mark.slow
def test_its_sockets_are_in_a_folder_of_the_user(cluster):
    """Ray lets everybody write into the folders that it makes: the one around them keeps others out."""
    around = [folder for folder in Path(cluster["object_store_address"]).parents if folder.parent == Path("/tmp")]
    assert [folder.stat().st_mode & 0o777 for folder in around] == [0o700]
