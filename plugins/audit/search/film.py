"""Films of behaviours in an environment: pictures that the env draws, side by side in one file."""

import base64
import multiprocessing
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from pydantic import Field, StringConstraints, with_config

from harness.errors import reason_of
from harness.experiment.environments.frames import strip_of
from harness.experiment.environments.played_again import let_draw, picture_of
from harness.files.plain import Plain
from harness.record.file_forms import EXACT, Whole, told_as
from harness.registry import Registry, load_registry
from harness.registry.given import Given
from harness.registry.spec import require_pillow
from harness.text import one_line

from .place import Place, Text
from .spaces import coded
from .world import Actions, Shown

PICTURES = 60
"""The most pictures of a behaviour."""
SIZE = (200, 200)
"""The most pixels of a picture."""
MOST_BYTES = 230_000
"""The most bytes of a behaviour's pictures: a page of three stays below 1 MB."""
SCREEN = "harness doctor says what is missing; without a screen MuJoCo needs MUJOCO_GL=egl"
PATIENCE = 120.0
"""Seconds in which the pictures of all behaviours of a reward have to be drawn."""
Pixels = Annotated[int, Field(ge=1, le=1_000)]


@with_config(EXACT)
@dataclass(frozen=True)
class Film(Plain):
    """Pictures of one behaviour.

    Attributes:
        reason: Why there are none; empty if there are some.
        steps: After which step each was taken; the first is 0.
        size: Width and height of a picture, [px].
        strip: All pictures side by side, as WebP; in a file in Base64.

    Raises:
        ValueError: It holds no pictures of these steps.
    """

    reason: Text = ""
    steps: Annotated[tuple[Whole, ...], Field(max_length=100)] = ()
    size: tuple[Pixels, Pixels] = (1, 1)
    strip: Annotated[
        bytes,
        told_as(Annotated[str, StringConstraints(max_length=2 * MOST_BYTES)], partial(base64.b64decode, validate=True)),
    ] = b""

    def __post_init__(self) -> None:
        if self.strip and (self.strip[:4], self.strip[8:12]) != (b"RIFF", b"WEBP"):
            raise ValueError("its pictures are no WebP")
        if bool(self.strip) != bool(self.steps) or any(b <= a for a, b in pairwise(self.steps)):
            raise ValueError("its pictures are not of steps in order")

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {**super().to_json(), "strip": base64.b64encode(self.strip).decode()}


def films_of(place: Place, registry: Registry, episodes: Sequence[Shown]) -> list[Film]:
    """A film of each episode, on one clock.

    A process of its own draws them: graphics libraries may crash where there is no screen.

    Args:
        place: An environment.
        registry: The plugins.
        episodes: What was done.
    """
    clock = np.unique(np.linspace(0, max(len(it.paid) for it in episodes), PICTURES).round().astype(int)).tolist()
    films = list[Film]()
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        asked = [pool.submit(draw_film, place, registry.given, it.start, it.actions, clock) for it in episodes]
        until = time.monotonic() + PATIENCE
        for film in asked:
            try:
                films.append(film.result(max(0.0, until - time.monotonic())))
            except TimeoutError:
                films.append(Film("There is no film: to draw it took too long."))
            except BrokenProcessPool:
                films.append(Film(f"There is no film: the process that draws it ended. {SCREEN}."))
        for process in list((pool._processes or {}).values()):
            process.kill()  # one that takes too long
    return films


def draw_film(place: Place, given: Sequence[Given], start: int, actions: Actions, clock: Sequence[int]) -> Film:
    """Play an episode in a new env, which draws it: the steps of the clock and the last one.

    All pictures stand side by side; fewer of them, if they would take too much.
    """
    registry = load_registry(given=given)
    try:
        require_pillow()
        with closing(place.task.build(registry, "environments").make()) as env:
            let_draw(env, place.name)
            decoded = coded(env.action_space, place.name).decoded
            env.reset(seed=start)
            pictures = {0: picture_of(env, place.name)}
            for step, action in enumerate(actions, 1):
                env.step(decoded(action))
                if step in clock or step == len(actions):
                    pictures[step] = picture_of(env, place.name)
        steps = sorted(pictures)
        while len(steps) > 1:
            strip, size = strip_of([pictures[step] for step in steps], SIZE, MOST_BYTES)
            if strip:
                return Film("", tuple(steps), size, strip)
            steps = [*steps[:-1:2], steps[-1]] if len(steps) > 2 else steps[:1]
        return Film(f"There is no film: its pictures take more than {MOST_BYTES:,} bytes.")
    except Exception as error:  # an env of anybody
        return Film(f"There is no film: {one_line(reason_of(error))}")
