"""Experiment files and policies: what they have to come to, counted and multiplied out here."""

import itertools
import json

import numpy as np
import safetensors.numpy
from numpy.random import default_rng

from harness.errors import HarnessError
from harness.experiment.plan import expand, read_experiment
from harness.policy import load_policy
from harness.record.folder import CARD, WEIGHTS
from tests.oracles.trial import Refused, Trial
from tests.registered import REGISTRY

SIMS, ALGOS = ("kinematic", "mujoco"), ("sb3-sac", "td3", "random")
REWARDS = {"arp": {"k2": 1.5}, "dense": {}, "sparse": {}}


def _asked(read):
    """A reader of the program as a question: its errors are refusals if they are one line."""

    def ask():
        try:
            return read(), ""
        except HarnessError as error:
            raise Refused(str(error)) from None

    return ask


# Experiment files


def draw_experiment(rng):
    """The keys of a file, each a list of what is combined."""
    return {
        "sim": rng.sample(SIMS, rng.randrange(1, 3)),
        "algo": rng.sample(ALGOS, rng.randrange(1, 3)),
        "reward": rng.sample(list(REWARDS), rng.randrange(1, 4)),
        "baseline": "baseline",
        "seeds": rng.sample(range(100), rng.randrange(1, 5)),
        "steps": rng.choice((1_000, 250_000)),
        "evaluation_episodes": rng.randrange(1, 60),
        "deterministic": rng.random() < 0.5,
    }


def cells_of(keys):
    """Every combination, counted out."""
    rewards = [keys["baseline"], *keys["reward"]]
    cells = [
        [sim, algo, reward, dict(REWARDS.get(reward, {})).get("k2"), seed]
        for sim, algo, reward, seed in itertools.product(keys["sim"], keys["algo"], rewards, keys["seeds"])
    ]
    told = [keys["steps"], keys["evaluation_episodes"], keys["deterministic"]]
    return {"cells": sorted([*cell, *told] for cell in map(_sortable, cells))}


def _sortable(cell):
    return [*cell[:3], cell[3] or 0.0, *cell[4:]]


def _read_experiment(path):
    plan = expand(read_experiment(path, {}), REGISTRY)
    found = []
    for cell in plan.cells:
        k2 = dict(cell.reward.params).get("k2") if cell.reward.name == "arp" else None
        names = [cell.simulator.name, cell.algorithm.name, cell.reward.name, k2, cell.seed]
        found.append([*_sortable(names), cell.steps, cell.evaluation_episodes, cell.deterministic])
    return {"cells": sorted(found)}


def _spell(value, rng):
    """A value of a TOML file, in one of the ways to write it."""
    if isinstance(value, list):
        inside = [_spell(part, rng) for part in value]
        return rng.choice((f"[{', '.join(inside)}]", "[\n  " + ",\n  ".join(inside) + ",\n]"))
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        k2 = REWARDS.get(value, {}).get("k2")
        if k2 is not None:
            return rng.choice((f'"{value}:k2={k2}"', f'{{name = "{value}", k2 = {k2}}}', f"'{value}:k2=1.50'"))
        return rng.choice((f'"{value}"', f"'{value}'", f'{{name = "{value}"}}')) if value in SIMS else f'"{value}"'
    return rng.choice((str(value), f"{value:_}", hex(value)))


def text_of(keys, rng):
    """The file."""
    lines = [f"{name} = {_spell(value, rng)}" for name, value in keys.items()]
    rng.shuffle(lines)
    lines = [f"{line}  # what is tried" if rng.random() < 0.3 else line for line in lines]
    return rng.choice(("\n", "\r\n")).join([*lines, ""])


def experiment(rng, folder):
    """Written otherwise, with a changed number, or with what cannot be meant."""
    keys = draw_experiment(rng)
    change = rng.choice(list(EXPERIMENT_CHANGES))
    right, changed = EXPERIMENT_CHANGES[change](keys, rng)
    path = folder / "a.toml"
    path.write_text(text_of(changed, rng), newline="")
    return Trial(change, _asked(lambda: _read_experiment(path)), [cells_of(one) for one in right])


def _other(name, value):
    def change(keys, rng):
        changed = {**keys, name: value}
        return [changed], changed

    return change


def _wrong(name, value):
    return lambda keys, rng: ([], {**keys, name: value})


EXPERIMENT_CHANGES = {
    "as it is": lambda keys, rng: ([keys], keys),
    "written otherwise": lambda keys, rng: ([keys], keys),
    "other steps": _other("steps", 7_777),
    "other seeds": _other("seeds", [3, 1]),
    "an algorithm twice": lambda keys, rng: ([keys], {**keys, "algo": [*keys["algo"], keys["algo"][0]]}),
    "a reward twice": lambda keys, rng: ([keys], {**keys, "reward": [*keys["reward"], keys["reward"][0]]}),
    "an unknown key": _wrong("stpes", 7),
    "no steps": _wrong("steps", 0),
    "a seed below 0": _wrong("seeds", [-1, 2]),
    "a text for a number": _wrong("steps", "many"),
    "an unknown reward": _wrong("reward", ["arpp"]),
    "an unknown parameter": _wrong("reward", ["arp:k9=2"]),
    "half an episode": _wrong("evaluation_episodes", "1.5"),
}

# Policies


def _layers(draw, sizes, heads):
    made = {f"hidden.{place}": pair for place, pair in enumerate(list(itertools.pairwise(sizes)))}
    made |= {name: (sizes[-1], size) for name, size in heads.items()}
    arrays = {f"{name}.weight": draw.normal(size=(out, into)) for name, (into, out) in made.items()}
    arrays |= {f"{name}.bias": draw.normal(size=out) for name, (_, out) in made.items()}
    return {name: array.astype(np.float32) for name, array in arrays.items()}


def _acted(weights, kind, card, seen):
    """Layer after layer, in 64 bits."""
    values = seen.astype(float)
    if "observation.mean" in weights:
        values = (values - weights["observation.mean"]) / weights["observation.std"]
    for place in range(sum(name.startswith("hidden") for name in weights) // 2):
        values = values @ weights[f"hidden.{place}.weight"].astype(float).T + weights[f"hidden.{place}.bias"]
        values = np.tanh(values) if card["activation"] == "tanh" else np.maximum(values, 0)
    head = "mean" if kind == "squashed-gaussian" else "value"
    out = values @ weights[f"{head}.weight"].astype(float).T + weights[f"{head}.bias"]
    if kind == "greedy":
        return out.argmax(axis=1).tolist()
    low, high = (np.array(card["action"][end]) for end in ("low", "high"))
    return np.round(low + (np.tanh(out) + 1) / 2 * (high - low), 3).ravel().tolist()


def policy(rng, folder):
    """A policy that is saved, written otherwise, with other numbers, or with what does not fit."""
    draw = default_rng(rng.randrange(2**32))
    sizes = [rng.randrange(2, 9) for _ in range(rng.randrange(2, 4))]
    kind, size = rng.choice(("squashed-gaussian", "greedy")), rng.randrange(2, 5)
    weights = _layers(draw, sizes, {"mean": size, "log_std": size} if kind == "squashed-gaussian" else {"value": size})
    if rng.random() < 0.4:
        weights |= {"observation.mean": np.float32(draw.normal(size=sizes[0]))}
        weights |= {"observation.std": np.float32(draw.uniform(0.5, 2.0, sizes[0]))}
    card = _card(kind, sizes[0], size, weights, rng)
    change = rng.choice(list(POLICY_CHANGES))
    is_right = POLICY_CHANGES[change](weights, card, rng)
    names = rng.sample(list(weights), len(weights))
    (folder / WEIGHTS).write_bytes(safetensors.numpy.save({name: weights[name] for name in names}))
    keys = rng.sample(list(card), len(card))
    (folder / CARD).write_text(json.dumps({key: card[key] for key in keys}, indent=rng.choice((None, 1))))
    seen = draw.normal(size=(5, sizes[0])).astype(np.float32)

    def act():
        found = np.asarray(load_policy(folder).act(seen))
        return {"actions": found.tolist() if kind == "greedy" else [round(float(it), 3) for it in found.ravel()]}

    right = [_near(_acted(weights, kind, card, seen))] if is_right else []
    return Trial(f"{kind}, {change}", _asked(act), right)


class Thousandth(float):
    """A number in 32 bits, as far as it matters."""

    def __eq__(self, other):
        return isinstance(other, int | float) and abs(float(self) - other) < 0.0021

    __hash__ = float.__hash__


def _near(actions):
    return {"actions": [one if isinstance(one, int) else Thousandth(one) for one in actions]}


def _card(kind, seen, size, weights, rng):
    action = {"type": "continuous", "low": [-1.0] * size, "high": [rng.choice((1.0, 3.0))] * size}
    if kind == "greedy":
        action = {"type": "discrete", "choices": size}
    mean = {"mean": "observation.mean", "std": "observation.std"} if "observation.mean" in weights else None
    beside = {"epsilon": 0.0} if kind == "greedy" else {}
    return {
        "format": 2, "kind": kind, "algorithm": "mine", **beside, "observation": {"size": seen}, "normalisation": mean,
        "activation": rng.choice(("tanh", "relu")), "action": action, "cell": None,
    }  # fmt: skip


def _same(weights, card, rng):
    return True


def _moved(weights, card, rng):
    name = rng.choice(list(weights))
    if name != "observation.std":
        weights[name] = weights[name] + np.float32(1.5)
    return True


def _without(weights, card, rng):
    del weights[rng.choice([name for name in weights if not name.startswith("observation")])]
    return False


def _transposed(weights, card, rng):
    name = rng.choice([name for name in weights if name.endswith("weight")])
    is_square = weights[name].shape[0] == weights[name].shape[1]
    weights[name] = np.ascontiguousarray(weights[name].T)
    return is_square


def _not_finite(weights, card, rng):
    name = rng.choice(list(weights))
    weights[name] = weights[name].copy()
    weights[name].flat[0] = rng.choice((np.nan, np.inf))
    return False


def _other_size(weights, card, rng):
    card["observation"] = {"size": card["observation"]["size"] + 1}
    return False


def _unknown_activation(weights, card, rng):
    card["activation"] = "gelu"
    return False


def _no_spread(weights, card, rng):
    size = card["observation"]["size"]
    weights["observation.mean"], weights["observation.std"] = np.zeros(size, np.float32), np.zeros(size, np.float32)
    card["normalisation"] = {"mean": "observation.mean", "std": "observation.std"}
    return False


POLICY_CHANGES = {
    "as it is": _same,
    "written otherwise": _same,
    "a weight is another": _moved,
    "an array is missing": _without,
    "a weight is transposed": _transposed,
    "a weight is not finite": _not_finite,
    "the card tells another size": _other_size,
    "an unknown activation": _unknown_activation,
    "observations divided by 0": _no_spread,
}
ORACLES = {"experiment file": experiment, "policy": policy}
