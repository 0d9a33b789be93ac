"""Prints the processor time [s] in which VTK or Gmsh reads a mesh file; nothing if neither does. Needs vtk and gmsh."""

import sys
import time


def vtk_reader(path):
    import vtk

    kind = path.rpartition(".")[2]
    if kind == "vtk":
        return vtk.vtkUnstructuredGridReader()
    names = {"vtu": "XMLUnstructuredGridReader", "ply": "PLYReader", "stl": "STLReader", "obj": "OBJReader"}
    return getattr(vtk, "vtk" + names[kind])()


def main(path):
    if path.endswith(".msh"):
        import gmsh

        gmsh.initialize()
        gmsh.option.setNumber("General.Terminal", 0)
        start = time.process_time()
        gmsh.open(path)
        print(time.process_time() - start)
        return
    reader = vtk_reader(path)
    reader.SetFileName(path)
    start = time.process_time()
    reader.Update()
    print(time.process_time() - start)


main(sys.argv[1])
