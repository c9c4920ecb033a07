"""An alarm before a training, held against what trainings did: ``python experiments/cheats/study.py``.

Asks ``harness audit`` of every reward that a committed race or experiment has trained, and writes
``results/reference/cheats/cheats.csv``: what it said, and how often the trained robots succeeded.
"""

import csv
import json
import subprocess
import sys
from pathlib import Path
from statistics import mean

ROOT = Path(__file__).parents[2]
REFERENCE = ROOT / "results" / "reference"
STUDIES = {
    "race/arm": ["fd100-small-target:epsilon=0.025"],
    "fd100": ["fd100-reach"],
    "arp-2021": ["arp-2021"],
    "race/pendulum": ["gymnasium:id=Pendulum-v1", "experiments/race/pendulum"],
    "cheats/reacher": ["gymnasium:id=Reacher-v5", "experiments/cheats/reacher"],
    "cheats/cartpole": ["gymnasium:id=CartPole-v1", "experiments/cheats/cartpole"],
}
"""By the folder of its record: what is audited, and where its plugin files lie."""
WORSE = 0.1
"""By so much less success than the best reward of its record a reward counts as worse."""


def trained(study: str) -> dict[str, list[float]]:
    """By reward, the success of each training; of the two algorithms of the published record, that which learns."""
    found: dict[str, list[float]] = {}
    with (REFERENCE / study / "cells.csv").open(newline="", encoding="utf-8") as file:
        for cell in csv.DictReader(file):
            success = cell.get("success_rate") or cell.get("behaviour_success")
            if success and not (study == "arp-2021" and cell["algorithm"] != "sac-fast"):
                found.setdefault(cell["reward"], []).append(float(success))
    return found


def audited(study: str, rewards: list[str]) -> dict[str, dict]:
    """By reward, what the search says."""
    subject, *folder = STUDIES[study]
    files = [it for path in folder for it in ("--plugin", f"{ROOT / path}/*.py")]
    call = [sys.executable, "-m", "harness", "audit", subject, "--reward", ",".join(rewards), *files, "--json"]
    answer = json.loads(subprocess.run(call, check=True, capture_output=True, text=True).stdout)
    findings = [it for part in (answer if isinstance(answer, list) else [answer]) for it in part["cheats"]]
    return {it["reward"]: it for it in findings}


def rows(study: str) -> list[dict[str, object]]:
    """One for each reward of a record, the most successful first."""
    successes = {reward: mean(each) for reward, each in trained(study).items()}
    found = audited(study, list(successes))
    best = max(successes.values())
    return [
        {
            "study": study, "reward": reward, "trainings": len(trained(study)[reward]), "success": round(success, 4),
            "is_worse": success < best - WORSE, "answer": found[reward]["answer"],
            "strength": found[reward]["strength"],
        }
        for reward, success in sorted(successes.items(), key=lambda it: -it[1])
    ]  # fmt: skip


def main() -> None:
    """Write the table, study by study."""
    table = [row for study in STUDIES for row in rows(study)]
    with (REFERENCE / "cheats" / "cheats.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(table[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)


if __name__ == "__main__":
    main()
