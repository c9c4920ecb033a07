"""Connects this process to a Ray cluster, for as long as it is needed."""

import logging
import math
import os
import secrets
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import Any, Final

import ray
from ray._private import ray_constants

from harness.errors import UsageError, one_line
from harness.experiment.workers.workers import core_count


@contextmanager
def set_variables(values: Mapping[str, str]) -> Iterator[None]:
    """Within the block the environment has these variables; afterwards it is as before."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


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


QUIET = {"RAY_USAGE_STATS_ENABLED": "0", "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0"}
"""Environment variables of Ray: nothing is reported to its makers, and no warning about a later change of defaults."""


@contextmanager
def connected(address: str, cpus: float | None, environment: Mapping[str, Any]) -> Iterator[None]:
    """Within the block this process belongs to a cluster.

    If it belonged to one before, that cluster is used, and the process stays in it.

    Args:
        address: As ``ray.init`` takes it; ``local`` starts a cluster of this machine, which ends with the block and
            which only this process reaches.
        cpus: CPUs that a new cluster offers; it offers those of the machine if they are more. None if a cluster exists.
        environment: Ray's runtime environment of what runs on the nodes.

    Raises:
        UsageError: There is no such cluster, or it does not fit this process.
    """
    if ray.is_initialized():
        yield
        return
    if address.startswith("ray://"):
        raise UsageError(f"address={address}: Ray clients are not supported, run harness on a node of the cluster")
    added = {name: value for name, value in QUIET.items() if name not in os.environ}
    cluster: AbstractContextManager[dict[str, Any]] = nullcontext({}) if cpus is None else own_cluster()
    with set_variables(added), cluster as own:
        try:
            ray.init(
                address=address,
                num_cpus=None if cpus is None else max(math.ceil(cpus), core_count()),
                **own,
                runtime_env=dict(environment) or None,
                log_to_driver=False,
                logging_level=logging.ERROR,
            )
        except (ConnectionError, RuntimeError, ValueError) as error:
            raise UsageError(
                f"No Ray cluster at address={address} can be joined: start one with 'ray start --head', add machines "
                f"with 'ray start --address=HOST:6379', set RAY_AUTH_MODE=token if it asks for one: {one_line(error)}"
            ) from error
        try:
            yield
        finally:
            ray.shutdown()
