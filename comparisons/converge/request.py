"""What is asked of ``cea converge``."""

from dataclasses import dataclass

from cea.errors import InputError
from scenes.spec.body import Backend


@dataclass(frozen=True)
class Request:
    """A scene, the digits asked for, what may be spent; options out of range are refused."""

    scene: str  # TOML file, or the name of a scene
    digits: int = 3  # significant ones of frequencies: errors are at most half a unit of the last
    growth_digits: int | None = None  # those of growth rates; None takes one less, 1 at least
    backends: tuple[Backend, ...] | None = None  # None takes those on which the scene has meshes
    budget: float = 900.0  # seconds that all of it may take
    unstable: bool = False  # whether only modes not known to be stable must hold their digits
    sweep_digits: int = 2  # digits that the mesh for sweeps must hold
    overrides: tuple[str, ...] = ()  # fields of the scene that differ, as ``--set`` takes them

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
    """Half a unit of the last of some significant digits, relative."""
    return 0.5 * 10.0**-digits
