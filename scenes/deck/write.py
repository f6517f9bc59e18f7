"""Scenes written as decks: a model, and the steps of each program, which include it."""

from pathlib import Path

from cea.errors import InputError
from cea.files import check_writable, write_whole
from cea.petsc import MPI
from cea.ranks import made_on_first
from scenes.deck.abaqus import abaqus_text
from scenes.deck.bodies import DeckBody, deck_bodies
from scenes.deck.calculix import calculix_text
from scenes.deck.checks import check_exportable
from scenes.deck.model import model_text
from scenes.names import file_name
from scenes.read import Scene

MAX_MODES = 10_000
"""Modes that a deck may ask for."""
PROGRAMS = {"calculix": calculix_text, "abaqus": abaqus_text}
"""What writes the deck of each program."""


def write_deck(scene: Scene, folder: Path, modes: int = 20) -> list[Path]:
    """Write a scene as decks of CalculiX and Abaqus; collective, rank 0 writes.

    Parameters
    ----------
    scene
        A scene of Lagrange bodies whose elements these programs have.
    folder
        Folder of ``NAME_model.inp``, ``NAME_calculix.inp``, ``NAME_abaqus.inp``, NAME that of the
        scene, in which signs but letters, digits, _ and - become _.
    modes
        Number of modes to ask for.

    Returns
    -------
    list of Path
        The files, the model first.

    Raises
    ------
    SceneError, InputError
        When a deck cannot hold the scene, naming the field.
    """
    if not 1 <= modes <= MAX_MODES:
        raise InputError("modes", modes, f"1 to {MAX_MODES}")
    check_exportable(scene)
    name = file_name(scene.name)
    files = [folder / f"{name}_{kind}.inp" for kind in ("model", *PROGRAMS)]
    made_on_first(MPI.COMM_WORLD, lambda: _write(scene, files, modes))
    return files


def _write(scene: Scene, files: list[Path], modes: int) -> None:
    for file in files:
        check_writable(file, "out")
    bodies = deck_bodies(scene)
    model, *decks = files
    texts = [model_text(scene, bodies)]
    for program, write in PROGRAMS.items():
        texts.append(write(scene, bodies, model.name, modes, _told(scene, bodies, program)))
    for file, text in zip([model, *decks], texts, strict=True):
        write_whole(text.encode("ascii", "replace"), file)  # all that both programs surely read


def _told(scene: Scene, bodies: dict[str, DeckBody], program: str) -> list[str]:
    """What heads a deck."""
    lines = [f"{scene.name}, for {program}. Units are those of the scene."]
    lines += [
        f"{name}: {len(body.mesh.points)} nodes, {len(body.mesh.cells)} {body.element_type}"
        for name, body in bodies.items()
    ]
    for name, contact in scene.contacts.items():
        lines.append(
            f"Contact {name}: slave {contact.a}, master {contact.b}, penalty on the surface of the "
            f"slave in place of the formulation {contact.formulation.method}."
        )
    if program == "abaqus":
        lines.append("Written after the manual of Abaqus/Standard, and not run with it.")
    return lines
