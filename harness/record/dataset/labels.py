"""Whether an episode succeeded: true, false, or not known. A probability is no label until a user says from where on.

Labels are false and true, 0 and 1. NaN and -1 are what people write for "nobody looked": not known. Everything else
needs a threshold, ``KEY>0.5``.
"""

import math
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.errors import SchemaError, UsageError
from harness.log.text_table import parse_table, read_text
from harness.text import shortened

UNKNOWN, FAILURE, SUCCESS = -1, 0, 1
WHOLE = -1
"""In place of the number of an episode, of a label that a training has as a whole."""
_RULE = re.compile(r"\s*(?P<key>[^<>=]+?)\s*(?:(?P<sign>>=|<=|>|<)\s*(?P<number>[^<>=\s]+)\s*)?")
_COMPARE = {">": np.greater, ">=": np.greater_equal, "<": np.less, "<=": np.less_equal}
_TRUTH, _UNTOLD = {"true": "1", "false": "0"}, ("", "none", "null")


@dataclass(frozen=True)
class SuccessRule:
    """Where success stands, and from where on a number is one.

    Attributes:
        key: The key or column; empty where it is found by its name.
        sign: ``>``, ``>=``, ``<`` or ``<=``; empty where it holds labels.
        threshold: What the sign compares with.
    """

    key: str = ""
    sign: str = ""
    threshold: float = 0.0

    @property
    def text(self) -> str:
        """What a user types for it."""
        return f"{self.key}{self.sign}{self.threshold:g}" if self.sign else self.key

    def of_steps(self, values: NDArray[Any], noun: str) -> NDArray[np.int8]:
        """`SUCCESS`, `FAILURE` or `UNKNOWN` of each step, (steps,).

        Args:
            values: What stands there, (steps,) or (steps, 1).
            noun: What a message calls it.

        Raises:
            UsageError: It is neither a label nor is there a threshold.
        """
        if values.dtype.kind not in "biuf":
            raise UsageError(f"{noun} holds {values.dtype}, no labels: 0, 1, false and true are")
        if values.size != len(values):
            raise UsageError(
                f"{noun} holds {values.size // len(values):,} numbers a step, no label: name another key with --success"
            )
        flat = np.asarray(values, np.float64).ravel()
        known = ~np.isnan(flat)
        told: NDArray[np.int8] = np.full(len(flat), UNKNOWN, np.int8)
        if self.sign:
            told[known] = _COMPARE[self.sign](flat[known], self.threshold)
            return told
        known &= flat != UNKNOWN
        odd = flat[known & (flat != FAILURE) & (flat != SUCCESS)]
        if len(odd):
            raise UsageError(
                f"{noun} holds {odd[0]:g}, which is no label: 0, 1, false and true are, NaN and -1 are not known. Say "
                f"from where on it is a success: --success '{self.key}>0.5'"
            )
        told[known] = flat[known]
        return told

    def of_episode(self, value: Any, noun: str) -> int:
        """The same of one value that holds for a whole episode; text and None as they stand in JSON and CSV."""
        if isinstance(value, bytes):
            value = value.decode(errors="replace")
        if isinstance(value, str):
            text = value.strip().lower()
            try:
                value = None if text in _UNTOLD else float(_TRUTH.get(text, text) if not self.sign else text)
            except ValueError:
                raise UsageError(f"{noun} says {shortened(value, 40)!r}: 0, 1, false and true are labels") from None
        numbers = np.asarray([] if value is None else value).ravel()
        if len(numbers) > 1:
            raise UsageError(f"{noun} holds {len(numbers):,} values, no label: name another key with --success")
        return int(self.of_steps(numbers, noun)[0]) if len(numbers) else UNKNOWN


def parse_success(text: str) -> SuccessRule:
    """What ``--success`` says: ``KEY``, ``KEY>0.5``, also with ``>=``, ``<`` or ``<=``.

    Raises:
        UsageError: It is neither.
    """
    if not text:
        return SuccessRule()
    found, threshold = _RULE.fullmatch(text), math.nan
    with suppress(ValueError):
        threshold = float(found["number"] or 0.0) if found else threshold
    if found is None or not math.isfinite(threshold):
        raise UsageError(f"--success {text}: write KEY, or KEY>0.5 with a number; >, >=, < and <= are allowed")
    return SuccessRule(found["key"], found["sign"] or "", threshold)


def read_labels(path: Path, rule: SuccessRule, runs: int = 0) -> dict[str, dict[int, int]]:
    """By run and number of the episode, its label: a table with the columns ``episode`` and ``success``, or ``run``.

    Args:
        path: The file.
        rule: Names another column than ``success``, or a threshold.
        runs: How many trainings the column ``run`` may name; 0: it is not read, and the name of the run is empty. It
            may be left out where there is one. Where it is there, ``episode`` may be: then `WHOLE` is the number.

    Raises:
        UsageError: It is not there or has other columns; a line has no number, no label, or contradicts another.
    """
    key = rule.key or "success"
    known = {"episode": "episode", "episode_index": "episode", key.lower(): key}
    try:
        table = parse_table(path, f"{read_text(path).rstrip()}\n")
    except SchemaError as error:
        raise UsageError(f"--labels {error}") from None
    spelled = [name if name == key else known.get(name.lower(), name) for name in table.names]
    needed = ("run" if runs > 1 or (runs and "run" in spelled) else "episode", key)
    if any(spelled.count(name) != 1 for name in needed) or spelled.count("episode") > 1:
        raise UsageError(
            f"--labels {path} has the columns {shortened(', '.join(table.names), 100)}; it needs "
            f"{' and '.join(needed)} once each, and a line for each {needed[0]}"
        )
    cells = dict(zip(spelled, table.cells.values(), strict=True))
    labels: dict[str, dict[int, int]] = {}
    for row, (line, value) in enumerate(zip(table.lines, cells[key], strict=True)):
        where = f"--labels {path}, line {line}"
        run, number = cells["run"][row].strip() if "run" in needed else "", str(WHOLE)
        if "episode" in cells:
            number = cells["episode"][row].strip().removesuffix(".0")
            if not re.fullmatch(r"\d{1,9}", number):
                raise UsageError(f"{where}: {shortened(number, 40)!r} is no number of an episode, counted from 0")
        label = rule.of_episode(value, where)
        if labels.setdefault(run, {}).setdefault(int(number), label) != label:
            told = f"'{run}'" if run else f"episode {number}"
            raise UsageError(f"{where}: {told} has another label above")
    return labels
