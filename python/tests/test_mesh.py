"""Meshes: generators, arrays, files, other packages."""

import numpy as np
import pytest

import canopy_fem as cf


def test_generators_and_quality():
    ring = cf.mesh.annulus(inner_radius=0.1, outer_radius=1.0, nodes=200, boundary_nodes=60)
    assert len(ring.nodes) == 200 and ring.quality()["total_area"] == pytest.approx(np.pi * 0.99, rel=0.02)
    assert len(cf.mesh.disc(radius=1.0, nodes=100).nodes) == 100
    chain = cf.mesh.chain(start=[0, 0, 0], end=[0, 0, -2], segments=4)
    assert chain.edges.tolist() == [[0, 1], [1, 2], [2, 3], [3, 4]] and chain.nodes[-1].tolist() == [0, 0, -2]
    canopy = cf.mesh.parachute(type="flat-circular", nominal_diameter=8.5, gores=12, vent_diameter=0.8,
                               radial_segments=6, gore_segments=1, lines={"length": 7.0, "segments": 2})  # fmt: skip
    assert {"canopy", "lines", "payload"} <= set(canopy.groups)
    with pytest.raises(cf.CaseError, match="columns"):
        cf.mesh.generate("rectangle", width=1, height=1, colums=2, rows=2)
    with pytest.raises(cf.CaseError, match="width"):
        cf.mesh.rectangle(width=-1, height=1, columns=2, rows=2)


def test_files_keep_a_mesh(tmp_path):
    """A mesh with groups comes back from .vtu as it was; an existing file is kept unless it may be replaced."""
    nodes = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    mesh = cf.mesh.Mesh(
        nodes, triangles=[[0, 1, 2], [0, 2, 3]], groups={"cut": {"edges": [1]}, "foot": {"nodes": [0, 1]}}
    )
    assert mesh.edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]
    path = tmp_path / "square.vtu"
    mesh.write(path)
    again = cf.mesh.read(path)
    assert (again.nodes == nodes).all() and (again.triangles == mesh.triangles).all()
    assert again.groups["cut"]["edges"].tolist() == [1] and again.groups["foot"]["nodes"].tolist() == [0, 1]
    with pytest.raises(OSError, match="exists already"):
        mesh.write(path)
    mesh.write(path, replace=True)
    with pytest.raises(OSError, match="none.vtu"):
        cf.mesh.read(tmp_path / "none.vtu")


def test_meshio_there_and_back():
    pytest.importorskip("meshio")
    mesh = cf.mesh.Mesh(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 2, 0]],
        edges=[[3, 4], [0, 1], [0, 2], [0, 3], [1, 2], [2, 3]],
        triangles=[[0, 1, 2], [0, 2, 3]],
        groups={"line": {"edges": [0]}, "cloth": {"triangles": [0, 1]}, "end": {"nodes": [4]}},
    )
    again = cf.mesh.from_meshio(cf.mesh.to_meshio(mesh))
    for name in ("nodes", "edges", "triangles"):
        np.testing.assert_array_equal(getattr(again, name), getattr(mesh, name))
    groups = {name: {kind: list(n) for kind, n in group.items()} for name, group in again.groups.items()}
    assert groups == {"line": {"edges": [0]}, "cloth": {"triangles": [0, 1]}, "end": {"nodes": [4]}}


SQUARES = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0.0]])


def test_quads_of_other_packages_are_cut_as_those_of_files(tmp_path):
    """Two quads, one of them concave at its second corner, and a triangle that is written as a quad."""
    meshio = pytest.importorskip("meshio")
    points = np.vstack([SQUARES, [[1.6, 0.4, 0], [3, 0, 0]]])
    cells = [("quad", [[0, 1, 4, 3], [2, 6, 4, 5]]), ("triangle", [[1, 2, 6]]), ("quad", [[2, 7, 5, 5]])]
    sets = {"right": [np.array([1]), np.array([0]), np.array([0])]}
    made = cf.mesh.from_meshio(meshio.Mesh(points, cells, cell_sets=sets))
    path = tmp_path / "squares.vtu"
    meshio.Mesh(points, cells).write(path)
    read = cf.mesh.read(path)
    assert len(made.triangles) == 6
    assert {tuple(sorted(t)) for t in made.triangles.tolist()} == {tuple(sorted(t)) for t in read.triangles.tolist()}
    assert {tuple(sorted(e)) for e in made.edges.tolist()} == {tuple(sorted(e)) for e in read.edges.tolist()}
    assert made.groups["right"]["triangles"].tolist() == [2, 3, 4, 5]
    assert made.notes == ["3 quads were cut into two triangles each"]
    crossed = meshio.Mesh(points, [("quad", [[0, 4, 1, 3]])])
    with pytest.raises(cf.CaseError, match="crosses itself"):
        cf.mesh.from_meshio(crossed)


def test_cells_that_cannot_be_used_are_refused():
    """Those of second order and volumes, by name; points are left out with a note."""
    meshio = pytest.importorskip("meshio")
    for kind, cells in {"triangle6": [[0, 2, 5, 1, 4, 3]], "tetra": [[0, 1, 2, 4]], "line3": [[0, 2, 1]]}.items():
        with pytest.raises(cf.CaseError, match=f"1 cells of type {kind}"):
            cf.mesh.from_meshio(meshio.Mesh(SQUARES, [("triangle", [[0, 1, 4]]), (kind, cells)]))
    spots = meshio.Mesh(SQUARES, [("vertex", [[0]]), ("triangle", [[0, 1, 4]])])
    assert cf.mesh.from_meshio(spots).notes == ["1 point cells were left out"]
    pyvista = pytest.importorskip("pyvista")
    tetra = pyvista.UnstructuredGrid({10: np.array([[0, 1, 2, 4]])}, SQUARES + [[0, 0, i % 2] for i in range(6)])
    with pytest.raises(cf.CaseError, match="types 10.*extract_surface"):
        cf.mesh.from_pyvista(tetra)


def test_pyvistas_strips_and_quads_are_taken():
    """A sphere of strips has all of its triangles; quads are cut as from meshio; polygons are triangulated."""
    pyvista = pytest.importorskip("pyvista")
    sphere = pyvista.Sphere()
    strips = cf.mesh.from_pyvista(sphere.strip())
    assert len(strips.triangles) == sphere.n_cells == 1680
    nodes = strips.nodes[strips.triangles.astype(int)]
    outwards = np.cross(nodes[:, 1] - nodes[:, 0], nodes[:, 2] - nodes[:, 0])
    assert (np.einsum("ij,ij->i", outwards, nodes.mean(axis=1)) > 0).all()
    quads = pyvista.PolyData(SQUARES, faces=np.array([4, 0, 1, 4, 3, 4, 1, 2, 5, 4]))
    assert len(cf.mesh.from_pyvista(quads).triangles) == 4
    assert len(cf.mesh.from_pyvista(pyvista.Disc(c_res=8).extract_surface()).triangles) == 16
    assert len(cf.mesh.from_pyvista(pyvista.Polygon(n_sides=6)).triangles) == 4


def test_pyvista_there_and_back():
    pytest.importorskip("pyvista")
    mesh = cf.mesh.rectangle(width=1, height=1, columns=2, rows=2)
    data = cf.mesh.to_pyvista(mesh, mesh.nodes + 1.0)
    assert data.n_points == 9 and data.bounds[0] == 1.0
    again = cf.mesh.from_pyvista(cf.mesh.to_pyvista(mesh))
    assert {tuple(sorted(pair)) for pair in again.edges.tolist()} == {tuple(sorted(p)) for p in mesh.edges.tolist()}
    np.testing.assert_array_equal(again.triangles, mesh.triangles)


def test_files_are_repaired_as_a_case_says(tmp_path):
    """Two panels in millimetres that do not share their nodes become one sheet in metres."""
    panels = [f"v {x} {y} 0" for left in (0, 1000) for y in (0, 1000) for x in (left, left + 1000)]
    faces = ["f 1 2 4 3", "f 5 6 8 7"]
    path = tmp_path / "panels.obj"
    path.write_text("\n".join(panels + faces))
    assert len(cf.mesh.read(path).nodes) == 8
    sail = cf.mesh.read(path, scale=1e-3, axes="y-up", translate=(0, 0, 2), merge=1e-9, orient=True, diagonals="both")
    assert len(sail.nodes) == 6 and len(sail.edges) == 11
    assert np.allclose(sail.nodes.max(axis=0), [2, 0, 3])
    with pytest.raises(cf.CaseError, match="scale"):
        cf.mesh.read(path, scale=-1.0)
    assert sail.write(tmp_path / "sail.vtu") == []
    assert "1 group" in sail.write(tmp_path / "sail.stl")[0]


def test_flat_pieces_are_sewn(tmp_path):
    """Two squares of a drawing become one sheet along a side of each."""
    lines = ["0", "SECTION", "2", "ENTITIES"]
    for layer, left in (("a", 0.0), ("b", 2.0)):
        lines += ["0", "LWPOLYLINE", "8", layer, "90", "4", "70", "1"]
        for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)):
            lines += ["10", str(left + x), "20", str(float(y))]
    path = tmp_path / "two.dxf"
    path.write_text("\n".join([*lines, "0", "ENDSEC", "0", "EOF", ""]))
    apart = cf.mesh.read(path, edge=0.5)
    sewn = cf.mesh.read(path, edge=0.5, sew=[{"edges": ["a.2", "b.4"], "name": "hem"}])
    assert len(sewn.nodes) < len(apart.nodes)
    assert len(sewn.groups["hem"]["edges"]) >= 2
    with pytest.raises(cf.CaseError, match="a.1"):
        cf.mesh.read(path, edge=0.5, sew=[{"edges": ["a.2", "b.9"]}])
