"""A saved policy: what is in its folder, and what becomes of a folder that was damaged."""

import contextlib
import json
import os
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import safetensors.numpy
from hypothesis import HealthCheck, given, settings, strategies as st
from numpy.random import default_rng
from numpy.testing import assert_array_equal

from harness.errors import SchemaError
from harness.policy import (
    Categorical,
    Deterministic,
    Gaussian,
    Greedy,
    Policy,
    SquashedGaussian,
    Uniform,
    UniformChoice,
    load_policy,
)
from harness.policy.kinds import every_kind
from harness.policy.policy import ACTIVATIONS, FORMAT, Network
from harness.record.folder import CARD, WEIGHTS

Make = Callable[..., Network]

EXAMPLES = {
    "squashed": lambda make: make(SquashedGaussian, low=-0.3, high=0.7),
    "squashed, no layer": lambda make: make(SquashedGaussian, layers=0),
    "gaussian": lambda make: make(Gaussian, activation="relu"),
    "gaussian, normalised": lambda make: make(Gaussian, is_normalised=True),
    "deterministic": lambda make: make(Deterministic, noise=0.25),
    "greedy": lambda make: make(Greedy, epsilon=0.5, is_normalised=True),
    "categorical": lambda make: make(Categorical, layers=1),
    "uniform": lambda make: Uniform((-1.0,), (2.0,), "floor"),
    "uniform choice": lambda make: UniformChoice(7, "floor"),
}
EVERY = pytest.mark.parametrize("example", EXAMPLES.values(), ids=EXAMPLES)


def _card(folder):
    return json.loads((folder / CARD).read_text())


def _change(folder, **changes):
    """Other entries into the card."""
    (folder / CARD).write_text(json.dumps({**_card(folder), **changes}))


def _change_arrays(folder, **changes):
    """Other arrays into the weights; None takes one out. Names have a double underscore for the dot."""
    arrays = safetensors.numpy.load_file(folder / WEIGHTS)
    arrays |= {name.replace("__", "."): array for name, array in changes.items()}
    safetensors.numpy.save_file({name: array for name, array in arrays.items() if array is not None}, folder / WEIGHTS)


@pytest.fixture
def saved(make_network, tmp_path):
    """The folder of a policy with two hidden layers of 4, normalised."""
    make_network(SquashedGaussian, is_normalised=True).save(tmp_path / "policy")
    return tmp_path / "policy"


@EVERY
def test_policy_is_loaded_as_it_was_saved(make_network, observations, tmp_path, example):
    """Kind, every array bit for bit, every field, the same actions with noise and without."""
    policy = example(make_network)
    policy.save(tmp_path / "policy")
    loaded = load_policy(tmp_path / "policy")
    assert type(loaded) is type(policy)
    assert {name: array.tobytes() for name, array in loaded.weights.items()} == {
        name: array.tobytes() for name, array in policy.weights.items()
    }
    fields = set(policy.__dataclass_fields__) - {"weights"}
    assert {name: getattr(loaded, name) for name in fields} == {name: getattr(policy, name) for name in fields}
    for seed in (None, 3):
        ours, theirs = (
            each.act(observations(), None if seed is None else default_rng(seed)) for each in (policy, loaded)
        )
        assert_array_equal(ours, theirs)


def test_kinds_have_names_of_their_own():
    """A card says unmistakably what it is the card of."""
    names = [kind.kind for kind in every_kind()]
    assert len(set(names)) == len(names) > 5


def test_card_says_what_the_policy_is(make_network, tmp_path):
    """Another program finds format, kind, sizes, bounds, normalisation and the training cell in plain JSON."""
    make_network(Deterministic, is_normalised=True, low=-0.5).save(tmp_path / "policy", {"seed": 3})
    assert _card(tmp_path / "policy") == {
        "format": FORMAT,
        "kind": "deterministic",
        "algorithm": "wander",
        "observation": {"size": 5},
        "action": {"type": "continuous", "low": [-0.5, -0.5], "high": [1.0, 1.0]},
        "normalisation": {"mean": "observation.mean", "std": "observation.std"},
        "activation": "tanh",
        "noise": 0.1,
        "cell": {"seed": 3},
    }
    assert {path.name for path in (tmp_path / "policy").iterdir()} == {CARD, WEIGHTS}


def test_card_of_choices_says_how_many(make_network, tmp_path):
    """Where actions are discrete, the card has their number."""
    make_network(Greedy).save(tmp_path / "policy")
    assert _card(tmp_path / "policy")["action"] == {"type": "discrete", "choices": 3}


def test_weights_in_column_order_are_saved_right(make_network, observations, tmp_path):
    """A transposed view keeps its numbers where they belong."""
    policy = make_network(SquashedGaussian)
    weights = {name: np.asfortranarray(weight) for name, weight in policy.weights.items()}
    SquashedGaussian(weights, "tanh", policy.action_low, policy.action_high).save(tmp_path / "policy")
    assert_array_equal(load_policy(tmp_path / "policy").act(observations()), policy.act(observations()))


def test_policy_of_format_1_is_read(make_network, observations, tmp_path):
    """What an earlier version saved acts as it did."""
    policy = make_network(SquashedGaussian, low=-0.5)
    policy.save(tmp_path / "policy")
    card = {
        "format": 1,
        "kind": "squashed-gaussian-mlp",
        "algorithm": "sac",
        "activation": "tanh",
        "observation_size": 5,
        "action_low": [-0.5, -0.5],
        "action_high": [1.0, 1.0],
    }
    (tmp_path / "policy" / CARD).write_text(json.dumps(card))
    loaded = load_policy(tmp_path / "policy")
    assert (type(loaded), loaded.algorithm) == (SquashedGaussian, "sac")
    assert_array_equal(loaded.act(observations()), policy.act(observations()))


class _Bomb:
    """Unpickling this runs code."""

    def __reduce__(self):
        return Path.touch, (Path("exploded"),)


@pytest.mark.parametrize("file", [CARD, WEIGHTS])
def test_loading_never_unpickles(saved, tmp_path, monkeypatch, file):
    """A pickle in the place of either file is refused, and what it would run does not run."""
    monkeypatch.chdir(tmp_path)
    (saved / file).write_bytes(pickle.dumps(_Bomb(), protocol=0))
    with pytest.raises(SchemaError, match="holds no readable policy"):
        load_policy(saved)
    assert not (tmp_path / "exploded").exists()
    pickle.loads((saved / file).read_bytes())
    assert (tmp_path / "exploded").exists()  # the bomb was live


@pytest.mark.parametrize(
    "card", ["", "{", "[]", "3", "null", "{}", '{"format": 1}', '{"format": "x"}', '{"format": 2, "kind": []}', "\xff"]
)
def test_damaged_card_is_refused(saved, card):
    """Whatever is in the file, the error is ours and names the folder."""
    (saved / CARD).write_text(card, encoding="latin-1")
    with pytest.raises(SchemaError, match="policy holds no readable policy"):
        load_policy(saved)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.just(10**400) | st.floats() | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
    max_leaves=4,
)


@EVERY
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40)
@given(data=st.data())
def test_odd_card_is_refused_or_read(make_network, tmp_path, example, data):
    """With anything at all in one entry, loading gives a policy or an error of ours."""
    folder = tmp_path / "policy"
    example(make_network).save(folder)
    card = _card(folder)
    entry = data.draw(st.sampled_from(sorted(card)))
    if isinstance(card[entry], dict) and card[entry] and data.draw(st.booleans()):
        card[entry][data.draw(st.sampled_from(sorted(card[entry])))] = data.draw(JSON)
    else:
        card[entry] = data.draw(JSON)
    (folder / CARD).write_text(json.dumps(card))
    with contextlib.suppress(SchemaError):
        assert isinstance(load_policy(folder), Policy)


def _box(low, high):
    return {"action": {"type": "continuous", "low": low, "high": high}}


def _choices(count):
    return {"action": {"type": "discrete", "choices": count}}


CHANGED = {
    "newer": (SquashedGaussian, {"format": FORMAT + 1}, f"has format {FORMAT + 1}, this version reads up to {FORMAT}"),
    "sizes": (
        SquashedGaussian,
        {"observation": {"size": 99}},
        r"observation \{'size': 99\}, and its arrays have",
    ),
    "kind": (SquashedGaussian, {"kind": "oracle"}, "no kind 'oracle'; there is: squashed-gaussian, gaussian"),
    "activation": (
        *(SquashedGaussian, {"activation": "swish"}),
        f"no activation 'swish'; there is: {', '.join(ACTIVATIONS)}",
    ),
    "an end less": (SquashedGaussian, _box([-1.0], [1.0, 1.0]), "1 lower and 2 upper ends"),
    "no action": (SquashedGaussian, _box([], []), "0 lower and 0 upper ends"),
    "ends swapped": (SquashedGaussian, _box([1.0, 1.0], [-1.0, -1.0]), "no action lies between"),
    "no number": (SquashedGaussian, _box([float("nan"), 0.0], [1.0, 1.0]), "it holds NaN, which is no JSON"),
    "too large": (SquashedGaussian, _box([-1e39, 0.0], [1.0, 1.0]), "no action lies between"),
    "too many": (SquashedGaussian, _box([0.0] * 101, [1.0] * 101), "there are 101 actions, 100 are allowed"),
    "another size": (SquashedGaussian, _box([-1.0] * 3, [1.0] * 3), "mean does not have 3 outputs"),
    "no choice": (Greedy, _choices(0), "0 choices leave none"),
    "many choices": (Greedy, _choices(10**30), "100,000 are allowed"),
    "other choices": (Greedy, _choices(4), "value does not have 4 outputs"),
    "negative noise": (Deterministic, {"noise": -0.1}, "noise is -0.1"),
    "large noise": (Deterministic, {"noise": 1e300}, r"noise is 1e\+300"),
    "large share": (Greedy, {"epsilon": 1.1}, "epsilon is 1.1"),
}


@pytest.mark.parametrize(("kind", "changes", "reason"), CHANGED.values(), ids=CHANGED)
def test_card_that_cannot_be_is_refused(make_network, tmp_path, kind, changes, reason):
    """When it is loaded, not when the policy acts: of a later version, of other arrays, or of no actions."""
    make_network(kind, is_normalised=True).save(tmp_path / "policy")
    _change(tmp_path / "policy", **changes)
    with pytest.raises(SchemaError, match=reason):
        load_policy(tmp_path / "policy")


@pytest.mark.parametrize("name", ["mean.weight", "log_std.bias", "hidden.0.bias", "hidden.1.weight", "observation.std"])
def test_missing_array_is_refused(saved, name):
    """A network that lacks a part is refused when it is loaded, and the part is named."""
    _change_arrays(saved, **{name.replace(".", "__"): None})
    with pytest.raises(SchemaError, match=f"'{name}' is missing"):
        load_policy(saved)


ARRAYS = {
    "not of float32": ("mean.bias", np.zeros(2), "mean.bias is float64, not float32"),
    "not finite": ("mean.bias", np.full(2, np.nan, np.float32), "mean.bias has numbers that are not finite"),
    "bias too long": ("hidden.0.bias", np.zeros(5, np.float32), r"hidden.0 is \(4, 5\) and \(5,\)"),
    "no matrix": ("hidden.0.weight", np.zeros(4, np.float32), r"hidden.0 is \(4,\) and \(4,\)"),
    "other inputs": ("hidden.1.weight", np.zeros((4, 3), np.float32), r"hidden.1 is \(4, 3\) and \(4,\), on 4 inputs"),
    "other outputs": ("mean.weight", np.zeros((3, 4), np.float32), "mean is"),
    "other mean": ("observation.mean", np.zeros(4, np.float32), r"observation.mean is \(4,\), on 5 numbers"),
    "no deviation": ("observation.std", np.zeros(5, np.float32), "observation.std is not above 0 everywhere"),
    "a gap": ("hidden.7.weight", np.zeros((4, 4), np.float32), "'hidden.2.weight' is missing"),
    "twice": ("hidden.00.weight", np.zeros((4, 4), np.float32), "a hidden layer is there twice"),
    "no numbers": ("more", np.zeros((0, 10**12), np.float32), "more has no numbers"),
    "no index": ("hidden.x.weight", np.zeros((4, 4), np.float32), "invalid literal"),
}


@pytest.mark.parametrize(("name", "array", "reason"), ARRAYS.values(), ids=ARRAYS)
def test_array_that_does_not_fit_is_refused(saved, name, array, reason):
    """What would fail later, or act without meaning, is refused when it is loaded."""
    _change_arrays(saved, **{name.replace(".", "__"): array})
    with pytest.raises(SchemaError, match=reason):
        load_policy(saved)


@pytest.mark.parametrize("log_std", [None, np.zeros(3, np.float32)])
def test_gaussian_without_its_deviation_is_refused(make_network, tmp_path, log_std):
    """The array has to be there, with one number for each action."""
    make_network(Gaussian).save(tmp_path / "policy")
    _change_arrays(tmp_path / "policy", log_std=log_std)
    with pytest.raises(SchemaError, match="log_std"):
        load_policy(tmp_path / "policy")


def test_truncated_weights_are_refused(saved):
    """A copy that broke off is no policy."""
    whole = (saved / WEIGHTS).read_bytes()
    for length in (0, 7, 100, len(whole) - 1):
        (saved / WEIGHTS).write_bytes(whole[:length])
        with pytest.raises(SchemaError, match="holds no readable policy"):
            load_policy(saved)


def test_missing_files_are_refused(tmp_path):
    """An empty folder holds no policy, nor does one that is not there."""
    for folder in (tmp_path, tmp_path / "nowhere"):
        with pytest.raises(SchemaError, match="holds no readable policy"):
            load_policy(folder)


@pytest.mark.parametrize("file", [CARD, WEIGHTS])
def test_large_files_are_not_opened(saved, file):
    """A sparse file of 10 GB is refused at once."""
    with (saved / file).open("wb") as opened:
        opened.truncate(10**10)
    with pytest.raises(SchemaError, match=r"it has 10,000,000,000 bytes, [\d,]+ are allowed") as refused:
        load_policy(saved)
    assert str(saved) in str(refused.value)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes in the file system")
@pytest.mark.parametrize("file", [CARD, WEIGHTS])
def test_pipes_are_refused(saved, file):
    """To read one would take forever."""
    (saved / file).unlink()
    os.mkfifo(saved / file)
    with pytest.raises(SchemaError, match="it is no regular file"):
        load_policy(saved)


def test_many_names_are_refused(saved):
    """The header is looked at before it is read."""
    (saved / WEIGHTS).write_bytes((2**40).to_bytes(8, "little") + b"{}")
    with pytest.raises(SchemaError, match=r"the header of .* has 1,099,511,627,776 bytes, 1,048,576 are allowed"):
        load_policy(saved)


@pytest.mark.parametrize("card", ["[" * 100_000, '{"format": -1e999}', "7", '{"format": 2}', "\ufeff{}"])
def test_cards_of_strangers_are_refused(saved, card):
    """Deep, endless, of another type, with less than it takes."""
    (saved / CARD).write_text(card)
    with pytest.raises(SchemaError, match="holds no readable policy"):
        load_policy(saved)


@pytest.mark.parametrize("algorithm", [7, None, ["sac"]])
def test_what_trained_is_a_text(saved, algorithm):
    """For the reader of the card."""
    _change(saved, algorithm=algorithm)
    with pytest.raises(SchemaError, match="no text"):
        load_policy(saved)
