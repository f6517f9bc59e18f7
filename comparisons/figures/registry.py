"""Every figure by its name."""

from cea.errors import InputError
from comparisons.figures.figure import PaperFigure
from comparisons.figures.patch_figures import PATCH_FIGURES
from comparisons.figures.quadrature import QUADRATURE
from comparisons.figures.settings import SETTINGS

_NUMBERED: tuple[PaperFigure, ...] = (*SETTINGS, *PATCH_FIGURES)
_STUDIES: tuple[PaperFigure, ...] = (QUADRATURE,)

FIGURES: dict[str, PaperFigure] = {
    figure.name: figure
    for figure in (*sorted(_NUMBERED, key=lambda figure: int(figure.name)), *_STUDIES)
}
"""Figures by number, then studies by name."""


def chosen(name: str) -> list[PaperFigure]:
    """The figure of a name, or every one for ``all``.

    Raises
    ------
    InputError
        When there is no such figure.
    """
    if name == "all":
        return list(FIGURES.values())
    if name not in FIGURES:
        raise InputError("figure", name, f"one of {', '.join(FIGURES)}, or all")
    return [FIGURES[name]]
