"""Scenes: what is accepted, and that every fault is one clear line before work begins."""

from pathlib import Path

import pytest
from catalogue import MESHED

from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene

MU = "contacts.pad_disc.mu"


@pytest.mark.parametrize(("name", "backend"), MESHED)
def test_every_scene_reads_on_the_backends_it_has_meshes_for(name, backend):
    scene = load_scene(Path(name), backend=backend)
    assert scene.name == name
    assert {body.backend for body in scene.bodies.values()} == {backend}


@pytest.mark.parametrize(
    ("override", "field", "value", "allowed"),
    [
        (f"{MU}=-1", MU, "-1", "greater than or equal to 0"),
        (f"{MU}='much'", MU, "'much'", "number"),
        (f"{MU}=nan", MU, "nan", "finite"),
        ("bodies.pad.material.rho=-2500", "bodies.pad.material.rho", "-2500", "positive"),
        ("bodies.pad.material={E=8e9,nu=0.3}", "bodies.pad.material.rho", "None", "density"),
        ("bodies.pad.material.nu=0.5", "bodies.pad.material.nu", "0.5", "-1 and 0.5"),
        ("bodies.pad.materail={}", "bodies.pad.materail", "{}", "no such field"),
        ("bodies.pad.geometry.outer_radius=0.01", "outer_radius", "0.01", "more than inner_radius"),
        ("bodies.pad.geometry.shape=cone", "bodies.pad.geometry.shape", "cone", "annulus, sector"),
        ("bodies.pad.mesh.iga.elements=[6, 11]", "mesh.iga.elements", "(6, 11)", "r, theta, z"),
        ("bodies.pad.supports=[{surface='back'}]", "bodies.pad.supports.0.surface", "back", "top"),
        ("contacts.pad_disc.a=pad.botom", "contacts.pad_disc.a", "pad.botom", "pad.bottom"),
        ("contacts.pad_disc.b=pad.top", "contacts.pad_disc.b", "pad.top", "another body"),
        ("contacts.pad_disc.p=1e12", "contacts.pad_disc.P", "1000000000.0", "not both"),
        ("contacts.pad_disc.formulation={method='node_to_surface'}",
         "contacts.pad_disc.formulation.method", "node_to_surface", "greville"),
        ("contacts.pad_disc.friction_direction_on_a=7",
         "contacts.pad_disc.friction_direction_on_a", "7", "a table"),
        ("bodies.pad.mesh.fe.cell=triangle", "mesh.fe.cell", "triangle", "tetrahedron"),
        ("bodies.pad.mesh.fe.cell=quadrilateral", "mesh.fe.cell", "quadrilateral", "hexahedron"),
        ("bodies.pad.mesh.fe={cell='tetrahedron'}", "mesh.fe.size", "None", "or elements"),
        ("bodies.pad.mesh.fe={cell='tetrahedron',size=0.01,elements=[3,4,1]}",
         "mesh.fe.size", "0.01", "either size"),
        ("bodies.pad.mesh.fe={cell='tetrahedron',size=0.01,through={r=[0.1]}}",
         "mesh.fe.through", "0.1", "left out"),
        ("bodies.pad.mesh.fe.size=0.01", "mesh.fe.size", "0.01", "left out"),
        ("bodies.pad.mesh.fe={cell='tetrahedron',size=0.01,edges=[{r=0.1,z=0.0}]}",
         "mesh.fe.edges", "0.1", "left out"),
        ("bodies.disc.mesh.fe={elements=[3,24,1],layers=2}", "mesh.fe.layers", "2", "edges"),
        ("bodies.disc.mesh.fe={elements=[3,24,1],edges=[{r=0.06}],layers=2}",
         "mesh.fe.edges", "0.06", "along the same two"),
        ("bodies.disc.mesh.fe={elements=[3,24,1],edges=[{r=0.06,z=7.0}],layers=2}",
         "mesh.fe.edges", "7.0", "0.0 to 0.012"),
        ("bodies.disc.mesh.fe={elements=[1,24,1],edges=[{r=0.06,z=0.0},{r=0.15,z=0.012}],layers=2}",
         "mesh.fe.elements", "(1, 24, 1)", "more elements"),
        ("bodies.pad.mesh.fe={degree=1}", "mesh.fe.elements", "None", "hexahedron"),
        ("analysis.max_frequency=0", "analysis.max_frequency", "0", "greater than 0"),
        ("loads=[{surface='pad.side',pressure=1.0}]", "loads.0.surface", "pad.side", "pad.top"),
    ],
)  # fmt: skip
def test_faults_name_field_value_and_what_is_allowed(override, field, value, allowed):
    with pytest.raises(SceneError) as caught:
        load_scene(Path("disc_pad"), [override])
    (fault,) = caught.value.faults
    assert fault.field.endswith(field)
    assert value in repr(fault.value)
    assert allowed in fault.allowed
    assert str(caught.value) == f"{fault.field} = {fault.value!r}: {fault.allowed}"


def test_every_fault_is_told_at_once():
    with pytest.raises(SceneError) as caught:
        load_scene(Path("disc_pad"), [f"{MU}=-1", "bodies.pad.material.E=0"])
    assert len(caught.value.faults) == 2


@pytest.mark.parametrize("field", ["mu", "p"])
@pytest.mark.parametrize("text", ["much", "x +", "__import__('os').getcwd()", "import os"])
def test_expressions_that_are_none_are_refused(field, text):
    scene = [f'{MU.removesuffix("mu")}{field}="{text}"']
    with pytest.raises(SceneError, match=r"an expression in x, y, z, r, theta"):
        load_scene(Path("disc_pad"), scene)
