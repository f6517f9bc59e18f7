"""Figures of complex eigenvalue analysis: measures, false stiffness of lumping, mode shapes."""

from dataclasses import replace
from math import tau
from types import SimpleNamespace

import numpy as np
import pytest
from dolfinx.mesh import exterior_facet_indices
from paper_figures import made

from cea.contact.formulations import Greville
from cea.eigen.matching import ModeSet
from cea.timing import StageTimer
from comparisons.paper.diagram import Diagram
from comparisons.paper.disc_pad import GPTS, LUMPED, DiscPad
from comparisons.paper.lumping import false_shifts, rotation_ratio
from comparisons.paper.mode_shapes import EDGE, SHAPES
from comparisons.paper.normal_compliance import NORMAL_COMPLIANCE
from comparisons.paper.spectra import Spectrum, means_of, measures, paired
from scenes import run_modes
from scenes.building.build import build_bodies, build_interfaces, build_system

ELEMENTS = {"pad": ([3, 4, 1], [3, 5, 1]), "disc": ([6, 16, 1], [5, 20, 1])}
SIZES = {"pad": 0.02, "disc": 0.03}
DIVIDED = replace(GPTS, divided=True)


def coarse(scene):
    """Disc and pad on meshes that run in a second, up to 5 kHz."""
    changes = {"analysis.max_frequency": 5e3}
    for name, body in scene.bodies.items():
        fe, iga = (f"bodies.{name}.mesh.{backend}.elements" for backend in ("fe", "iga"))
        if body.backend == "iga":
            changes[iga] = ELEMENTS[name][1]
        elif body.mesh.fe.elements is None:
            changes[f"bodies.{name}.mesh.fe.size"] = SIZES[name]
        else:
            changes[fe] = ELEMENTS[name][0]
    return scene.change(changes)


def run(case, mesh):
    """A case on these meshes."""
    return run_modes(coarse(case.scene(mesh)))


def assembled(case, mesh):
    """The case without its modes."""
    scene, timer = coarse(case.scene(mesh)), StageTimer()
    bodies = build_bodies(scene, timer)
    system = build_system(scene, bodies, build_interfaces(scene, bodies, timer), timer)
    return SimpleNamespace(system=system)


def spectrum(*modes, motion=None):
    """A run of modes (number of its shape, growth, Hz): unstable above 10 1/s."""
    number, growth, hertz = np.array(modes, dtype=float).reshape(-1, 3).T
    kept = ModeSet(growth + 1j * tau * hertz, np.eye(9, dtype=complex)[:, number.astype(int)])
    motion = np.ones(len(modes)) if motion is None else np.array(motion)
    run = {"search": 2.0, "points": 8}
    rest = (motion, motion, np.zeros(len(modes)), np.ones(len(modes)), run)
    return Spectrum(kept, np.flatnonzero(growth > 10), *rest)


def compared(own, reference):
    return measures(own, reference, paired(own, reference))


def test_coinciding_modes_are_counted_with_those_alone():
    own = spectrum((0, 100, 5000), (1, 50, 9000), (2, 19, 1000), (3, 30, 12000))
    reference = spectrum((0, 100.5, 5040), (1, 80, 9010), (2, 19, 1020))
    found = compared(own, reference)
    assert found["share_frequency"] == pytest.approx(2 / 4)
    assert found["share_both"] == pytest.approx(1 / 4)
    assert found["alone"] == 1
    assert compared(spectrum((0, 0, 900)), spectrum((0, 0, 900)))["share_frequency"] == 1.0


def test_growth_of_a_mode_that_the_other_run_does_not_have_is_lost():
    own, reference = spectrum((0, 100, 5000), (1, 30, 9000)), spectrum((0, 110, 5000))
    assert compared(own, reference)["growth_difference"] == pytest.approx(30)
    assert compared(reference, own)["growth_difference"] == pytest.approx(30)
    found = compared(spectrum((0, 100, 5000)), reference)
    assert found["growth_difference"] == pytest.approx(10)
    assert found["growth_part"] == pytest.approx(1 / 11)


def test_sums_and_shifts_keep_to_their_band():
    own = spectrum((0, 0, 1010), (1, 0, 14100), (2, 30, 2000), (3, 28, 12000))
    reference = spectrum((0, 0, 1000), (1, 0, 14000), (2, 20, 2000), (3, 20, 12000))
    found = compared(own, reference)
    assert found["growth_over"] == pytest.approx(58 / 40)
    assert found["growth_below_10k"] == pytest.approx(30 / 20)
    assert found["shift"] == found["shift_below_13k"] == pytest.approx(0.01)
    assert found["shift_above_13k"] == pytest.approx(1 / 140)
    assert found["distance"] == pytest.approx(0.01)


def test_motions_are_compared_by_their_median_where_there_are_some():
    modes = [(i, 0, 1000 * (i + 1)) for i in range(4)]
    own, reference = (
        spectrum(*modes, motion=motion)
        for motion in ((1.0, 6.0, 3.0, np.nan), (1.0, 2.0, 1.5, 2.0))
    )
    assert compared(own, reference)["contact_motion"] == pytest.approx(2.0)
    nowhere = spectrum(*modes, motion=4 * [np.nan])
    assert compared(nowhere, reference)["contact_motion"] is None


def test_the_linearised_law_is_the_tangent():
    rows = made(NORMAL_COMPLIANCE, "none")[0]["law"]
    curves = {name: [r for r in rows if r["curve"] == name] for name in ("law", "linearised")}
    closure = np.array([row["closure"] for row in curves["law"]])
    pressure, linear = (np.array([row["pressure"] for row in own]) for own in curves.values())
    at = np.argmin(np.abs(closure - NORMAL_COMPLIANCE.closure))
    assert linear[at] == pytest.approx(pressure[at])
    slopes = [np.diff(curve[at - 1 : at + 2 : 2])[0] for curve in (linear, pressure)]
    assert slopes[0] == pytest.approx(slopes[1])  # a parabola's chord is its tangent
    assert not pressure[closure <= 0].any()
    assert pressure == pytest.approx(NORMAL_COMPLIANCE.law.pressure(closure))


def test_error_of_the_linearised_law_in_closed_form():
    """With m = 2 the change is 2 e + e^2 of which 2 e is linear."""
    for part in (0.01, 0.1, 1.0):
        assert NORMAL_COMPLIANCE.error(part) == pytest.approx(part / (2 + part))


def test_divided_hexahedra_fill_the_same_bodies():
    hexahedra = build_bodies(coarse(DIVIDED.scene("hexahedra")), StageTimer())
    for name, body in build_bodies(coarse(DIVIDED.scene("tetrahedra")), StageTimer()).items():
        whole = hexahedra[name]
        assert body.space.scalar.mesh.topology.cell_name() == "tetrahedron"
        assert body.num_scalar_dofs == whole.num_scalar_dofs
        for surface, side in body.surfaces.items():
            assert side.num_elements == 2 * whole.surfaces[surface].num_elements
            assert side.area == pytest.approx(whole.surfaces[surface].area, rel=1e-12)
        # A face divided one way on one side and another way on the other would be outside twice.
        body.space.scalar.mesh.topology.create_connectivity(2, 3)
        outside = exterior_facet_indices(body.space.scalar.mesh.topology)
        assert len(outside) == sum(side.num_elements for side in body.surfaces.values())


def test_tetrahedra_trace_the_pad_where_hexahedra_are_divided():
    assert DIVIDED.on("hexahedra") == GPTS.on("hexahedra")
    assert DIVIDED.on("tetrahedra").boundary == "traced"
    assert GPTS.on("tetrahedra").boundary == "ignored"
    assert DIVIDED.on("tetrahedra").label == f"divided hexahedra, {GPTS.on('hexahedra').label}"
    tetrahedra, hexahedra = (Spectrum.of(run(DIVIDED, m)) for m in ("tetrahedra", "hexahedra"))
    assert tetrahedra.run["dofs"] == hexahedra.run["dofs"]
    # Fewer functions of the same nodes: quadratic tetrahedra are the stiffer ones.
    first, second = means_of(paired(tetrahedra, hexahedra))
    shifts = first.imag / second.imag - 1
    assert len(shifts) > 4
    assert 0 < np.median(shifts) < 0.1


def test_pad_has_as_many_greville_points_as_the_paper_says():
    scene = DiscPad(Greville()).scene("NURBS")
    pad = replace(scene, bodies={"pad": scene.bodies["pad"]}, contacts={})
    surface = build_bodies(pad, StageTimer())["pad"].surfaces["bottom"]
    assert len(surface.abscissae("greville")) == 104


@pytest.mark.parametrize("mesh", ["NURBS", "hexahedra", "tetrahedra"])
def test_rotation_of_both_bodies_is_free_without_lumping(mesh):
    assert abs(rotation_ratio(assembled(GPTS, mesh))) < 1e-12


def test_lumping_gives_a_rotation_false_stiffness_on_nurbs_only():
    """On traced quadratic hexahedra lumping is Simpson's rule, exact for squares of rotations."""
    nurbs, hexahedra = (rotation_ratio(assembled(LUMPED, m)) for m in ("NURBS", "hexahedra"))
    assert nurbs > 0.05
    assert abs(hexahedra) < 1e-3


def test_false_stiffness_shifts_modes_as_lumping_does_at_low_stiffness():
    plain, lumped = (run(replace(case, P=1e6), "NURBS") for case in (GPTS, LUMPED))
    expected = false_shifts(plain, lumped)
    match = paired(Spectrum.of(lumped), Spectrum.of(plain))
    assert len(match.groups) > 4
    first, second = means_of(match)
    false = [expected[group.second].mean() for group in match.groups]
    assert max(false) > 1e-5
    found = first.imag / second.imag - 1
    assert found == pytest.approx(false, rel=0.05, abs=0.02 * max(false))


def test_spectrum_agrees_with_itself_and_its_parts_are_sound():
    spectrum = Spectrum.of(run(GPTS, "NURBS"))
    match = paired(spectrum, spectrum)
    assert all(group.assurance == pytest.approx(1) for group in match.groups)
    found = measures(spectrum, spectrum, match)
    assert found["distance"] == found["shift"] == found["growth_difference"] == found["alone"] == 0
    assert found["contact_gap"] == found["search_over"] == found["points_over"] == 1


def test_a_diagram_measures_its_cases_beside_the_first():
    """Spectra are those of the cases; equal cases on a kind of mesh are one."""
    figure = Diagram("small", "small", (GPTS, LUMPED, replace(GPTS, divided=True)), (1e9, 1e12))
    tables, _ = made(figure, "hexahedra", coarse)
    assert [(row["P"], row["number"]) for row in tables["runs"]] == [
        *((1e9, 0), (1e9, 1), (1e12, 0), (1e12, 1))
    ]
    for measured in tables["measures"]:
        own = [row for row in tables["matches"] if row["P"] == measured["P"]]
        shifts = [abs(row["frequency"] / row["reference_frequency"] - 1) for row in own]
        assert measured["shift"] == pytest.approx(max(shifts), rel=1e-9)
    for row in tables["runs"]:
        modes = [mode for mode in tables["modes"] if mode["P"] == row["P"]]
        own = [mode for mode in modes if mode["number"] == row["number"]]
        assert row["unstable"] == sum(mode["unstable"] for mode in own)


def test_shapes_and_lines_of_a_mode():
    tables, arrays = made(SHAPES, "NURBS", coarse)
    plain = [row for row in tables["lines"] if row["run"] == "plain"]
    arc, disc, pad = (np.array([row[n] for row in plain], float) for n in ("arc", "disc", "pad"))
    assert np.abs(disc).max() == pytest.approx(1)
    # The line is a chord: the pad's radial ends cut it at 0.115 tan 20 degrees.
    assert pytest.approx(0.115 * np.tan(np.radians(20))) == EDGE
    assert (np.isfinite(pad) == (np.abs(arc) < EDGE + 1e-9)).all()
    for body in ("disc", "pad"):
        points, cells, u = (
            arrays[f"plain/{body}/{n}"] for n in ("points", "cells", "displacement")
        )
        assert points.shape == u.shape
        assert cells.max() == len(points) - 1
    assert {row["what"] for row in tables["numbers"]} >= {"plain: frequency", "lumped: frequency"}
