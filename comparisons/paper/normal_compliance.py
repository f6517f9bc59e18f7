"""Figure 1: the law of normal compliance and its linearisation at a steady sliding state.

Equations 7 and 8 of the paper: the pressure is c_n (u_n - g_n)_+^m_n for the closure u_n - g_n, and
its derivative is p = m_n c_n (u_n - g_n)_+^(m_n - 1). No bodies are needed.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cea.contact.pressure_and_friction import NormalCompliance
from comparisons.paper.figure import Figure, Mesh, Row, Tables, quoted, rows_of
from comparisons.study.session import Session

LAW, CLOSURE = NormalCompliance(1e16, 2.0), 1e-5
"""The law, and the closure of steady sliding (m): its pressure is 1 N/mm^2, and P is near the
1e9 N/m of Figure 6 of the paper, which draws the law without numbers."""
_AREA = float(0.5 * (0.14**2 - 0.09**2) * np.radians(40.0))  # of the pad, P = p * area (m^2)


@dataclass(frozen=True)
class Law(Figure):
    """The law, its linearisation, and the error of the linearisation."""

    def inputs(self, mesh: Mesh) -> Mapping[str, Any]:
        """Return the constants."""
        return {"law": LAW, "closure": CLOSURE, "area": _AREA}

    def evaluate(self, mesh: Mesh, session: Session) -> Tables:
        """Return the law and its tangent for closures from open to twice the steady one."""
        at = np.array(CLOSURE)
        closure = np.linspace(-0.5, 2.0, 126) * at
        steady, p = float(LAW.pressure(at)), float(LAW.slope(at))
        curves = {"law": LAW.pressure(closure), "linearised": steady + p * (closure - at)}
        rows: list[Row] = []
        for curve, pressure in curves.items():
            rows += rows_of({"curve": [curve] * 126, "closure": closure, "pressure": pressure})
        numbers = [
            quoted("m_n", None, LAW.m),
            quoted("c_n", None, LAW.c, f"N/m^{2 + LAW.m:g}"),
            quoted("closure of steady sliding", None, CLOSURE, "m"),
            quoted("pressure of steady sliding", None, steady, "N/m²"),
            quoted("p = m_n c_n (u_n - g_n)^(m_n - 1)", None, p, "N/m³"),
            quoted("P, over the pad of disc_pad", None, p * _AREA, "N/m"),
        ]
        for part in (0.01, 0.1):
            change = f"error of the linearised change, perturbation {part:.0%}"
            numbers.append(quoted(change, None, error(part)))
        return {"law": rows, "numbers": numbers}


def error(part: float) -> float:
    """Return the relative error of the linearised pressure change, for a relative change."""
    change = LAW.pressure(np.array([1.0 + part, 1.0]) * CLOSURE)
    slope = float(LAW.slope(np.array(CLOSURE)))
    return 1 - slope * part * CLOSURE / float(change[0] - change[1])


NORMAL_COMPLIANCE = Law(
    "1", "Normal compliance and its linearisation at steady sliding", meshes=("none",)
)
"""Figure 1."""
