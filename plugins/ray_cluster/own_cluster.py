"""A Ray cluster that this process starts for itself: who can reach it, and where its files lie."""

import secrets
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import ray
from ray._private import ray_constants

from .environment import set_variables

SHORT: Final = Path("/tmp")
"""Where Ray's files are put if it is there: the names of its sockets have to be short."""


@contextmanager
def own_cluster() -> Iterator[dict[str, Any]]:
    """Within the block this process can start a cluster that nobody else reaches; yields arguments for `ray.init`.

    The cluster listens on the loopback address alone, whatever addresses this machine has: Ray's own variable says so,
    by which it does the same on macOS and Windows. It asks for a token, which is random, and is known to this process
    and those that it starts: without one in the environment Ray writes one into a file. Its sockets and files are in a
    folder of the user, because Ray lets everybody write into those that it makes. The folder is removed afterwards.
    """
    private = {
        "RAY_AUTH_MODE": "token",
        "RAY_AUTH_TOKEN": secrets.token_hex(32),
        ray_constants.ENABLE_RAY_CLUSTERS_ENV_VAR: "0",
    }
    place = Path(tempfile.mkdtemp(prefix="ray-", dir=SHORT if SHORT.is_dir() else None))  # for the user alone
    try:
        with set_variables(private):
            _read_variables()
            yield {"_temp_dir": str(place / "files"), "include_dashboard": False, "dashboard_host": "127.0.0.1"}
    finally:
        _read_variables()
        shutil.rmtree(place, ignore_errors=True)  # a process that is being ended may still write there


def _read_variables() -> None:
    """Have Ray look at the environment again: it keeps what it read when it was imported or last connected."""
    ray._raylet.Config.initialize("")
    ray._raylet.AuthenticationTokenLoader.instance().reset_cache()
    ray_constants.ENABLE_RAY_CLUSTER = ray_constants.env_bool(
        ray_constants.ENABLE_RAY_CLUSTERS_ENV_VAR, not ray_constants.IS_WINDOWS_OR_OSX
    )
