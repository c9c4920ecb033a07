"""Recorded trainings as their format is, written here without the recorder, and what may become of them.

A training is a folder of ``recording-<n>.json``, which carries its own digest, and of Parquet files of its steps. A
change is sealed again, so that a lie with a valid digest is read.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.random import default_rng

from harness.files.bounded import seal
from tests.oracles.answers import etas, indices
from tests.oracles.trial import Shown, Trial, call_json

BASE, NEXT = REWARDS = ("plain", "shaped")
EIGHTH = 0.125
NOTHING = {"nothing": "is left to compare"}
SOURCE = {"sha256": "", "text": "what the env pays"}
TYPES = {
    "time": pa.int64(), "env": pa.int32(), "episode": pa.int32(), "step": pa.int32(), "terminated": pa.bool_(),
    "truncated": pa.bool_(),
}  # fmt: skip


@dataclass
class Training:
    """One training with one env; a change changes it.

    Attributes:
        trained_with: What taught it.
        seed: Of it.
        columns: Of its steps, in the order of the file.
        facts: What differs from the usual ones.
    """

    trained_with: str
    seed: int
    columns: dict[str, Any]
    facts: dict[str, Any] = field(default_factory=dict)

    def paid(self, name):
        """By a reward, each step."""
        return [float(value) for value in self.columns[f"reward_{name}"]]

    def mean_return(self, name):
        """Of an episode that ended."""
        sums = {}
        ended = set()
        for number, paid, one, other in zip(
            self.columns["episode"],
            self.paid(name),
            self.columns["terminated"],
            self.columns["truncated"],
            strict=True,
        ):
            sums[int(number)] = sums.get(int(number), 0.0) + paid
            ended |= {int(number)} if one or other else set()
        return sum(sums[number] for number in ended) / len(ended)


def draw_trainings(rng):
    """Some of each reward, of as many steps."""
    steps, seeds = rng.choice((30, 60, 120)), rng.randrange(1, 5)
    return [_draw_training(rng, name, seed, steps) for name in REWARDS for seed in range(seeds)]


def _draw_training(rng, trained_with, seed, steps):
    lengths = []
    while sum(lengths) < steps:
        lengths.append(min(rng.randrange(1, 12), steps - sum(lengths)))
    draw = default_rng(rng.randrange(2**32))
    ends = np.concatenate([np.arange(length) == length - 1 for length in lengths])
    is_cut = draw.random(steps) < 0.3
    columns = {
        "time": np.arange(steps),
        "env": np.zeros(steps, int),
        "episode": np.repeat(np.arange(len(lengths)), lengths),
        "step": np.concatenate([np.arange(length) for length in lengths]),
        **{f"reward_{name}": EIGHTH * draw.integers(-12, 16, steps) for name in REWARDS},
        "behaviour_success": np.where(ends, draw.integers(0, 2, steps), 0).astype(float),
        "terminated": ends & ~is_cut,
        "truncated": ends & is_cut,
    }
    return Training(trained_with, seed, columns)


def facts_of(training):
    """What stands in ``recording-0.json``."""
    names = [*(f"reward_{name}" for name in REWARDS), "behaviour_success"]
    return {
        "format": 2, "rewards": list(REWARDS), "trained_with": training.trained_with, "behaviour": ["success"],
        "lower_is_better": [], "evaluation": False, "num_envs": 1, "seed": training.seed,
        "env": {"id": "Arm-v0", "kwargs": {}}, "versions": {"gymnasium": "1.0"},
        "sources": dict.fromkeys(names, SOURCE), "failures": [], "paid_otherwise": "", "closed": True,
        **training.facts,
    }  # fmt: skip


def write(training, folder, rng=None):
    """Both files; by the random numbers, in one of the ways that must not matter."""
    folder.mkdir(parents=True)
    facts, how = facts_of(training), {}
    if rng is not None:
        facts = {name: facts[name] for name in rng.sample(list(facts), len(facts))}
        how = {
            "compression": rng.choice(("zstd", "snappy", "gzip", "none")),
            "row_group_size": rng.choice((1, 7, 1_000)),
            "use_dictionary": rng.random() < 0.5,
            "write_page_checksum": rng.random() < 0.5,
            "data_page_version": rng.choice(("1.0", "2.0")),
        }
    (folder / "recording-0.json").write_bytes(seal(facts))
    arrays = {name: pa.array(values, TYPES.get(name, pa.float64())) for name, values in training.columns.items()}
    pq.write_table(pa.table(arrays), folder / "steps-0-00000.parquet", **how)


def write_all(trainings, folder, rng=None):
    """A folder each; with random numbers, at any depth, under any name."""
    for place, training in enumerate(trainings):
        name = f"{training.trained_with}-{place}"
        if rng is not None:
            name = f"{rng.choice(('', 'a/', 'b/c/'))}{rng.randrange(10**6)}-{place}"
        write(training, folder / name, rng)


def answer_of(trainings):
    """What `harness eta` and `report` have to say of them."""
    groups = {name: [training for training in trainings if training.trained_with == name] for name in REWARDS}
    eta_n, eta_p = etas(*([one.paid(name) for one in groups[name]] for name in REWARDS))
    told = {"eta_N": eta_n, "eta_P": eta_p}
    for name in REWARDS:
        below, above = indices([one.paid(name) for one in groups[name]])
        told[name] = {"I_N": Shown(below), "I_P": Shown(above), "trainings": len(groups[name])}
    told["returns"] = {
        f"{taught} paid by {paid}": sum(one.mean_return(paid) for one in groups[taught]) / len(groups[taught])
        for taught in REWARDS
        for paid in REWARDS
    }
    return told


def reduced(told):
    """What is compared of ``--json``."""
    if not told["combinations"]:  # one reward is left, and told alone
        return NOTHING
    (one,) = (found for found in told["combinations"] if {found["baseline"], found["proposed"]} == set(REWARDS))
    names = {"baseline": one["baseline"], "proposed": one["proposed"]}
    if names["baseline"] != BASE:
        raise AssertionError(f"the baseline is {names['baseline']}")
    returns = one["returns"]["over the training"]["returns"]
    return {
        "eta_N": one["eta_N"]["eta"]["value"],
        "eta_P": one["eta_P"]["eta"]["value"],
        **{
            names[who]: {**{key: one[f"{who}_index"][key] for key in ("I_N", "I_P")}, "trainings": len(one["seeds"])}
            for who in names
        },
        "returns": {f"{names[it['trained_by']]} paid by {names[it['paid_by']]}": it["value"] for it in returns},
    }


def ask(folder, command):
    """What a command says of the folder."""
    told, said = call_json(command, folder)
    return reduced(told), said


COMMANDS = ("eta", "report")


def no_matter(rng, folder):
    """The same trainings, written otherwise."""
    trainings, command = draw_trainings(rng), rng.choice(COMMANDS)
    write_all(rng.sample(trainings, len(trainings)), folder, rng)
    return Trial(f"written otherwise, {command}", lambda: ask(folder, command), [answer_of(trainings)])


def matters(rng, folder):
    """Other numbers, sealed: the answer is another, and follows."""
    trainings, command = draw_trainings(rng), rng.choice(COMMANDS)
    change = rng.choice(CHANGES)
    change(trainings, rng)
    write_all(trainings, folder, rng)
    return Trial(f"{change.__name__}, {command}", lambda: ask(folder, command), [answer_of(trainings)])


def move_value(trainings, rng):
    """A step pays much more."""
    one = rng.choice(trainings)
    one.columns[f"reward_{rng.choice(REWARDS)}"][rng.randrange(len(one.columns["time"]))] += rng.choice((-64.0, 64.0))


def swap_columns(trainings, rng):
    """What two rewards paid has changed places."""
    columns = rng.choice(trainings).columns
    one, other = (f"reward_{name}" for name in REWARDS)
    columns[one], columns[other] = columns[other], columns[one]


def swap_teachers(trainings, rng):
    """The facts of all say that the other reward taught."""
    for training in trainings:
        training.trained_with = NEXT if training.trained_with == BASE else BASE


def move_end(trainings, rng):
    """The last episode never ended: it is no return."""
    columns = rng.choice(trainings).columns
    if int(columns["episode"][-1]):
        columns["terminated"][-1] = columns["truncated"][-1] = False


def more_envs(trainings, rng):
    """The facts tell of an env that took no step: no number depends on it."""
    rng.choice(trainings).facts = {"num_envs": 2}


CHANGES = (move_value, swap_columns, swap_teachers, move_end, more_envs)


def damaged(rng, folder):
    """One training is damaged, and sealed all the same: it is left out and told, or all is refused."""
    trainings, command = draw_trainings(rng), rng.choice(COMMANDS)
    place, change = rng.randrange(len(trainings)), rng.choice(list(DAMAGES))
    rest = [training for other, training in enumerate(trainings) if other != place]
    DAMAGES[change](trainings[place], rng)
    write_all(trainings, folder)
    is_left = {training.trained_with for training in rest} == set(REWARDS)
    # the others of its seed may be left out with it, since pairs are of one seed
    paired = [training for training in rest if training.seed != trainings[place].seed]
    right = [_without_pairing(answer_of(rest))] if is_left else []
    right = [*right, _without_pairing(answer_of(paired))] if paired else right or [NOTHING]
    return Trial(f"{change}, {command}", lambda: ask(folder, command), right, True, r"(?i)left out|damaged")


def _without_pairing(answer):
    """Without how many trainings a pair has: the rest may be of other seeds."""
    kept = {name: {key: answer[name][key] for key in ("I_N", "I_P")} for name in REWARDS}
    return {**answer, **kept}


def _keep(training, rows):
    training.columns = {name: values[rows] for name, values in training.columns.items()}


def _drop_row(training, rng):
    step = training.columns["step"]
    inner = np.flatnonzero((step > 0) & (step < np.append(step[1:], 0))).tolist() or [1]
    _keep(training, np.arange(len(step)) != rng.choice(inner))


def _double_row(training, rng):
    rows = np.arange(len(training.columns["time"]))
    _keep(training, np.sort(np.append(rows, rng.choice(rows.tolist()))))


def _set(name, value):
    def change(training, rng):
        values = training.columns[name].copy()
        values[rng.randrange(len(values) // 2, len(values))] = value
        training.columns[name] = values

    return change


def _tell(**facts):
    def change(training, rng):
        training.facts = facts

    return change


def _backwards(training, rng):
    _keep(training, np.arange(len(training.columns["time"]))[::-1])


DAMAGES = {
    "a step is gone": _drop_row,
    "a step stands twice": _double_row,
    "a reward is NaN, and no failure told": _set("reward_plain", np.nan),
    "a reward is infinite": _set("reward_shaped", np.inf),
    "an env beyond": _set("env", 3),
    "an episode beyond": _set("episode", 10_000),
    "an episode below": _set("episode", -1),
    "a step of another number": _set("step", 77),
    "time stands still": _set("time", 0),
    "backwards": _backwards,
    "a reward more is told": _tell(rewards=["plain", "shaped", "third"]),
    "a reward less is told": _tell(rewards=["plain", "shaped"], behaviour=[]),
    "a teacher that is none": _tell(trained_with="third"),
    "a newer format": _tell(format=99),
    "an odd field": _tell(shell="rm"),
}


def copies(rng, folder):
    """A training lies there twice: it counts once, or is refused."""
    trainings, command = draw_trainings(rng), rng.choice(COMMANDS)
    twice = [*trainings, *(replace(rng.choice(trainings)) for _ in range(rng.randrange(1, 3)))]
    write_all(twice, folder, rng)
    return Trial(f"copies, {command}", lambda: ask(folder, command), [answer_of(trainings)], True)


ORACLES = {
    "recording, written otherwise": no_matter,
    "recording, other numbers": matters,
    "recording, damaged": damaged,
    "recording, copies": copies,
}
