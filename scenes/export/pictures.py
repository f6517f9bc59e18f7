"""Pictures of modes: at the phase of largest deflection, and through a period."""

from io import BytesIO
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from cea.files import write_whole
from scenes.pictures.drawing import Drawing
from scenes.results.result import Result

_FRAMES = 24
_FRAME_MILLISECONDS = 60
_REDUCTION = 2
"""Pixels of a window along each side of a pixel of an animation."""
_COLOURS = 128
"""Colours of an animation."""


def draw_modes(result: Result, count: int, out: Path, *, animated: bool = False) -> list[Path]:
    """Draw the most unstable modes, or the first ones where none is unstable.

    Parameters
    ----------
    result
        A complex eigenvalue analysis.
    count
        Number of modes at most.
    out
        Folder for the PNG files ``mode_<backend>_<number of the mode>.png``, at the phase of
        largest deflection.
    animated
        Whether to write GIF files too, of the same names: a period without growth.

    Returns
    -------
    list of Path
        The files, the most unstable mode first; rank 0 writes them.
    """
    modes = result.most_unstable(count)
    files = []
    for mode, drawing in zip_longest(modes, result.drawings(modes)):
        picture = out / f"mode_{result.scene.backends}_{mode + 1}.png"
        animation = picture.with_suffix(".gif")
        files += [picture, animation] if animated else [picture]
        if drawing is None:
            continue
        (image,) = drawing.images([0.0])
        write_whole(_content(image, "png"), picture)
        if animated:
            _write_animation(drawing, animation)
    return files


def _write_animation(drawing: Drawing, file: Path) -> None:
    """Write a period of a mode as an endless GIF."""
    phases = 2 * np.pi * np.arange(_FRAMES) / _FRAMES
    frames = drawing.images(phases.tolist(), _REDUCTION)
    # One table of colours, of all that a quarter period shows, keeps still parts still.
    quarter = np.concatenate([np.asarray(frame) for frame in frames[: _FRAMES // 4 + 1 : 2]])
    palette = Image.fromarray(quarter).quantize(_COLOURS)
    first, *others = (f.quantize(palette=palette, dither=Image.Dither.NONE) for f in frames)
    options = {"append_images": others, "duration": _FRAME_MILLISECONDS, "loop": 0}
    write_whole(_content(first, "gif", save_all=True, **options), file)


def _content(image: Image.Image, kind: str, **options: Any) -> bytes:
    """An image as the content of a file."""
    stream = BytesIO()
    image.save(stream, format=kind, **options)
    return stream.getvalue()
