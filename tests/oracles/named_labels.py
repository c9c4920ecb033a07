"""Labels that a user names: a threshold, a file, the list of episodes, a return; and functions that pay a step."""

import csv
from dataclasses import replace

import h5py
import numpy as np

from tests.oracles import lerobot_sets, minari_sets
from tests.oracles.answers import auc_within_tasks
from tests.oracles.recorded_runs import answer_of, draw_runs
from tests.oracles.trial import Trial, call_json

SETS = {"lerobot": lerobot_sets, "minari": minari_sets}
PLUGIN = """
def near(observation, action, next_observation, info):
    return -8.0 * round(float(abs(next_observation[0])))


def still(observation, action, next_observation, info):
    return -8.0 * round(float(abs(action[0])))
"""


def _unlabelled(runs):
    return [replace(run, success=np.zeros(len(run))) for run in runs]


def _labelled(runs, told):
    numbers = [np.nan if one is None else float(one) for one in told]
    return [replace(run, success=np.full(len(run), one)) for run, one in zip(runs, numbers, strict=True)]


def _draw_labels(rng, runs):
    return [rng.choice((True, False, True, False, None)) for _ in runs]


def _write(rng, runs, folder, lerobot=None, minari=None):
    """In one format or the other, which is told; what its layout has to be, where not any will do."""
    kind = rng.choice(list(SETS))
    layout = replace(SETS[kind].draw_layout(rng), **({"lerobot": lerobot, "minari": minari}[kind] or {}))
    (lerobot_sets.put if kind == "lerobot" else minari_sets.write)(runs, layout, folder / "it")
    return kind


def _ask(kind, folder, *flags):
    return SETS[kind].ask(folder / "it", *flags)


def threshold(rng, folder):
    """The label is a probability of each step, and the user says from where on it is a success."""
    runs = draw_runs(rng)
    runs = [replace(run, success=np.array([rng.randrange(65) / 64 for _ in run.rewards])) for run in runs]
    limit = rng.randrange(8, 60) / 64
    right = answer_of([replace(run, success=(run.success > limit).astype(float)) for run in runs])
    kind = _write(rng, runs, folder, {"label_type": rng.choice(("float32", "float64"))}, {"info_before": False})
    name = "next.success" if kind == "lerobot" else "success"
    return Trial("a threshold", lambda: _ask(kind, folder, "--success", f"{name}>{limit}"), [right])


def labels_file(rng, folder):
    """A CSV file has a line for each episode, in any order."""
    runs = draw_runs(rng)
    told = _draw_labels(rng, runs)
    kind = _write(rng, _unlabelled(runs), folder)
    words = {True: rng.choice(("1", "true", "True", "1.0")), False: rng.choice(("0", "false", "0.0")), None: ""}
    lines = [[str(number), words[one]] for number, one in enumerate(told) if one is not None or rng.random() < 0.5]
    rng.shuffle(lines)
    header, turn = ["episode", "success"], rng.choice((1, -1))
    with (folder / "labels.csv").open("w", newline="") as file:
        csv.writer(file, lineterminator=rng.choice(("\n", "\r\n"))).writerows([one[::turn] for one in [header, *lines]])
    right = answer_of(_labelled(runs, told))
    return Trial("labels in a file", lambda: _ask(kind, folder, "--labels", str(folder / "labels.csv")), [right])


def wrong_labels_file(rng, folder):
    """An episode stands there twice, has an odd label, or is none of the data set."""
    runs = draw_runs(rng)
    kind = _write(rng, _unlabelled(runs), folder)
    odd = rng.choice(("0,1\n0,0\n", "0,maybe\n", "0,0.5\n", "x,1\n", "-1,1\n", "0\n", "0.5,1\n"))
    rest = "".join(f"{number},{number % 2}\n" for number in range(1, len(runs)))
    (folder / "labels.csv").write_text(f"episode,success\n{odd}{rest}")
    return Trial(f"odd labels {odd!r}", lambda: _ask(kind, folder, "--labels", str(folder / "labels.csv")))


def in_the_list(rng, folder):
    """The list of episodes, or the attributes of a group, say it."""
    runs = draw_runs(rng)
    told = [bool(one) for one in _draw_labels(rng, runs)]
    right, kind = answer_of(_labelled(runs, told)), rng.choice(("lerobot", "minari"))
    if kind == "lerobot":
        layout = replace(lerobot_sets.draw_layout(rng), label="next.other")
        parts = lerobot_sets.parts_of(_unlabelled(runs), layout)
        for episode, one in zip(parts.episodes, told, strict=True):
            episode["goal_reached"] = one
        lerobot_sets.write(parts, folder / "it")
    else:
        minari_sets.write(_unlabelled(runs), minari_sets.draw_layout(rng), folder / "it")
        with h5py.File(folder / "it" / minari_sets.MAIN, "r+") as file:
            for number, one in enumerate(told):
                file[f"episode_{number}"].attrs["goal_reached"] = one
    return Trial(f"in the list of {kind}", lambda: _ask(kind, folder, "--success", "goal_reached"), [right])


def above_a_return(rng, folder):
    """An episode is a success if its recorded return is above a number."""
    runs = draw_runs(rng)
    kind = _write(rng, _unlabelled(runs), folder)
    limit = sorted(run.told.pay for run in runs)[len(runs) // 2] - 1 / 16
    told = [run.told.pay > limit for run in runs]
    right = {key: value for key, value in answer_of(_labelled(runs, told)).items() if key != "auc"}
    flags = ("--success-above", f"{limit}")
    return Trial("above a return", lambda: _ask(kind, folder, *flags), [right])


def functions(rng, folder):
    """Functions pay each step; one that looks at what was seen after the last one cannot pay it in LeRobot's sets."""
    runs = draw_runs(rng)
    (folder / "pay.py").write_text(PLUGIN)
    kind = _write(rng, runs, folder, minari={"nested": ""})
    is_lerobot = kind == "lerobot"
    last = -1 if is_lerobot else None
    paid = {
        "near": [-8.0 * sum(round(float(abs(row[0]))) for row in run.states[1:][:last]) for run in runs],
        "still": [-8.0 * sum(round(float(abs(row[0]))) for row in run.actions) for run in runs],
    }
    right = {}
    for name, sums in paid.items():
        # an episode of one step is paid nothing by what cannot pay its only step
        kept = [place for place, run in enumerate(runs) if not (name == "near" and is_lerobot and len(run) == 1)]
        told = [runs[place].told._replace(pay=sums[place]) for place in kept]
        right[name] = auc_within_tasks(told)

    def ask():
        told, said = call_json("audit", f"{kind}:{folder / 'it'}", "--plugin", folder / "pay.py")
        return {one["reward"]: one["success"]["value"] for one in told["rewards"]}, said

    return Trial(f"functions, {kind}", ask, [right])


def partial(rng, folder):
    """What is there is enough for the user: the rest is answered, and what is missing is told."""
    runs = draw_runs(rng)
    parts = lerobot_sets.parts_of(runs, lerobot_sets.draw_layout(rng))
    gone = rng.randrange(len(runs))
    parts.keep(parts.columns["episode_index"] != gone)
    lerobot_sets.write(parts, folder / "it")
    right = answer_of([run for place, run in enumerate(runs) if place != gone])
    return Trial("a part", lambda: lerobot_sets.ask(folder / "it", "--partial"), [right], tells="partial")


ORACLES = {
    "labels, a threshold": threshold,
    "labels, a file": labels_file,
    "labels, a wrong file": wrong_labels_file,
    "labels, in the list": in_the_list,
    "labels, a return": above_a_return,
    "data set, functions": functions,
    "data set, a part": partial,
}
