"""What ``harness audit`` says of each case: ``python -m tests.plugins.audit.cases.run [PART OF A NAME ...]``.

A row for each search: case, whether it is hacked, seed, word, strength, seconds, right or wrong.
"""

import csv
import json
import subprocess
import sys
import time

from tests.plugins.audit.cases.table import HACKED, HONEST

SEEDS = (0, 1, 2)
"""Of the search; each case is searched so often."""


def search(case, seed):
    """What the command finds, and how long it takes, [s]."""
    call = [sys.executable, "-m", "harness", *case.command, "--json", "--seed", str(seed)]
    begin = time.perf_counter()
    answer = subprocess.run(call, capture_output=True, text=True, check=False)
    if not answer.stdout:
        return {"answer": answer.stderr.strip(), "strength": ""}, time.perf_counter() - begin
    (finding,) = json.loads(answer.stdout)["cheats"]
    return finding, time.perf_counter() - begin


def answer_of(case, word):
    """Whether a word is right: a cheat that exists is found, and none where there is none."""
    if word == "CANNOT TELL":
        return "cannot tell"
    is_alarm = word in ("PAYS FOR FAILING", "PAYS FOR LOITERING")
    return "right" if is_alarm == (case in HACKED) and (is_alarm or word == "NOTHING FOUND") else "wrong"


def main(parts):
    """Search every case whose name has one of these parts, with all seeds in turn."""
    writer = csv.writer(sys.stdout, lineterminator="\n")
    for seed in SEEDS:
        for case in (*HACKED, *HONEST):
            if not parts or any(part in case.name for part in parts):
                finding, seconds = search(case, seed)
                truth, word = "hacked" if case in HACKED else "honest", finding["answer"]
                told = answer_of(case, word)
                writer.writerow((case.name, truth, seed, word, finding["strength"], f"{seconds:.1f}", told))
                sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:])
