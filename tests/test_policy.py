"""A policy that acts with numpy alone, saved without pickle."""

import json
import math
import pickle
from pathlib import Path

import numpy as np
import pytest
import safetensors.numpy
from hypothesis import example, given
from hypothesis import strategies as st

from harness.errors import SchemaError
from harness.policy import CARD, FORMAT, WEIGHTS, Policy

SEEN, WIDTH, ACTIONS = 5, 3, 2


def _policy(
    seed: int = 0, layers: int = 1, activation: str = "relu", low: float = -1.0, high: float = 1.0, scale: float = 1.0
) -> Policy:
    rng = np.random.default_rng(seed)
    sizes = [SEEN] + [WIDTH] * layers
    shapes = {f"hidden.{index}": (sizes[index + 1], sizes[index]) for index in range(layers)}
    shapes |= {"mean": (ACTIONS, sizes[-1]), "log_std": (ACTIONS, sizes[-1])}
    weights = {}
    for layer, (out, into) in shapes.items():
        weights[f"{layer}.weight"] = (scale * rng.normal(size=(out, into))).astype(np.float32)
        weights[f"{layer}.bias"] = (scale * rng.normal(size=out)).astype(np.float32)
    return Policy(weights, activation, (low,) * ACTIONS, (high,) * ACTIONS, "wander")


def _observations(count: int = 4) -> np.ndarray:
    return np.random.default_rng(1).normal(size=(count, SEEN)).astype(np.float32)


def _slow_mean(policy: Policy, observation: list[float]) -> list[float]:
    """The mean action of one observation, in loops and double precision."""

    def linear(values: list[float], layer: str) -> list[float]:
        weight, bias = policy.weights[f"{layer}.weight"].tolist(), policy.weights[f"{layer}.bias"].tolist()
        return [sum(w * v for w, v in zip(row, values, strict=True)) + b for row, b in zip(weight, bias, strict=True)]

    activation = {"relu": lambda value: max(value, 0.0), "tanh": math.tanh}[policy.activation]
    values, index = observation, 0
    while f"hidden.{index}.weight" in policy.weights:
        values = [activation(value) for value in linear(values, f"hidden.{index}")]
        index += 1
    ends = zip(linear(values, "mean"), policy.action_low, policy.action_high, strict=True)
    return [low + (math.tanh(value) + 1.0) / 2.0 * (high - low) for value, low, high in ends]


@pytest.mark.parametrize("layers", [0, 1, 3])
@pytest.mark.parametrize("activation", ["relu", "tanh"])
def test_act_agrees_with_a_plain_computation(layers: int, activation: str):
    """Layer by layer in loops, the squashed mean is the same."""
    policy = _policy(layers=layers, activation=activation, low=-2.0, high=3.0)
    expected = [_slow_mean(policy, observation) for observation in _observations().tolist()]
    np.testing.assert_allclose(policy.act(_observations()), expected, atol=1e-5)


def test_act_is_float32_per_env():
    """One action for each env of the batch."""
    actions = _policy().act(_observations(7))
    assert (actions.shape, actions.dtype) == ((7, ACTIONS), np.float32)


def test_each_env_is_on_its_own():
    """An observation gives the same action alone as in a batch."""
    alone = np.concatenate([_policy().act(row[None]) for row in _observations()])
    np.testing.assert_allclose(alone, _policy().act(_observations()), atol=1e-6)


def test_mean_action_is_deterministic():
    """Without a generator nothing is drawn."""
    np.testing.assert_array_equal(_policy().act(_observations()), _policy().act(_observations()))


def test_drawn_actions_come_from_the_generator():
    """Equal generators draw equal actions, others draw others, and none is the mean."""
    drawn = [_policy().act(_observations(), np.random.default_rng(seed)) for seed in (3, 3, 4)]
    np.testing.assert_array_equal(drawn[0], drawn[1])
    assert (drawn[0] != drawn[2]).all()
    assert (drawn[0] != _policy().act(_observations())).all()


def test_drawn_actions_have_the_policy_s_distribution():
    """Before squashing, mean and standard deviation are those of the two heads."""
    policy = _policy(layers=0, scale=0.1)
    observation = _observations(1)
    drawn = np.arctanh(policy.act(np.repeat(observation, 20_000, axis=0), np.random.default_rng(5)).astype(float))
    mean = np.arctanh(policy.act(observation)[0])
    std = np.exp(observation @ policy.weights["log_std.weight"].T + policy.weights["log_std.bias"])[0]
    np.testing.assert_allclose(drawn.mean(axis=0), mean, atol=0.05)
    np.testing.assert_allclose(drawn.std(axis=0), std, rtol=0.05)


@given(st.integers(0, 100), st.floats(-10, 10, width=32), st.floats(-10, 10, width=32), st.booleans())
@example(0, -9.899999618530273, 0.10000000149011612, False)
def test_actions_stay_in_the_box(seed: int, low: float, high: float, is_drawn: bool):
    """Bounds included, also where tanh is 1 to the last bit and high - low is rounded."""
    low, high = sorted((low, high))
    policy = _policy(seed=seed, low=low, high=high, scale=30.0)
    actions = policy.act(100 * _observations(), np.random.default_rng(seed) if is_drawn else None)
    assert (actions >= np.float32(low)).all()
    assert (actions <= np.float32(high)).all()


def test_saturated_policy_reaches_both_ends():
    """The whole box can be used."""
    policy = _policy(low=-0.5, high=2.0, scale=1000.0)
    actions = policy.act(_observations(100))
    assert {-0.5, 2.0} <= set(actions.ravel().tolist())


def test_policy_is_loaded_as_it_was_saved(tmp_path: Path):
    """Every weight bit for bit, every field, the same actions."""
    policy = _policy(layers=2, activation="tanh", low=-0.3, high=0.7)
    policy.save(tmp_path / "policy")
    loaded = Policy.load(tmp_path / "policy")
    assert set(loaded.weights) == set(policy.weights)
    for name, weight in policy.weights.items():
        assert loaded.weights[name].tobytes() == weight.tobytes()
    for field in ("activation", "action_low", "action_high", "algorithm"):
        assert getattr(loaded, field) == getattr(policy, field)
    np.testing.assert_array_equal(loaded.act(_observations()), policy.act(_observations()))


def test_weights_in_column_order_are_saved_right(tmp_path: Path):
    """A transposed view keeps its numbers where they belong."""
    policy = _policy()
    weights = {name: np.asfortranarray(weight) for name, weight in policy.weights.items()}
    Policy(weights, "relu", policy.action_low, policy.action_high).save(tmp_path / "policy")
    np.testing.assert_array_equal(Policy.load(tmp_path / "policy").act(_observations()), policy.act(_observations()))


def test_card_says_what_the_policy_is(tmp_path: Path):
    """Another program finds format, kind, sizes and bounds in plain JSON."""
    _policy().save(tmp_path / "policy")
    assert json.loads((tmp_path / "policy" / CARD).read_text()) == {
        "format": FORMAT,
        "kind": "squashed-gaussian-mlp",
        "algorithm": "wander",
        "activation": "relu",
        "observation_size": SEEN,
        "action_low": [-1.0, -1.0],
        "action_high": [1.0, 1.0],
    }
    assert {path.name for path in (tmp_path / "policy").iterdir()} == {CARD, WEIGHTS}


class _Bomb:
    """Unpickling this runs code."""

    def __reduce__(self) -> tuple[object, ...]:
        return Path.touch, (Path("exploded"),)


@pytest.mark.parametrize("file", [CARD, WEIGHTS])
def test_loading_never_unpickles(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, file: str):
    """A pickle in the place of either file is refused, and what it would run does not run."""
    monkeypatch.chdir(tmp_path)
    _policy().save(tmp_path / "policy")
    (tmp_path / "policy" / file).write_bytes(pickle.dumps(_Bomb(), protocol=0))
    with pytest.raises(SchemaError, match="holds no readable policy"):
        Policy.load(tmp_path / "policy")
    assert not (tmp_path / "exploded").exists()
    pickle.loads((tmp_path / "policy" / file).read_bytes())
    assert (tmp_path / "exploded").exists()  # the bomb was live


def test_newer_card_is_refused(tmp_path: Path):
    """A policy of a later version is not guessed at."""
    _policy().save(tmp_path / "policy")
    card = json.loads((tmp_path / "policy" / CARD).read_text())
    (tmp_path / "policy" / CARD).write_text(json.dumps({**card, "format": FORMAT + 1}))
    with pytest.raises(SchemaError, match=f"has format {FORMAT + 1}, this version reads up to {FORMAT}"):
        Policy.load(tmp_path / "policy")


@pytest.mark.parametrize(
    "card", ["", "{", "[]", "3", "null", "{}", '{"format": 1}', '{"format": "x"}', '{"format": 1, "action_low": 3}']
)
def test_damaged_card_is_refused(tmp_path: Path, card: str):
    """Whatever is in the file, the error is ours and names the folder."""
    _policy().save(tmp_path / "policy")
    (tmp_path / "policy" / CARD).write_text(card)
    with pytest.raises(SchemaError, match="policy holds no readable policy"):
        Policy.load(tmp_path / "policy")


def test_unknown_activation_is_refused(tmp_path: Path):
    """A card that asks for what this version cannot do is refused when it is loaded, not when the policy acts."""
    _policy(activation="swish").save(tmp_path / "policy")
    with pytest.raises(SchemaError, match="swish"):
        Policy.load(tmp_path / "policy")


@pytest.mark.parametrize("missing", ["mean.weight", "log_std.bias", "hidden.0.bias"])
def test_missing_weights_are_refused(tmp_path: Path, missing: str):
    """A network that lacks a part is refused when it is loaded, and the part is named."""
    policy = _policy()
    weights = {name: weight for name, weight in policy.weights.items() if name != missing}
    policy.save(tmp_path / "policy")
    safetensors.numpy.save_file(weights, tmp_path / "policy" / WEIGHTS)
    with pytest.raises(SchemaError, match=missing):
        Policy.load(tmp_path / "policy")


def test_missing_files_are_refused(tmp_path: Path):
    """An empty folder holds no policy, nor does one that is not there."""
    for folder in (tmp_path, tmp_path / "nowhere"):
        with pytest.raises(SchemaError, match="holds no readable policy"):
            Policy.load(folder)
