"""What a page holds to draw plots itself: plotly.js of the Python package plotly, our scripts.

Pages ask nothing of a network.
"""

from functools import cache
from html import escape
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from markupsafe import Markup

from comparisons.kit.binary import packed
from comparisons.kit.plots import BLUE, GREY, ORANGE, VERMILION

_HERE = Path(__file__).parent
_SCRIPTS = ("tables.js", "contents.js", "plots.js", "shapes.js", "viewer.js", "start.js")

VERDICT_MARKS = {
    "unstable": ("triangle-up", VERMILION, "▲"),
    "grows slowly": ("triangle-up-open", VERMILION, "△"),
    "undecided": ("diamond", ORANGE, "◆"),
    "stable": ("circle", BLUE, "●"),
    "rigid": ("circle-open", GREY, "○"),
}
"""Marker, colour and sign of each verdict: none is told by colour alone."""


def literal(text: Any) -> str:
    """Text as plotly.js shows it, which reads tags in it."""
    return escape(str(text), quote=False)


def sign(verdict: str) -> str:
    """The word of a mode, or of a run, with its sign where it has one."""
    return f"{VERDICT_MARKS[verdict][2]} {verdict}" if verdict in VERDICT_MARKS else verdict


@cache
def library() -> str:
    """plotly.js as a page holds it: compressed with gzip, in base64.

    Raises
    ------
    ModuleNotFoundError
        Where the package plotly is not installed.
    """
    found = find_spec("plotly")
    if found is None or not found.submodule_search_locations:
        raise ModuleNotFoundError("plotly")
    folder = Path(found.submodule_search_locations[0])
    return packed((folder / "package_data" / "plotly.min.js").read_bytes())


@cache
def scripts() -> Markup:
    """Our own scripts of every page."""
    return Markup("\n".join((_HERE / "scripts" / name).read_text("utf-8") for name in _SCRIPTS))


@cache
def style() -> Markup:
    """Style of every page."""
    return Markup((_HERE / "style.css").read_text("utf-8"))
