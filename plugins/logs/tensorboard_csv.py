"""One curve as TensorBoard's page exports it: ``run-RUN-tag-TAG.csv`` with ``Wall time,Step,Value``."""

import re
from dataclasses import dataclass
from pathlib import Path

from harness.log import Log, LogFacts
from harness.log.text_table import header_of, read_table

from ..curves import CURVES, CurveSettings, curve_log

HEADER = ("Wall time", "Step", "Value")
FILE_NAME = re.compile(r"run[-_](?P<run>.+)-tag-(?P<tag>.+)\.csv")
SAMPLED = "TensorBoard exports a sample of at most 1,000 points, unless it was told otherwise"


@dataclass(frozen=True)
class TensorBoardCsv(CurveSettings):
    """One exported curve. Its name stands in the file's name alone: where it does not, say reward=Value, or success."""

    def recognises(self, path: Path, head: bytes) -> bool:
        """By its three columns."""
        return header_of(path, head) == HEADER

    def read(self, path: Path) -> tuple[Log, ...]:
        """The training whose curve it is.

        Raises:
            UsageError: Neither the file's name nor the user says of what the values are.
            SchemaError: It is damaged; names the line.
        """
        table = read_table(path)
        named = FILE_NAME.fullmatch(path.name)
        is_told = self.reward or self.success or self.length or self.measure
        tag = "" if is_told else _tag(named["tag"] if named else "")
        names = [tag] if tag else list(table.names)
        curve = self.chosen(path, names)
        facts = LogFacts(
            path=path,
            format="export of TensorBoard" + (f", names of {curve.program}" if curve.program else ""),
            run=named["run"] if named else "",
            thinned=SAMPLED,
            notes=table.notes,
        )
        columns = {curve.main: table.numbers("Value", may_lack=True), "step": table.numbers("Step")}
        return (curve_log(facts, curve, names, columns, self),)

    def write_example(self, folder: Path) -> Path:
        """Three points."""
        path = folder / "run-base_0-tag-rollout_ep_rew_mean.csv"
        rows = [",".join(HEADER), "1700000000.5,2048,-9.5", "1700000001.5,4096,-7.25", "1700000002.5,6144,-3.125"]
        path.write_text("\r\n".join(rows) + "\r\n", encoding="utf-8", newline="")
        return path


def _tag(written: str) -> str:
    """The tag that a file's name means, in which signs stand for others; empty if no table knows it."""
    known = [name for curve in CURVES for name in (curve.reward, *curve.success)]
    return next((name for name in known if _plain(name) == _plain(written)), "")


def _plain(name: str) -> str:
    return re.sub(r"[\W_]+", "_", name)
