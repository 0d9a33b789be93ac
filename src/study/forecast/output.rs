//! What writing results costs a run: frames and rows, encoded once in memory, and what the system takes for a file.

use std::hint::black_box;

use super::cost::median_seconds;
use crate::case::spec::{OutputSpec, RowEvery};
use crate::mesh::CrossingFinder;
use crate::output::frame::{Fields, Frame, FrameSize};
use crate::output::rows::HistoryRow;
use crate::output::space::frame_bytes;
use crate::output::writer::most_frames;
use crate::scene::Scene;
use crate::vtk::write::{Array, Cells, Snapshot, Values, VtuWriter};

/// [s] spent on measuring a frame and a row each.
const BUDGET: f64 = 2e-3;
/// [s] What making, renaming and listing a file takes the system (501 frames of a single mass: 0.05 to 0.25 s).
const FILE: f64 = 1.5e-4;
/// [s] What handing a row to the writing thread and its share of a write take (10,000 rows: 0.03 to 0.08 s).
const ROW: f64 = 4e-6;

/// What results cost.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct OutputCost {
    /// frames of the whole run
    pub frames: f64,
    /// [s] a frame
    pub frame_seconds: f64,
    /// [s] a row of `history.csv`
    pub row_seconds: f64,
    /// [byte] a frame
    pub frame_bytes: u64,
    /// [byte] frames on their way to the disk, at most
    #[serde(skip)]
    pub(super) waiting_bytes: u64,
    #[serde(skip)]
    rows: RowEvery,
    #[serde(skip)]
    end: f64,
}

impl OutputCost {
    /// Measures at the start of a scene what `output` asks for until `end` [s].
    pub fn of(scene: &dyn Scene, output: &OutputSpec, fields: Fields, end: f64) -> OutputCost {
        let fields = fields.of_scene(scene);
        let state = scene.initial_state();
        let at = state.as_ref();
        let (nodes, edges, triangles) = (scene.reference().len(), scene.edges().len(), scene.triangles().len());
        let size = FrameSize { nodes, edges, triangles, fields };
        let mut frame = Frame::new(size);
        let cells = Cells { points: nodes, triangles: scene.triangles(), edges: scene.edges() };
        let encode = VtuWriter::new(&cells, output.format).map_or(0.0, |mut vtu| {
            let mut file: Vec<u8> = Vec::new();
            let zeros = vec![0.0; vtu.cells()];
            let scalars = |name| Array { name, values: Values::Scalars(&zeros) };
            let of_cells = [fields.tension, fields.strain, fields.rest_length, fields.pressure]
                .into_iter()
                .filter(|asked| *asked)
                .count();
            // A vector of the membranes costs as much as three scalars.
            let asked = of_cells + if fields.membrane { 8 } else { 0 };
            let cell_data = &[scalars("cells"); 12][..asked];
            let mut crossings = fields.crossing.then(|| CrossingFinder::new(scene.triangles())).flatten();
            median_seconds(BUDGET, || {
                file.clear();
                scene.trace(at, &mut frame.positions, &mut frame.velocities);
                if fields.tension || fields.strain {
                    scene.edge_tension(at, &mut frame.tension, &mut frame.strain);
                }
                if fields.tension {
                    scene.springs().into_iter().for_each(|springs| springs.add_axial_damping(at, &mut frame.tension));
                }
                if fields.pressure {
                    scene.air().into_iter().for_each(|air| air.triangle_pressure(at, &mut frame.pressure));
                }
                if fields.membrane {
                    scene.triangle_membranes(at, &mut frame.membrane);
                }
                if let Some(finder) = &mut crossings {
                    finder.find(&frame.positions);
                }
                let vectors = |name| Array { name, values: Values::Vectors(&frame.velocities) };
                let point_data = [vectors("displacement"), vectors("velocity"), vectors("force"), vectors("reaction")];
                let asked = 2 + usize::from(fields.force) + usize::from(fields.reaction);
                let point_data = &point_data[..asked];
                let picture = Snapshot { time: Some(0.0), points: &frame.positions, point_data, cell_data };
                black_box(vtu.write(&picture, &mut file).is_ok());
            })
        });
        let mut line = Vec::new();
        let row = median_seconds(BUDGET, || {
            line.clear();
            let (max_speed, max_strain) = (scene.max_speed(at), scene.max_strain(at));
            black_box(HistoryRow { max_speed, max_strain, ..HistoryRow::default() }.write(&mut line).is_ok());
        });
        let frames = 1.0 + output.frames_every.map_or(1.0, |every| (end / every).ceil());
        OutputCost {
            frames,
            waiting_bytes: (frames.min(most_frames(size) as f64) * size.bytes() as f64) as u64,
            frame_seconds: encode + FILE,
            row_seconds: row + ROW,
            frame_bytes: frame_bytes(scene, fields, output.format.precision),
            rows: output.history_every,
            end,
        }
    }

    /// [s] All output of a run of so many steps.
    pub fn seconds(&self, steps: f64) -> f64 {
        let rows = match self.rows {
            RowEvery::Steps(every) => steps / every.max(1) as f64,
            RowEvery::Time(every) => (self.end / every).min(steps),
        };
        self.frames * self.frame_seconds + rows * self.row_seconds
    }
}
