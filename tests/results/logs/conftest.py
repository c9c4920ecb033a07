import json
import re

import pytest

from harness.log.open_log import find_logs
from harness.results.logs.trainings import sort_logs
from tests.registered import REGISTRY


@pytest.fixture
def monitor(tmp_path):
    """Writes a file as stable-baselines3's Monitor does: the name below the folder, then a number an episode."""

    def write(
        name,
        returns=(1.0, 2.0, 4.0),
        *,
        lengths=(),
        success=(),
        started=1.7e9,
        env="Toy-v0",
        at=(),
    ):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        steps = lengths or [10] * len(returns)
        ends = at or [number + 0.5 for number in range(len(steps))]
        rows = [f"{pay},{length},{end}" for pay, length, end in zip(returns, steps, ends, strict=True)]
        if success:
            rows = [f"{row},{flag}" for row, flag in zip(rows, success, strict=True)]
        head = "r,l,t" + ",is_success" * bool(success)
        path.write_text("\n".join([f"#{json.dumps({'t_start': started, 'env_id': env})}", head, *rows]) + "\n")
        return path

    return write


def sorts_of(asked):
    """The templates that a refusal says can be typed."""
    return re.findall("--sort '([^']*)'", str(asked))


@pytest.fixture
def sort(tmp_path):
    """Sorts all logs of the folder."""
    return lambda *given, **more: sort_logs(tmp_path, find_logs(tmp_path, REGISTRY).logs, *given, **more)
