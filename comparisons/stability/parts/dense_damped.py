"""Dense eigenvalues of a scene with damping or rotation (scipy), contact forces eliminated.

    lambda^2 M + lambda D + K,    D = sum C_b + Omega Y_b + contacts that slide,

with C_b = alpha M_b + beta K_b and, where modes of bodies are damped, the sum of
2 zeta omega (M_b phi) (M_b phi)^T of all their modes. Of bodies that rotate, Omega C_b M_b^-1 B_b
is part of K, but for springs (:mod:`cea.rotation`). All are put together once more from bodies'
matrices, contact points and what the scene says, and solved as a generalised problem of twice the
size in which lambda is relative to its typical size.

Of a body that rotates without Coriolis forces, convective stiffness included, a change of frame
gives the eigenvalues from those at rest: waves of m diameters have lambda_0 +- i m Omega, with

    lambda_0^2 + (alpha + beta kappa + 2 zeta sqrt(kappa)) lambda_0 + kappa = 0.

Of the rotation only m is taken, the eigenvalues of X^T B X of modes X of one frequency rounded.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.linalg import eigh, eigvals

from cea.arrays import Complexes, Floats
from cea.contact.contact import Contact
from cea.expressions import Expression, evaluate
from cea.system.coupled import CoupledSystem
from comparisons.stability.parts.dense import array, constraint, jump
from scenes.running.system import coupled
from scenes.spec.body import DampingSpec
from scenes.spec.contact import SlidingSpec
from scenes.spec.reading import read_scene

_RIGID = 1e-12
"""Eigenvalues of a body relative to its largest up to which motions are rigid."""


def damped_eigenvalues(data: Mapping[str, Any]) -> Complexes:
    """Lambda (1/s) of every mode of a scene with Im >= 0, by rising frequency.

    Parameters
    ----------
    data
        The scene as plain data, no side tied.
    """
    scene = read_scene(dict(data) | {"analysis": {"kind": "cea", "max_frequency": 1.0}})
    system, _, _ = coupled(scene)
    stiffness, mass = array(system.stiffness), array(system.mass)
    damping = np.zeros_like(mass)
    for contact in system.contacts:
        J, T, C = constraint(system, contact)
        stiffness = stiffness + (J - T).T @ np.linalg.solve(C, J)
        sliding = scene.contacts[contact.pair].sliding
        if sliding is not None:
            damping += _sliding(system, contact, sliding)
    start = 0
    for name, body in system.bodies.items():
        own = slice(start, start + body.stiffness().getSize()[0])
        start = own.stop
        spec = scene.bodies[name]
        M, of_material = array(body.mass()), np.zeros_like(mass[own, own])
        if spec.damping is not None:
            springs = body.spring_stiffness()
            of_springs = np.zeros_like(M) if springs is None else array(springs)
            of_material = _of_body(spec.damping, M, array(body.stiffness()), of_springs)
            damping[own, own] += of_material + _beta(spec.damping) * of_springs
        if spec.rotation is not None:
            rate = spec.rotation.rate
            transport = 0.5 * array(body.gyroscopic(replace(spec.rotation, coriolis=False)))
            stiffness[own, own] += rate * of_material @ np.linalg.solve(M, transport)
            damping[own, own] += rate * array(body.gyroscopic(spec.rotation))
            if spec.rotation.convective_stiffness:
                stiffness[own, own] -= rate**2 * array(body.convective_stiffness(spec.rotation))
    return _eigenvalues(stiffness, damping, mass)


def _eigenvalues(K: Floats, D: Floats, M: Floats) -> Complexes:
    n, size = len(K), np.sqrt(np.abs(K).max() / np.abs(M).max())
    K, D, one, nothing = K / size**2, D / size, np.eye(n), np.zeros((n, n))
    values = size * eigvals(
        np.block([[nothing, one], [-K, -D]]), np.block([[one, nothing], [nothing, M]])
    )
    kept = values[values.imag >= 0]
    return kept[np.lexsort((kept.real, kept.imag))]


def _beta(spec: DampingSpec) -> float:
    rayleigh = spec.rayleigh()
    return 0.0 if rayleigh is None else rayleigh.beta


def _of_body(spec: DampingSpec, M: Floats, K: Floats, springs: Floats) -> Floats:
    """Rayleigh damping without springs, and modal damping by all modes, as a full matrix."""
    damping = np.zeros_like(M)
    rayleigh, modal = spec.rayleigh(), spec.modal
    if rayleigh is not None:
        damping += rayleigh.alpha * M + rayleigh.beta * (K - springs)
    if modal is not None:
        kappa, vectors = eigh(K, M)
        elastic = kappa > _RIGID * kappa[-1]
        omega, images = np.sqrt(kappa[elastic]), M @ vectors[:, elastic]
        ratios = np.zeros_like(omega)
        if modal.max_frequency is not None:
            ratios[omega <= 2 * np.pi * modal.max_frequency] = modal.ratio
        elif modal.frequencies is None:
            ratios[: len(modal.ratios or ())] = modal.ratios
        else:
            table = 2 * np.pi * np.asarray(modal.frequencies)
            ratios = np.interp(omega, table, np.asarray(modal.ratios), right=0.0)
        damping += (images * (2 * ratios * omega)) @ images.T
    return damping


def _sliding(system: CoupledSystem, contact: Contact, spec: SlidingSpec) -> Floats:
    """What a half pass that slides adds to the damping."""
    points, friction = contact.interface.points, contact.friction
    assert friction is not None
    x, n = points.x, points.normal
    share = 1 / sum(other.pair == contact.pair for other in system.contacts)
    given = {name: _at(value, x) for name, value in spec.fields.items() if value is not None}
    load = share * points.weight * given["pressure"]
    k = friction.direction.at(x, n)
    along = jump(system, contact, k)
    damping: Floats = along.T @ ((load * given.get("mu_slope", 0.0))[:, None] * along)
    if "speed" in given:
        across = jump(system, contact, np.cross(n, k))
        damping += across.T @ ((load * friction.mu / given["speed"])[:, None] * across)
    return damping


def _at(value: float | str, x: Floats) -> Floats:
    return evaluate(Expression(value) if isinstance(value, str) else value, x)


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
