"""An alarm before a training, held against what trainings did: ``python experiments/cheats/alarms.py``.

Asks ``harness audit`` of every reward that a committed record has trained, and writes
``results/reference/cheats/cheats.csv``: what it said, and how often the trained robots succeeded.
"""

import csv
import json
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from statistics import mean
from typing import Any, TypeAlias

ROOT = Path(__file__).parents[2]
REFERENCE = ROOT / "results" / "reference"
RECORD = REFERENCE / "cheats" / "cheats.csv"
STUDIES: Mapping[str, Sequence[str]] = {
    "race/arm": ("fd100-small-target:epsilon=0.025",),
    "fd100": ("fd100-reach",),
    "arp-2021": ("arp-2021",),
    "race/pendulum": ("gymnasium:id=Pendulum-v1", "experiments/race/pendulum"),
    "cheats/reacher": ("gymnasium:id=Reacher-v5", "experiments/cheats/reacher"),
    "cheats/cartpole": ("gymnasium:id=CartPole-v1", "experiments/cheats/cartpole"),
}
"""By the folder of its record: what is audited, and where its plugin files lie."""
WORSE = 0.1
"""By so much less success than the best reward of its record a reward counts as worse."""
ALARMS = ("PAYS FOR FAILING", "PAYS FOR LOITERING")
Row: TypeAlias = Mapping[str, Any]


def successes(study: str) -> dict[str, list[float]]:
    """By reward, the success of each training of a record, by the learner that it names first."""
    found: dict[str, list[float]] = {}
    with (REFERENCE / study / "cells.csv").open(newline="", encoding="utf-8") as file:
        cells = list(csv.DictReader(file))
        for cell in [it for it in cells if it["algorithm"] == cells[0]["algorithm"]]:
            if success := cell.get("success_rate") or cell.get("behaviour_success"):
                found.setdefault(cell["reward"], []).append(float(success))
    return found


def trained(study: str) -> list[Row]:
    """A row for each reward of a record, the most successful first."""
    found = successes(study)
    best = max(map(mean, found.values()))
    rows = [
        {"study": study, "reward": reward, "trainings": len(each), "success": round(mean(each), 4),
         "is_worse": mean(each) < best - WORSE}
        for reward, each in found.items()
    ]  # fmt: skip
    return sorted(rows, key=lambda row: -row["success"])


def audited(study: str, rewards: Iterable[str]) -> dict[str, dict[str, Any]]:
    """By reward, what the search says."""
    subject, *folder = STUDIES[study]
    files = [it for path in folder for it in ("--plugin", f"{ROOT / path}/*.py")]
    call = [sys.executable, "-m", "harness", "audit", subject, "--reward", ",".join(rewards), *files, "--json"]
    answer = json.loads(subprocess.run(call, check=True, capture_output=True, text=True).stdout)
    findings = [it for part in (answer if isinstance(answer, list) else [answer]) for it in part["cheats"]]
    return {it["reward"]: it for it in findings}


def with_answers(rows: Sequence[Row]) -> list[Row]:
    """The rows of one record, each with what a search says of its reward."""
    found = audited(rows[0]["study"], [row["reward"] for row in rows])
    return [
        {**row, "answer": found[row["reward"]]["answer"], "strength": found[row["reward"]]["strength"]} for row in rows
    ]


def read() -> list[Row]:
    """The committed table."""
    with RECORD.open(newline="", encoding="utf-8") as file:
        return [
            {**row, "trainings": int(row["trainings"]), "success": float(row["success"]),
             "is_worse": row["is_worse"] == "True"}
            for row in csv.DictReader(file)
        ]  # fmt: skip


def counts(rows: Sequence[Row]) -> str:
    """How many rewards got each answer, and how many of those were worse than the best of their record."""
    lines = ["| answer | rewards | worse than the best | success |", "| --- | --- | --- | --- |"]
    for answer in dict.fromkeys((row["answer"], row["strength"]) for row in sorted(rows, key=_order)):
        those = [row for row in rows if (row["answer"], row["strength"]) == answer]
        worse = sum(row["is_worse"] for row in those)
        name = ", ".join(filter(None, answer))
        lines.append(f"| {name} | {len(those)} | {worse} | {mean(row['success'] for row in those):.1%} |")
    return "\n".join(lines)


def _order(row: Row) -> tuple[int, str]:
    """Alarms first, the robust ones before."""
    words = (*ALARMS, "CANNOT TELL", "NOTHING FOUND")
    return words.index(row["answer"]), {"ROBUST": "0"}.get(row["strength"], "1")


def by_record(rows: Sequence[Row]) -> str:
    """The rewards of each record with their success, by what was said of them."""
    lines = ["| record | alarm | nothing found | cannot tell |", "| --- | --- | --- | --- |"]
    for study in dict.fromkeys(row["study"] for row in rows):
        cells = [
            ", ".join(
                f"{row['reward']} {row['success']:.0%}"
                for row in rows
                if row["study"] == study and row["answer"] in answers
            )
            for answers in (ALARMS, ("NOTHING FOUND",), ("CANNOT TELL",))
        ]
        lines.append("| " + " | ".join((study, *cells)).replace("|  ", "| ") + " |")
    return "\n".join(line.replace("|  |", "| |").replace("|  |", "| |") for line in lines)


def in_words(rows: Sequence[Row]) -> str:
    """How often an alarm was right, and how often a reward without one was close to the best."""
    alarms = [row["is_worse"] for row in rows if row["answer"] in ALARMS]
    quiet = [not row["is_worse"] for row in rows if row["answer"] == "NOTHING FOUND"]
    share = (sum(alarms) + sum(quiet)) / (len(alarms) + len(quiet))
    return (
        f"Of {len(alarms)} alarms {sum(alarms)} were right. Of {len(quiet)} rewards of which nothing was found "
        f"{sum(quiet)} were close to the best: {share:.0%} of what was said is right."
    )


def main() -> None:
    """Write the table, record by record, and print what the page shows of it."""
    rows = [row for study in STUDIES for row in with_answers(trained(study))]
    with RECORD.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    sys.stdout.write(f"{in_words(rows)}\n\n{counts(rows)}\n\n{by_record(rows)}\n")


if __name__ == "__main__":
    main()
