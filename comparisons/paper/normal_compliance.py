"""Figure 1: the law of normal compliance and its linearisation at a steady sliding state.

Equations 7 and 8 of the paper: a closure u_n - g_n is met by the pressure c_n (u_n - g_n)_+^m_n,
and a perturbation of it by p = m_n c_n (u_n - g_n)_+^(m_n - 1). No bodies are needed.
"""

from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from cea.contact.laws import NormalCompliance
from comparisons.kit.plots import AXIS, BLACK
from comparisons.kit.progress import Progress
from comparisons.kit.tables import Column, Table
from comparisons.paper.common.figure import Data, Number
from comparisons.paper.common.style import COLOURS, drawing
from scenes.spec.body import Backend


@dataclass(frozen=True)
class NormalComplianceFigure:
    """The law, its linearisation, and how far the one is from the other.

    Parameters
    ----------
    law
        The law.
    closure
        Closure of steady sliding (m).
    area
        Area by which p becomes a global contact stiffness P (m^2).
    """

    law: NormalCompliance
    closure: float
    area: float
    name: str = "1"
    title: str = "Figure 1: normal compliance and its linearisation at steady sliding"

    @property
    def stiffness(self) -> float:
        """Contact stiffness p (N/m^3) of small perturbations of steady sliding."""
        return float(self.law.slope(np.array(self.closure)))

    def inputs(self, backend: Backend) -> Data:
        """Constants; the same for every backend."""
        return asdict(self)

    def compute(self, backend: Backend, progress: Progress) -> Data:
        """The law and its linearisation over closures from open to twice the steady one."""
        progress.step(f"figure {self.name}")
        closure = np.linspace(-0.5, 2.0, 126) * self.closure
        steady = float(self.law.pressure(np.array(self.closure)))
        linear = steady + self.stiffness * (closure - self.closure)
        return {
            "closure": closure.tolist(),
            "pressure": self.law.pressure(closure).tolist(),
            "linearised": linear.tolist(),
            "steady": [self.closure, steady],
            "stiffness": self.stiffness,
        }

    def draw(self, data: Data, stem: Path) -> list[Path]:
        """Draw both, with the steady state."""
        file = stem.with_suffix(".png")
        x = 1e6 * np.array(data["closure"])
        at, steady = data["steady"]
        with drawing(file, (6.5, 4.2)) as figure:
            axes = figure.subplots()
            axes.plot(
                x,
                np.array(data["pressure"]) / 1e6,
                color=COLOURS[0],
                label=r"$c_n (u_n - g_n)_+^{m_n}$",
            )
            axes.plot(
                x,
                np.array(data["linearised"]) / 1e6,
                "--",
                color=COLOURS[1],
                label=r"$m_n c_n (\overline{u}_n - g_n)^{m_n - 1}\, \tilde{u}_n$ "
                "about steady sliding",
            )
            axes.plot([1e6 * at], [steady / 1e6], "o", color=BLACK, label="steady sliding")
            axes.axvline(0.0, color=AXIS, linewidth=0.6)
            axes.annotate("open", (0.2, 0.02), xycoords="axes fraction", ha="right")
            axes.set(xlabel=r"closure $u_n - g_n$ (µm)", ylabel="contact pressure (N/mm²)")
            axes.set_ylim(bottom=-0.6 * steady / 1e6)
            axes.set_title(self.title)
            axes.grid(visible=True)
            axes.legend()
        return [file]

    def numbers(self, data: Data) -> list[Number]:
        """Stiffness of the linearisation, and its error for two perturbations."""
        at, steady = data["steady"]
        errors = [
            Number(
                f"error of the linearised change, perturbation {part:.0%} of the closure",
                None,
                self.error(part),
            )
            for part in (0.01, 0.1)
        ]
        return [
            Number("m_n", None, self.law.m),
            Number("c_n", None, self.law.c, f"N/m^{2 + self.law.m:g}"),
            Number("closure of steady sliding", None, at, "m"),
            Number("pressure of steady sliding", None, steady, "N/m²"),
            Number("p = m_n c_n (u_n - g_n)^(m_n - 1)", None, data["stiffness"], "N/m³"),
            Number("P, over the pad of disc_pad", None, data["stiffness"] * self.area, "N/m"),
            *errors,
        ]

    def error(self, part: float) -> float:
        """Relative error of the change of pressure when the closure grows by a part of itself."""
        change = self.law.pressure(np.array([1.0 + part, 1.0]) * self.closure)
        exact = float(change[0] - change[1])
        return 1 - self.stiffness * part * self.closure / exact

    def note(self, data: Data) -> str:
        """Where the constants come from."""
        return (
            "The paper draws the law without numbers. The constants here give 1 N/mm² at a "
            "closure of 10 µm, and P near the 10⁹ N/m of Figure 6."
        )

    def tables(self, data: Data, stem: str) -> list[Table]:
        """Both curves."""
        names = ("closure", "pressure", "linearised")
        return [
            Table(
                f"{stem}_curves",
                self.title,
                tuple(Column(name, name) for name in names),
                list(zip(*(data[name] for name in names), strict=True)),
            )
        ]


_PAD_AREA = 0.5 * (0.14**2 - 0.09**2) * np.radians(40.0)

NORMAL_COMPLIANCE = NormalComplianceFigure(NormalCompliance(1e16, 2.0), 1e-5, float(_PAD_AREA))
"""Figure 1."""
