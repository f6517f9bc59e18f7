"""What every page shares: its layout, tables and images in it."""

from base64 import b64encode
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined


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


def render(template: Path, **context: Any) -> str:
    """Render a template of an application; layout and macros stand beside this module."""
    environment = Environment(
        loader=FileSystemLoader([template.parent, Path(__file__).parent]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template.name).render(context)
