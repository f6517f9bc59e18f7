"""Dense eigenvalues of a scene (scipy), from its bodies' matrices and its contact points alone.

Contact forces are unknowns at every point of a rule, or for every trace of a mortar side, and
nothing is compressed, inverted or iterated:

    [ K - kappa M   L^T ] [x]
    [      J        -C  ] [f] = 0,     J = G or B,  L = J - mu-weighted slip,  C compliance

The eigenvalues are those of the displacement part of A(sigma)^-1 [M; 0], which is accurate for the
low ones however stiff the contact is; far from sigma those of M^-1 (K + L^T C^-1 J) take their
place, unless sides are tied. Where they are (C = 0), the limit P -> infinity of the penalty form is
taken by a singular value decomposition.

With damping or rotation contact forces are eliminated, no side may be tied, and the problem
lambda^2 M + lambda D + K is solved at twice the size, lambda relative to its typical size. D holds
alpha M_b + beta K_b and sum 2 zeta omega (M_b phi) (M_b phi)^T of all modes of bodies, Omega Y_b,
and what contacts that slide add; of bodies that rotate, Omega C_b M_b^-1 B_b is part of K, but for
springs (:mod:`cea.motion`).
"""

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

import numpy as np
from scipy.linalg import block_diag, eigh, eigvals, svd

from cea.arrays import Complexes, Floats
from cea.contact.contact import Contact
from cea.contact.interface import along
from cea.expressions import evaluate
from cea.matrices import local_part
from cea.system.coupled import CoupledSystem
from scenes.running.run import coupled
from scenes.spec.body import DampingSpec
from scenes.spec.contact import SlidingSpec
from scenes.spec.reading import Scene, read_scene

_SHIFT = 0.37  # shift relative to the low eigenvalues; negative, so near none of them
_DEPENDENT = 1e-11  # relative singular value below which gaps are linearly dependent
_LOW = 24  # number of low eigenvalues whose size sets the shift
_ABOUT = 30.0  # factor around the optimum within which near and far eigenvalues are joined
_INFINITE = 1e-11  # relative eigenvalue of the inverse below which it belongs to tied gaps
_RIGID = 1e-12  # eigenvalue of a body, relative to its largest, below which a mode is rigid
_TOGETHER = 1e-3  # relative distance of kappa below which waves have one frequency

Constraint = tuple[Floats, Floats, Floats]  # J, T and C: gaps, slips times mu, compliances


def dense_eigenvalues(data: Mapping[str, Any]) -> Complexes:
    """Lambda (1/s) with Im >= 0 by rising frequency; undamped, the growing one of real pairs."""
    contacts = {
        name: contact
        | ({"form": "saddle"} if np.inf in (contact.get("P"), contact.get("p")) else {})
        for name, contact in data.get("contacts", {}).items()
    }
    analysis = {"max_frequency": 1.0, **data["analysis"]}
    scene = read_scene({**data, "analysis": analysis, "contacts": contacts})
    system, _ = coupled(scene)
    bodies = system.bodies.values()
    stiffness = block_diag(*(array(body.stiffness()) for body in bodies))
    mass = block_diag(*(array(body.mass()) for body in bodies))
    compliant, stiff = [], []
    for contact in system.contacts:
        if contact.coupling == "lumped":
            stiffness = stiffness + array(contact.K_n)
            if contact.K_f is not None:
                stiffness -= array(contact.K_f)
        elif np.isinf(contact.slope).any():
            stiff.append(constraint(system, contact))
        else:
            compliant.append(constraint(system, contact))
    constraints = [*compliant, *([_tied(stiff)] if stiff else [])]
    of_motion, damping = _moving(scene, system)
    stiffness = stiffness + of_motion
    if damping.any():
        for J, T, C in constraints:
            stiffness = stiffness + (J - T).T @ np.linalg.solve(C, J)
        return _quadratic(stiffness, damping, mass)
    return lambdas(dense_kappas(stiffness, mass, [(J, J - T, C) for J, T, C in constraints]))


def dense_kappas(stiffness: Floats, mass: Floats, constraints: list[Constraint]) -> Complexes:
    """Every finite kappa = -lambda^2 of a dense pencil with constraints J, L (m, n), C (m, m)."""
    n = len(stiffness)
    J = np.vstack([np.empty((0, n)), *(c[0] for c in constraints)])
    L = np.vstack([np.empty((0, n)), *(c[1] for c in constraints)])
    C = block_diag(np.empty((0, 0)), *(c[2] for c in constraints))
    low = 1e-6 * eigh(stiffness + stiffness.T, 2 * mass, eigvals_only=True).max()
    for _ in range(3):  # from the second time on with the size of the low eigenvalues
        shift = _SHIFT * float(low)
        near = _kappas_about(-shift, stiffness, mass, J, L, C)
        low = np.sort(np.abs(near))[:_LOW].max()
    if np.abs(np.diag(C)).min(initial=np.inf) == 0:
        return near
    far = eigvals(stiffness + (L.T @ np.linalg.solve(C, J) if len(J) else 0.0), mass)
    return _joined(near, far, shift)


def _joined(near: Complexes, far: Complexes, shift: float) -> Complexes:
    """Join eigenvalues that are accurate near a shift with those that are accurate far from it.

    Rounding moves the near ones in proportion to kappa^2 / shift, the far ones to the largest: they
    are joined at the widest gap around the kappa where both are equal.
    """
    sizes = np.sort(np.abs(far))
    middle = np.sqrt(sizes[-1] * shift)
    about = sizes[(sizes > middle / _ABOUT) & (sizes < middle * _ABOUT)]
    if len(about) > 1:
        widest = int(np.argmax(np.diff(np.log(about))))
        middle = float(np.sqrt(about[widest] * about[widest + 1]))
    joined = np.concatenate([near[np.abs(near) < middle], far[np.abs(far) >= middle]])
    return joined if len(joined) == len(far) else near


def _kappas_about(shift: float, K: Floats, M: Floats, J: Floats, L: Floats, C: Floats) -> Complexes:
    n = len(K)
    typical = np.abs(np.diag(K)).mean()
    scale = 1 / np.sqrt(np.abs(np.diag(C)) + (J**2).sum(axis=1) / typical)
    J, L, C = scale[:, None] * J, scale[:, None] * L, scale[:, None] * C * scale
    A = np.block([[K - shift * M, L.T], [J, -C]])
    rows = 1 / np.abs(A).max(axis=1)
    inverse = np.linalg.solve(rows[:, None] * A, rows[:, None] * np.vstack([M, np.zeros_like(J)]))
    inverses = eigvals(inverse[:n])
    finite = np.abs(inverses) > _INFINITE * np.abs(inverses).max()
    return shift + 1 / inverses[finite]


def lambdas(kappa: Complexes) -> Complexes:
    """Lambda with Im >= 0 of each kappa, the growing one if both are real."""
    values = np.sqrt(-np.asarray(kappa, dtype=complex))
    values = np.where(values.imag < 0, -values, values)
    return values[np.lexsort((values.real, values.imag))]


def constraint(system: CoupledSystem, contact: Contact) -> Constraint:
    """J, T and C of a half pass; if tied, C is that of a stiffness of 1 N/m over the interface."""
    points, friction = contact.interface.points, contact.friction
    bonded = contact.coupling == "bonded"
    tied = np.isinf(contact.slope).any()
    closed = contact.slope > 0  # open points carry no force
    compliance = np.zeros(len(points))
    compliance[closed] = points.weight.sum() if tied else 1 / contact.slope[closed]
    normal = points.normal
    axes = np.eye(normal.shape[1])[:, None] if bonded else normal[None]
    copies = len(axes)
    gap = np.vstack([jump(system, contact, np.broadcast_to(n, normal.shape)) for n in axes])
    slip = np.zeros_like(gap)
    if friction is not None and contact.has_friction:
        mu = np.broadcast_to(friction.mu, len(points))
        slip = mu[:, None] * jump(system, contact, friction.along(points.x, normal))
    if contact.coupling in ("mortar", "bonded"):
        a = contact.interface.a
        trace = (a.trace if bonded else a.split_trace)(points.at)
        if not closed.all():
            return _projected(points.weight, compliance, trace.toarray(), gap, slip)
        psi = trace[:, np.unique(trace.indices)].toarray()
        project = block_diag(*[psi.T * points.weight] * copies)
        C = block_diag(*[(psi.T * (points.weight * compliance)) @ psi] * copies)
        return project @ gap, project @ slip, C
    root = np.sqrt(points.weight)[closed, None]
    return root * gap[closed], root * slip[closed], np.diag(compliance[closed])


def _projected(
    weight: Floats, compliance: Floats, psi: Floats, gap: Floats, slip: Floats
) -> Constraint:
    """Constraint projected on traces at closed points, which may be linearly dependent.

    With U an orthonormal basis of sqrt(w c) psi at the closed points, K_n is the square of
    U^T sqrt(w / c) G.
    """
    closed = compliance > 0
    w, c = weight[closed], compliance[closed]
    at_points = np.sqrt(w * c)[:, None] * psi[closed]
    length = np.linalg.norm(at_points, axis=0)
    U, s, _ = svd(at_points[:, length > 0] / length[length > 0], full_matrices=False)
    rows = (U[:, s > _DEPENDENT * s[0]].T * np.sqrt(w / c)).T
    copies = len(gap) // len(weight)
    project = block_diag(*[rows.T] * copies)
    every = np.tile(closed, copies)
    slip = slip[np.tile(closed, len(slip) // len(weight))]
    return project @ gap[every], project @ slip, np.eye(project.shape[0])


def _tied(parts: list[Constraint]) -> Constraint:
    """Limit of stiff contacts: independent gaps, with forces distributed by the compliances.

    Halves of a full pass, and contacts that meet in a point, have linearly dependent gaps.
    """
    J, T = (np.vstack([part[i] for part in parts]) for i in (0, 1))
    values, vectors = eigh(block_diag(*(part[2] for part in parts)))
    kept = values > _DEPENDENT * values[-1]
    root = vectors[:, kept] / np.sqrt(values[kept])
    U, s, V = svd(root.T @ J, full_matrices=False)
    independent = s > _DEPENDENT * s.max()
    U, J = U[:, independent], s[independent, None] * V[independent]
    return J, U.T @ (root.T @ T), np.zeros((len(J), len(J)))


def jump(system: CoupledSystem, contact: Contact, direction: Floats) -> Floats:
    """Jump along a direction at every point, on the unknowns of the system, shape (points, n)."""
    interface, parts = contact.interface, []
    for name, body in system.bodies.items():
        expansion = local_part(body.expansion)
        part = np.zeros((len(direction), expansion.shape[1]))
        if name == contact.a:
            part += (along(interface.trace_a, direction) @ expansion).toarray()
        if name == contact.b:
            part -= (along(interface.trace_b, direction) @ expansion).toarray()
        parts.append(part)
    return np.hstack(parts)


def array(matrix: Any) -> Floats:
    """Dense array of a PETSc matrix of one rank."""
    return local_part(matrix).toarray()


def _quadratic(K: Floats, D: Floats, M: Floats) -> Complexes:
    n, size = len(K), np.sqrt(np.abs(K).max() / np.abs(M).max())
    K, D, one, nothing = K / size**2, D / size, np.eye(n), np.zeros((n, n))
    values = size * eigvals(
        np.block([[nothing, one], [-K, -D]]), np.block([[one, nothing], [nothing, M]])
    )
    kept = values[values.imag >= 0]
    return kept[np.lexsort((kept.real, kept.imag))]


def _moving(scene: Scene, system: CoupledSystem) -> tuple[Floats, Floats]:
    """Contributions of prestress, damping, rotation and sliding contacts to K and D."""
    stiffness, damping = np.zeros((2, system.size, system.size))
    for contact in system.contacts:
        sliding = scene.contacts[contact.pair].sliding
        if sliding is not None:
            damping += _sliding(system, contact, sliding)
    for term in system.prestress:
        stiffness += array(term.matrix)
    start = 0
    for name, body in system.bodies.items():
        own = slice(start, start + body.stiffness().getSize()[0])
        start = own.stop
        spec, M = scene.bodies[name], array(body.mass())
        of_material = np.zeros_like(M)
        if spec.damping is not None:
            springs, rayleigh = body.spring_stiffness(), spec.damping.rayleigh()
            of_springs = np.zeros_like(M) if springs is None else array(springs)
            of_material = _of_body(spec.damping, M, array(body.stiffness()), of_springs)
            damping[own, own] += of_material
            if rayleigh is not None:
                damping[own, own] += rayleigh.beta * of_springs
        if spec.rotation is not None:
            rate = spec.rotation.rate
            transport = 0.5 * array(body.gyroscopic(replace(spec.rotation, coriolis=False)))
            stiffness[own, own] += rate * of_material @ np.linalg.solve(M, transport)
            damping[own, own] += rate * array(body.gyroscopic(spec.rotation))
            if spec.rotation.convective_stiffness:
                stiffness[own, own] -= rate**2 * array(body.convective_stiffness(spec.rotation))
    return stiffness, damping


def _of_body(spec: DampingSpec, M: Floats, K: Floats, springs: Floats) -> Floats:
    """Rayleigh damping without springs plus modal damping of all modes, as a dense matrix."""
    damping = np.zeros_like(M)
    rayleigh, modal = spec.rayleigh(), spec.modal
    if rayleigh is not None:
        damping += rayleigh.alpha * M + rayleigh.beta * (K - springs)
    if modal is not None:
        kappa, vectors = eigh(K, M)
        elastic = kappa > _RIGID * kappa[-1]
        omega, images = np.sqrt(kappa[elastic]), M @ vectors[:, elastic]
        frequencies, ratios = omega / (2 * np.pi), np.zeros_like(omega)
        if modal.max_frequency is not None:
            ratios[frequencies <= modal.max_frequency] = modal.ratio
        else:
            table = modal.frequencies or (), modal.ratios or ()
            ratios = np.interp(frequencies, *table, right=0.0)
        damping += (images * (2 * ratios * omega)) @ images.T
    return damping


def _sliding(system: CoupledSystem, contact: Contact, spec: SlidingSpec) -> Floats:
    """Contribution of a sliding half pass to the damping."""
    points, friction = contact.interface.points, contact.friction
    assert friction is not None
    x, n = points.x, points.normal
    share = 1 / sum(other.pair == contact.pair for other in system.contacts)
    fields = asdict(spec).items()
    given = {name: evaluate(value, x) for name, value in fields if value is not None}
    load = share * points.weight * given["pressure"]
    k = friction.along(x, n)
    along = jump(system, contact, k)
    damping: Floats = along.T @ ((load * given.get("mu_slope", 0.0))[:, None] * along)
    if "speed" in given:
        across = jump(system, contact, np.cross(n, k))
        damping += across.T @ ((load * friction.mu / given["speed"])[:, None] * across)
    return damping


def carried_eigenvalues(data: Mapping[str, Any]) -> Complexes:
    """Lambda (1/s) with Im >= 0 of one rotating body without springs, from those at rest.

    Damping is by Rayleigh factors or one modal ratio. Without Coriolis forces, but with convective
    stiffness, a change of frame gives waves of m diameters lambda_0 +- i m Omega, with

        lambda_0^2 + (alpha + beta kappa + 2 zeta sqrt(kappa)) lambda_0 + kappa = 0.

    Of the rotation only m is used: the rounded eigenvalues of X^T B X, X the modes of a frequency.
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
