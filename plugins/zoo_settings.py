"""What RL Baselines3 Zoo keeps of a training's settings, in ``ENV/args.yml`` and ``ENV/config.yml`` beside its logs."""

import re
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from harness.files import read_bytes

PAIR = re.compile(r"^[ -]*- (?P<key>\w+)\n +- (?P<value>[^\n]+)$", re.MULTILINE)
"""A key and its value in an ordered mapping, as PyYAML writes it: a list of pairs. No other YAML is read, and none of
its tags is followed."""
PLAIN = re.compile(r"[\w'\"+-]")
"""What a value begins with that is a number or text; an object of the zoo's own classes begins with its tag."""
MOST_PLACES = 1000
"""What is looked at beside a log that does not tell its environment."""


class ZooSettings(NamedTuple):
    """The settings of a training, as far as its files tell them.

    Attributes:
        env: Id of the environment.
        algorithm: What learned.
        seed: Of the training.
        asked: Environment steps that it was to take; 0 if nobody said.
    """

    env: str = ""
    algorithm: str = ""
    seed: int | None = None
    asked: int = 0


def zoo_settings(log: Path, env: str = "") -> ZooSettings:
    """The settings of the training that wrote a log; empty where it was not the zoo's, or they cannot be read.

    Args:
        log: Its file.
        env: Id of its environment, if it is known.
    """
    try:
        place = log.parent
        inside = [place / env.replace("/", "-")] if env else islice(place.iterdir(), MOST_PLACES)
        [args] = [folder / "args.yml" for folder in inside if (folder / "args.yml").is_file()]
        told = _pairs(args)
        config = args.with_name("config.yml")
        tuned = _pairs(config) if config.is_file() else {}
    except (OSError, ValueError):
        return ZooSettings(env)
    asked = max(whole(told.get("n_timesteps", "")) or 0, 0) or whole(tuned.get("n_timesteps", "")) or 0
    return ZooSettings(env or args.parent.name, told.get("algo", ""), whole(told.get("seed", "")), asked)


def _pairs(path: Path) -> dict[str, str]:
    pairs = {found["key"]: found["value"] for found in PAIR.finditer(read_bytes(path).decode())}
    return {key: value.strip("'\"") for key, value in pairs.items() if PLAIN.match(value)}


def whole(text: str) -> int | None:
    """The whole number that a text is; None of another text."""
    try:
        number = float(text)
    except ValueError:
        return None
    return int(number) if number.is_integer() else None
