"""Pictures of modes: at the phase of largest deflection, and through a period."""

from pathlib import Path

import numpy as np
from PIL import Image

from cea.errors import InputError
from comparisons.kit.numbers import backend_name
from scenes.drawing import Drawing, largest_deflection
from scenes.run import SceneResult
from scenes.run_matching import complex_displacement
from scenes.spec import ComplexEigenvalueAnalysis

__all__ = ["Drawing", "chosen_modes", "draw_modes", "largest_deflection"]

_FRAMES = 24
_FRAME_MILLISECONDS = 60
_REDUCTION = 2
"""Pixels of a window along each side of a pixel of an animation."""
_COLOURS = 128
"""Colours of an animation."""


def draw_modes(result: SceneResult, count: int, out: Path, *, animated: bool = False) -> list[Path]:
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

    Raises
    ------
    InputError
        When the scene has no modes.
    """
    if result.modes is None:
        raise InputError("output.pictures", count, "0 for a static analysis: it has no modes")
    bodies = result.system.bodies
    backend = "+".join(sorted({spec.backend for spec in result.scene.bodies.values()}))
    samples = {name: body.volume_sample(2) for name, body in bodies.items()}
    is_root = next(iter(bodies.values())).comm.rank == 0
    if is_root:
        out.mkdir(parents=True, exist_ok=True)
    files = []
    for mode in chosen_modes(result, count):
        vector = result.modes.vector(mode)
        dofs = {
            name: complex_displacement(result.system, name, *vector, everywhere=False)
            for name in bodies
        }
        for part in vector:
            part.destroy()
        picture = out / f"mode_{backend}_{mode + 1}.png"
        animation = picture.with_suffix(".gif")
        files += [picture, animation] if animated else [picture]
        if is_root:
            title = (
                f"{backend_name(backend)}, mode {mode + 1}: "
                f"{result.modes.frequencies[mode]:.2f} Hz, "
                f"growth rate {result.modes.growth_rates[mode]:+.2f} 1/s"
            )
            drawing = Drawing.of(
                samples, {name: samples[name].values @ dofs[name] for name in bodies}, title
            )
            (image,) = drawing.images([0.0])
            image.save(picture)
            if animated:
                _write_animation(drawing, animation)
    return files


def chosen_modes(result: SceneResult, count: int) -> list[int]:
    """Numbers, from 0, of the most unstable modes; of the first ones where none is unstable."""
    assert result.modes is not None
    assert isinstance(result.scene.analysis, ComplexEigenvalueAnalysis)
    unstable = np.flatnonzero(result.modes.unstable(result.scene.analysis.growth_threshold))
    if not len(unstable):
        return list(range(min(count, len(result.modes.eigenvalues))))
    order = np.argsort(-result.modes.growth_rates[unstable], kind="stable")
    return unstable[order][:count].tolist()


def _write_animation(drawing: Drawing, file: Path) -> None:
    """Write a period of a mode as an endless GIF."""
    phases = 2 * np.pi * np.arange(_FRAMES) / _FRAMES
    frames = drawing.images(phases.tolist(), _REDUCTION)
    # One table of colours, of all that a quarter period shows, keeps still parts still.
    quarter = np.concatenate([np.asarray(frame) for frame in frames[: _FRAMES // 4 + 1 : 2]])
    palette = Image.fromarray(quarter).quantize(_COLOURS)
    first, *others = (f.quantize(palette=palette, dither=Image.Dither.NONE) for f in frames)
    first.save(file, save_all=True, append_images=others, duration=_FRAME_MILLISECONDS, loop=0)
