"""What every page shares: its layout, tables, plots and images in it, and what lies beside it."""

from base64 import b64encode
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from comparisons.kit.interactive import library, scripts, style

if TYPE_CHECKING:
    from comparisons.kit.shapes import Shapes


REPORT = "report.html"
"""Name of a page."""


@dataclass(frozen=True)
class Image:
    """An image that a page holds.

    Parameters
    ----------
    source
        The PNG file as a ``data:`` address.
    file
        Name of the file.
    """

    source: str
    file: str

    @classmethod
    def of(cls, file: Path) -> "Image":
        """Read a PNG file."""
        return cls("data:image/png;base64," + b64encode(file.read_bytes()).decode(), file.name)


def render(
    template: Path, *, plots: bool = False, shapes: "Shapes | None" = None, **context: Any
) -> str:
    """Render a template of an application; layout and macros stand beside this module.

    Parameters
    ----------
    template
        The template.
    plots
        Whether the page draws plots itself: then it holds the library that draws them.
    shapes
        Modes that it shows.
    context
        What the template uses.

    Returns
    -------
    str
        The page: one file that needs no other. Texts are escaped.
    """
    environment = Environment(
        loader=FileSystemLoader([template.parent, Path(__file__).parent]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template.name).render(
        **context,
        style=style(),
        scripts=scripts(),
        library=library() if plots else "",
        shapes=shapes,
    )
