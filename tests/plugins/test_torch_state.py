"""What torch learned comes back, bit for bit."""

import numpy as np
import torch

from harness_plugins.torch_state import pack_optimizer, pack_tensors, restore_optimizer, restore_tensors


def _made(seed):
    torch.manual_seed(seed)
    net = torch.nn.Linear(3, 2)
    return net, torch.optim.Adam(net.parameters(), 0.1)


def _climb(net, optimizer):
    optimizer.zero_grad()
    net(torch.ones(3)).pow(2).sum().backward()
    optimizer.step()


def test_net_and_optimizer_go_on_as_they_would_have():
    """Weights in place, moments and their count of steps."""
    (net, optimizer), (other, again) = _made(0), _made(1)
    for _ in range(3):
        _climb(net, optimizer)
    restore_tensors(other.state_dict(), pack_tensors(net.state_dict()))
    restore_optimizer(again, pack_optimizer(optimizer))
    for pair in ((net, optimizer), (other, again)):
        _climb(*pair)
    assert torch.equal(net.weight, other.weight)
    assert torch.equal(net.bias, other.bias)


def test_optimizer_that_has_done_nothing_remembers_nothing():
    """And comes back so."""
    _, optimizer = _made(0)
    assert pack_optimizer(optimizer) == {}
    restore_optimizer(optimizer, {})
    assert pack_optimizer(optimizer) == {}


def test_what_is_packed_stays():
    """A later step changes no copy."""
    net, optimizer = _made(0)
    packed = pack_tensors(net.state_dict())
    before = {name: array.copy() for name, array in packed.items()}
    _climb(net, optimizer)
    assert all(np.array_equal(packed[name], array) for name, array in before.items())
