"""Figures of complex eigenvalue analysis: measures, false stiffness of lumping, mode shapes."""

from dataclasses import replace
from math import tau
from types import SimpleNamespace

import numpy as np
import pytest
from dolfinx.mesh import exterior_facet_indices
from paper_figures import made

from cea.contact.formulations import Greville, Grid, NodeToSurface
from cea.timing import StageTimer
from comparisons.paper import measures as cea_measures
from comparisons.paper.disc_pad import COLLOCATION, GPTS, GRID, LUMPED, DiscPad
from comparisons.paper.figures import FIGURES
from comparisons.paper.lumping import false_shifts, rotation_ratio
from comparisons.paper.measures import Diagram
from comparisons.paper.mode_shapes import EDGE, SHAPES
from comparisons.paper.normal_compliance import NORMAL_COMPLIANCE
from comparisons.paper.spectra import compare_spectra, spectrum_of
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


def matched(*pairs, groups=(), alone=(0, 0)):
    """A match of unstable modes, each (growth, Hz, reference growth, reference Hz)."""

    def group(growth, hertz, other, reference):
        return {"lambda": [[growth, tau * hertz], [other, tau * reference]]}

    return {
        "unstable": [group(*pair) for pair in pairs],
        "groups": [group(*pair) for pair in groups],
        "only_first": alone[0],
        "only_second": alone[1],
        "unpaired": list(alone),
    }


def test_coinciding_modes_are_counted_with_those_alone():
    match = matched(
        (100, 5000, 100.5, 5040), (50, 9000, 80, 9010), (9, 1000, 9, 1020), alone=(1, 0)
    )
    assert cea_measures.coinciding(match) == pytest.approx(2 / 4)
    assert cea_measures.coinciding(match, growth=True) == pytest.approx(1 / 4)
    assert cea_measures.coinciding(matched()) == 1.0


def test_growth_of_a_mode_that_the_other_run_does_not_have_is_lost():
    match = matched((100, 5000, 110, 5000))
    match["unstable"][0]["modes"] = [[1], [0]]
    reference = {"unstable": [{"growth": 110.0}]}
    case = {"unstable": [{"growth": 30.0}, {"growth": 100.0}]}
    assert cea_measures.growth_difference(case, reference, match) == pytest.approx(30)
    case["unstable"].pop(0)
    match["unstable"][0]["modes"] = [[0], [0]]
    assert cea_measures.growth_difference(case, reference, match) == pytest.approx(10)


def test_sums_and_shifts_keep_to_their_band():
    case = {"unstable": [{"frequency": f, "growth": g} for f, g in ((2e3, 5.0), (12e3, 7.0))]}
    assert cea_measures.growth_sum(case) == 12.0
    assert cea_measures.growth_sum(case, 10e3) == 5.0
    match = matched(groups=((0, 1010, 0, 1000), (0, 14100, 0, 14000), (30, 2000, 0, 2000)))
    assert cea_measures.largest_shift(match) == pytest.approx(0.01)
    assert cea_measures.largest_shift(match, above=13e3) == pytest.approx(1 / 140)
    assert cea_measures.largest_distance(match) == pytest.approx(0.01)


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


def test_cases_on_other_meshes():
    assert COLLOCATION.on("hexahedra").formulation == NodeToSurface()
    assert GRID.on("tetrahedra").formulation == Grid(4)
    assert GRID.on("NURBS").formulation == Grid(10)
    mesh = replace(GPTS, boundary="refined").scene("NURBS").bodies["disc"]
    through = mesh.mesh.iga.through
    assert {0.09, 0.14} < set(through["r"])
    assert len(through["r"]) == len(through["theta"]) == 6
    ignored = replace(GPTS, boundary="ignored").scene("hexahedra")
    assert ignored.bodies["disc"].mesh.fe.through == {}
    assert GPTS.scene("NURBS").contacts["pad_disc"].mu == 0.7


def test_higher_degrees_take_larger_elements():
    def elements(degree, mesh):
        spec = replace(GPTS, degree=degree).scene(mesh).bodies["disc"].mesh
        return spec.iga.elements if mesh == "NURBS" else spec.fe.elements

    assert [elements(p, "NURBS") for p in (2, 3, 4, 5)] == [
        *2 * [(16, 80, 2)],
        (12, 60, 2),
        (10, 48, 1),
    ]
    assert [elements(p, "hexahedra")[:2] for p in (2, 3, 4)] == [(9, 60), (6, 40), (4, 30)]


def test_degrees_that_lagrange_elements_do_not_have_are_no_cases():
    degrees = {"hexahedra": [2, 2, 3, 4], "NURBS": [2, 2, 3, 4, 5]}
    for mesh, expected in degrees.items():
        (panel,) = FIGURES["14"].panels(mesh).values()
        assert [case.degree for case in panel.values()] == expected


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
    tetrahedra, hexahedra = (spectrum_of(run(DIVIDED, m)) for m in ("tetrahedra", "hexahedra"))
    assert tetrahedra.data["dofs"] == hexahedra.data["dofs"]
    # Fewer functions of the same nodes: quadratic tetrahedra are the stiffer ones.
    shifts = [
        g["lambda"][0][1] / g["lambda"][1][1] - 1
        for g in compare_spectra(tetrahedra, hexahedra)["groups"]
    ]
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
    groups = compare_spectra(spectrum_of(lumped), spectrum_of(plain))["groups"]
    assert len(groups) > 4
    found = [g["lambda"][0][1] / g["lambda"][1][1] - 1 for g in groups]
    false = [expected[g["modes"][1]].mean() for g in groups]
    assert max(false) > 1e-5
    assert found == pytest.approx(false, rel=0.05, abs=0.02 * max(false))


def test_spectrum_agrees_with_itself_and_its_parts_are_sound():
    spectrum = spectrum_of(run(GPTS, "NURBS"))
    match = compare_spectra(spectrum, spectrum)
    assert all(group["assurance"] == pytest.approx(1) for group in match["groups"])
    found = cea_measures.measures(spectrum.data, spectrum.data, match)
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
