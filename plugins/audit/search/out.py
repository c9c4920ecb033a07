"""What a search leaves behind: certificates and their page, in a folder or in one file; and both read again."""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from harness.errors import SchemaError, UsageError, one_line
from harness.files.bounded import write_whole
from harness.record import Store
from harness.record.out_folder import make_folder, refuse_links, storage_errors
from harness.record.scene import Scene, read_scene, write_scene
from harness.registry import Registry, choose, require_given
from harness.report.page.page import write_page
from harness.robot.robot import load_robot
from harness.scene.scene import scene_of

from .behaviour import ROLES
from .certificate import BEGINS, NOUN, Certificate, file_names, read_certificate, write_certificate
from .film import films_of
from .finding import Finding
from .page import cheats_page
from .place import Place, called_here, elsewhere_of, needs_of, runs_on, world_at
from .replay import Replayed, certify, differences, replay

INDEX = "index.html"
MOST_FILES = 300
"""The most certificates of a folder that are shown."""


def certificates_of(
    findings: Sequence[Finding], places: Sequence[Place], registry: Registry, *, seed: int, budget: int
) -> tuple[list[Certificate], list[str]]:
    """Certificates of all that findings show, with films; and a line for each behaviour that does not repeat.

    Args:
        findings: What a search found of each reward.
        places: Where, one for each.
        registry: The plugins.
        seed: Of the search.
        budget: Steps that it might take for each.
    """
    certificates, refused = list[Certificate](), list[str]()
    for finding, asked in zip(findings, places, strict=True):
        place = replace(asked, success=finding.success)
        make, told = partial(world_at, place, registry), runs_on(place, registry)
        made, lines = certify(finding, place, make, told, seed=seed, budget=budget)
        if place.is_environment and made:
            films = films_of(place, registry, [it.shown for it in made])
            made = [replace(it, film=film) for it, film in zip(made, films, strict=True)]
        certificates += made
        refused += lines
    return certificates, refused


def write_found(
    folder: Path, certificates: Sequence[Certificate], registry: Registry, remarks: Sequence[str] = ()
) -> None:
    """Leave certificates and their page in a folder. What an earlier search left there of the same rewards goes.

    Raises:
        UsageError: The folder cannot be written, holds a link, or is that of an experiment.
        StorageError: The disk is full, or fails.
    """
    require_free(folder)
    scene, names = scene_for(certificates, registry), file_names(certificates)
    page = cheats_page(certificates, scene, remarks)
    with storage_errors(folder):
        for certificate, name in zip(certificates, names, strict=True):
            write_certificate(certificate, folder / name)
        for name in names:
            stem = name.rpartition("-")[0]
            for role in ROLES:
                other = folder / f"{stem}-{role}.json"
                if other.name not in names and _is_certificate(other):
                    other.unlink()
        if scene is not None:
            write_scene(scene, folder)
        write_whole(folder / INDEX, page)


def require_free(folder: Path) -> None:
    """Make the folder, or see that certificates may be written into the one that is there.

    Raises:
        UsageError: It cannot be written, holds a link, or is that of an experiment.
    """
    if Store.is_experiment(folder):
        raise UsageError(f"--out '{folder}' is the folder of an experiment: name another one")
    make_folder(folder)
    refuse_links(folder)


def write_found_page(
    path: Path, certificates: Sequence[Certificate], registry: Registry, remarks: Sequence[str]
) -> None:
    """Leave the page alone, without files beside it.

    Raises:
        UsageError: It cannot be written.
    """
    page = cheats_page(certificates, scene_for(certificates, registry), remarks, files=False)
    write_page(page, path, "The page")


def scene_for(certificates: Sequence[Certificate], registry: Registry) -> Scene | None:
    """What the arm of certificates looks like; None of an environment."""
    robots = [it.place.robot for it in certificates if it.place.robot]
    return scene_of(load_robot(robots[0], registry)) if robots else None


def page_in(path: Path) -> str | None:
    """The page of a certificate, or of a folder of certificates; None where there is none. Nothing is run for it.

    Raises:
        SchemaError: A file that is named is damaged, or a newer version wrote it.
        UsageError: A library of the extra ``report`` is missing.
    """
    if path.is_file():
        return cheats_page([read_certificate(path)], read_scene(path.parent))
    certificates, damaged = list[Certificate](), list[str]()
    for file in [it for it in sorted(path.glob("*.json")) if _is_certificate(it)][:MOST_FILES]:
        try:
            certificates.append(read_certificate(file))
        except SchemaError as error:
            damaged.append(f"Left out: {error}")
    return cheats_page(certificates, read_scene(path), damaged) if certificates or damaged else None


def _is_certificate(path: Path) -> bool:
    """Whether a regular file begins as certificates do."""
    if path.is_symlink() or not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(len(BEGINS)) == BEGINS


def replay_file(path: Path, registry: Registry, sim: str | None = None) -> Replayed:
    """Play what is in a file again.

    Args:
        path: A certificate.
        registry: The plugins. Only those that are installed or that the user gave are used.
        sim: Another simulator for an arm; None for the certificate's own.

    Raises:
        UsageError: There is no such file, a plugin that it names is not given, or a simulator makes no sense.
        SchemaError: The file is damaged, or a newer version wrote it.
    """
    if not path.is_file():
        raise UsageError(f"--replay {path}: there is no such file. harness audit SUBJECT --out FOLDER writes {NOUN}s")
    certificate = read_certificate(path)
    place, elsewhere = certificate.place, ""
    require_given(list(place.plugins), registry.given, f"The {NOUN}")
    if sim is not None:
        if place.is_environment:
            raise UsageError(f"--sim does not go with {path}: {place.name} brings its own simulation. Leave out --sim")
        engine = choose(registry, "simulators", sim)
        elsewhere = engine.label if engine != place.simulator else ""
        place = replace(place, simulator=engine)
    others = elsewhere_of(place, registry, certificate.elsewhere)
    reasons = [
        *(f"{it}." for it in differences(certificate.runs_on, runs_on(place, registry))),
        *(f"No plugin that is given is {need}." for need in place.plugins if need not in needs_of(registry)),
    ]
    with closing(world_at(place, registry)) as world:
        chosen = (certificate.policy or {}).get("choices", {}).values()
        if not all(world.space.contains(np.asarray(it)) for it in [*certificate.shown.actions, *chosen]):
            raise SchemaError(f"{path} holds actions that {world.name} does not take")
        try:
            here = called_here(place, registry)
            return replay(certificate, world, () if elsewhere else reasons, elsewhere, here, others)
        except (ValueError, IndexError, ZeroDivisionError) as error:  # a policy of other sizes
            raise SchemaError(f"{path} does not fit {world.name}: {one_line(error)}") from error
