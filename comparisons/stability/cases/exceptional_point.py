"""Next to a coalescence, where eigenvalues have the square root of a perturbation."""

from collections.abc import Iterator

import numpy as np
from scipy.linalg import block_diag

from comparisons.stability.parts.case import ACCURATE, NONE, WARNED, Run, case
from comparisons.stability.parts.dense import lambdas
from comparisons.stability.parts.problems import OfMatrices
from comparisons.stability.parts.references import formula
from comparisons.stability.parts.ways import ALONE

_K11, _K12, _K22, _K3 = 2.5, 0.5, 2.0, 4 / 3
_CRITICAL = ((_K11 - _K22) ** 2 + 4 * _K12**2) / (4 * _K12 * _K3)
"""Friction at which both modes of Hoffmann's model coalesce."""
_OTHERS = np.linspace(0.6, 4.0, 6)
"""Eigenvalues kappa beside it, of dofs that are coupled to nothing."""
_CLEAR = 1e-6
"""Distance from which growth is far above rounding and the threshold."""


@case("Hoffmann's model at 1e-2 to 1e-14 from its coalescence", subject="friction and spectra")
def exceptional_point() -> Iterator[Run]:
    """Beyond mu_c (1 + d) it grows by about sqrt(d); below there is no growth to be found."""
    for side, word in ((1.0, "beyond"), (-1.0, "before")):
        for distance in (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14):
            # kappa = 2.25 -+ sqrt(-d (k11 - k22)^2 / 4 - d k12^2), with mu_c as it is
            split = -side * distance * ((_K11 - _K22) ** 2 / 4 + _K12**2)
            root = np.sqrt(complex(split))
            middle = 0.5 * (_K11 + _K22)
            true = lambdas(np.array([middle - root, middle + root, *_OTHERS]))
            friction = np.zeros((8, 8))
            friction[0, 1] = _CRITICAL * (1 + side * distance) * _K3
            yield Run(
                f"{word} it by {distance:.0e}",
                ALONE[0],
                OfMatrices(
                    block_diag([[_K11, _K12], [_K12, _K22]], np.diag(_OTHERS)),
                    np.eye(8),
                    friction,
                ),
                formula(true.tolist()),
                ACCURATE if distance > _CLEAR else WARNED,
                lowest=7,
                warnings=NONE,
            )
