"""Extras of the installation: which of them a command needs, told before it begins."""

from importlib.util import find_spec

_MODULES = {
    "pictures": ("matplotlib", "PIL", "plotly", "pyvista"),
    "maps": ("h5netcdf", "xarray"),
    "exact": ("flint",),
}
"""Modules that each extra of `pyproject.toml` brings."""


class MissingExtraError(Exception):
    """A command needs an extra that is not installed."""


def need(*extras: str) -> None:
    """Refuse to begin without what an extra brings.

    Parameters
    ----------
    extras
        Names of extras: ``pictures``, ``maps`` or ``exact``.

    Raises
    ------
    MissingExtraError
        With the command that installs it, when a module of one cannot be found.
    """
    for extra in extras:
        missing = [module for module in _MODULES[extra] if find_spec(module) is None]
        if missing:
            raise MissingExtraError(
                f"{', '.join(missing)} is not installed: "
                f"python -m pip install 'friction-cea[{extra}]'"
            )
