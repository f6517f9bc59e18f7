"""Pictures of modes, at the phase of largest deflection."""

from pathlib import Path

from cea.files import write_whole
from scenes.pictures.drawing import png
from scenes.results.result import Result


def write_modes(result: Result, count: int, out: Path) -> list[Path]:
    """Draw so many modes, the most unstable first, or the first ones where none is; collective.

    Rank 0 writes the files ``mode_<backend>_<number of the mode>.png``.
    """
    modes = result.most_unstable(count)
    files = [out / f"mode_{result.scene.backends}_{mode + 1}.png" for mode in modes]
    for file, image in zip(files, result.images(modes), strict=False):
        write_whole(png(image), file)
    return files
