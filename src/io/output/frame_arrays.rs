//! The arrays of a frame, by their names, whichever file they go to.

use super::files::FilesSpec;
use super::frame::{CellMap, Fields, Frame, FrameSize, SIDE};
use crate::mesh::group::{GroupNumbers, KIND};
use crate::model::observables::MembranePicture;
use crate::vtk::write::{Array, Cells, FixedArrays, Snapshot, Values};

/// The cell array by which VTK leaves cells out of pictures; they are cells as before to all that reads the file.
/// Source: `vtkDataSetAttributes::GhostArrayName` and its `HIDDENCELL`.
const VTK_GHOSTS: &str = "vtkGhostType";
const HIDDEN_CELL: u8 = 32;

/// Makes the arrays of frames; buffers are reused.
#[derive(Debug)]
pub(super) struct FrameArrays {
    map: CellMap,
    cells: usize,
    fields: Fields,
    reference: Vec<[f64; 3]>,
    displacement: Vec<[f64; 3]>,
    tension: Vec<f64>,
    strain: Vec<f64>,
    rest_length: Vec<f64>,
    pressure: Vec<f64>,
    crossing: Vec<u8>,
    membranes: MembraneArrays,
}

/// The cells of a scene.
pub(super) fn cells_of<'a>(spec: &FilesSpec<'a>) -> Cells<'a> {
    Cells { points: spec.reference.len(), triangles: spec.triangles, edges: spec.edges }
}

impl FrameArrays {
    pub(super) fn new(spec: &FilesSpec<'_>) -> Self {
        let cells = match spec.triangles.len() + spec.edges.len() {
            // A scene without triangles and edges has vertex cells.
            0 => spec.reference.len(),
            cells => cells,
        };
        Self {
            map: CellMap::new(spec.triangles, spec.edges, cells),
            cells,
            fields: spec.fields,
            reference: spec.reference.to_vec(),
            displacement: vec![[0.0; 3]; spec.reference.len()],
            tension: Vec::new(),
            strain: Vec::new(),
            rest_length: Vec::new(),
            pressure: Vec::new(),
            crossing: Vec::new(),
            membranes: MembraneArrays::default(),
        }
    }

    /// Shows a frame of zeros, which has all arrays.
    pub(super) fn show_zeros<T>(&mut self, spec: &FilesSpec<'_>, then: impl FnOnce(&Snapshot<'_>) -> T) -> T {
        let (nodes, edges, triangles) = (spec.reference.len(), spec.edges.len(), spec.triangles.len());
        self.show(&Frame::new(FrameSize { nodes, edges, triangles, fields: spec.fields }), then)
    }

    /// Shows a frame with all its arrays.
    pub(super) fn show<T>(&mut self, frame: &Frame, then: impl FnOnce(&Snapshot<'_>) -> T) -> T {
        self.prepare(frame);
        let vectors = |name, values| Array { name, values: Values::Vectors(values) };
        let scalars = |name, values| Array { name, values: Values::Scalars(values) };
        let Fields { force, reaction, tension, strain, rest_length, pressure, membrane, crossing } = self.fields;
        let points = [
            (true, vectors("displacement", &self.displacement)),
            (true, vectors("velocity", &frame.velocities)),
            (force, vectors("force", &frame.force)),
            (reaction, vectors("reaction", &frame.reaction)),
        ];
        let cells = [
            (tension, scalars("tension", &self.tension)),
            (strain, scalars("strain", &self.strain)),
            (rest_length, scalars("rest_length", &self.rest_length)),
            (pressure, scalars("pressure", &self.pressure)),
            (membrane, scalars("stress_1", &self.membranes.scalars[0])),
            (membrane, scalars("stress_2", &self.membranes.scalars[1])),
            (membrane, scalars("strain_1", &self.membranes.scalars[2])),
            (membrane, scalars("strain_2", &self.membranes.scalars[3])),
            (membrane, scalars("wrinkling", &self.membranes.scalars[4])),
            (membrane, vectors("warp", &self.membranes.warp)),
            (crossing, Array { name: "crossing", values: Values::Flags(&self.crossing) }),
        ];
        then(&Snapshot {
            time: Some(frame.time),
            points: &frame.positions,
            point_data: &asked_for(&points),
            cell_data: &asked_for(&cells),
        })
    }

    fn prepare(&mut self, frame: &Frame) {
        let moved = frame.positions.as_flattened().iter().zip(self.reference.as_flattened());
        for (d, (x, x0)) in self.displacement.as_flattened_mut().iter_mut().zip(moved) {
            *d = x - x0;
        }
        if self.fields.tension {
            self.map.spread(&frame.tension, &mut self.tension);
        }
        if self.fields.strain {
            self.map.spread(&frame.strain, &mut self.strain);
        }
        if self.fields.rest_length {
            self.map.of_edges(&frame.rest_length, &mut self.rest_length);
        }
        if self.fields.pressure {
            self.map.of_triangles(&frame.pressure, &mut self.pressure);
        }
        if self.fields.crossing {
            self.map.of_triangles(&frame.crossing, &mut self.crossing);
        }
        if self.fields.membrane {
            self.membranes.fill(&frame.membrane, self.cells);
        }
    }
}

/// Cell arrays of membranes.
#[derive(Debug, Default)]
struct MembraneArrays {
    /// principal stresses, principal strains, wrinkling
    scalars: [Vec<f64>; 5],
    warp: Vec<[f64; 3]>,
}

impl MembraneArrays {
    /// Of the triangles, which come first among so many cells; all others have no membrane.
    fn fill(&mut self, triangles: &[MembranePicture], cells: usize) {
        let all = || triangles.iter().copied().chain(std::iter::repeat(MembranePicture::default())).take(cells);
        for (i, scalars) in self.scalars.iter_mut().enumerate() {
            scalars.clear();
            scalars.extend(all().map(|MembranePicture { stress: [s1, s2], strain: [e1, e2], wrinkling, .. }| {
                [s1, s2, e1, e2, wrinkling][i]
            }));
        }
        self.warp.clear();
        self.warp.extend(all().map(|of| of.warp));
    }
}

/// Shows what tells the parts of a scene apart: kinds of cells, and in a scene with groups their numbers and where the
/// nodes are on the mesh.
pub(super) fn with_parts<T>(spec: &FilesSpec<'_>, arrays: &FrameArrays, then: impl FnOnce(&FixedArrays<'_>) -> T) -> T {
    let kinds = arrays.map.kinds();
    let hide = |kind: &u8| if *kind == SIDE { HIDDEN_CELL } else { 0 };
    let hidden: Option<Vec<u8>> = kinds.as_ref().filter(|_| !spec.draw_sides).map(|k| k.iter().map(hide).collect());
    let flags = [(KIND, kinds.as_deref()), (VTK_GHOSTS, hidden.as_deref())];
    let flags: Vec<(&str, &[u8])> = flags.into_iter().filter_map(|(name, of)| Some((name, of?))).collect();
    let groups = GroupNumbers::new(spec.groups, [spec.reference.len(), spec.triangles.len(), spec.edges.len()]);
    let named = FixedArrays { cell_flags: &flags, ..FixedArrays::default() };
    if spec.groups.is_empty() {
        return then(&named);
    }
    then(&FixedArrays {
        point_vectors: Some(("reference_position", spec.reference)),
        point_numbers: groups.point_array(),
        cell_numbers: groups.cell_array(),
        field: &groups.field_arrays(),
        ..named
    })
}

fn asked_for<'a>(arrays: &[(bool, Array<'a>)]) -> Vec<Array<'a>> {
    arrays.iter().filter(|(on, _)| *on).map(|(_, array)| *array).collect()
}
