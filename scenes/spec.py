"""What a scene says: frozen dataclasses, each of which refuses what is wrong with itself."""

from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, Literal, Union

from pydantic import ConfigDict, Field, GetCoreSchemaHandler
from pydantic_core import CoreSchema

from cea.contact.coupling import Form
from cea.contact.formulations import Formulation, registered
from cea.contact.friction import FrictionDirection
from cea.contact.laws import NormalCompliance
from cea.errors import InputError
from cea.fields import Expression
from cea.material import IsotropicMaterial
from cea.mesh import SIMPLICES, Cell
from cea.rotation import Rotation
from cea.supports.boundary import Spring, Support
from cea.supports.frames import Cartesian, Cylindrical, SurfaceNormal
from meshes.placement import Placement
from meshes.shapes import Shape
from scenes.load_spec import LoadSpec
from scenes.motion_spec import DampingSpec, SlidingSpec

Backend = Literal["fe", "iga"]
Component = Literal["x", "y", "z", "radial", "circumferential", "axial", "normal"]
_CARTESIAN: tuple[Component, ...] = ("x", "y", "z")
_CYLINDRICAL: tuple[Component, ...] = ("radial", "circumferential", "axial")
_NORMAL: tuple[Component, ...] = ("normal",)
_COMPONENTS = (_CARTESIAN, _CYLINDRICAL, _NORMAL)
"""Components of each frame; a support names those of one."""


@dataclass(frozen=True)
class FeMesh:
    """Lagrange mesh of a body.

    Parameters
    ----------
    cell
        Kind of cell.
    degree
        Degree of the elements.
    geometry_degree
        Degree of the geometry; by default that of the elements. 1 gives straight facets.
    elements
        Cells of a structured mesh along each direction of the shape; of closed shapes, all the way
        round. Tetrahedra or triangles are such cells each divided into six or two.
    size
        Target edge length of unstructured tetrahedra or triangles (m), given instead.
    through
        Coordinates that must be element boundaries of a structured mesh, by direction.
    """

    cell: Cell = "hexahedron"
    degree: Annotated[int, Field(ge=1, le=4)] = 2
    geometry_degree: Annotated[int, Field(ge=1, le=4)] | None = None
    elements: tuple[int, ...] | None = None
    size: Annotated[float, Field(gt=0)] | None = None
    through: dict[str, tuple[float, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.cell not in SIMPLICES:
            if self.elements is None:
                raise InputError("elements", None, f"needed for cell = {self.cell!r}")
            if self.size is not None:
                raise InputError("size", self.size, f"left out for cell = {self.cell!r}")
        elif (self.elements is None) == (self.size is None):
            allowed = "either size, unstructured, or elements, boxes divided"
            raise InputError("size", self.size, f"{allowed}, for cell = {self.cell!r}")
        if self.elements is None and self.through:
            raise InputError("through", self.through, "left out where size is given")


@dataclass(frozen=True)
class IgaMesh:
    """NURBS discretisation of a body.

    Parameters
    ----------
    degree
        Degree along each direction.
    elements
        Knot spans along each direction of the shape; of closed shapes, all the way
        round.
    continuity
        Continuity at inner knots; by default one less than the degree.
    through
        Coordinates that must be knots, by direction.
    """

    degree: tuple[Annotated[int, Field(ge=1, le=8)], ...]
    elements: tuple[int, ...]
    continuity: tuple[Annotated[int, Field(ge=0)], ...] | None = None
    through: dict[str, tuple[float, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        continuity = self.continuity or ()
        if any(c >= p for c, p in zip(continuity, self.degree, strict=False)):
            raise InputError("continuity", continuity, f"below the degree {self.degree}")


@dataclass(frozen=True)
class MeshSpec:
    """Discretisations of a body, one for each backend it can be run on."""

    fe: FeMesh | None = None
    iga: IgaMesh | None = None


@dataclass(frozen=True)
class SupportSpec:
    """Displacement components held on a surface; every one when none is named.

    Parameters
    ----------
    surface
        Name of the surface.
    components
        Some of x, y, z; or of radial, circumferential, axial; or normal, a roller.
    axis
        Direction of the axis of radial, circumferential, axial; left out in 2D.
    origin
        A point of it (m), by default the origin.
    """

    surface: str
    components: tuple[Component, ...] = ()
    axis: tuple[float, float, float] | None = None
    origin: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        if not any(set(self.components) <= set(names) for names in _COMPONENTS):
            allowed = "of one frame: " + ", or ".join(", ".join(names) for names in _COMPONENTS)
            raise InputError("components", list(self.components), allowed)
        for name, value in (("axis", self.axis), ("origin", self.origin)):
            if value is not None and not self._cylindrical:
                allowed = "left out beside components other than radial, circumferential, axial"
                raise InputError(name, list(value), allowed)
        self.support()

    @property
    def _cylindrical(self) -> bool:
        return bool(set(self.components) & set(_CYLINDRICAL))

    def support(self) -> Support:
        """The support as backends take it."""
        if not self.components:
            return Support(self.surface)
        names = next(names for names in _COMPONENTS if self.components[0] in names)
        numbers = tuple(names.index(component) for component in self.components)
        if self._cylindrical:
            return Support(self.surface, numbers, Cylindrical(self.origin or (), self.axis or ()))
        return Support(self.surface, numbers, SurfaceNormal() if names == _NORMAL else Cartesian())


@dataclass(frozen=True)
class BodySpec:
    """A body: backend, geometry, meshes, material, supports, damping, rotation."""

    backend: Backend
    geometry: Annotated[Shape, Field(discriminator="shape")]
    material: IsotropicMaterial
    mesh: MeshSpec
    supports: tuple[SupportSpec, ...] = ()
    springs: tuple[Spring, ...] = ()
    placement: Placement = field(default_factory=Placement)
    damping: DampingSpec | None = None
    rotation: Rotation | None = None

    left_out: ClassVar[tuple[str, ...]] = ("damping", "rotation")
    """Fields left out of plain data where they say nothing (:mod:`scenes.plain`)."""


class _Registered:
    """Lets pydantic read every registered formulation, told apart by ``method``."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        every: Any = Union[tuple(registered().values())]  # noqa: UP007  (made of a list)
        return handler.generate_schema(Annotated[every, Field(discriminator="method")])


@dataclass(frozen=True)
class ContactSpec:
    """A contact between side a, where the points lie, and side b.

    Parameters
    ----------
    a, b
        Sides as "body.surface".
    formulation
        Points and weights.
    P
        Global contact stiffness, the integral of p over the interface (N/m).
    p
        Contact stiffness (N/m^3), a number or an expression in the coordinates
        (:class:`cea.fields.Expression`); either P or p is given, or c_n.
    c_n, m_n
        Normal compliance -sigma_n = c_n (u_n - g_n)_+^m_n (N/m^(2 + m_n)), m_n 1 or more, 1 by
        default: the loads press the sides together, and p is that of steady sliding.
    added_gap
        With c_n: what is added to the distance between the sides (m), a number or an expression.
    mu
        Friction coefficient, likewise.
    friction_direction_on_a
        Direction of the friction traction on side a: {vector = [...]} or
        {circumferential_about = [...], origin = [...]}, or {field = [...]} with an expression for
        each component.
    full_pass
        Whether points lie on both sides, each half with half the stiffness; P and mu as in a half
        pass. Of the larger side, points that find nothing opposite are dropped.
    form
        ``penalty``, or ``saddle``: contact forces as unknowns, which takes P = inf too. Left open,
        it is the penalty form where that costs no more than six digits, saddle where it would.
    reach
        Largest distance (m) between the sides; left out, they must touch.
    max_missed
        Largest fraction of side a that may find nothing on side b.
    sliding
        Speed, pressure and slope of friction, where they damp or feed small motions.
    """

    a: str
    b: str
    formulation: Annotated[Formulation, _Registered()]
    P: Annotated[float, Field(gt=0, allow_inf_nan=True)] | None = None
    p: Annotated[float, Field(allow_inf_nan=True)] | str | None = None
    c_n: Annotated[float, Field(allow_inf_nan=True)] | None = None
    m_n: Annotated[float, Field(allow_inf_nan=True)] | None = None
    added_gap: float | str = 0.0
    mu: float | str = 0.0
    friction_direction_on_a: FrictionDirection | None = None
    full_pass: bool = False
    form: Form | None = None
    reach: Annotated[float, Field(gt=0)] | None = None
    max_missed: Annotated[float, Field(ge=0, lt=1)] = 0.0
    sliding: SlidingSpec | None = None

    left_out: ClassVar[tuple[str, ...]] = ("c_n", "m_n", "added_gap", "sliding")
    """Fields left out of plain data where they say nothing (:mod:`scenes.plain`)."""

    def __post_init__(self) -> None:
        if isinstance(self.p, float) and not self.p > 0:
            raise InputError("p", self.p, "greater than 0")
        if isinstance(self.mu, float) and not self.mu >= 0:
            raise InputError("mu", self.mu, "greater than or equal to 0")
        for name, value in (("p", self.p), ("mu", self.mu), ("added_gap", self.added_gap)):
            if isinstance(value, str):
                Expression(value).check(name)
        self._check_stiffness()
        if self.mu != 0 and self.friction_direction_on_a is None:
            raise InputError("friction_direction_on_a", None, "needed when mu is not zero")
        coupling = self.formulation.coupling
        for name, stiffness in (("P", self.P), ("p", self.p)):
            if stiffness == float("inf") and self.form == "penalty":
                raise InputError(name, stiffness, "finite, or form = 'saddle'")
            if stiffness == float("inf") and coupling == "lumped":
                raise InputError(name, stiffness, "finite where lumped")
        if coupling == "lumped" and self.form == "saddle":
            raise InputError("form", "saddle", "penalty where lumped")
        if coupling == "bonded" and (self.mu != 0 or self.full_pass):
            method = self.formulation.method
            raise InputError("formulation.method", method, "a half pass with mu = 0")
        if self.sliding is not None:
            self._check_sliding()

    def _check_sliding(self) -> None:
        if self.formulation.coupling == "bonded":
            allowed = "one that is not bonded where it slides"
            raise InputError("formulation", self.formulation.method, allowed)
        if self.friction_direction_on_a is None:
            raise InputError("friction_direction_on_a", None, "needed where it slides")

    @property
    def law(self) -> NormalCompliance | None:
        """Its normal compliance; None where its stiffness is given."""
        return None if self.c_n is None else NormalCompliance(self.c_n, self.m_n or 1.0)

    def _check_stiffness(self) -> None:
        """Refuse another number of stiffnesses than one, and what does not go with a law."""
        given = {"P": self.P, "p": self.p, "c_n": self.c_n}
        if sum(value is not None for value in given.values()) != 1:
            others = ", ".join(f"{name} = {value}" for name, value in given.items() if name != "P")
            raise InputError("P", self.P, f"either P, p or c_n is given, not both ({others})")
        if self.c_n is None:
            for name, value in (("m_n", self.m_n), ("added_gap", self.added_gap or None)):
                if value is not None:
                    raise InputError(name, value, "left out where c_n is not given")
            return
        if self.m_n is not None:
            NormalCompliance(1.0, self.m_n)
        NormalCompliance(self.c_n, 1.0)
        if self.formulation.coupling in ("lumped", "bonded"):
            allowed = "one whose gaps at points meet a law, where c_n is given: not lumped, bonded"
            raise InputError("formulation.method", self.formulation.method, allowed)
        if self.formulation.coupling == "mortar" and self.form == "saddle":
            allowed = "penalty where c_n is given: open parts of mortar contact have no compliance"
            raise InputError("form", self.form, allowed)


@dataclass(frozen=True)
class StaticAnalysis:
    """Displacements under the loads; reports stresses over the contacts."""

    kind: Literal["static"]
    samples: Annotated[int, Field(ge=2, le=1000)] = 91


@dataclass(frozen=True)
class ComplexEigenvalueAnalysis:
    """All modes up to a frequency.

    Parameters
    ----------
    max_frequency
        Upper end of the window (Hz).
    growth_threshold
        Growth rate above which a mode is called unstable (1/s); by default 1e-4 of abs(lambda).
    min_growth
        With damping or rotation, growth rate (1/s), zero or less, down to which modes are sought;
        by default a tenth of the angular frequency of the upper end.
    """

    kind: Literal["cea"]
    max_frequency: Annotated[float, Field(gt=0)]
    growth_threshold: Annotated[float, Field(ge=0)] | None = None
    min_growth: Annotated[float, Field(le=0)] | None = None

    left_out: ClassVar[tuple[str, ...]] = ("min_growth",)
    """Fields left out of plain data where they say nothing (:mod:`scenes.plain`)."""


Analysis = StaticAnalysis | ComplexEigenvalueAnalysis


@dataclass(frozen=True)
class OutputSpec:
    """What is made beside numbers.

    Parameters
    ----------
    pictures
        Modes to draw and animate, the most unstable first.
    paraview
        Modes to write for ParaView, the most unstable first; of a static analysis, whether to
        write its displacement.
    """

    pictures: Annotated[int, Field(ge=0)] = 0
    paraview: Annotated[int, Field(ge=0)] = 0


@dataclass(frozen=True)
class SceneSpec:
    """Bodies, contacts, loads and the analysis to be made of them, each right by itself."""

    name: str
    bodies: dict[str, BodySpec]
    analysis: Annotated[Analysis, Field(discriminator="kind")]
    contacts: dict[str, ContactSpec] = field(default_factory=dict)
    loads: tuple[LoadSpec, ...] = ()
    output: OutputSpec = field(default_factory=OutputSpec)
    description: str = ""

    # Nested dataclasses, those of other rooms too, are checked under the same configuration.
    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(
        extra="forbid", strict=True, allow_inf_nan=False
    )
