"""Meshes, cases and parameters of the cavity, as `cavity.py make` writes them."""

CELLS = 32
STEP = 0.1
MODULUS, THICKNESS, DENSITY = 250.0, 0.002, 500.0
# [m] from here up the sides are open
SILL = 0.875
SPEED = "(1-cos(2*pi*t/5))"


def mdpa(nodes, cells, kind, parts, conditions=()):
    """The text of a mesh file: nodes, elements of a kind, and parts, each of nodes, elements and conditions."""
    lines = ["Begin Properties 0", "End Properties", "Begin Nodes"]
    lines += [f"{i} {x:.17g} {y:.17g} 0.0" for i, (x, y) in enumerate(nodes, 1)]
    lines += ["End Nodes", f"Begin Elements {kind}"]
    lines += [f"{i} 0 {' '.join(str(n) for n in cell)}" for i, cell in enumerate(cells, 1)]
    lines.append("End Elements")
    for name, members in conditions:
        lines += [f"Begin Conditions {name}", *(f"{i} 0 {' '.join(map(str, cell))}" for i, cell in members)]
        lines.append("End Conditions")
    for name, part in parts.items():
        lines.append(f"Begin SubModelPart {name}")
        for what in ("Nodes", "Elements", "Conditions"):
            members = [f"  {i}" for i in part.get(what, ())]
            lines += [f" Begin SubModelPart{what}", *members, f" End SubModelPart{what}"]
        lines.append("End SubModelPart")
    return "\n".join(lines) + "\n"


def fluid_mesh():
    """The square: triangles with alternating diagonals, and its sides."""
    n = CELLS + 1
    number = lambda i, j: j * n + i + 1
    nodes = [(i / CELLS, j / CELLS) for j in range(n) for i in range(n)]
    cells = []
    for j in range(CELLS):
        for i in range(CELLS):
            a, b, c, d = number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)
            cells += [(a, b, c), (a, c, d)] if (i + j) % 2 == 1 else [(a, b, d), (b, c, d)]
    sill = round(SILL * CELLS)
    sides = {
        "Bottom": [number(i, 0) for i in range(n)],
        "Lid": [number(i, CELLS) for i in range(n)],
        "Inlet": [number(0, j) for j in range(sill, n)],
        "Outlet": [number(CELLS, j) for j in range(sill, n)],
        "Left": [number(0, j) for j in range(sill + 1)],
        "Right": [number(CELLS, j) for j in range(sill + 1)],
    }
    parts, lines = {"Fluid": {"Nodes": range(1, n * n + 1), "Elements": range(1, len(cells) + 1)}}, []
    for name, side in sides.items():
        first = len(lines) + 1
        lines += [(first + k, pair) for k, pair in enumerate(zip(side, side[1:]))]
        parts[name] = {"Nodes": side, "Conditions": range(first, len(lines) + 1)}
    return mdpa(nodes, cells, "Element2D3N", parts, [("LineCondition2D2N", lines)])


def process(module, parameters, application="KratosMultiphysics", name=None):
    """One process of Kratos."""
    return {
        "python_module": module,
        "kratos_module": application,
        "process_name": name or "".join(word.capitalize() for word in module.split("_")),
        "Parameters": parameters,
    }


def part(name, **more):
    return {"model_part_name": f"FluidModelPart.{name}", **more}


def fluid_parameters(end):
    """Incompressible flow on a mesh that follows the bottom."""
    flow = "KratosMultiphysics.FluidDynamicsApplication"
    still = ("Lid", "Inlet", "Outlet", "Left", "Right")
    lu = {"solver_type": "LinearSolversApplication.sparse_lu"}
    return {
        "problem_data": {
            "problem_name": "cavity", "parallel_type": "OpenMP", "echo_level": 0, "start_time": 0.0, "end_time": end,
        },
        "solver_settings": {
            "solver_type": "ale_fluid",
            "echo_level": 0,
            "ale_boundary_parts": ["Bottom"],
            "fluid_solver_settings": {
                "solver_type": "Monolithic",
                "model_part_name": "FluidModelPart",
                "domain_size": 2,
                "model_import_settings": {"input_type": "mdpa", "input_filename": "cavity"},
                "material_import_settings": {"materials_filename": "FluidMaterials.json"},
                "formulation": {"element_type": "vms", "dynamic_tau": 1.0},
                "maximum_iterations": 20,
                "relative_velocity_tolerance": 1e-5,
                "absolute_velocity_tolerance": 1e-7,
                "relative_pressure_tolerance": 1e-5,
                "absolute_pressure_tolerance": 1e-7,
                "compute_reactions": True,
                "reform_dofs_at_each_step": False,
                "linear_solver_settings": lu,
                "volume_model_part_name": "FluidModelPart.Fluid",
                "skin_parts": [f"FluidModelPart.{name}" for name in ("Bottom", *still)],
                "no_skin_parts": [],
                "time_scheme": "bossak",
                "alpha": -0.3,
                "time_stepping": {"automatic_time_step": False, "time_step": STEP},
            },
            "mesh_motion_solver_settings": {
                "solver_type": "structural_similarity", "domain_size": 2, "linear_solver_settings": lu,
            },
        },
        "processes": {
            "boundary_conditions_process_list": [
                process("apply_inlet_process", part("Lid", modulus=SPEED, direction=[1.0, 0.0, 0.0]), flow),
                process(
                    "apply_inlet_process",
                    part("Inlet", modulus=f"{SPEED}*(y-{SILL})/{1 - SILL}", direction=[1.0, 0.0, 0.0]),
                    flow,
                ),
                process("apply_outlet_process", part("Outlet", value=0.0), flow),
                *(process("apply_noslip_process", part(name), flow) for name in ("Left", "Right", "Bottom")),
                *(
                    process(
                        "assign_vector_variable_process",
                        part(name, variable_name="MESH_DISPLACEMENT", constrained=[True] * 3, value=[0.0] * 3),
                    )
                    for name in still
                ),
                process(
                    "fix_vector_variable_process",
                    part("Bottom", variable_name="MESH_DISPLACEMENT", constrained=[True] * 3),
                ),
            ],
        },
        "output_processes": {
            "midpoint": [
                process(
                    "point_output_process",
                    part(
                        "Bottom",
                        position=[0.5, 0.0, 0.0],
                        entity_type="node",
                        output_variables=["MESH_DISPLACEMENT"],
                        output_file_settings={"file_name": "midpoint"},
                    ),
                )
            ],
        },
    }


def coupling_parameters(structure, model_part, size, force, end):
    """Strong coupling: the flow, then the structure, until the displacement of the bottom rests."""
    data = lambda name, variable: {"model_part_name": name, "variable_name": variable, "dimension": size}
    return {
        "problem_data": {
            "problem_name": "flexible_cavity", "start_time": 0.0, "end_time": end, "echo_level": 0,
            "print_colors": False, "parallel_type": "OpenMP",
        },
        "solver_settings": {
            "type": "coupled_solvers.gauss_seidel_strong",
            "echo_level": 1,
            "num_coupling_iterations": 30,
            "convergence_accelerators": [
                {"type": "mvqn", "solver": "structure", "data_name": "disp", "horizon": 20, "alpha": 0.1}
            ],
            "convergence_criteria": [
                {
                    "type": "relative_norm_previous_residual", "solver": "structure", "data_name": "disp",
                    "abs_tolerance": 1e-8, "rel_tolerance": 1e-6,
                }
            ],
            "data_transfer_operators": {
                "mapper": {"type": "kratos_mapping", "mapper_settings": {"mapper_type": "nearest_element"}}
            },
            "coupling_sequence": [
                {
                    "name": "fluid",
                    "input_data_list": [
                        {
                            "data": "disp", "from_solver": "structure", "from_solver_data": "disp",
                            "data_transfer_operator": "mapper",
                        }
                    ],
                    "output_data_list": [],
                },
                {
                    "name": "structure",
                    "input_data_list": [
                        {
                            "data": "load", "from_solver": "fluid", "from_solver_data": "load",
                            "data_transfer_operator": "mapper",
                            "data_transfer_operator_options": ["swap_sign", "use_transpose"],
                        }
                    ],
                    "output_data_list": [],
                },
            ],
            "solvers": {
                "fluid": {
                    "type": "solver_wrappers.kratos.fluid_dynamics_wrapper",
                    "solver_wrapper_settings": {"input_file": "ProjectParametersCFD"},
                    "data": {
                        "disp": {**data("FluidModelPart.Bottom", "MESH_DISPLACEMENT"), "dimension": 2},
                        "load": {**data("FluidModelPart.Bottom", "REACTION"), "dimension": 2},
                    },
                },
                "structure": {
                    **structure,
                    "data": {"disp": data(model_part, "DISPLACEMENT"), "load": data(model_part, force)},
                },
            },
        },
    }


def own_case(kind, end):
    """The bottom as a case of canopy-fem: bars of finite strain, or a strip of membranes one cell wide."""
    n = CELLS + 1
    rigidity, mass = MODULUS * THICKNESS, DENSITY * THICKNESS
    network = {"gravity": [0, 0, 0]}
    if kind == "bars":
        nodes = [[i / CELLS, 0.0, 0.0] for i in range(n)]
        mesh = {"nodes": nodes, "springs": [[i, i + 1] for i in range(CELLS)]}
        ends = [0, CELLS]
        network["springs"] = [{"on": "all", "axial_rigidity": rigidity, "law": "green", "linear_density": mass}]
    else:
        nodes = [[i / CELLS, 0.0, row / CELLS] for i in range(n) for row in (0, 1)]
        mesh = {"nodes": nodes, "triangles": []}
        for i in range(CELLS):
            a, b, c, d = 2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1
            # All diagonals in one direction, for equal masses along both edges.
            mesh["triangles"] += [[a, b, c], [a, c, d]]
        ends = [0, 1, 2 * CELLS, 2 * CELLS + 1]
        sheet = {"on": "all", "thickness": THICKNESS, "modulus": MODULUS, "poisson": 0.0}
        network |= {"membranes": [sheet], "mass": {"areal_density": mass}}
    mesh["groups"] = {"bottom": {"nodes": list(range(len(nodes)))}}
    held = [{"on": {"ids": ends}, "fix": "xyz"}, {"on": "all", "fix": "z"}]
    return {
        "name": f"cavity-{kind}",
        "system": {"network": {"mesh": {"explicit": mesh}, "supports": held, **network}},
        "time": {"end": end, "method": "newmark", "step": STEP},
    }


def kratos_structure(end):
    """The bottom as solids of Kratos, of finite strain in plane stress: mesh, materials and parameters by file name."""
    n = CELLS + 1
    nodes = [(i / CELLS, row * THICKNESS) for row in (0, -1) for i in range(n)]
    cells = [(n + i, n + i + 1, i + 1, i) for i in range(1, n)]
    parts = {
        "Sheet": {"Nodes": range(1, 2 * n + 1), "Elements": range(1, n)},
        "Ends": {"Nodes": [1, n, n + 1, 2 * n]},
        "Interface": {"Nodes": range(1, n + 1), "Conditions": range(1, n)},
    }
    sides = [(i, (i, i + 1)) for i in range(1, n)]
    loads = [(n + i, (i,)) for i in range(1, n + 1)]
    mesh = mdpa(
        nodes, cells, "TotalLagrangianElement2D4N", parts,
        [("LineLoadCondition2D2N", sides), ("PointLoadCondition2D1N", loads)],
    )
    held = process(
        "assign_vector_variable_process",
        {
            "model_part_name": "Structure.Ends", "variable_name": "DISPLACEMENT",
            "constrained": [True] * 3, "value": [0.0] * 3,
        },
    )
    material = {
        "constitutive_law": {"name": "LinearElasticPlaneStress2DLaw"},
        "Variables": {"DENSITY": DENSITY, "YOUNG_MODULUS": MODULUS, "POISSON_RATIO": 0.0, "THICKNESS": 1.0},
        "Tables": {},
    }
    parameters = {
        "problem_data": {
            "problem_name": "bottom", "parallel_type": "OpenMP", "echo_level": 0, "start_time": 0.0, "end_time": end,
        },
        "solver_settings": {
            "solver_type": "dynamic",
            "model_part_name": "Structure",
            "domain_size": 2,
            "echo_level": 0,
            "analysis_type": "non_linear",
            "time_integration_method": "implicit",
            "scheme_type": "newmark",
            "model_import_settings": {"input_type": "mdpa", "input_filename": "bottom"},
            "material_import_settings": {"materials_filename": "StructureMaterials.json"},
            "time_stepping": {"time_step": STEP},
            "convergence_criterion": "residual_criterion",
            "residual_relative_tolerance": 1e-9,
            "residual_absolute_tolerance": 1e-12,
            "max_iteration": 50,
            "linear_solver_settings": {"solver_type": "LinearSolversApplication.sparse_lu"},
            "rotation_dofs": False,
        },
        "processes": {"constraints_process_list": [held]},
    }
    return {
        "bottom.mdpa": mesh,
        "StructureMaterials.json": {
            "properties": [{"model_part_name": "Structure.Sheet", "properties_id": 1, "Material": material}]
        },
        "ProjectParametersCSM.json": parameters,
    }
