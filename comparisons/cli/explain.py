"""What ``cea run --explain`` tells: the steps of a run and what it leaves out, with reasons."""

from collections.abc import Mapping
from typing import Literal

import typer


def explain_bodies(scene: str, set_: list[str], backend: Literal["fe", "iga"] | None) -> None:
    """Tell the steps of a scene of bodies; nothing is built."""
    from scenes.checking.steps import needed_by, skipped_by
    from scenes.spec.reading import load_scene

    chosen = load_scene(scene, set_, backend)
    _tell(needed_by(chosen), skipped_by(chosen))


def explain_matrices(scene: str, set_: list[str], data: str | None) -> None:
    """Tell the steps of a scene of matrices, which are read: their entries decide."""
    from scenes.matrices.pencil import read_pieces
    from scenes.running.matrices import skipped_by
    from scenes.spec.matrices import ROLES, load_matrices

    chosen = load_matrices(scene, set_, data)
    needed: dict[str, str] = {}
    for role in ROLES:
        if matrices := chosen.sum(role):
            needed[role] = " + ".join(matrices)
    needed["eigenvalues"] = f"to {chosen.window.max_frequency:g} Hz"
    _tell(needed, skipped_by(chosen, read_pieces(chosen)))


def _tell(needed: Mapping[str, str], skipped: Mapping[str, str]) -> None:
    for title, steps in (("steps", needed), ("left out", skipped)):
        typer.echo(f"{title}:")
        for name, reason in steps.items():
            typer.echo(f"  {name}: {reason}")
