"""What this machine's floating-point operations come to, so that bytes are compared only where they can be the same."""

import math
import sys
from functools import cache
from hashlib import sha256
from importlib.metadata import version

import numpy as np
from numpy.linalg import norm
from numpy.random import default_rng

LIBRARIES = ("numpy", "gymnasium", "mujoco")
ROWS, WIDTHS, FUNCTIONS = (1, 2, 8, 16), (1, 3, 4, 6, 8, 20), (np.tanh, np.exp, np.sin, np.cos, np.square)


@cache
def arithmetic():
    """Versions, and a digest of what small networks, their way back and an arm's frames are computed with.

    No code of ours takes part: a change of ours must not look like another machine.
    """
    rng, digest = default_rng(0), sha256()
    for kind in (np.float32, np.float64):
        for rows in ROWS:
            for into in WIDTHS:
                inputs = rng.uniform(-1.0, 1.0, (2, rows, into + 1)).astype(kind)
                digest.update(norm(inputs[0, 0]).tobytes() + np.vdot(inputs, inputs).tobytes())
                for function in (*FUNCTIONS, np.sum, lambda values: np.log(values * values + 1e-6)):
                    digest.update(function(inputs).tobytes())
                for out in WIDTHS:
                    weight = rng.uniform(-1.0, 1.0, (2, into + 1, out)).astype(kind)
                    values = np.ones((2, rows, out + 1), kind)
                    np.matmul(inputs, weight, out=values[..., :-1])
                    back = np.matmul(inputs.swapaxes(-1, -2), values[..., :-1])
                    for told in (values, back, np.matmul(values[..., :-1], weight.swapaxes(-1, -2))):
                        digest.update(told.tobytes())
    for number in rng.uniform(-3.0, 3.0, 99):
        digest.update(str([math.sin(number), math.cos(number), math.exp(number), abs(number) ** 1.5]).encode())
    frames = rng.uniform(-1.0, 1.0, (3, 4, 4))
    for told in (
        frames @ frames[0],
        frames[..., :3, :3] @ frames[..., :3, 3:],
        np.linalg.solve(frames, frames[..., :1]),
    ):
        digest.update(told.tobytes())
    return f"{' '.join(map(version, LIBRARIES))} {sys.platform} {digest.hexdigest()[:16]}"
