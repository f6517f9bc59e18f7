"""A figure on both backends: overlaid where it can be, else its pictures side by side."""

from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Protocol, runtime_checkable

from PIL import Image

from cea.files import write_whole
from cea.petsc import MPI
from comparisons.kit.progress import Progress
from comparisons.paper.common.figure import Data, PaperFigure
from comparisons.paper.common.store import MadeFigure, make_figure
from scenes.results.record import read_record
from scenes.spec.body import Backend

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
            backend: read_record(each.data_file) for backend, each in made.items()
        }
        return BothMade(made, figure.draw_both(data, stem))
    pictures = [each.pictures[0] for each in made.values()]
    return BothMade(made, [side_by_side(pictures, stem.with_suffix(".png"))])


def side_by_side(pictures: list[Path], file: Path) -> Path:
    """Join pictures into one, next to each other, pixel by pixel."""
    images = [Image.open(picture).convert("RGB") for picture in pictures]
    size = sum(image.width for image in images), max(image.height for image in images)
    joined = Image.new("RGB", size, "white")
    left = 0
    for image in images:
        joined.paste(image, (left, 0))
        left += image.width
    stream = BytesIO()
    joined.save(stream, format="png")
    return write_whole(stream.getvalue(), file)
