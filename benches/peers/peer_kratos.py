"""Kratos: springs as TrussElement3D2N, membranes as MembraneElement3D3N with LinearElasticPlaneStress2DLaw,
lumped masses as concentrated elements, weights and dead pressure as point loads.

`newmark-cg`, `newmark-lu`: Newmark 1/2, 1/4 (Bossak with damping 0) with Newton's iteration to the same residual as
ours, and the fastest iterative and the fastest direct solver of its packages. `central-difference`: explicit.

Its own truss law is linear in Green's strain, another spring than k (l - L). Ogden's law with the exponents 2 and 1 has
the energy E (stretch - 1)^2/2 and is ours exactly.
"""

import time

import KratosMultiphysics as KM
import numpy as np

KM.Logger.GetDefaultOutput().SetSeverity(KM.Logger.Severity.WARNING)
import KratosMultiphysics.ConstitutiveLawsApplication as CLA  # noqa: E402
import KratosMultiphysics.LinearSolversApplication  # noqa: E402, F401
import KratosMultiphysics.StructuralMechanicsApplication as SMA  # noqa: E402
from KratosMultiphysics.python_linear_solver_factory import ConstructSolver  # noqa: E402
from peer_common import Diverged, serve, steps_a_frame  # noqa: E402

SOLVERS = {
    "newmark-cg": '{"solver_type": "LinearSolversApplication.sparse_cg", "tolerance": 1e-8}',
    "newmark-lu": '{"solver_type": "LinearSolversApplication.sparse_lu"}',
}
EXPLICIT = [SMA.MIDDLE_VELOCITY, KM.NODAL_MASS, KM.FORCE_RESIDUAL, KM.RESIDUAL_VECTOR]
AXES = [(KM.DISPLACEMENT_X, KM.REACTION_X), (KM.DISPLACEMENT_Y, KM.REACTION_Y), (KM.DISPLACEMENT_Z, KM.REACTION_Z)]


def add_springs(scene, part):
    length = np.linalg.norm(scene.x0[scene.ends[:, 1]] - scene.x0[scene.ends[:, 0]], axis=1)
    if scene.damped or np.any(np.abs(length - scene.rest) > 1e-12 * length):
        raise ValueError("only unstretched springs without dashpots and air are modelled")
    for e, ((a, b), k, l0) in enumerate(
        zip(scene.ends.tolist(), scene.k.tolist(), scene.rest.tolist(), strict=True), start=1
    ):
        properties = part.CreateNewProperties(e)
        properties[KM.YOUNG_MODULUS] = k * l0
        properties[KM.DENSITY] = 0.0
        properties[SMA.CROSS_AREA] = 1.0
        properties[SMA.TRUSS_PRESTRESS_PK2] = 0.0
        properties[CLA.OGDEN_BETA_1], properties[CLA.OGDEN_BETA_2] = 2.0, 1.0
        properties[KM.CONSTITUTIVE_LAW] = CLA.HyperElasticIsotropicOgden1D()
        part.CreateNewElement("TrussElement3D2N", e, [a + 1, b + 1], properties)


def add_membranes(scene, part):
    """One material for all triangles alike."""
    first, materials = part.NumberOfElements() + 1, {}
    for e, (a, b, c, *material) in enumerate(scene.membranes.tolist(), start=first):
        if tuple(material) not in materials:
            thickness, modulus, poisson, wrinkles = material
            if wrinkles:
                raise ValueError("its law of wrinkling leaves a sheet that starts unstrained slack for ever")
            properties = materials[tuple(material)] = part.CreateNewProperties(part.NumberOfProperties() + 1)
            properties[KM.YOUNG_MODULUS], properties[KM.POISSON_RATIO] = modulus, poisson
            properties[KM.THICKNESS], properties[KM.DENSITY] = thickness, 0.0
            properties[KM.CONSTITUTIVE_LAW] = SMA.LinearElasticPlaneStress2DLaw()
        part.CreateNewElement("MembraneElement3D3N", e, [int(i) + 1 for i in (a, b, c)], materials[tuple(material)])


def build(scene):
    """The model part; whoever holds the model must outlive it."""
    model = KM.Model()
    part = model.CreateModelPart("cloth")
    for variable in (
        KM.DISPLACEMENT,
        KM.VELOCITY,
        KM.ACCELERATION,
        KM.REACTION,
        KM.VOLUME_ACCELERATION,
        SMA.POINT_LOAD,
        *EXPLICIT,
    ):
        part.AddNodalSolutionStepVariable(variable)
    part.ProcessInfo[KM.DOMAIN_SIZE] = 3
    part.SetBufferSize(2)
    for i, x in enumerate(scene.x0.tolist(), start=1):
        node = part.CreateNewNode(i, *x)
        for displacement, reaction in AXES:
            node.AddDof(displacement, reaction)
    add_springs(scene, part)
    add_membranes(scene, part)
    plain, elements = part.CreateNewProperties(part.NumberOfProperties() + 1), part.NumberOfElements()
    for i, (m, fixed, force) in enumerate(zip(scene.mass.tolist(), scene.fixed, scene.constant, strict=True), start=1):
        node = part.GetNode(i)
        if fixed:
            for displacement, _ in AXES:
                node.Fix(displacement)
            continue
        part.CreateNewElement("NodalConcentratedElement3D1N", elements + i, [i], plain).SetValue(KM.NODAL_MASS, m)
        part.CreateNewCondition("PointLoadCondition3D1N", i, [i], plain)
        for buffer in (0, 1):
            node.SetSolutionStepValue(SMA.POINT_LOAD, buffer, KM.Vector(force.tolist()))
            # At rest and unstretched nothing else accelerates.
            node.SetSolutionStepValue(KM.ACCELERATION, buffer, KM.Vector((force / m).tolist()))
    return model, part


def central_difference(part):
    """Its explicit scheme with the lumped masses; the step is that of the model part."""
    part.ProcessInfo[KM.COMPUTE_LUMPED_MASS_MATRIX] = True
    scheme = SMA.ExplicitCentralDifferencesScheme(1.0, 1.0, 0)
    steps = SMA.MechanicalExplicitStrategy(part, scheme, False, False, True)
    steps.SetRebuildLevel(0)
    return steps


def newmark(scene, part, solver):
    """Newton's iteration on Newmark's equations."""
    free = 3 * int(np.sum(~scene.fixed))
    weight = np.linalg.norm(scene.constant[~scene.fixed])
    settings = '{"damp_factor_m": 0.0, "newmark_beta": 0.25, "projection_variables_list": []}'
    scheme = SMA.StructuralMechanicsBossakScheme(KM.Parameters(settings))
    # The criterion divides the residual by the number of unknowns.
    criterion = KM.ResidualCriteria(0.0, 1e-8 * weight / free)
    criterion.SetEchoLevel(0)
    builder = KM.ResidualBasedEliminationBuilderAndSolver(ConstructSolver(KM.Parameters(solver)))
    return KM.ResidualBasedNewtonRaphsonStrategy(part, scheme, criterion, builder, 50, False, False, True)


def run(scene, method, _kind, step):
    if method != "central-difference" and method not in SOLVERS:
        raise ValueError("central-difference or " + " or ".join(SOLVERS))
    each = steps_a_frame(scene, step)
    h = scene.every / each
    model, part = build(scene)
    frames, before = [], time.process_time()
    solving = central_difference(part) if method == "central-difference" else newmark(scene, part, SOLVERS[method])
    solving.SetEchoLevel(0)
    part.ProcessInfo[KM.DELTA_TIME] = h
    solving.Initialize()
    for n in range(1, each * scene.frames + 1):
        part.CloneTimeStep(n * h)
        part.ProcessInfo[KM.STEP] = n
        solving.InitializeSolutionStep()
        solving.Predict()
        try:
            solved = solving.SolveSolutionStep() or method not in SOLVERS
        except RuntimeError as why:  # it throws where a linear solver fails on what Newton made of the matrix
            raise Diverged(f"at t = {n * h:g} s: {' '.join(str(why).split())[:100]}") from why
        if not solved:
            raise Diverged(f"Newton's iteration did not converge at t = {n * h:g} s")
        solving.FinalizeSolutionStep()
        if n % each == 0:
            frames.append(np.array([[node.X, node.Y, node.Z] for node in part.Nodes]))
    seconds = time.process_time() - before
    del solving, part, model
    return f"{each * scene.frames} steps", frames, seconds


if __name__ == "__main__":
    serve("Kratos " + KM.KratosGlobals.Kernel.Version().replace('"', ""), run)
