"""Every figure by its name."""

from cea.errors import InputError
from comparisons.figures.cea_figures import DIAGRAMS
from comparisons.figures.cea_lumping import LUMPING
from comparisons.figures.cea_shapes import SHAPES
from comparisons.figures.cea_studies import STUDIES
from comparisons.figures.figure import PaperFigure
from comparisons.figures.normal_compliance import NORMAL_COMPLIANCE
from comparisons.figures.patch_figures import PATCH_FIGURES
from comparisons.figures.quadrature import QUADRATURE
from comparisons.figures.settings import SETTINGS

_NUMBERED: tuple[PaperFigure, ...] = (
    NORMAL_COMPLIANCE,
    *SETTINGS,
    *PATCH_FIGURES,
    *SHAPES,
    *DIAGRAMS,
)
_STUDIES: tuple[PaperFigure, ...] = (QUADRATURE, LUMPING, *STUDIES)

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
