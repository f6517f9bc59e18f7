"""Input checks that scenes, meshes of either backend and the API share.

Each refuses with :class:`cea.errors.InputError` before work begins, naming field, value and what
is allowed.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.errors import InputError
from cea.material import IsotropicMaterial
from cea.suggestions import did_you_mean

_FLAT = 1e-10
"""Smallest Jacobian of a cell, relative to its largest, that is not called inverted."""


_TILTED = 1e-4
"""Angle (rad) from which surfaces are said to be tilted."""


def check_surface(name: str, known: Iterable[str], field: str) -> None:
    """Refuse a surface that does not exist."""
    names = list(known)
    if name not in names:
        there = ", ".join(names) or "none: no surface is named"
        raise InputError(field, name, f"one of {there}{did_you_mean(name, names)}")


def check_density(material: IsotropicMaterial, field: str) -> float:
    """Density (kg/m^3) of a material that needs one; refuse one without."""
    if material.rho is None:
        raise InputError(f"{field}.rho", None, "a density (kg/m^3) is needed for eigenvalues")
    return material.rho


def check_knots(knots: Floats, degree: int, functions: int, field: str) -> None:
    """Refuse knots that do not rise, are not open, or repeat an inner knot beyond the degree."""
    n, p = functions, degree
    ends = len(knots) == n + p + 1 and np.ptp(knots[: p + 1]) == np.ptp(knots[n:]) == 0
    inner = knots[p + 1 : n]
    inside = np.all((inner > knots[0]) & (inner < knots[-1])) and knots[0] < knots[-1]
    continuous = not len(inner) or np.unique(inner, return_counts=True)[1].max() <= p
    if not (ends and inside and continuous and np.all(np.diff(knots) >= 0)):
        allowed = f"{n + p + 1} rising knots, ends {p + 1} times, others at most {p} times"
        raise InputError(field, knots, allowed)


def check_weights(weights: Any, field: str) -> None:
    """Refuse weights that are not positive."""
    if not (np.isfinite(weights).all() and np.all(np.asarray(weights) > 0)):
        raise InputError(field, weights, "positive numbers")


def check_point_weights(weights: Floats, field: str) -> None:
    """Refuse points of a contact whose area weights are not numbers, zero or positive.

    A negative weight is a negative stiffness: such a rule has no K_n that is positive, no sqrt(D).
    """
    wrong = ~(np.isfinite(weights) & (weights >= 0))
    if wrong.any() or (len(weights) and not (weights > 0).any()):
        value = float(weights[wrong][0]) if wrong.any() else 0.0
        allowed = "area weights of points that are zero or positive, and some positive"
        raise InputError(f"{field}.formulation.weights", value, allowed)


def check_jacobians(jacobians: Floats, field: str) -> None:
    """Refuse cells that are inverted: whose Jacobian changes sign or vanishes inside.

    Parameters
    ----------
    jacobians
        Jacobian determinants at points of each cell, shape (cells, points).
    field
        Name of the mesh, for the message.
    """
    largest = np.abs(jacobians).max(axis=1)
    turned = np.sign(jacobians[:, :1]) * jacobians
    inverted = ~(turned.min(axis=1) > _FLAT * largest)
    if inverted.any():
        allowed = "cells whose Jacobian keeps its sign: some are inverted or flat"
        value = f"{inverted.sum()} of {len(jacobians)} cells"
        raise InputError(field, value, allowed)


def check_coverage(missed: int, count: int, fraction: float, limit: float, **words: str) -> None:
    """Refuse a contact whose points find too little on the other side.

    Parameters
    ----------
    missed, count
        Points that found nothing, and all points.
    fraction
        Share of the rule's area that found nothing.
    limit
        Largest share allowed.
    words
        ``field``, ``sides`` and ``reach`` for the message.
    """
    if fraction > limit and not missed:
        raise InputError(
            words["field"],
            words["sides"],
            f"surfaces that face each other within {words['reach']}: {100 * fraction:.2g} % of the "
            "area of side a has no points, for they find nothing on side b there, or the rule is "
            f"too coarse for the weights of a spline; at most {100 * limit:.2g} % may have none: "
            "take more elements, else raise max_missed",
        )
    if fraction > limit:
        raise InputError(
            words["field"],
            words["sides"],
            f"surfaces that face each other within {words['reach']}: {missed} of {count} points "
            f"({100 * fraction:.2g} % of the area of side a) find nothing on side b, at most "
            f"{100 * limit:.2g} % may; where curved rims only nearly meet, take more elements or "
            "a higher degree of geometry, else raise max_missed",
        )


def check_gap(
    distances: tuple[float, float], angle: float, allowed: float, field: str, sides: str
) -> None:
    """Refuse surfaces apart, into each other, or tilted, that nobody said may be.

    Parameters
    ----------
    distances
        Least and largest distance (m) between the surfaces, below zero inside of each other.
    angle
        Largest angle (rad) by which their normals are not opposite.
    allowed
        What their meshes explain (m).
    field, sides
        Name of the contact, and of its surfaces, for the message.
    """
    least, largest = distances
    if max(-least, largest) <= allowed:
        return
    found = [f"{largest:.3g} m apart"] if largest > allowed else []
    found += [f"{-least:.3g} m inside each other"] if -least > allowed else []
    tilt = f", tilted by up to {np.degrees(angle):.2g} degrees" if angle > _TILTED else ""
    raise InputError(
        f"{field}.reach",
        None,
        f"given where surfaces do not touch: {sides} is up to {' and '.join(found)}{tilt}, and "
        f"their meshes explain {allowed:.3g} m",
    )
