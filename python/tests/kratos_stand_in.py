"""A flow for Kratos' CoSimulation that costs nothing: forces that give way to displacements, on a line of points."""

import KratosMultiphysics as KM
from KratosMultiphysics.CoSimulationApplication.base_classes.co_simulation_solver_wrapper import (
    CoSimulationSolverWrapper,
)


def Create(settings, model, solver_name):
    return Flow(settings, model, solver_name)


class Flow(CoSimulationSolverWrapper):
    """`cells` of equal length from x = 0 to 1; -REACTION_Y = share (push - give MESH_DISPLACEMENT_Y)."""

    def __init__(self, settings, model, solver_name):
        super().__init__(settings, model, solver_name)
        own = self.settings["solver_wrapper_settings"]
        self._cells, self._step = own["cells"].GetInt(), own["step"].GetDouble()
        self._push, self._give = own["push"].GetDouble(), own["give"].GetDouble()
        self._breaks = own["breaks"].GetDouble()
        self.part = self.model.CreateModelPart("Flow")
        self.part.ProcessInfo[KM.DOMAIN_SIZE] = 2
        for variable in (KM.MESH_DISPLACEMENT, KM.REACTION):
            self.part.AddNodalSolutionStepVariable(variable)
        for i in range(self._cells + 1):
            self.part.CreateNewNode(i + 1, i / self._cells, 0.0, 0.0)
        properties = self.part.CreateNewProperties(1)
        for i in range(self._cells):
            self.part.CreateNewElement("Element2D2N", i + 1, [i + 1, i + 2], properties)

    def AdvanceInTime(self, current_time):
        self._time = current_time + self._step
        self.part.CloneTimeStep(self._time)
        return self._time

    def SolveSolutionStep(self):
        for node in self.part.Nodes:
            share = (0.5 if node.Id in (1, self._cells + 1) else 1.0) / self._cells
            moved = node.GetSolutionStepValue(KM.MESH_DISPLACEMENT_Y)
            force = share * (self._push - self._give * moved)
            broken = self._time > self._breaks
            node.SetSolutionStepValue(KM.REACTION_Y, float("nan") if broken and node.Id == 3 else -force)

    def Check(self):
        pass
