"""The state of a training by stable-baselines3 between two rollouts, as arrays. A checkpoint holds it."""

from collections.abc import Sequence
from operator import attrgetter
from typing import Any, TypeAlias

import numpy as np
import torch

from harness.algorithm import Ring, TrainingState, as_state, pack_generator, restore_generator, under

from ..torch_state import pack_optimizer, pack_tensors, restore_optimizer, restore_tensors

ARRAYS = ("_last_obs", "_last_episode_starts")
NUMBERS = ("num_timesteps", "_n_updates", "_episode_num", "_current_progress_remaining", "exploration_rate", "_n_calls")
"""Attributes of a model, as far as it has them."""
COLUMNS = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts", "ep_start")
"""Attributes of a replay buffer, as far as it has them."""
EPISODES = ("ep_length", "_current_ep_start")
"""Attributes of a replay buffer that knows its episodes. Not only their newest rows change."""

Part: TypeAlias = tuple[dict[str, Any], Any]
"""Tensors by name, or an optimiser."""


def can_be_packed(model: Any) -> bool:
    """Whether `pack_model` finds what a model has learned. It finds only parameters of PyTorch."""
    names, _ = model._get_torch_save_params()
    return bool(names)


def pack_model(model: Any) -> TrainingState:
    """The state of a model: parameters, replay buffer, counters, logged values and random generators."""
    state = _values(model, (*ARRAYS, *NUMBERS))
    for name, (tensors, optimizer) in _parts(model).items():
        state[name] = pack_optimizer(optimizer) if optimizer else pack_tensors(tensors)
    buffer = getattr(model, "replay_buffer", None)
    if buffer is not None:
        state["replay"] = Ring(as_state(_values(buffer, COLUMNS)), model.num_timesteps // model.n_envs)
        state["episodes"] = _values(buffer, EPISODES)
    return as_state({**state, "logged": model.logger.name_to_value, **_pack_generators(model)})


def restore_model(model: Any, state: TrainingState) -> None:
    """Restore a model that was made with the same settings. Its logged values come later, by `restore_logged`."""
    for name in ARRAYS:
        setattr(model, name, _array_of(name, state))
    for name in (name for name in NUMBERS if name in state):
        setattr(model, name, state[name].item())
    for name, (tensors, optimizer) in _parts(model).items():
        packed = under(f"{name}.", state)
        if optimizer:
            restore_optimizer(optimizer, packed)
        else:
            restore_tensors(tensors, packed)
    if "replay" in state:
        ring, buffer = state["replay"], model.replay_buffer
        ring.copy_into(as_state(_values(buffer, COLUMNS)))
        for name, values in under("episodes.", state).items():
            getattr(buffer, name)[:] = values
        buffer.pos, buffer.full = ring.written % buffer.buffer_size, ring.written >= buffer.buffer_size
    _restore_generators(model, state)


def restore_logged(model: Any, state: TrainingState) -> None:
    """Restore the values that were logged last. The model must have its logger by now."""
    for name, value in under("logged.", state).items():
        model.logger.record(name, value.item())


def _values(owner: Any, names: Sequence[str]) -> dict[str, Any]:
    return {name: getattr(owner, name) for name in names if hasattr(owner, name)}


def _array_of(name: str, state: TrainingState) -> Any:
    """A copy of the attribute `name`, from a state."""
    if name in state:
        return np.array(state[name])
    return {key: np.array(value) for key, value in under(f"{name}.", state).items()}


def _parts(model: Any) -> dict[str, Part]:
    """What the library would save: tensors by name, or an optimiser, each under its own name."""
    names, variables = model._get_torch_save_params()
    parts: dict[str, Part] = {"variable": ({name: getattr(model, name) for name in variables}, None)}
    for name in names:
        owner = attrgetter(name)(model)
        is_optimizer = isinstance(owner, torch.optim.Optimizer)
        parts[name] = ({}, owner) if is_optimizer else (owner.state_dict(), None)
    return parts


def _pack_generators(model: Any) -> dict[str, Any]:
    """The generators of torch and numpy, from which the library draws, and the generator of the first actions."""
    _, keys, *rest = np.random.get_state()
    return {
        "torch": torch.get_rng_state().numpy(),
        "numpy.keys": keys,
        "numpy.rest": np.array(rest, float),
        "actions": pack_generator(model.action_space.np_random),
    }


def _restore_generators(model: Any, state: TrainingState) -> None:
    torch.set_rng_state(torch.from_numpy(np.array(state["torch"])))
    position, has_gauss, gauss = state["numpy.rest"].tolist()
    np.random.set_state(("MT19937", state["numpy.keys"], int(position), int(has_gauss), gauss))
    restore_generator(model.action_space.np_random, state["actions"])
