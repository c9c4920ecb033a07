"""The state of a random generator as an array for a checkpoint, and back, without pickle."""

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.errors import SchemaError


def pack_generator(rng: np.random.Generator) -> NDArray[np.uint8]:
    """The state of `rng`, as the bytes of a JSON text."""
    # Its numbers have up to 128 bits: no array holds them, JSON does.
    return np.frombuffer(json.dumps(rng.bit_generator.state).encode(), np.uint8)


def restore_generator(rng: np.random.Generator, packed: NDArray[Any]) -> None:
    """Set the state of a generator to one that `pack_generator` packed.

    Args:
        rng: Changed in place.
        packed: Bytes, (count,) of uint8.

    Raises:
        SchemaError: `packed` is no state of a generator of the same kind.
    """
    try:
        rng.bit_generator.state = json.loads(packed.tobytes())
    except (ValueError, TypeError, KeyError) as error:
        raise SchemaError(f"no state of a {type(rng.bit_generator).__name__}: {error!r}") from error
