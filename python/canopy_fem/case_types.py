"""Types of a case as a dictionary, for checkers such as mypy and pyright.

python/tools/case_types.py makes them of the schema.

No key is required, since other values may come by path (`Case(source, overrides)`). Arrays of numpy stand for lists,
paths for texts, and a mesh for the section `mesh`.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias, TypedDict

import numpy.typing as npt

from ._core import Mesh

__all__ = ["CaseDict"]

Text: TypeAlias = "str | os.PathLike[str]"
Numbers: TypeAlias = "Sequence[float] | npt.NDArray[Any]"


CaseDict = TypedDict("CaseDict", {
    "$schema": "Text | None",
    "acknowledge": "Sequence[WarningCode]",
    "description": "Text | None",
    "materials": "Text | Mapping[str, Material] | None",
    "name": "Text",
    "output": "Output | None",
    "solver": "Solver | None",
    "study": "Study | None",
    "system": "System",
    "time": "Time",
}, total=False)
"""A simulation case for canopy-fem. Values are SI. Comments (`//` and `/* */`) and trailing commas are allowed."""


class Aero(TypedDict, total=False):
    """The air. At least one of `law`, `canopy` and `drag` is given."""

    altitude: float | None
    atmosphere: Atmosphere | None
    canopy: Canopy | Sequence[Canopy] | None
    drag: Sequence[Drag]
    law: PorousLaw | None
    wind: Numbers | AeroWindTable | AeroWindFile | AeroWindProfile | AeroWindGust | AeroWindSum | None


class AeroWindTable(TypedDict, total=False):
    table: Sequence[Numbers] | npt.NDArray[Any]
    when: When


class AeroWindFile(TypedDict, total=False):
    file: Text
    when: When


class AeroWindProfile(TypedDict, total=False):
    profile: Sequence[Numbers] | npt.NDArray[Any]


class AeroWindGust(TypedDict, total=False):
    gust: Gust
    when: When


class AeroWindSum(TypedDict, total=False):
    sum: Sequence[Numbers | AeroWindSumSumTable | AeroWindSumSumFile | AeroWindSumSumProfile | AeroWindSumSumGust]


class AeroWindSumSumTable(TypedDict, total=False):
    table: Sequence[Numbers] | npt.NDArray[Any]
    when: When


class AeroWindSumSumFile(TypedDict, total=False):
    file: Text
    when: When


class AeroWindSumSumProfile(TypedDict, total=False):
    profile: Sequence[Numbers] | npt.NDArray[Any]


class AeroWindSumSumGust(TypedDict, total=False):
    gust: Gust
    when: When


class AnnulusParameters(TypedDict, total=False):
    """A flat ring around the origin, meshed with triangles that grow with the distance from its edges."""

    boundary_nodes: int | None
    grading: float | None
    inner_radius: float
    nodes: int
    outer_radius: float
    seams: int | None
    seed: int


Atmosphere: TypeAlias = 'Literal["isa"] | AtmosphereDensity | AtmosphereExponential'
"""Density of the air over the height above sea level."""


class AtmosphereDensity(TypedDict, total=False):
    """[kg/m^3] The same density at all heights."""

    density: float


class AtmosphereExponential(TypedDict, total=False):
    """density exp(-height/scale_height)."""

    exponential: ExponentialAtmosphere


Axes: TypeAlias = 'Literal["auto", "z-up", "y-up"]'
"""Which axis of a file points up."""


class Ball(TypedDict, total=False):
    """A solid sphere."""

    center: Numbers
    radius: float


Bar = TypedDict("Bar", {
    "from": "Numbers",
    "radius": "float",
    "to": "Numbers",
}, total=False)
"""A round bar with half a ball at either end."""


class BendingRule(TypedDict, total=False):
    """Bending stiffness, quadratic in the positions (Bergou et al. 2006). At rest cloth is flat and lines are
    straight, whatever the mesh. Triangles and edges whose corners are all held are a clamp. Exactly one of
    `stiffness` and `flexural_rigidity` is given."""

    flexural_rigidity: float | None
    on: EdgeSelection
    stiffness: float | None


class Canopy(TypedDict, total=False):
    """The air in a canopy: a pressure from inside to outside along the normals of its triangles, dp = q dCp with q =
    rho V |V|/2, or that of a balance of the air inside. V is the axial air speed: the mean velocity of the skirt
    minus the wind there (with `cavity` and `filling` that of the confluence), along the axis from the apex to the
    confluence of the lines. Cloth that moves outwards at the normal speed w in the air that goes with the canopy
    meets less of it, by rho/2 (V |V| - (V - w) |V - w|) dCp: this damps the breathing of the canopy, its turning
    and its motion across the axis, and is nothing in steady flight."""

    apparent_mass: float | None
    cavity: Cavity | None
    confluence: NodeSelection | None
    filling: Filling | None
    glide: Glide | None
    inflow_loss: float | None
    law: ClothLaw | None
    on: NodeSelection
    schedule: FillingSchedule | Sequence[FillingSchedule] | None
    skirt: NodeSelection | None
    table: PressureTable | None


CanopyType: TypeAlias = 'Literal["flat-circular", "conical", "biconical", "triconical", "hemispherical", "extended-skirt", "annular", "cruciform", "ringslot", "ribbon", "ringsail", "disk-gap-band", "elliptical", "toroidal", "square", "triangular"]'
"""How the canopy is cut."""


class Cavity(TypedDict, total=False):
    """A canopy with a mouth (experimental; the balance is this program's own). One pressure acts on the whole canopy,
    dp = p_i - Cp q, with p_i inside such that as much air flows in through the mouth as the volume grows and the
    cloth lets through: eta V A_m x = dVol/dt + A w(dp), p_i = q (1 - x |x|). A_m is the size of the area vector of
    the skirt's loop, Vol the volume between the cloth and flat covers of its openings, A the area of the cloth.
    What leaves through vents and slots is not counted."""

    inflow: float
    law: ClothLaw | None
    outer_pressure_coefficient: float


ChainParameters = TypedDict("ChainParameters", {
    "from": "Numbers",
    "segments": "int",
    "to": "Numbers",
}, total=False)
"""A straight line of equal edges without triangles; node 0 is at `from`, node `segments` at `to`."""


ClothLaw: TypeAlias = "ClothLawErgun | ClothLawPermeable"
"""Pressure difference over a cloth as a function of the speed of the air through it."""


class ClothLawErgun(TypedDict, total=False):
    """Ergun's equation for a porous layer."""

    ergun: ErgunLaw


class ClothLawPermeable(TypedDict, total=False):
    """Measured permeability of a cloth: dp = e (a w + b w |w|)."""

    permeable: PermeableLaw


class ClothMaterial(TypedDict, total=False):
    """A cloth. It has no compression, and damping along its threads."""

    about: Text | None
    areal_density: float
    damping_time: float | None
    modulus: float
    permeability: PermeableLaw | None
    poisson: float | None
    sources: Mapping[str, Text]
    strength: float | None
    thickness: float


ClothModel: TypeAlias = 'Literal["net", "membrane"]'
"""A model of cloth: one of `membranes`, or of springs with a `membrane` stiffness, can be both. Errors are
distances from the solution with membranes."""


class ClusterParameters(TypedDict, total=False):
    """Equal parachutes that share the end of their risers (or their confluence), leaning outwards so far that they do
    not touch at the start. Each group holds the parts of all of them; those of the first alone are in `canopy-1`,
    `skirt-1`, and so on. Canopies pass through each other unless `contact` names them, or springs on the edges of
    the group `spacers`, from the apex of each to those of its neighbours, stand for what holds them apart."""

    canopies: int


Compression: TypeAlias = 'Literal["none", "zlib"]'
"""Whether appended bytes are compressed."""


class Contact(TypedDict, total=False):
    """Parts of the scene that may touch each other, or a rigid body. Below the distance `gap` they push each other
    apart. Parts that share a node never touch. Without this section everything passes through everything."""

    between: Literal["self"] | Sequence[Text | Obstacle]
    friction: float | None
    gap: float | None


CrossingSearch: TypeAlias = 'Literal["frames", "steps", "none"]'
"""Where cloth is searched for triangles that pass through others."""


class Cuboid(TypedDict, total=False):
    """A box with its sides along the axes."""

    max: Numbers
    min: Numbers


class CutTable(TypedDict, total=False):
    """Springs that are cut one after another, in the order of the mesh."""

    table: Sequence[Numbers] | npt.NDArray[Any]
    together: int


class Damping(TypedDict, total=False):
    """Damping of the network as a whole."""

    rayleigh: Rayleigh


Dashpot: TypeAlias = "DashpotAxial | DashpotRelative"
"""A dashpot beside a spring."""


class DashpotAxial(TypedDict, total=False):
    """c ldot along the spring. Beside a tension-only spring the sum of both is at least 0: a rope never pushes. It
    pulls while it is slack where its ends move apart faster than k/c times the slack."""

    axial: DashpotRule


class DashpotRelative(TypedDict, total=False):
    """c (vb - va), all three components, slack or not."""

    relative: DashpotRule


DashpotRule: TypeAlias = 'Literal["step"] | DashpotRuleCoefficient | DashpotRuleTime | DashpotRulePerStrain'
"""How the coefficient c of a dashpot is found."""


class DashpotRuleCoefficient(TypedDict, total=False):
    """[N s/m] The coefficient c itself."""

    coefficient: float


class DashpotRuleTime(TypedDict, total=False):
    """[s] Retardation time tau: c = k tau."""

    time: float


class DashpotRulePerStrain(TypedDict, total=False):
    """[N s] Coefficient of the strain rate: c = this/l0."""

    per_strain: float


Diagonals: TypeAlias = 'Literal["one", "both"]'
"""Which diagonals of a quad become edges."""


class DiscParameters(TypedDict, total=False):
    """A flat disc around the origin, meshed with triangles that grow with the distance from its edge."""

    boundary_nodes: int | None
    grading: float | None
    nodes: int
    radius: float
    seams: int | None
    seed: int


class Drag(TypedDict, total=False):
    """Drag in the air around lines or bodies: of lines with `diameter` and `coefficient`, of bodies with `drag_area`."""

    coefficient: float | None
    diameter: float | None
    drag_area: float | None
    glide: Glide | None
    on: NodeOrEdgeSelection


EdgeSelection: TypeAlias = 'Literal["all", "boundary", "interior", "seams", "lines"] | EdgesExcept | EdgeSelectionIds | EdgeSelectionGroup'
"""Some edges of the mesh; every edge can carry a spring."""


class EdgeSelectionIds(TypedDict, total=False):
    """[-] The edges with these numbers, counted from 0."""

    ids: Numbers


class EdgeSelectionGroup(TypedDict, total=False):
    """The edges of the mesh's group with this name: those it lists, or, if it lists none, those of its triangles."""

    group: Text


EdgesExcept = TypedDict("EdgesExcept", {
    "except": "EdgeSelection",
    "of": "EdgeSelection",
}, total=False)
"""Edges without some of them."""


ElasticLawRule: TypeAlias = 'Literal["linear", "green"] | ElasticLawRuleTable'
"""How the tension T of a spring grows with its strain r = (l - l0)/l0. All but the linear law need a rest length."""


class ElasticLawRuleTable(TypedDict, total=False):
    """[-, N] Rows of strain and force as measured: linear between the rows, and beyond them with the first and last
    slopes. Strains increase and forces do not fall; the force is 0 at the strain 0. In place of a stiffness:
    dashpots by `time` and Kang's filter take the steepest slope over l0 for k."""

    table: Sequence[Numbers] | npt.NDArray[Any]


ErgunForm: TypeAlias = 'Literal["corrected", "paper"]'
"""Which reading of Ergun's equation."""


class ErgunLaw(TypedDict, total=False):
    """Ergun's equation (Ergun 1952) for a layer of thickness e: dp = e (A v_s + B v_s |v_s|)."""

    air_density: float
    air_viscosity: float
    form: ErgunForm
    pore_diameter: float
    porosity: float
    thickness: float


class Every(TypedDict, total=False):
    """An interval of simulated time."""

    every: float


class EveryCheckpoint(TypedDict, total=False):
    """An interval of simulated time between checkpoints."""

    every: float


class EverySteps(TypedDict, total=False):
    """An interval in steps."""

    every: int


class ExplicitMesh(TypedDict, total=False):
    """Nodes, springs and triangles as lists."""

    groups: Mapping[str, Group]
    nodes: Sequence[Numbers] | npt.NDArray[Any]
    springs: Sequence[Numbers] | npt.NDArray[Any] | None
    triangles: Sequence[Numbers] | npt.NDArray[Any]


class ExponentialAtmosphere(TypedDict, total=False):
    """Density of the air that decays exponentially with height."""

    density: float
    scale_height: float


class FactorTable(TypedDict, total=False):
    """A factor over time."""

    table: Sequence[Numbers] | npt.NDArray[Any]


Field: TypeAlias = 'Literal["velocity", "force", "reaction", "tension", "strain", "rest-length", "pressure", "membrane"]'
"""A field of a frame."""


class Filling(TypedDict, total=False):
    """A canopy that fills by a balance of the air at each of its rings, the rows of its cloth (this program's own law,
    held against measured openings of rescue parachutes). What passes the disc of a ring is the growth of the volume
    above it and what leaks there: x = (dVol/dt + leaks)/(A |V|). The pressure inside is q - q (x |x| + max(0, X^2 -
    1)) with the largest x from the ring to the skirt, X; outside it is Cb q above the widest ring, and rises below
    it as the mouth takes the stream. V is the axial air speed of the confluence. All constants have defaults."""

    damping: float
    drag_coefficient: float | None
    geometric_porosity: float
    law: ClothLaw | None
    outer_pressure_coefficient: float | None
    quadratic_damping: float
    slot_discharge: float
    vent_discharge: float


class FillingSchedule(TypedDict, total=False):
    """The drag area of a canopy while it fills: from what it was at `start` (0 for the first stage) to `drag_area` by
    ((t - start)/t_f)^exponent, until the filling time t_f = n D0/v_s (Knacke 1991). The same pressure acts on all
    triangles; it is scaled so that its force along the axis is q times the drag area where the cloth does not
    breathe. At most one of `drag_area` and `drag_coefficient`, and at most one of `filling_constant` and
    `filling_time` is given. A generated parachute has defaults by its type, which `check` prints; else exactly one
    of them is given."""

    drag_area: float | None
    drag_coefficient: float | None
    exponent: float | None
    filling_constant: float | None
    filling_time: float | None
    nominal_diameter: float | None
    speed: float | None
    start: float
    when: When | None


class FrameFile(TypedDict, total=False):
    """A frame of a run."""

    frame: Text


FrameFormat: TypeAlias = 'Literal["vtu", "vtkhdf"]'
"""The files of frames."""


class Gas(TypedDict, total=False):
    """Gas that triangles enclose, with the pressure p = p_a (V_a/V)^gamma - p_a on them, from inside to outside. V is
    the volume, p_a the absolute pressure outside, V_a the amount of gas as its volume at that pressure. So p
    V^gamma of the absolute pressure is constant while the amount is. Exactly one of `pressure` and `amount` is
    given."""

    ambient: float
    amount: float | ValueTable | None
    gamma: float
    on: NodeSelection
    pressure: float | ValueTable | None
    volume: float | None


class Gauge(TypedDict, total=False):
    """Something that is measured at every step."""

    every: int | None
    name: Text
    of: GaugeQuantity
    on: NodeOrEdgeSelection


GaugeQuantity: TypeAlias = 'Literal["tension", "force", "reaction", "acceleration", "velocity", "speed", "displacement", "position", "crossings", "stress", "strain", "wrinkling", "gas", "contact"]'
"""What a gauge measures."""


class Glide(TypedDict, total=False):
    """A lift beside the drag, L = `ratio` D. It is normal to the velocity against the air and lies in the vertical
    plane of the `heading`: up and forward in a glide, along the heading in a vertical fall. In steady flight the
    path through the air sinks by arctan(1/ratio). The wind carries both along, so the course over the ground is
    another one. Motion across the plane is sideslip, which has drag and no lift. While a canopy fills, its lift
    grows with its drag."""

    heading: float | ValueTable
    ratio: float


class Group(TypedDict, total=False):
    """The members of a group; every list is ascending."""

    edges: Numbers
    nodes: Numbers
    triangles: Numbers


class Gust(TypedDict, total=False):
    """A one-minus-cosine gust: velocity/2 (1 - cos(2 pi (t - start)/duration)), 0 before and after. Where it lasts
    less than eight fixed steps, its mean is kept, but not its shape."""

    duration: float
    start: float
    velocity: Numbers


Initial = TypedDict("Initial", {
    "displacement": "Numbers | Sequence[Numbers] | npt.NDArray[Any] | None",
    "from": "Text | FrameFile | None",
    "keep": "Keep | None",
    "velocity": "Numbers | Sequence[Numbers] | npt.NDArray[Any] | None",
}, total=False)
"""Initial displacements and velocities of the nodes."""


class InnerLineParameters(TypedDict, total=False):
    """Lines from the vent to the confluence."""

    length: float | None
    material: Text | None
    segments: int


Keep: TypeAlias = 'Literal["tensions", "rest_lengths"]'
"""What springs keep of an earlier run, by the arrays of its frame; `static` writes both."""


class LineMaterial(TypedDict, total=False):
    """A line, cord, tape, webbing or cable. It has no compression. Either `axial_rigidity` or `modulus` and `diameter`
    are given."""

    about: Text | None
    axial_rigidity: float | None
    damping_time: float | None
    diameter: float | None
    drag_coefficient: float | None
    linear_density: float
    modulus: float | None
    sources: Mapping[str, Text]
    strength: float | None


class LineParameters(TypedDict, total=False):
    """Straight lines of equal segments."""

    length: float
    segments: int


Linear: TypeAlias = 'Literal["auto", "cholesky", "lu", "cg"]'
"""Linear solver."""


class Load(TypedDict, total=False):
    """A pressure or snow on triangles, or a force on nodes; exactly one of `pressure`, `force` and `snow` is given."""

    direction: Numbers | None
    force: Numbers | None
    kind: PressureKindKey | None
    on: NodeSelection
    pressure: float | None
    shape: float | None
    snow: float | None
    table: Sequence[Numbers] | npt.NDArray[Any] | None


class Mass(TypedDict, total=False):
    """Mass of the nodes: the sum of what is given."""

    areal_density: float | None
    nodal: float | Numbers | None
    points: Sequence[PointMass]


class MassScaling(TypedDict, total=False):
    """For how long a step nodes get more mass."""

    step: float


Material: TypeAlias = "MaterialCloth | MaterialLine"
"""A material. Its numbers are those of a rule that names it, unless the rule gives them itself."""


class MaterialCloth(TypedDict, total=False):
    """A cloth or a coated membrane."""

    cloth: ClothMaterial


class MaterialLine(TypedDict, total=False):
    """A line, cord, tape, webbing or cable."""

    line: LineMaterial


class Membrane(TypedDict, total=False):
    """Stiffness from a continuous sheet: k = E t (sum of the adjacent triangles' areas)/l^2, areas and l on the mesh
    as given (Van Gelder 1998). On a regular net it tends to k = (sqrt 3/2) E t and a Poisson ratio of 1/3."""

    modulus: float
    thickness: float


class MembraneRule(TypedDict, total=False):
    """Triangles that are a membrane: a sheet of constant strain (St. Venant-Kirchhoff), in place of springs on their
    edges. A triangle follows the first rule that selects it."""

    damping_time: float | None
    material: Text | None
    modulus: float | Numbers | None
    on: NodeSelection
    poisson: float | None
    shear: float | None
    strength: float | None
    thickness: float | None
    warp: Numbers | None
    wrinkling: bool


MeshFile = TypedDict("MeshFile", {
    "axes": "Axes",
    "diagonals": "Diagonals",
    "edge": "float | None",
    "file": "Text",
    "merge": "float | None",
    "orient": "bool",
    "scale": "float | None",
    "sew": "Sequence[Seam]",
    "strict": "bool",
    "translate": "Numbers",
    "with": "Sequence[Text]",
}, total=False)
"""A mesh file, and how its mesh is placed and repaired: in the order axes, scale, edge, merge, orient, sew,
translate."""


MeshSource: TypeAlias = "MeshSourceAnnulus | MeshSourceDisc | MeshSourceRectangle | MeshSourceChain | MeshSourceParachute | MeshSourceExplicit | MeshFile"
"""Where the mesh of a network comes from."""


class MeshSourceAnnulus(TypedDict, total=False):
    """A flat ring in the x-y plane around the origin, normal +z."""

    annulus: AnnulusParameters


class MeshSourceDisc(TypedDict, total=False):
    """A flat disc in the x-y plane around the origin, normal +z."""

    disc: DiscParameters


class MeshSourceRectangle(TypedDict, total=False):
    """A flat rectangle in the x-y plane from the origin, normal +z."""

    rectangle: RectangleParameters


class MeshSourceChain(TypedDict, total=False):
    """A straight line of edges without triangles."""

    chain: ChainParameters


class MeshSourceParachute(TypedDict, total=False):
    """A rigged parachute with its axis along z and the payload below; its parts are groups."""

    parachute: ParachuteParameters


class MeshSourceExplicit(TypedDict, total=False):
    """Nodes, springs and triangles listed in the case."""

    explicit: ExplicitMesh


Method: TypeAlias = 'Literal["explicit-euler", "euler-cromer", "euler-richardson", "improved-euler", "improved-euler-pec", "velocity-verlet", "beeman", "rk4", "dormand-prince", "dop853", "newmark", "hht", "kang", "backward-euler", "generalized-alpha", "esdirk4", "central-difference", "multirate", "energy-momentum", "xpbd", "vbd"] | MethodExplicitEuler | MethodEulerCromer | MethodEulerRichardson | MethodImprovedEuler | MethodImprovedEulerPec | MethodVelocityVerlet | MethodBeeman | MethodRk4 | MethodDormandPrince | MethodDop853 | MethodNewmark | MethodHht | MethodKang | MethodBackwardEuler | MethodGeneralizedAlpha | MethodEsdirk4 | MethodCentralDifference | MethodMultirate | MethodEnergyMomentum | MethodXpbd | MethodVbd'
"""Method of integration: its name, or an object with its name and its parameters."""


MethodExplicitEuler = TypedDict("MethodExplicitEuler", {
    "explicit-euler": "MethodExplicitEulerExplicitEuler",
}, total=False)


class MethodExplicitEulerExplicitEuler(TypedDict, total=False):
    pass


MethodEulerCromer = TypedDict("MethodEulerCromer", {
    "euler-cromer": "MethodEulerCromerEulerCromer",
}, total=False)


class MethodEulerCromerEulerCromer(TypedDict, total=False):
    pass


MethodEulerRichardson = TypedDict("MethodEulerRichardson", {
    "euler-richardson": "MethodEulerRichardsonEulerRichardson",
}, total=False)


class MethodEulerRichardsonEulerRichardson(TypedDict, total=False):
    pass


MethodImprovedEuler = TypedDict("MethodImprovedEuler", {
    "improved-euler": "MethodImprovedEulerImprovedEuler",
}, total=False)


class MethodImprovedEulerImprovedEuler(TypedDict, total=False):
    pass


MethodImprovedEulerPec = TypedDict("MethodImprovedEulerPec", {
    "improved-euler-pec": "MethodImprovedEulerPecImprovedEulerPec",
}, total=False)


class MethodImprovedEulerPecImprovedEulerPec(TypedDict, total=False):
    pass


MethodVelocityVerlet = TypedDict("MethodVelocityVerlet", {
    "velocity-verlet": "MethodVelocityVerletVelocityVerlet",
}, total=False)


class MethodVelocityVerletVelocityVerlet(TypedDict, total=False):
    pass


class MethodBeeman(TypedDict, total=False):
    beeman: MethodBeemanBeeman


class MethodBeemanBeeman(TypedDict, total=False):
    pass


class MethodRk4(TypedDict, total=False):
    rk4: MethodRk4Rk4


class MethodRk4Rk4(TypedDict, total=False):
    pass


MethodDormandPrince = TypedDict("MethodDormandPrince", {
    "dormand-prince": "MethodDormandPrinceDormandPrince",
}, total=False)


class MethodDormandPrinceDormandPrince(TypedDict, total=False):
    pass


class MethodDop853(TypedDict, total=False):
    dop853: MethodDop853Dop853


class MethodDop853Dop853(TypedDict, total=False):
    pass


class MethodNewmark(TypedDict, total=False):
    newmark: MethodNewmarkNewmark


class MethodNewmarkNewmark(TypedDict, total=False):
    beta: float
    gamma: float


class MethodHht(TypedDict, total=False):
    hht: MethodHhtHht


class MethodHhtHht(TypedDict, total=False):
    alpha: float


class MethodKang(TypedDict, total=False):
    kang: MethodKangKang


class MethodKangKang(TypedDict, total=False):
    pass


MethodBackwardEuler = TypedDict("MethodBackwardEuler", {
    "backward-euler": "MethodBackwardEulerBackwardEuler",
}, total=False)


class MethodBackwardEulerBackwardEuler(TypedDict, total=False):
    pass


MethodGeneralizedAlpha = TypedDict("MethodGeneralizedAlpha", {
    "generalized-alpha": "MethodGeneralizedAlphaGeneralizedAlpha",
}, total=False)


class MethodGeneralizedAlphaGeneralizedAlpha(TypedDict, total=False):
    rho_inf: float


class MethodEsdirk4(TypedDict, total=False):
    esdirk4: MethodEsdirk4Esdirk4


class MethodEsdirk4Esdirk4(TypedDict, total=False):
    pass


MethodCentralDifference = TypedDict("MethodCentralDifference", {
    "central-difference": "MethodCentralDifferenceCentralDifference",
}, total=False)


class MethodCentralDifferenceCentralDifference(TypedDict, total=False):
    pass


class MethodMultirate(TypedDict, total=False):
    multirate: MethodMultirateMultirate


class MethodMultirateMultirate(TypedDict, total=False):
    substeps: int


MethodEnergyMomentum = TypedDict("MethodEnergyMomentum", {
    "energy-momentum": "MethodEnergyMomentumEnergyMomentum",
}, total=False)


class MethodEnergyMomentumEnergyMomentum(TypedDict, total=False):
    dissipation: float


class MethodXpbd(TypedDict, total=False):
    xpbd: MethodXpbdXpbd


class MethodXpbdXpbd(TypedDict, total=False):
    iterations: int
    substeps: int


class MethodVbd(TypedDict, total=False):
    vbd: MethodVbdVbd


class MethodVbdVbd(TypedDict, total=False):
    iterations: int


class Network(TypedDict, total=False):
    """Point masses joined by springs."""

    aero: Aero | None
    base_acceleration: VectorTable | None
    bending: Sequence[BendingRule]
    contact: Sequence[Contact]
    damping: Damping | None
    gas: Gas | Sequence[Gas] | None
    gravity: Numbers | None
    initial: Initial | None
    loads: Sequence[Load]
    mass: Mass | None
    membranes: Sequence[MembraneRule]
    mesh: MeshSource | Mesh
    model: NetworkModel | None
    springs: Sequence[SpringRule]
    supports: Sequence[Support]


NetworkModel: TypeAlias = 'Literal["point"]'
"""What stands for a network."""


class Newton(TypedDict, total=False):
    """Newton's method for the equations of a step."""

    max_iterations: int | None
    relative: float | None
    strategy: Strategy


NodeOrEdgeSelection: TypeAlias = 'Literal["all", "boundary", "outer", "inner", "interior", "seams", "lines"] | NodesOrEdgesExcept | NodeOrEdgeSelectionContact | NodeOrEdgeSelectionIds | NodeOrEdgeSelectionBox | NodeOrEdgeSelectionSphere | NodeOrEdgeSelectionGroup'
"""Some nodes or some edges of the mesh, or a contact."""


class NodeOrEdgeSelectionContact(TypedDict, total=False):
    """[-] The contact with this number in the section `contact`, counted from 0, for a gauge of `contact`."""

    contact: int


class NodeOrEdgeSelectionIds(TypedDict, total=False):
    """[-] The nodes, or the edges, with these numbers, counted from 0."""

    ids: Numbers


class NodeOrEdgeSelectionBox(TypedDict, total=False):
    """[m] The nodes inside an axis-aligned box, its faces included: lowest corner, highest corner."""

    box: Sequence[Numbers] | npt.NDArray[Any]


class NodeOrEdgeSelectionSphere(TypedDict, total=False):
    """The nodes inside a sphere, its surface included."""

    sphere: Ball


class NodeOrEdgeSelectionGroup(TypedDict, total=False):
    """The nodes, or the edges, of the mesh's group with this name."""

    group: Text


NodeSelection: TypeAlias = 'Literal["all", "boundary", "outer", "inner"] | NodesExcept | NodeSelectionIds | NodeSelectionBox | NodeSelectionSphere | NodeSelectionGroup'
"""Some nodes of the mesh. Nodes count from 0; positions are those of the mesh as given."""


class NodeSelectionIds(TypedDict, total=False):
    """[-] The nodes with these numbers, counted from 0."""

    ids: Numbers


class NodeSelectionBox(TypedDict, total=False):
    """[m] The nodes inside an axis-aligned box, its faces included: lowest corner, highest corner."""

    box: Sequence[Numbers] | npt.NDArray[Any]


class NodeSelectionSphere(TypedDict, total=False):
    """The nodes inside a sphere, its surface included."""

    sphere: Ball


class NodeSelectionGroup(TypedDict, total=False):
    """The members of the mesh's group with this name: its nodes, or, if it lists none, those of its edges and
    triangles. Where triangles are selected, its triangles."""

    group: Text


NodesExcept = TypedDict("NodesExcept", {
    "except": "NodeSelection",
    "of": "NodeSelection",
}, total=False)
"""Nodes, or triangles, without some of them."""


NodesOrEdgesExcept = TypedDict("NodesOrEdgesExcept", {
    "except": "NodeOrEdgeSelection",
    "of": "NodeOrEdgeSelection",
}, total=False)
"""Nodes, edges or triangles without some of them."""


class Obstacle(TypedDict, total=False):
    """A rigid body that nothing moves but its own table. Exactly one of `plane`, `sphere`, `cylinder`, `box` and
    `file` is given. No node that can move is inside of it at the start."""

    box: Cuboid | None
    cylinder: Bar | None
    file: Text | None
    motion: VectorTable | None
    plane: Plane | None
    sphere: Ball | None


class Output(TypedDict, total=False):
    """What is written."""

    checkpoint: EveryCheckpoint | None
    compression: Compression | None
    crossings: CrossingSearch
    edges: bool
    fields: Sequence[Field]
    format: FrameFormat
    frames: Every | None
    gauges: Sequence[Gauge]
    history: EverySteps | None
    precision: Precision
    probes: Sequence[Probe]


class PackedStart(TypedDict, total=False):
    """The size of a pack, which begins at the confluence. A riser below it hangs straight."""

    bag: bool
    length: float | None
    radius: float | None


class ParachuteParameters(TypedDict, total=False):
    """A parachute. The pattern is cut so that cloth, slots and vent together have the area pi D0^2/4."""

    arm_ratio: float | None
    at: Numbers | None
    axis: Numbers | None
    band: float | None
    cap_angle: float | None
    centre_line: RigLineParameters | None
    cloth: Text | None
    cluster: ClusterParameters | None
    coarsen: bool
    cone_angle: float | None
    cone_angles: Numbers | None
    cone_breaks: Numbers | None
    constructed_diameter: float | None
    corner_cut: float | None
    disk: float | None
    fullness: float | None
    gap: float | None
    gore_segments: int
    gores: int
    height_ratio: float | None
    inner_lines: InnerLineParameters | None
    lines: RigLineParameters | None
    nominal_diameter: float | None
    payload: PayloadParameters | None
    pull_down: float | None
    radial_segments: int
    reefing: ReefingParameters | None
    rings: int | None
    riser: RigLineParameters | None
    sails: int | None
    skirt_angle: float | None
    skirt_extension: float | None
    slot_porosity: float | None
    start: Start
    start_radius: float | None
    tapes: TapeMaterials | None
    type: CanopyType
    vent_diameter: float | None
    vent_lines: bool | None
    verticals: int | None


class PayloadParameters(TypedDict, total=False):
    """A rigid payload: four particles of a quarter of its mass each, which have its centre and its moments of inertia."""

    below_riser: float
    box: Numbers | None
    radii_of_gyration: Numbers | None


class Pendulum(TypedDict, total=False):
    """A simple pendulum: m L^2 theta'' = -m g L sin(theta) - c theta'. Its bob is node 0 at (L sin, 0, -L cos)."""

    angle: float
    damping: float
    gravity: float
    length: float
    mass: float
    rate: float


class PermeableLaw(TypedDict, total=False):
    """Measured permeability of a cloth: dp = e (a v_n + b v_n |v_n|). At least one of a and b is above 0."""

    a: float
    b: float
    thickness: float


class Plane(TypedDict, total=False):
    """A half-space."""

    normal: Numbers
    point: Numbers


class PointMass(TypedDict, total=False):
    """A mass on each of some nodes, or one that they share; exactly one of `mass` and `total` is given."""

    mass: float | None
    on: NodeSelection
    total: float | None


PorousLaw: TypeAlias = "PorousLawErgun | PorousLawPermeable | PorousLawPressureCoefficient | PorousLawSurfacePressure"
"""Pressure jump as a function of v_n, or pressure coefficients by zone."""


class PorousLawErgun(TypedDict, total=False):
    """Ergun's equation for a porous layer."""

    ergun: ErgunLaw


class PorousLawPermeable(TypedDict, total=False):
    """Measured permeability of a cloth: dp = e (a v_n + b v_n |v_n|)."""

    permeable: PermeableLaw


class PorousLawPressureCoefficient(TypedDict, total=False):
    """A plain pressure coefficient: dp = cp rho/2 v_n |v_n|."""

    pressure_coefficient: PressureCoefficientLaw


class PorousLawSurfacePressure(TypedDict, total=False):
    """[-] Pressure coefficients by zone, as building codes give them: `{group: cp}`, the groups being triangles; `all`
    stands for all of them. cp q acts along the normal of each triangle, with the dynamic pressure of the wind at
    its height, q = rho |V|^2/2. The outer face is the one that the triangles' right-hand normals look out of: a
    positive cp pushes onto it, a negative one is suction. cp is a number, or rows `[angle, cp]` over the angle, in
    radians, between the outer normal and the direction that the wind comes from: 0 where the wind meets the outer
    face, pi/2 along it, pi on the lee side; linear between the rows, constant outside them. Triangles in no zone
    have no pressure. The velocity of the surface does not count."""

    surface_pressure: Mapping[str, float | Sequence[Numbers] | npt.NDArray[Any]]


Precision: TypeAlias = 'Literal["f64", "f32"]'
"""How many digits numbers keep."""


class PressureCoefficientLaw(TypedDict, total=False):
    """A plain pressure coefficient: dp = cp rho/2 v_n |v_n|."""

    air_density: float
    cp: float


PressureKindKey: TypeAlias = 'Literal["follower", "dead"]'
"""How a pressure follows the surface."""


class PressureTable(TypedDict, total=False):
    """The pressure in a canopy over the dynamic pressure."""

    pressure_coefficient: float | Sequence[Numbers] | npt.NDArray[Any]


class Probe(TypedDict, total=False):
    """Nodes whose motion is written."""

    name: Text
    on: NodeSelection


class Rayleigh(TypedDict, total=False):
    """Rayleigh damping f -= (alpha M + beta K0) v, with K0 = sum of k n n^T on the mesh as given: no slack, no
    geometric part."""

    mass: float
    stiffness: float


class RectangleParameters(TypedDict, total=False):
    """A flat rectangle in the x-y plane, its corners at (0, 0) and (width, height), normal +z."""

    columns: int
    height: float
    pattern: RectanglePattern
    rows: int
    width: float


RectanglePattern: TypeAlias = 'Literal["regular", "crossed"]'
"""How a rectangle's cells are cut."""


class ReefingParameters(TypedDict, total=False):
    """A reefing line: a ring of edges from line to line along the skirt. A spring rule for the group `reefing` gives
    it stiffness; without one no line acts, and the diameter is that of the start `inflated` alone. The rest length
    of each edge is pi times the diameter over the number of gores, unless the rule gives another. In a case whose
    mesh is a file the rule must give it."""

    diameter: float


class RigLineParameters(TypedDict, total=False):
    """Lines of a parachute, each of equal segments."""

    length: float | None
    material: Text | None
    segments: int


class Seam(TypedDict, total=False):
    """A seam that joins two sides, or the gores of a canopy."""

    allowance: float
    copies: int | None
    ease: bool
    edges: Sequence[Text] | None
    gores: Sequence[Text] | None
    hem: float
    lines: LineParameters | None
    name: Text | None
    reverse: bool


SizedStart: TypeAlias = "SizedStartStretched | SizedStartPacked"
"""A shape at the start with its sizes."""


class SizedStartStretched(TypedDict, total=False):
    """The tube of line stretch."""

    stretched: StretchedStart


class SizedStartPacked(TypedDict, total=False):
    """The pack."""

    packed: PackedStart


SlackRule: TypeAlias = 'Literal["tension-only", "compression-only"] | SlackRuleDeadZone | SlackRuleCompressionLimit'
"""When a spring is slack; e = l - l0 is its elongation."""


class SlackRuleDeadZone(TypedDict, total=False):
    """[m] T = k max(e - eps, 0): tension only, where the spring is longer than l0 by more than this eps."""

    dead_zone: float


class SlackRuleCompressionLimit(TypedDict, total=False):
    """[m] T = k max(e, -eps): the compression is constant where the spring is shorter than l0 by more than this eps."""

    compression_limit: float


class Solver(TypedDict, total=False):
    """How the equations of an implicit method are solved."""

    linear: Linear
    newton: Newton | None


class SpringRule(TypedDict, total=False):
    """Springs on some edges. An edge that no rule selects has no spring. A rule for a group adds its springs to all
    edges of the group, beside those of other rules: a tape along the edges of a cloth. Of the other rules an edge
    follows the first that selects it. Exactly one of `stiffness`, `axial_rigidity`, `membrane`, `loads_only` and a
    `law` with a table is given, or a `material`."""

    axial_rigidity: float | None
    breaks: bool
    cut: float | CutTable | None
    dashpot: Dashpot | None
    law: ElasticLawRule | None
    linear_density: float | None
    loads_only: bool
    material: Text | None
    membrane: Membrane | None
    on: EdgeSelection
    rest_length: float | Numbers | None
    rest_scale: float | FactorTable | None
    slack: SlackRule | None
    stiffness: float | None
    strength: float | None
    when: When | None


Start: TypeAlias = "StartShape | SizedStart"
"""The shape at the start, by its name or with its sizes. Masses and rest lengths are those of the pattern in any
shape."""


StartShape: TypeAlias = 'Literal["flat", "inflated", "stretched", "packed"]'
"""A shape at the start by its name."""


Strategy: TypeAlias = 'Literal["auto", "full", "modified", "quasi"]'
"""When the tangent is computed again."""


class StretchedStart(TypedDict, total=False):
    """The size of the tube of line stretch."""

    radius: float


class Study(TypedDict, total=False):
    """What `canopy-fem tradeoff` and `canopy-fem stability` try; a list that is not given is chosen by the command."""

    budget_seconds: float | None
    methods: Sequence[Method] | None
    models: Sequence[ClothModel] | None
    quantities: Sequence[Text] | None
    repeat: int | None
    steps: Numbers | None
    tolerances: Numbers | None


class Support(TypedDict, total=False):
    """Nodes that are held where the initial displacement puts them, or are moved from there."""

    fix: Text
    motion: VectorTable | None
    on: NodeSelection
    settlement: Numbers | None
    until: float | None
    when: When | None


System: TypeAlias = "SystemNetwork | SystemPendulum"
"""What moves: a network of masses and springs, or a simple pendulum."""


class SystemNetwork(TypedDict, total=False):
    """Point masses joined by springs: cloth, canopies, chains."""

    network: Network


class SystemPendulum(TypedDict, total=False):
    """A simple pendulum: m L^2 theta'' = -m g L sin(theta) - c theta'."""

    pendulum: Pendulum


class TapeMaterials(TypedDict, total=False):
    """Names of the materials of a parachute's tapes. Those that are absent have the material of `lines`: the lines of
    many round canopies run over them, in the seams."""

    radials: Text | None
    rims: Text | None
    skirt: Text | None
    vent: Text | None
    vent_lines: Text | None
    verticals: Text | None


class Time(TypedDict, total=False):
    """End, method and steps of the run. Exactly one of `step` and `tolerance` is given."""

    end: float
    mass_scaling: MassScaling | None
    method: Method
    step: float | None
    tolerance: Tolerance | None
    until: Until | None
    until_rest: UntilRest | None


class Tolerance(TypedDict, total=False):
    """Error that the run may make in positions: `absolute` plus `relative` times the largest displacement so far, both
    as the root mean square over the free degrees of freedom. Each step may make a share of it in proportion to its
    size. The error of a run also depends on the scene: on swinging pendulums and cloths it is within a factor of
    ten of this."""

    absolute: float
    relative: float


class Until(TypedDict, total=False):
    """What ends a run before its time: the ground, at a height z."""

    ground: float
    of: NodeOrEdgeSelection | None


class UntilRest(TypedDict, total=False):
    """When a scene is at rest: no degree of freedom is faster than `speed`, and the forces would not make one faster
    within the time `every`."""

    every: float | None
    speed: float


class ValueTable(TypedDict, total=False):
    """A value over time."""

    table: Sequence[Numbers] | npt.NDArray[Any]


class VectorTable(TypedDict, total=False):
    """A vector over time."""

    table: Sequence[Numbers] | npt.NDArray[Any]


WarningCode: TypeAlias = 'Literal["mass-scaling", "air-pressure", "areal-density", "branching-edge", "braked-rotation", "cloth-crossing", "closing-canopy", "coincident-nodes", "contact-at-start", "contact-step", "disk-space", "drag-area", "drag-coefficient", "energy-dissipated", "energy-made", "event-at-start", "event-beyond-end", "experimental-model", "failed-start", "filling-beyond-end", "hanging-node", "initial-strain", "inside-out", "large-extent", "large-gravity", "large-mass", "leaning-canopy", "long-step", "loose-lines", "loose-nodes", "lost-motion", "mesh-file", "no-suction", "no-support", "no-wind", "overlapping-triangles", "reefing-line", "rounded-coordinates", "seam-gap", "short-pulse", "slack-opening", "slack-springs", "small-extent", "small-hole", "step-above-critical", "step-beyond-end", "step-dashpot", "strained-cloth", "stray-triangles", "supersonic-speed", "thin-air", "tight-cloth", "unlikely-material", "unselected-edges", "unused-rule", "up-axis", "wind-in-plane"]'
"""Kinds of warnings, by their codes in a case."""


class When(TypedDict, total=False):
    """When something happens, in place of a time that is given: once, the first time that a condition holds. A
    condition that holds at the start is met at t = 0. Exactly one of the conditions, `time` and `after` is given."""

    after: Text | None
    delay: float | None
    descending: bool | None
    dynamic_pressure_above: float | None
    dynamic_pressure_below: float | None
    height_above: float | None
    height_below: float | None
    name: Text | None
    of: NodeOrEdgeSelection | None
    speed_above: float | None
    speed_below: float | None
    tension_above: float | None
    time: float | None
