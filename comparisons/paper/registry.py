"""Every figure by its name."""

from cea.errors import InputError
from comparisons.paper.common.figure import PaperFigure
from comparisons.paper.crowned_pad.study import CROWNED_PAD
from comparisons.paper.disc_pad.figures import DIAGRAMS
from comparisons.paper.disc_pad.lumping import LUMPING
from comparisons.paper.disc_pad.mode_shapes import SHAPES
from comparisons.paper.disc_pad.studies import STUDIES
from comparisons.paper.normal_compliance import NORMAL_COMPLIANCE
from comparisons.paper.patch_test.figures import PATCH_TEST_FIGURES
from comparisons.paper.patch_test.geometry import GEOMETRY_FIGURES
from comparisons.paper.patch_test.quadrature import QUADRATURE

_NUMBERED: tuple[PaperFigure, ...] = (
    NORMAL_COMPLIANCE,
    *GEOMETRY_FIGURES,
    *PATCH_TEST_FIGURES,
    *SHAPES,
    *DIAGRAMS,
)
_STUDIES: tuple[PaperFigure, ...] = (QUADRATURE, LUMPING, *STUDIES, CROWNED_PAD)

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
