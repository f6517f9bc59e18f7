"""Eigenvalues of a damped body that rotates, by a change of frame from those at rest.

Without Coriolis forces, convective stiffness included, waves of m diameters on an axisymmetric body
are carried along (:mod:`cea.rotation`): lambda_0 +- i m Omega, with lambda_0 at rest from

    lambda_0^2 + (alpha + beta kappa + 2 zeta sqrt(kappa)) lambda_0 + kappa = 0.

Of a rotation only m is taken, the eigenvalues of X^T B X of modes X of one frequency rounded.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.linalg import eigh, eigvals

from cea.arrays import Complexes
from comparisons.stability.parts.dense import array
from scenes.read import read_scene
from scenes.run import coupled

_RIGID = 1e-12
"""Kappa relative to the largest up to which motions are rigid."""
_TOGETHER = 1e-3
"""Relative distance of kappa up to which waves of a mesh are two of one frequency."""


def carried_eigenvalues(data: Mapping[str, Any]) -> Complexes:
    """Lambda (1/s) with Im >= 0 of one body without springs, damped by factors or by one ratio.

    Parameters
    ----------
    data
        The scene as plain data; its rotation is without Coriolis forces.
    """
    scene = read_scene(dict(data) | {"analysis": {"kind": "cea", "max_frequency": 1.0}})
    ((name, spec),) = scene.bodies.items()
    assert spec.rotation is not None
    assert spec.damping is not None
    body = coupled(scene)[0].bodies[name]
    kappa, X = eigh(array(body.stiffness()), array(body.mass()))
    kappa[kappa <= _RIGID * kappa[-1]] = 0.0
    B = 0.5 * X.T @ array(body.gyroscopic(replace(spec.rotation, rate=1.0))) @ X
    apart = np.flatnonzero(np.diff(kappa) > _TOGETHER * kappa[1:]) + 1
    groups = np.split(np.arange(len(kappa)), apart)
    diameters = [np.round(eigvals(B[np.ix_(own, own)]).imag) for own in groups]
    rayleigh, modal = spec.damping.rayleigh(), spec.damping.modal
    damping = np.zeros_like(kappa)
    if rayleigh is not None:
        damping += rayleigh.alpha + rayleigh.beta * kappa
    if modal is not None:
        damping += 2 * (modal.ratio or 0.0) * np.sqrt(kappa)
    root = np.emath.sqrt(damping**2 / 4 - kappa)
    shift = 1j * spec.rotation.rate * np.concatenate(diameters)
    values = np.concatenate([-damping / 2 + root + shift, -damping / 2 - root + shift])
    return values[values.imag >= 0]
