"""Connects this process to a Ray cluster, for as long as it is needed."""

import logging
import math
import os
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Any

import ray

from harness.errors import UsageError, one_line
from harness.experiment.workers.workers import core_count

from .environment import set_variables
from .own_cluster import own_cluster

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
