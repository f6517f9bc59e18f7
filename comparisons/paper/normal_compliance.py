"""Figure 1: the law of normal compliance and its linearisation at a steady sliding state.

Equations 7 and 8 of the paper: the pressure is c_n (u_n - g_n)_+^m_n for the closure u_n - g_n, and
its derivative is p = m_n c_n (u_n - g_n)_+^(m_n - 1). No bodies are needed.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cea.contact.laws import NormalCompliance
from comparisons.paper.figure import Figure, Mesh, Row, Tables, quoted, rows_of
from comparisons.study.session import Session


@dataclass(frozen=True)
class Law(Figure):
    """The law, its linearisation, and the error of the linearisation."""

    law: NormalCompliance
    closure: float  # of steady sliding (m)
    area: float  # contact area, P = p * area (m^2)

    def inputs(self, mesh: Mesh) -> Mapping[str, Any]:
        """Return the constants."""
        return {"law": self.law, "closure": self.closure, "area": self.area}

    def evaluate(self, mesh: Mesh, session: Session) -> Tables:
        """Return the law and its tangent for closures from open to twice the steady one."""
        law, at = self.law, np.array(self.closure)
        closure = np.linspace(-0.5, 2.0, 126) * at
        steady, p = float(law.pressure(at)), float(law.slope(at))
        curves = {"law": law.pressure(closure), "linearised": steady + p * (closure - at)}
        rows: list[Row] = []
        for curve, pressure in curves.items():
            rows += rows_of({"curve": [curve] * 126, "closure": closure, "pressure": pressure})
        numbers = [
            quoted("m_n", None, law.m),
            quoted("c_n", None, law.c, f"N/m^{2 + law.m:g}"),
            quoted("closure of steady sliding", None, self.closure, "m"),
            quoted("pressure of steady sliding", None, steady, "N/m²"),
            quoted("p = m_n c_n (u_n - g_n)^(m_n - 1)", None, p, "N/m³"),
            quoted("P, over the pad of disc_pad", None, p * self.area, "N/m"),
        ]
        for part in (0.01, 0.1):
            change = f"error of the linearised change, perturbation {part:.0%}"
            numbers.append(quoted(change, None, self.error(part)))
        return {"law": rows, "numbers": numbers}

    def error(self, part: float) -> float:
        """Return the relative error of the linearised pressure change, for a relative change."""
        change = self.law.pressure(np.array([1.0 + part, 1.0]) * self.closure)
        slope = float(self.law.slope(np.array(self.closure)))
        return 1 - slope * part * self.closure / float(change[0] - change[1])


_PAD_AREA = 0.5 * (0.14**2 - 0.09**2) * np.radians(40.0)
NORMAL_COMPLIANCE = Law(
    "1",
    "Normal compliance and its linearisation at steady sliding",
    NormalCompliance(1e16, 2.0),
    1e-5,
    float(_PAD_AREA),
    meshes=("none",),
)
"""Constants for 1 N/mm^2 at a closure of 10 micrometres, and P near the 1e9 N/m of Figure 6 of the
paper, which draws the law without numbers."""
