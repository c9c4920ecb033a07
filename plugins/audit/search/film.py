"""Films of behaviours in an environment: pictures that the env draws, side by side in one file."""

import base64
import multiprocessing
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from harness.environment import AnyEnv
from harness.errors import HarnessError, reason_of
from harness.experiment.environments.frames import strip_of
from harness.experiment.environments.played_again import let_draw, picture_of
from harness.registry import Registry, load_registry
from harness.registry.given import Given
from harness.registry.spec import require_pillow
from harness.text import one_line

from .place import Place
from .spaces import coded
from .world import Actions, Data, Shown

if TYPE_CHECKING:
    from PIL import Image

PICTURES = 60
"""The most pictures of a behaviour."""
SIZE = (200, 200)
"""The most pixels of a picture."""
MOST_BYTES = 230_000
"""The most bytes of a behaviour's pictures: a page of three stays below 1 MB."""
SCREEN = "harness doctor says what is missing; without a screen MuJoCo needs MUJOCO_GL=egl"
PATIENCE = 120.0
"""Seconds in which the pictures of all behaviours of a reward have to be drawn."""


class Film(NamedTuple):
    """Pictures of one behaviour."""

    reason: str = ""
    """Why there are none; empty if there are some."""
    steps: tuple[int, ...] = ()
    """After which step each was taken; the first is 0."""
    size: tuple[int, int] = (1, 1)
    """Width and height of a picture, [px]."""
    strip: bytes = b""
    """All pictures side by side, as WebP."""

    def to_json(self) -> Data:
        """Plain data; `from_json` gives the same back."""
        return {**self._asdict(), "strip": base64.b64encode(self.strip).decode()}

    @classmethod
    def from_json(cls, data: Data) -> "Film":
        """What `to_json` told.

        Raises:
            ValueError: It holds no pictures of these steps.
        """
        strip, steps = base64.b64decode(data["strip"], validate=True), tuple(data["steps"])
        if strip and (strip[:4], strip[8:12]) != (b"RIFF", b"WEBP"):
            raise ValueError("its pictures are no WebP")
        if bool(strip) != bool(steps) or any(b <= a for a, b in pairwise(steps)):
            raise ValueError("its pictures are not of steps in order")
        return cls(data["reason"], steps, tuple(data["size"]), strip)


def films_of(place: Place, registry: Registry, episodes: Sequence[Shown]) -> list[Film]:
    """A film of each episode, on one clock.

    A process of its own draws them: graphics libraries may crash where there is no screen.

    Args:
        place: An environment.
        registry: The plugins.
        episodes: What was done.
    """
    clock = np.unique(np.linspace(0, max(len(it.paid) for it in episodes), PICTURES).round().astype(int)).tolist()
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        asked = [pool.submit(draw_film, place, registry.given, it.start, it.actions, clock) for it in episodes]
        until = time.monotonic() + PATIENCE
        films = [_awaited(it, until) for it in asked]
        for process in list((pool._processes or {}).values()):
            process.kill()  # one that takes too long
    return films


def _awaited(film: Future[Film], until: float) -> Film:
    """The film, or why there is none by a time of `time.monotonic`."""
    try:
        return film.result(max(0.0, until - time.monotonic()))
    except TimeoutError:
        return Film("There is no film: to draw it took too long.")
    except BrokenProcessPool:
        return Film(f"There is no film: the process that draws it ended. {SCREEN}.")


def draw_film(place: Place, given: Sequence[Given], start: int, actions: Actions, clock: Sequence[int]) -> Film:
    """Play an episode in a new env, which draws it."""
    registry = load_registry(given=given)
    try:
        require_pillow()
        with closing(place.task.build(registry, "environments").make()) as env:
            let_draw(env, place.name)
            return _strip(_pictures(env, place.name, start, actions, clock))
    except HarnessError as error:
        return Film(f"There is no film: {one_line(str(error))}")
    except Exception as error:  # an env of anybody
        return Film(f"There is no film: {one_line(reason_of(error))}")


def _pictures(env: AnyEnv, name: str, start: int, actions: Actions, clock: Sequence[int]) -> "dict[int, Image.Image]":
    """Pictures by step, those of the clock and the last one."""
    decoded = coded(env.action_space, name).decoded
    env.reset(seed=start)
    found = {0: picture_of(env, name)}
    for step, action in enumerate(actions, 1):
        env.step(decoded(action))
        if step in clock or step == len(actions):
            found[step] = picture_of(env, name)
    return found


def _strip(pictures: "Mapping[int, Image.Image]") -> Film:
    """All pictures side by side; fewer of them, if they would take too much."""
    steps = sorted(pictures)
    while len(steps) > 1:
        strip, size = strip_of([pictures[step] for step in steps], SIZE, MOST_BYTES)
        if strip:
            return Film("", tuple(steps), size, strip)
        steps = [*steps[:-1:2], steps[-1]] if len(steps) > 2 else steps[:1]
    return Film(f"There is no film: its pictures take more than {MOST_BYTES:,} bytes.")
