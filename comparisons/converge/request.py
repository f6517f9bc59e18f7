"""Input of ``cea converge``."""

from dataclasses import dataclass

from cea.errors import InputError
from scenes.spec.body import Backend


@dataclass(frozen=True)
class Request:
    """A scene, the digits requested and the budget; options out of range are refused."""

    scene: str  # TOML file, or the name of a scene
    digits: int = 3  # significant digits of frequencies: bars of at most half a unit of the last
    growth_digits: int | None = None  # digits of growth rates; None: one less, at least 1
    backends: tuple[Backend, ...] | None = None  # None: those for which the scene has meshes
    budget: float = 900.0  # time limit (s)
    unstable: bool = False  # whether stable modes need no digits
    sweep_digits: int = 2  # digits of the mesh for sweeps
    overrides: tuple[str, ...] = ()  # changes of the scene, as for ``--set``

    def __post_init__(self) -> None:
        for name, value in (
            ("digits", self.digits),
            ("growth_digits", self.of_growth),
            ("sweep_digits", self.sweep_digits),
        ):
            if not 1 <= value <= 10:
                raise InputError(name, value, "1 to 10")
        if not self.budget > 0:
            raise InputError("budget", self.budget, "more than 0 seconds")

    @property
    def of_growth(self) -> int:
        """Digits of growth rates."""
        return max(1, self.digits - 1) if self.growth_digits is None else self.growth_digits


def half_unit(digits: int) -> float:
    """Return half a unit of the last significant digit, relative to the number."""
    return 0.5 * 10.0**-digits
