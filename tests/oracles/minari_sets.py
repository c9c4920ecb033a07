"""Data sets as Minari lays them out in HDF5, and what may become of them.

By `minari.dataset._storages.hdf5_storage` of version 0.5: a group ``episode_<n>`` with the attributes ``id``, ``seed``
and ``total_steps``, arrays that can grow, one observation and one info more than steps; ``metadata.json`` beside it.
"""

import json
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import h5py
import numpy as np

from tests.oracles.lerobot_sets import LEFT_OUT, altered, copied, reduced, rewritten
from tests.oracles.recorded_runs import MATTERS, NO_MATTER, answer_of, draw_runs
from tests.oracles.trial import Trial, call_json

MAIN, METADATA = Path("data/main_data.hdf5"), Path("data/metadata.json")


@dataclass
class Layout:
    """How it is written: all that must not matter."""

    chunks: str = "guessed"
    compression: str | None = None
    pay_type: str = "float64"
    state_type: str = "float32"
    label_type: str = "bool"
    info_before: bool = True
    label_shape: tuple[int, ...] = ()
    nested: str = ""
    backwards: bool = False
    extra: bool = False
    in_file: bool = False
    indent: int | None = None


def draw_layout(rng):
    """Any."""
    return Layout(
        chunks=rng.choice(("guessed", "guessed", "none", "row")),
        compression=rng.choice((None, "gzip", "lzf")),
        pay_type=rng.choice(("float64", "float32")),
        state_type=rng.choice(("float32", "float64")),
        label_type=rng.choice(("bool", "int64", "uint8", "float32", "float64")),
        info_before=rng.random() < 0.7,
        label_shape=rng.choice(((), (), (1,))),
        nested=rng.choice(("", "dict", "tuple")),
        backwards=rng.random() < 0.3,
        extra=rng.random() < 0.3,
        in_file=rng.random() < 0.2,
        indent=rng.choice((None, 2)),
    )


def write(runs, layout, folder):
    """Both files."""
    (folder / "data").mkdir(parents=True)
    steps = sum(map(len, runs))
    told = {
        "total_episodes": len(runs), "total_steps": steps, "data_format": "hdf5", "minari_version": "0.5.3",
        "dataset_id": "arm/reach-v0", "env_spec": '{"id": "Arm-v0"}', "algorithm_name": "somebody's",
    }  # fmt: skip
    with h5py.File(folder / MAIN, "w", track_order=True) as file:
        numbers = range(len(runs))
        for number in reversed(numbers) if layout.backwards else numbers:
            _write_episode(file.create_group(f"episode_{number}"), number, runs[number], layout)
        if layout.in_file:
            file.attrs.update(told)
    if not layout.in_file:
        (folder / METADATA).write_text(json.dumps(told, indent=layout.indent))


def _write_episode(group, number, run, layout):
    attributes = {"id": number, "seed": 7 + number, "total_steps": len(run)}
    if layout.backwards:
        attributes = dict(reversed(attributes.items()))
    group.attrs.update(attributes)
    states = run.states.astype(layout.state_type)
    if layout.nested == "dict":
        _put(group, "observations/arm", states[:, :2], layout)
        _put(group, "observations/goal", states[:, 2:], layout)
    elif layout.nested == "tuple":
        _put(group, "observations/_index_0", states[:, :2], layout)
        _put(group, "observations/_index_1", states[:, 2], layout)
    else:
        _put(group, "observations", states, layout)
    _put(group, "actions", run.actions, layout)
    _put(group, "rewards", run.rewards.astype(layout.pay_type), layout)
    _put(group, "terminations", np.arange(len(run)) == len(run) - 1, layout)
    _put(group, "truncations", np.zeros(len(run), bool), layout)
    told = np.concatenate([[0.0], run.success]) if layout.info_before else run.success
    if np.isin(run.success, (0, 1)).all():
        told = told.astype(layout.label_type)
    elif layout.info_before:
        told[0] = run.success[0]
    _put(group, "infos/success", told.reshape(-1, *layout.label_shape), layout)
    if layout.extra:
        _put(group, "infos/nested/distance", np.ones(len(told)), layout)
        group["infos/words"] = ["a"] * len(told)


def _put(group, key, values, layout):
    if layout.chunks == "none":
        group.create_dataset(key, data=values)
        return
    chunks = True if layout.chunks == "guessed" else (1, *values.shape[1:])
    group.create_dataset(
        key, data=values, chunks=chunks, maxshape=(None, *values.shape[1:]), compression=layout.compression
    )


def ask(folder, *flags):
    """What `harness audit` says of it."""
    told, said = call_json("audit", f"minari:{folder}", *flags)
    return reduced(told), said


def no_matter(rng, folder):
    """Written in another way, in another order."""
    return rewritten(rng, folder, draw_runs(rng), NO_MATTER, (write, draw_layout, ask))


def matters(rng, folder):
    """Other episodes: the answer is another, and follows."""
    return altered(rng, folder, draw_runs(rng), MATTERS, (write, draw_layout, ask))


def changed(rng, folder):
    """Something in the file is wrong.

    A change takes the open file, and tells the episodes of each answer that is right, whether a refusal is, and what
    has to be told.
    """
    runs = draw_runs(rng)
    change = rng.choice(CHANGES)
    write(runs, replace(draw_layout(rng), chunks="guessed", compression=None, in_file=False), folder)
    with h5py.File(folder / MAIN, "r+") as file:
        rest, may_refuse, tells = change(file, runs, rng)
    right = [answer_of(one) for one in rest]
    if change is nan_pay:  # one reward loses the episode, and the data set does not
        right = [answer_of(runs) | {"auc": right[0]["auc"]}]
    if change in {linked_copy, link_instead}:  # copies may be counted where no pairs are
        right = [{"auc": one["auc"]} for one in right]
    return Trial(change.__name__, lambda: ask(folder), right, may_refuse, tells)


def _any(file, rng):
    return file[f"episode_{rng.randrange(len(file))}"]


REFUSED = [], True, ""


def short_array(file, runs, rng):
    """A reward, or an action, is missing at the end."""
    values = _any(file, rng)[rng.choice(("rewards", "actions"))]
    values.resize(len(values) - 1, axis=0)
    return REFUSED


def lie_on_steps(file, runs, rng):
    """The attribute tells of other steps than there are."""
    _any(file, rng).attrs["total_steps"] += rng.choice((1, 7))
    return REFUSED


def cut_whole(file, runs, rng):
    """All arrays of an episode lack the last step; attribute and metadata still tell of it."""
    group = _any(file, rng)

    def cut(name, found):
        if isinstance(found, h5py.Dataset) and len(found) and found.maxshape[0] is None:
            found.resize(len(found) - 1, axis=0)

    group.visititems(cut)
    return REFUSED


def drop_episode(file, runs, rng):
    """An episode is gone; metadata still tell of it."""
    del file[f"episode_{rng.randrange(len(runs))}"]
    return REFUSED


def probabilities(file, runs, rng):
    """A label is neither 0 nor 1."""
    group = _any(file, rng)["infos"]
    values = np.asarray(group["success"][...], np.float64)
    values[-1] = rng.choice((0.5, 0.97, 2.0))
    del group["success"]
    group["success"] = values
    return REFUSED


def no_key(file, runs, rng):
    """One episode lacks the key of success, the first one too."""
    number = rng.choice((0, rng.randrange(len(runs))))
    del file[f"episode_{number}/infos/success"]
    return [_but(runs, number, unlabelled=True)], False, LEFT_OUT


def nan_pay(file, runs, rng):
    """A reward is not finite."""
    number = rng.randrange(len(runs))
    rewards = file[f"episode_{number}/rewards"]
    rewards[rng.randrange(len(rewards))] = rng.choice((np.nan, -np.inf))
    return [_but(runs, number)], False, LEFT_OUT


def linked_copy(file, runs, rng):
    """An episode is a hard link to another one: it is no evidence of its own."""
    file[f"episode_{len(runs)}"] = _any(file, rng)
    return [runs], True, ""


def link_instead(file, runs, rng):
    """In the place of an episode stands a link to another one."""
    one, other = rng.sample(range(len(runs)), 2)
    del file[f"episode_{one}"]
    if rng.random() < 0.5:
        file[f"episode_{one}"] = file[f"episode_{other}"]
        return [_but(runs, one)], True, ""
    file[f"episode_{one}"] = h5py.SoftLink(f"/episode_{other}")
    return REFUSED


def loop(file, runs, rng):
    """A group of infos holds itself, or the same group along very many ways."""
    infos = file["episode_0/infos"]
    if rng.random() < 0.5:
        infos["again"] = infos
        return [runs], True, ""
    inner = infos.create_group("deep")
    for level in range(6):
        below = inner.create_group(f"way_{level}")
        for number in range(12):
            inner[f"other_{number}"] = below
        inner = below
    return [runs], True, ""


def dangling(file, runs, rng):
    """Rewards are a link to nothing, or into another file."""
    group = _any(file, rng)
    del group["rewards"]
    group["rewards"] = rng.choice((h5py.SoftLink("/nowhere"), h5py.ExternalLink("other.hdf5", "/rewards")))
    return REFUSED


def wide_rewards(file, runs, rng):
    """A step has two rewards."""
    group = _any(file, rng)
    values = np.stack([group["rewards"][...]] * 2, axis=1)
    del group["rewards"]
    group["rewards"] = values
    return REFUSED


def left_over(file, runs, rng):
    """More episodes lie there than metadata tell of: nothing says which belong."""
    group = file.create_group(f"episode_{len(runs)}")
    _write_episode(group, len(runs), replace(runs[0], rewards=runs[0].rewards + np.float32(8.0)), Layout())
    return [runs], True, LEFT_OUT


def swapped_arrays(file, runs, rng):
    """The rewards of two episodes of one length have changed places: it cannot be seen, and is what is told."""
    one, other = rng.sample(range(len(runs)), 2)
    if len(runs[one]) != len(runs[other]):
        return [runs], False, ""
    for number, rewards in ((one, runs[other].rewards), (other, runs[one].rewards)):
        file[f"episode_{number}/rewards"][...] = rewards
    found = list(runs)
    found[one], found[other] = (
        replace(runs[one], rewards=runs[other].rewards),
        replace(runs[other], rewards=runs[one].rewards),
    )
    return [found], False, ""


def _but(runs, number, unlabelled=False):
    if not unlabelled:
        return [run for place, run in enumerate(runs) if place != number]
    unknown = replace(runs[number], success=np.full(len(runs[number]), np.nan))
    return [unknown if place == number else run for place, run in enumerate(runs)]


CHANGES = (
    short_array, short_array, lie_on_steps, cut_whole, drop_episode, probabilities, no_key, nan_pay, linked_copy,
    link_instead, loop, dangling, wide_rewards, left_over, swapped_arrays,
)  # fmt: skip


def lie_on_totals(rng, folder):
    """Metadata tell of more episodes, or steps, than there are."""
    write(draw_runs(rng), replace(draw_layout(rng), in_file=False), folder)
    told = json.loads((folder / METADATA).read_text())
    key = rng.choice(("total_episodes", "total_steps"))
    (folder / METADATA).write_text(json.dumps({**told, key: told[key] + rng.choice((1, 10))}))
    return Trial(f"{key} is more than there is", lambda: ask(folder))


ORACLES = {
    "minari, written otherwise": no_matter,
    "minari, copies": partial(copied, put=write, layout=Layout(), draw=draw_layout, ask=ask),
    "minari, other episodes": matters,
    "minari, changed": changed,
    "minari, totals": lie_on_totals,
}
