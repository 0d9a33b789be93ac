#!/usr/bin/env python3
"""A cavity whose bottom is a flexible sheet, coupled with the flow of Kratos.

    cavity.py make FOLDER --structure bars       writes mesh, case and parameters: also membrane, or kratos
    cavity.py run FOLDER                         runs them, as Kratos' own main program does
    cavity.py plot FIGURE FOLDER ...             draws the mid-point of the bottom of several runs

The lid of a unit square moves with 1 - cos(2 pi t/5) m/s. Fluid enters at the left and leaves at the right, above
y = 0.875 m. The bottom has modulus 250 N/m^2, thickness 2 mm and density 500 kg/m^3 (Mok 2001, Valdes 2007).
"""

import argparse
import json
import math
import os
import sys
import time
from pathlib import Path

from files import coupling_parameters, fluid_mesh, fluid_parameters, kratos_structure, own_case

# [s]
END = 40.0


def make(folder, kind, end):
    """Writes all that a run reads."""
    water = {
        "constitutive_law": {"name": "Newtonian2DLaw"},
        "Variables": {"DENSITY": 1.0, "DYNAMIC_VISCOSITY": 0.01},
        "Tables": {},
    }
    files = {
        "cavity.mdpa": fluid_mesh(),
        "FluidMaterials.json": {
            "properties": [{"model_part_name": "FluidModelPart.Fluid", "properties_id": 1, "Material": water}]
        },
        "ProjectParametersCFD.json": fluid_parameters(end),
    }
    if kind == "kratos":
        files |= kratos_structure(end)
        structure = {
            "type": "solver_wrappers.kratos.structural_mechanics_wrapper",
            "solver_wrapper_settings": {"input_file": "ProjectParametersCSM"},
        }
        coupling = coupling_parameters(structure, "Structure.Interface", 2, "POINT_LOAD", end)
    else:
        files["structure.json"] = own_case(kind, end)
        structure = {
            "type": "canopy_fem.kratos",
            "solver_wrapper_settings": {"input_file": "structure.json", "domain_size": 2},
        }
        coupling = coupling_parameters(structure, "Structure.bottom", 2, "FORCE", end)
    files["ProjectParametersCoSim.json"] = coupling
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        text = content if isinstance(content, str) else json.dumps(content, indent=2) + "\n"
        (folder / name).write_text(text, encoding="utf-8")


def run(folder):
    """Runs the coupled simulation in its folder, and counts."""
    import KratosMultiphysics as KM
    import KratosMultiphysics.CoSimulationApplication as KMC
    from KratosMultiphysics.CoSimulationApplication.co_simulation_analysis import CoSimulationAnalysis

    class Counted(CoSimulationAnalysis):
        """Counts steps and iterations of the coupling."""

        steps = iterations = 0

        def FinalizeSolutionStep(self):
            super().FinalizeSolutionStep()
            self.steps += 1
            self.iterations += self._GetSolver().process_info[KMC.COUPLING_ITERATION_NUMBER]

    os.chdir(folder)
    parameters = KM.Parameters(Path("ProjectParametersCoSim.json").read_text(encoding="utf-8"))
    KM.Logger.GetDefaultOutput().SetSeverity(KM.Logger.Severity.WARNING)
    analysis, begun = Counted(parameters), time.process_time()
    analysis.Run()
    took, steps = time.process_time() - begun, analysis.steps
    print(f"{steps} steps, each {took / steps:.3f} s of the processor, {analysis.iterations / steps:.2f} iterations")


def curve(folder):
    """Times [s] and heights [m] of the mid-point of a run."""
    lines = (Path(folder) / "midpoint.dat").read_text(encoding="utf-8").splitlines()
    rows = [line.split() for line in lines if line.strip() and not line.startswith("#")]
    return [float(row[0]) for row in rows], [float(row[2]) for row in rows]


def last_period(times, heights):
    """[m] Least and greatest height of the last 5 s."""
    last = [height for t, height in zip(times, heights) if t > times[-1] - 5.0 + 1e-9]
    return min(last), max(last)


def plot(figure, folders):
    """Draws the runs in these folders, and prints the range of the last period and the distance to the last of them."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.rcParams["svg.hashsalt"] = "cavity"
    axes = pyplot.figure(figsize=(8, 3.6), layout="constrained").gca()
    runs = {Path(folder).name: curve(folder) for folder in folders}
    reference = list(runs.values())[-1]
    for style, (name, (times, heights)) in zip(("-", "--", ":", "-."), runs.items()):
        axes.plot(times, heights, style, label=name, linewidth=1.4)
        apart = math.sqrt(sum((a - b) ** 2 for a, b in zip(heights, reference[1])) / len(heights))
        low, high = last_period(times, heights)
        print(f"{name}: last period {low:.4f} to {high:.4f} m; rms distance to {list(runs)[-1]} {apart:.5f} m")
    for name, low, high, color in (("Valdes 2007", 0.1977, 0.2690, "0.35"), ("Mok 2001", 0.1430, 0.2139, "0.65")):
        axes.fill_between([35, 40], low, high, color=color, alpha=0.25, label=f"{name}: last period", linewidth=0)
    axes.set(xlabel="time [s]", ylabel="height of the mid-point [m]", xlim=(0, reference[0][-1]))
    axes.legend(frameon=False, fontsize=8, loc="lower right", ncols=2)
    axes.figure.savefig(figure, metadata={"Date": None} if str(figure).endswith(".svg") else None)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    making = commands.add_parser("make")
    making.add_argument("folder", type=Path)
    making.add_argument("--structure", choices=["bars", "membrane", "kratos"], default="bars")
    making.add_argument("--end", type=float, default=END)
    commands.add_parser("run").add_argument("folder", type=Path)
    drawing = commands.add_parser("plot")
    drawing.add_argument("figure", type=Path)
    drawing.add_argument("folders", nargs="+")
    given = parser.parse_args()
    if given.command == "make":
        make(given.folder, given.structure, given.end)
    elif given.command == "run":
        run(given.folder)
    else:
        plot(given.figure, given.folders)


if __name__ == "__main__":
    sys.exit(main())
