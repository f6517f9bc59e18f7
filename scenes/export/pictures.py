"""Pictures of modes, at the phase of largest deflection."""

from pathlib import Path

from cea.files import write_whole
from scenes.pictures.drawing import png
from scenes.results.result import Result


def write_modes(result: Result, count: int, out: Path) -> list[Path]:
    """Draw the most unstable modes, or the first ones where none is unstable; collective.

    Parameters
    ----------
    result
        A complex eigenvalue analysis.
    count
        Number of modes at most.
    out
        Folder for the PNG files ``mode_<backend>_<number of the mode>.png``.

    Returns
    -------
    list of Path
        The files, the most unstable mode first; rank 0 writes them.
    """
    modes = result.most_unstable(count)
    files = [out / f"mode_{result.scene.backends}_{mode + 1}.png" for mode in modes]
    for file, image in zip(files, result.images(modes), strict=False):
        write_whole(png(image), file)
    return files
