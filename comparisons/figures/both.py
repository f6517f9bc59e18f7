"""A figure on both backends: overlaid where it can be, else its pictures side by side."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

from matplotlib.image import imread
from mpi4py import MPI

from comparisons.compare import Progress
from comparisons.figures.figure import Data, PaperFigure
from comparisons.figures.store import MadeFigure, make_figure
from comparisons.figures.style import drawing
from comparisons.report.figures import DPI
from comparisons.scene import Backend

BACKENDS: tuple[Backend, ...] = ("iga", "fe")


@runtime_checkable
class Overlaid(Protocol):
    """A figure that draws both backends in one picture."""

    def draw_both(self, data: Mapping[Backend, Data], stem: Path) -> list[Path]:
        """Draw computed data of both backends to files whose names begin with ``stem``."""
        ...


@dataclass(frozen=True)
class BothMade:
    """A figure made on both backends.

    Parameters
    ----------
    made
        The figure by backend; one alone where no backend has a part in it.
    pictures
        Pictures of both backends together.
    """

    made: Mapping[Backend, MadeFigure]
    pictures: list[Path]


def make_both(
    figure: PaperFigure, out: Path, progress: Progress, *, recompute: bool = False
) -> BothMade:
    """Make a figure on each backend, or take what is stored of it, and draw them together.

    Parameters
    ----------
    figure
        The figure.
    out
        Folder of its files; the pictures are ``figure_<name>_both``. Rank 0 writes.
    progress
        Where progress is shown.
    recompute
        Whether stored data are left aside.
    """
    apart = figure.inputs("iga") != figure.inputs("fe")
    made = {
        backend: make_figure(figure, backend, out, progress, recompute=recompute)
        for backend in (BACKENDS if apart else BACKENDS[:1])
    }
    if not apart or MPI.COMM_WORLD.rank:
        return BothMade(made, [])
    stem = out / f"figure_{figure.name}_both"
    if isinstance(figure, Overlaid):
        data: dict[Backend, Data] = {
            backend: json.loads(each.data_file.read_text(encoding="utf-8"))
            for backend, each in made.items()
        }
        return BothMade(made, figure.draw_both(data, stem))
    pictures = [each.pictures[0] for each in made.values()]
    return BothMade(made, [side_by_side(pictures, stem.with_suffix(".png"))])


def side_by_side(pictures: list[Path], file: Path) -> Path:
    """Join pictures into one, next to each other, pixel by pixel."""
    images = [imread(picture) for picture in pictures]
    widths = [image.shape[1] / DPI for image in images]
    height = max(image.shape[0] for image in images) / DPI
    with drawing(file, (sum(widths), height)) as figure:
        figure.set_layout_engine("none")
        left = 0.0
        for image, width in zip(images, widths, strict=True):
            part = image.shape[0] / DPI / height
            axes = figure.add_axes((left / sum(widths), 1 - part, width / sum(widths), part))
            axes.imshow(image, aspect="auto")
            axes.set_axis_off()
            left += width
    return file
