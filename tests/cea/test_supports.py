"""Supports in local frames: against plain components, dense null spaces and closed forms."""

from itertools import pairwise

import numpy as np
import pytest
from blocks import ROTATED
from mpi4py import MPI
from scipy.linalg import null_space, subspace_angles
from scipy.optimize import brentq
from scipy.sparse import csr_array
from scipy.special import jv, jvp, yv, yvp

from cea.eigen.krylov_schur import solve_modes
from cea.eigen.pencil import Pencil
from cea.eigen.static import solve_static
from cea.errors import InputError
from cea.material import IsotropicMaterial
from cea.matrices import gather
from cea.supports.boundary import Support
from cea.supports.constraints import ProjectedConstraints, constrain
from cea.supports.directions import Directions, merged
from cea.supports.frames import Cartesian, Cylindrical, SurfaceNormal
from cea.timing import StageTimer
from iga_cea import NurbsBody
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import NurbsPatch, nurbs_shape
from meshes.placement import Placement
from meshes.shapes import Annulus
from scenes.build import build_bodies
from scenes.read import SceneError, read_scene
from scenes.run import run_scene

MATERIAL = IsotropicMaterial(E=2.0, nu=0.3, rho=1.5)
BOX = {"shape": "box", "size": [1.0, 0.7, 0.4]}
RING = {
    "shape": "annulus", "inner_radius": 0.8, "outer_radius": 1.6, "bottom": 0.0, "top": 0.2,
}  # fmt: skip
QUARTER = {**RING, "shape": "sector", "start": 0.0, "end": 90.0}
PLACED = Placement(tuple(ROTATED["axis"]), ROTATED["angle"], tuple(ROTATED["translation"]))
ABOUT_Z = {"axis": [0.0, 0.0, 1.0]}
ABOUT_PLACED = {"axis": PLACED.rotation[:, 2].tolist(), "origin": ROTATED["translation"]}


def build(backend, geometry, supports, elements, *, degree=2, placement=None, pressures=()):
    """A body as scenes say it."""
    part = {
        "backend": backend,
        "geometry": geometry,
        "material": {"E": MATERIAL.E, "nu": MATERIAL.nu, "rho": MATERIAL.rho},
        "supports": supports,
        "placement": placement or {},
        "mesh": {
            "fe": {"degree": degree, "elements": elements},
            "iga": {"degree": [degree] * 3, "elements": elements},
        },
    }
    scene = {
        "name": "supports",
        "bodies": {"part": part},
        "loads": [{"surface": f"part.{name}", "pressure": p} for name, p in pressures],
        "analysis": {"kind": "cea", "max_frequency": 1.0},
    }
    return build_bodies(read_scene(scene), StageTimer())["part"]


def on(names, component="normal", **frame):
    """One component held on each of several surfaces."""
    return [{"surface": name, "components": [component], **frame} for name in names]


def eigenvalues(body, max_frequency):
    """Squares of the angular frequencies."""
    modes = solve_modes(Pencil.of(body.stiffness(), body.mass()), max_frequency)
    return modes.eigenvalues.imag**2


def csr(matrix):
    starts, columns, values = matrix.getValuesCSR()
    return csr_array((values, columns, starts), shape=matrix.getSize())


def test_free_space_is_the_null_space_of_all_constraints():
    """Held directions, some alike, and projected rows, one redundant, against a dense SVD."""
    rng = np.random.default_rng(5)
    n = 9
    d = rng.normal(size=(5, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    y, z = np.eye(3)[1:]
    points = Directions(
        np.array([0, 0, 0, 4, 4, 7, 8, 8]),
        np.array([d[0], d[1], d[0], d[2], d[3], d[4], z, y]),
    )
    # Dof 5 anchors two rows, dof 3 has a direction held as well, dof 7 the very one of its row.
    points = Directions.joined([points, Directions(np.array([3]), d[4:])], 3)
    anchors = Directions(np.array([1, 2, 3, 5, 5, 7]), np.array([*d[:4], d[0], d[4]]))
    rows = np.zeros((6, n, 3))
    for k, (dof, direction) in enumerate(zip(anchors.dof, anchors.direction, strict=True)):
        rows[k, [1, 2, 3, 5, 7]] = 0.1 * rng.random((5, 3))
        rows[k, dof] += direction
    rows = rows.reshape(6, -1)
    constraints = constrain(n, points, ProjectedConstraints(anchors, csr_array(rows)))

    dense = np.zeros((len(points), n, 3))
    dense[np.arange(len(points)), points.dof] = points.direction
    expected = null_space(np.vstack([dense.reshape(len(points), -1), rows[:5]]))
    Z = csr(constraints.expansion(0, n, MPI.COMM_SELF)).toarray()
    assert Z.shape == expected.shape
    assert np.abs(subspace_angles(Z, expected)).max() < 1e-12
    assert not constraints.selects
    # Where axes are held what is left is plain, at the edge of two oblique rollers orthonormal.
    np.testing.assert_array_equal(Z[24:, -1], [1.0, 0.0, 0.0])
    edge = Z[12:15, np.abs(Z[12:15]).sum(axis=0) > 0]
    np.testing.assert_allclose(np.abs(edge[:, 0]), np.abs(null_space(d[2:4])[:, 0]), atol=1e-14)


@pytest.mark.parametrize("size", [1e-12, 1.0])
def test_prescribed_values_are_met_by_all_constraints(size):
    """Oblique directions, two of them alike, and projected rows, of values however small."""
    rng = np.random.default_rng(7)
    n, wanted = 6, size * rng.normal(size=(6, 3))
    d = rng.normal(size=(4, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    dofs = np.array([0, 0, 0, 3, 5])
    directions = np.array([d[0], d[1], d[0], d[2], d[3]])
    values = np.einsum("ij,ij->i", directions, wanted[dofs])
    held = Directions(dofs, directions, values)
    anchors = Directions(np.array([1, 3, 4]), d[[0, 0, 1]], np.full(3, size))
    rows = np.zeros((3, n, 3))
    for k, (dof, direction) in enumerate(zip(anchors.dof, anchors.direction, strict=True)):
        rows[k, [1, 3, 4]] = 0.1 * rng.random((3, 3))
        rows[k, dof] += direction
    matrix, right = csr_array(rows.reshape(3, -1)), size * rng.normal(size=3)
    constraints = constrain(n, held, ProjectedConstraints(anchors, matrix, right))
    Z = constraints.expansion(0, n, MPI.COMM_SELF)
    u = constraints.prescribed_displacement(0, n, Z).array.reshape(n, 3)
    assert np.einsum("ij,ij->i", directions, u[dofs]) == pytest.approx(values, abs=1e-13 * size)
    assert matrix @ u.ravel() == pytest.approx(right, abs=1e-12 * size)
    assert np.abs(matrix @ csr(Z)).max() < 1e-12
    values[2] += 1e-3 * size
    with pytest.raises(InputError, match=r"supports\.value"):
        constrain(n, Directions(dofs, directions, values))


def test_rows_that_cannot_be_solved_for_their_anchors_are_refused():
    x = np.eye(3)[0]
    anchors = Directions(np.array([0, 1]), np.array([x, x]))
    nothing = Directions.joined([], 3)
    for last in ([1.0, 0, 0, 1.0, 0, 0], [1.0, 0, 0, 1.0 + 1e-9, 0.5, 0]):
        rows = csr_array(np.array([[1.0, 0, 0, 1.0, 0, 0], last]))
        with pytest.raises(InputError, match="supports of the pad"):
            constrain(2, nothing, ProjectedConstraints(anchors, rows), field="supports of the pad")


def test_entries_of_one_dof_merge_by_direction():
    x, y = np.eye(3)[:2]
    near = np.array([np.cos(0.1), np.sin(0.1), 0.0])
    entries = Directions(np.array([4, 4, 2, 4, 2]), np.array([x, y, x, near, near]))
    label = merged(entries, np.cos(0.2))
    assert len(set(label)) == 3
    assert label[0] == label[3]
    assert label[2] == label[4]
    assert len(set(merged(entries, np.cos(0.05)))) == 5


def test_normal_of_an_upright_box_is_a_plain_component(backend):
    """The same matrices to the last bit, and the path that picks them agrees with the product."""
    names, axes = ("x_min", "y_max", "z_min"), "xyz"
    plain = [{"surface": n, "components": [a]} for n, a in zip(names, axes, strict=True)]
    parts = [build(backend, BOX, supports, [4, 3, 2]) for supports in (plain, on(names))]
    free = build(backend, BOX, [], [4, 3, 2])
    for matrices in zip(*[(p.expansion, p.stiffness(), p.mass()) for p in parts], strict=True):
        first, second = (csr(m) for m in matrices)
        assert (first != second).nnz == 0
    Z = csr(parts[1].expansion)
    assert abs(Z.T @ csr(free.stiffness()) @ Z - csr(parts[1].stiffness())).max() == 0


def test_rollers_on_a_turned_box_leave_its_frequencies(backend):
    """Faces held in every direction, edges and a corner where rollers meet at right angles."""
    names = ("x_min", "y_max", "z_min")
    plain = [{"surface": n, "components": [a]} for n, a in zip(names, "xyz", strict=True)]
    upright = build(backend, BOX, plain, [4, 3, 2])
    turned = build(backend, BOX, on(names), [4, 3, 2], placement=ROTATED)
    assert turned.expansion.getSize() == upright.expansion.getSize()
    Z = csr(turned.expansion)
    assert np.diff(Z.indptr).max() <= 3
    assert abs(Z.T @ Z - np.eye(Z.shape[1])).max() < 1e-14
    expected = eigenvalues(upright, 0.9)
    assert len(expected) > 5
    assert eigenvalues(turned, 0.9) == pytest.approx(expected, rel=1e-9)


def test_reduced_matrices_are_exactly_symmetric_and_the_product(backend):
    rim = on(("inner", "outer"))
    part = build(backend, RING, rim, [2, 8, 1], placement=ROTATED)
    free = build(backend, RING, [], [2, 8, 1], placement=ROTATED)
    Z = csr(part.expansion)
    for reduced, whole in ((part.stiffness(), free.stiffness()), (part.mass(), free.mass())):
        assert reduced.isSymmetric(0.0)
        expected = Z.T @ csr(whole) @ Z
        assert abs(csr(reduced) - expected).max() < 1e-14 * abs(expected).max()


@pytest.mark.parametrize("component", ["normal", "circumferential"])
def test_straight_sides_of_a_turned_sector(backend, component):
    """A quarter held across its sides; upright these are the components y and x."""
    frame = ABOUT_PLACED if component == "circumferential" else {}
    plain = [
        {"surface": "start", "components": ["y"]},
        {"surface": "end", "components": ["x"]},
        {"surface": "bottom", "components": ["z"]},
    ]
    upright = build(backend, QUARTER, plain, [3, 5, 1])
    sides = on(("start", "end"), component, **frame) + on(["bottom"])
    turned = build(backend, QUARTER, sides, [3, 5, 1], placement=ROTATED)
    assert np.diff(csr(turned.expansion).indptr).max() <= 3
    expected = eigenvalues(upright, 0.6)
    assert len(expected) > 5
    assert eigenvalues(turned, 0.6) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("component", "placement"), [("radial", None), ("radial", ROTATED), ("normal", ROTATED)]
)
def test_ring_between_rollers_turns_and_slides_freely(backend, component, placement):
    """Two zero eigenvalues and no more; the rotation satisfies every constraint exactly."""
    frame = (ABOUT_PLACED if placement else ABOUT_Z) if component == "radial" else {}
    rims = on(("inner", "outer"), component, **frame)
    part = build(backend, RING, rims, [2, 12, 1], placement=placement)
    kappa = eigenvalues(part, 0.25)
    assert np.abs(kappa[:2]).max() < 1e-12
    assert kappa[2] == pytest.approx(5.55e-3, rel=0.01)  # the ring tilts between its rims

    Z, K = csr(part.expansion).toarray(), csr(part.stiffness())
    place = PLACED if placement else Placement()
    axis, origin = place.rotation[:, 2], np.asarray(place.translation)
    sample = part.volume_sample(2)
    control = np.linalg.lstsq(sample.values.toarray(), sample.points, rcond=None)[0]
    for motion in (np.cross(axis, control - origin), np.broadcast_to(axis, control.shape)):
        v, *_ = np.linalg.lstsq(Z, motion.ravel(), rcond=None)
        assert np.abs(Z @ v - motion.ravel()).max() < 1e-12
        assert np.abs(K @ v).max() < 1e-12 * abs(K).max()


def plane_strain_determinant(omega, m):
    """Zero where waves of order m have u_r = 0 and no shear at both rims of the ring."""
    lam, mu = MATERIAL.lame
    alpha = omega * np.sqrt(MATERIAL.rho / (lam + 2 * mu))
    beta = omega * np.sqrt(MATERIAL.rho / mu)
    rows = []
    for r in (RING["inner_radius"], RING["outer_radius"]):
        waves = ((jv, jvp), (yv, yvp))
        radial = [alpha * df(m, alpha * r) for _, df in waves]
        radial += [m / r * f(m, beta * r) for f, _ in waves]
        shear = [
            2 * m / r * (f(m, alpha * r) / r - alpha * df(m, alpha * r)) for f, df in waves
        ] + [
            beta / r * df(m, beta * r)
            - (m / r) ** 2 * f(m, beta * r)
            - beta**2 * df(m, beta * r, 2)
            for f, df in waves
        ]
        rows += [radial, shear]
    return np.linalg.det(rows)


def exact_frequencies(m, upper):
    """Angular frequencies of order m below an upper end, rising."""
    grid = np.linspace(0.05, upper, 400)
    values = [plane_strain_determinant(omega, m) for omega in grid]
    return np.array(
        [
            brentq(plane_strain_determinant, a, b, args=(m,), xtol=1e-14, rtol=1e-14)
            for (a, f), (b, g) in pairwise(zip(grid, values, strict=True))
            if f * g < 0
        ]
    )


PLANE = on(("bottom", "top"), "axial", **ABOUT_Z)


@pytest.mark.convergence
@pytest.mark.parametrize("degree", [2, 3])
def test_projection_keeps_the_order_of_nurbs(degree):
    """Rims with u_r = 0 in plane strain: one u_r-dominated and two sheared modes, m = 0, 1."""
    exact = np.sort([*exact_frequencies(1, 3.2), *exact_frequencies(0, 3.2)])
    assert len(exact) == 3
    counts, errors = np.array([6, 8, 10]), []
    supports = [Support(name, None, SurfaceNormal()) for name in ("inner", "outer")]
    supports += [Support(name, (2,)) for name in ("bottom", "top")]
    shape = Annulus(0.8, 1.6, 0.0, 0.1)
    for n in counts:
        data = nurbs_shape(shape, breaks_of(shape, (n, 4 * n, 1)))
        part = NurbsBody(
            "ring", data.patches, data.faces, (degree, degree, 1),
            material=MATERIAL, supports=supports,
        )  # fmt: skip
        omega = np.sqrt(eigenvalues(part, 3.2 / (2 * np.pi)))
        errors.append([np.abs(omega / value - 1).min() for value in exact])
    rates = np.polyfit(np.log(1 / counts), np.log(errors), 1)[0]
    assert rates == pytest.approx(2 * degree, abs=0.2)
    assert np.max(errors[-1]) < {2: 3e-5, 3: 1e-7}[degree]


def ring_on_disc(backend):
    """A ring pad sliding on a disc, both between rollers u_r = 0 at their rims (SI units)."""

    def part(bottom, top, E, nu, rho, held):
        rims = on(("inner", "outer"), "radial", **ABOUT_Z, origin=[0.0, 0.0, 0.0])
        radii = {"inner_radius": 0.08, "outer_radius": 0.16}
        elements = {"fe": [2, 20, 1], "iga": [3, 16, 1]}[backend]
        return {
            "backend": backend,
            "geometry": {"shape": "annulus", "bottom": bottom, "top": top} | radii,
            "material": {"E": E, "nu": nu, "rho": rho},
            "supports": rims + held,
            "mesh": {
                "fe": {"degree": 3, "elements": elements},
                "iga": {"degree": [3, 3, 3], "elements": elements},
            },
        }

    contact = {
        "a": "pad.bottom",
        "b": "disc.top",
        "formulation": {"method": "gpts", "points": 4},
        "p": 1e12,
        "mu": 0.3,
        "friction_direction_on_a": {"circumferential_about": [0.0, 0.0, 1.0]},
    }
    return {
        "name": "ring rollers",
        "bodies": {
            "pad": part(0.0, 0.01, 1e10, 0.25, 2500.0, [{"surface": "top"}]),
            "disc": part(-0.02, 0.0, 2.1e11, 0.3, 7800.0, []),
        },
        "contacts": {"contact": contact},
        "analysis": {"kind": "cea", "max_frequency": 9350.0},
    }


def test_ring_on_disc_between_rollers_flutters_as_its_waves_do(backend):
    """Exact waves of order m = 0, 1, 2 by an independent solver; each m > 0 runs both ways."""
    found = run_scene(read_scene(ring_on_disc(backend))).modes.eigenvalues
    exact = np.array(
        [
            438.53362 + 42390.43290j,
            58434.47440j,
            110.55988 + 58465.55339j,
            1852.85321 + 58549.94087j,
        ]
    )
    # The rigid rotation of the disc comes first; the rest in the order of frequencies.
    assert len(found) == 8
    assert np.abs(found[0]) < 1.0
    for value in exact:
        for twin in (value, -value.conjugate()):
            assert np.abs(found - twin).min() < 5e-5 * abs(value)


def test_both_backends_agree_on_a_ring_between_rollers():
    supports = on(("inner", "outer"), "radial", **ABOUT_Z) + on(["bottom"])
    meshes = {"fe": ([3, 24, 1], 3), "iga": ([5, 24, 2], 3)}
    kappa = {
        backend: eigenvalues(build(backend, RING, supports, elements, degree=q), 0.45)
        for backend, (elements, q) in meshes.items()
    }
    assert len(kappa["fe"]) == len(kappa["iga"]) > 4
    assert kappa["fe"][0] == pytest.approx(0, abs=1e-10)
    assert kappa["fe"][1:] == pytest.approx(kappa["iga"][1:], rel=1e-4)


@pytest.mark.parametrize(
    ("geometry", "turned"), [(RING, ("inner", "outer")), (QUARTER, ("start", "end"))]
)
def test_ring_under_pressure_is_lame_s(backend, geometry, turned):
    """Plane strain, u_theta held: u_r = A r + B / r, in all of the body."""
    p, a, b = 0.3, RING["inner_radius"], RING["outer_radius"]
    part = build(
        backend, geometry, PLANE + on(turned, "circumferential", **ABOUT_Z),
        [4, 24 if geometry is RING else 6, 1], degree=3, pressures=[("inner", p)],
    )  # fmt: skip
    x = solve_static(Pencil.of(part.stiffness()), part.load()).displacement
    full = part.expansion.createVecLeft()
    part.expansion.mult(x, full)
    sample = part.volume_sample(2)
    u = sample.values @ gather(full).reshape(-1, 3)
    lam, mu = MATERIAL.lame
    scale = p * a**2 / (b**2 - a**2)
    r = np.linalg.norm(sample.points[:, :2], axis=1)
    radial = scale * (r / (2 * (lam + mu)) + b**2 / (2 * mu * r))
    expected = np.zeros_like(u)
    expected[:, :2] = sample.points[:, :2] * (radial / r)[:, None]
    assert np.abs(u - expected).max() < 1e-4 * radial.max()


def test_rollers_and_point_frames_in_the_plane():
    """A NURBS ring in two dimensions turns freely, and no more."""
    shape = Annulus(0.8, 1.6, 0.0, 1.0)
    data = nurbs_shape(shape, breaks_of(shape, (2, 12, 1)))
    patches = [
        NurbsPatch(
            p.degrees[:2], p.knots[:2], p.control_points[:, :, 0, :2] + [0.3, -0.1],
            p.weights[:, :, 0], p.breaks[:2],
        )
        for p in data.patches
    ]  # fmt: skip
    faces = {name: data.faces[name] for name in ("inner", "outer")}
    found = []
    for frame in (SurfaceNormal(), Cylindrical(origin=(0.3, -0.1))):
        part = NurbsBody(
            "ring", patches, faces, (2, 2), material=MATERIAL,
            supports=[Support(name, (0,), frame) for name in faces],
        )  # fmt: skip
        found.append(eigenvalues(part, 0.5))
    assert np.abs(found[0][0]) < 1e-10
    assert found[0][1] == pytest.approx(exact_frequencies(1, 1.2)[0] ** 2, rel=0.02)
    assert found[0][1:] == pytest.approx(found[1][1:], rel=1e-10)


def test_every_component_about_an_axis_is_every_component(backend):
    everything = [
        {"surface": "inner", "components": ["radial", "circumferential", "axial"], **ABOUT_Z}
    ]
    plain = csr(build(backend, RING, [{"surface": "inner"}], [2, 8, 1]).expansion)
    about = csr(build(backend, RING, everything, [2, 8, 1]).expansion)
    assert (plain != about).nnz == 0


@pytest.mark.parametrize(
    ("support", "field", "allowed"),
    [
        ({"components": ["x", "radial"]}, "components", "of one frame"),
        ({"components": ["normal", "z"]}, "components", "of one frame"),
        ({"components": ["normal"], "axis": [0, 0, 1]}, "axis", "left out"),
        ({"components": ["x"], "origin": [0, 0, 0]}, "origin", "left out"),
        ({"components": ["radial"], "axis": [0, 0, 0]}, "axis", "not zero"),
        ({"components": ["up"]}, "components.0", "'radial'"),
    ],
)
def test_mixed_frames_are_refused(support, field, allowed):
    with pytest.raises(SceneError) as caught:
        build("iga", RING, [{"surface": "inner", **support}], [2, 8, 1])
    (fault,) = caught.value.faults
    assert fault.field == f"bodies.part.supports.0.{field}"
    assert allowed in fault.allowed


@pytest.mark.parametrize(
    ("supports", "field", "allowed"),
    [
        (on(["inner"], "radial"), "axis", "three numbers"),
        (on(["inner"], "radial", **ABOUT_Z, origin=[0.0, 0.0]), "origin", "3 coord"),
        (on(["top"], "radial", **ABOUT_Z, origin=[1.0, 0.0, 0.0]), "components", "both or neither"),
    ],
)
def test_frames_that_do_not_fit_the_body_are_refused(backend, supports, field, allowed):
    with pytest.raises((InputError, SceneError)) as caught:
        _ = build(backend, RING, supports, [2, 8, 1]).expansion
    (fault,) = getattr(caught.value, "faults", [caught.value])
    assert fault.field.endswith(field)
    assert allowed in fault.allowed


@pytest.mark.parametrize(
    ("frame", "components", "dim"),
    [
        (Cartesian(), (2,), 2),
        (Cylindrical(), (2,), 2),
        (SurfaceNormal(), (1,), 3),
        (Cylindrical(axis=(0.0, 0.0, 1.0)), (0,), 2),
    ],
)
def test_supports_of_another_dimension_are_refused(frame, components, dim):
    with pytest.raises(InputError, match="support"):
        Support("rim", components, frame).check(dim, "supports[0]")
