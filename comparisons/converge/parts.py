"""The error of every mode as a sum of parts, one for each body and direction and for its edges.

What each part is comes from measurement on one mesh (:mod:`comparisons.converge.probes`); how it
falls from theory (:mod:`comparisons.converge.theory`). A part of smooth solutions falls with the
elements along its direction and the degree of its body, that of singular edges with the elements
across them and their layers. Bodies and directions so are refined by what they owe, and the errors
of two meshes are compared that are finer in different directions.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import log

import numpy as np

from cea.arrays import Floats, Ints
from comparisons.converge.theory import EXPONENT, LARGEST_ERROR, SMALLEST_ERROR
from scenes.refinement import RATIO, BodyResolution, Resolution


_LEAST_STEP = 0.1
"""What a finer mesh takes off at least: parts that are rounding do not tell."""


@dataclass(frozen=True)
class Part:
    """What a part of the errors comes from.

    Parameters
    ----------
    body
        Name of the body.
    directions
        Numbers of the directions along which finer elements make it fall: one; all of an
        unstructured mesh; those across which singular edges lie.
    edges
        Whether it is that of singular edges.
    """

    body: str
    directions: tuple[int, ...]
    edges: bool = False


@dataclass(frozen=True)
class Parts:
    """Errors of all modes of one mesh in their parts.

    Parameters
    ----------
    parts
        What the parts come from.
    errors
        Relative errors of lambda, shape (modes, parts).
    resolution
        The mesh on which they were measured, densities of all bodies given.
    level
        Its number in the sequence.
    """

    parts: tuple[Part, ...]
    errors: Floats
    resolution: Resolution
    level: int

    def at(self, resolution: Resolution, errors: Floats | None = None) -> Floats:
        """Errors in their parts on another mesh, shape (modes, parts).

        Parameters
        ----------
        resolution
            The mesh, densities of all bodies given.
        errors
            Errors on the mesh on which parts were measured; by default those measured.
        """
        old, new = dict(self.resolution.bodies), dict(resolution.bodies)
        before = self.errors if errors is None else errors
        columns = [
            _fallen(before[:, i], part, old[part.body], new[part.body])
            for i, part in enumerate(self.parts)
        ]
        return np.stack(columns, axis=1)

    def of(self, modes: Ints | None) -> Floats:
        """Parts of some modes, the largest of each; those usual in the window where None."""
        if modes is None or not len(modes):
            return np.median(self.errors, axis=0)[None, :]
        return self.errors[modes].max(axis=0)[None, :]

    def positions(self, modes: Ints | None, resolutions: Sequence[Resolution]) -> list[float]:
        """Logarithms, rising, of what the errors of some modes have fallen to on each mesh."""
        own = self.of(modes)
        sums = [max(float(self.at(each, own).sum()), SMALLEST_ERROR) for each in resolutions]
        found = [-log(sums[0])]
        for each in sums[1:]:
            found.append(max(-log(each), found[-1] + _LEAST_STEP))
        return found

    def of_bodies(self) -> Mapping[Part, float]:
        """Median of every part over the modes."""
        medians = np.median(self.errors, axis=0).tolist()
        return dict(zip(self.parts, medians, strict=True))


def _fallen(errors: Floats, part: Part, old: BodyResolution, new: BodyResolution) -> Floats:
    """A part of all modes on a finer, or a coarser, mesh of its body."""
    each = [log(new.densities[d] / old.densities[d]) for d in part.directions]
    more = min(each)
    if part.edges:
        taken = 2 * (more - (new.layers - old.layers) * log(RATIO))
        return np.asarray(errors * np.exp(-EXPONENT * (taken + 4 * log(new.degree / old.degree))))
    left = np.log(np.clip(errors, SMALLEST_ERROR, LARGEST_ERROR))
    finer = left - 2 * old.degree * more
    low, high = sorted((old.degree, new.degree))
    for degree in range(low, high):
        finer = finer * ((degree + 1) / degree if new.degree > old.degree else degree / (degree + 1))
    return np.asarray(errors * np.exp(finer - left))
