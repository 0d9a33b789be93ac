//! `canopy-fem mesh`: makes, converts and inspects meshes.

use super::mesh_json::to_json;
use super::mesh_output::doubts;
pub use super::mesh_output::{MeshCliError, OutputArgs};
use super::parachute::ParachuteArgs;
use crate::format_number::figures;
use crate::mesh::annulus::{AnnulusParameters, DiscParameters};
use crate::mesh::box_tree::Bounds;
use crate::mesh::canopy::Canopy;
use crate::mesh::chain::ChainParameters;
use crate::mesh::file::{Axes, Diagonals};
use crate::mesh::group::describe_groups;
use crate::mesh::read::{Imported, endings};
use crate::mesh::rectangle::{RectangleParameters, RectanglePattern};
use crate::mesh::sew::Seam;
use crate::mesh::write::write_mesh;
use crate::mesh::{BoundaryLoop, EdgeKind, Mesh, MeshFile, MeshSource, Quality, Topology};
use clap::{Args, Subcommand, ValueEnum};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Arguments of `canopy-fem mesh`.
#[derive(Clone, Debug, Args)]
pub struct MeshArgs {
    /// what to do
    #[command(subcommand)]
    pub command: MeshCommand,
}

/// What `canopy-fem mesh` can do.
#[derive(Clone, Debug, Subcommand)]
pub enum MeshCommand {
    /// Make a ring of triangles, graded towards its edges
    Annulus(AnnulusArgs),
    /// Make a disc of triangles, graded towards its edge
    Disc(DiscArgs),
    /// Make a rectangle of equal cells from the origin
    Rectangle(RectangleArgs),
    /// Make a straight chain of edges
    Chain(ChainArgs),
    /// Make a rigged parachute: canopy, lines, riser and payload, as named groups
    Parachute(Box<ParachuteArgs>),
    /// Read a mesh file, repair it if asked, and write it as .vtu, .vtp, .msh, .obj, .ply, .stl, .inp, .bdf, .mdpa or
    /// .glb
    #[command(after_long_help = format!("Reads {}.", endings()))]
    Convert(ConvertArgs),
    /// Print counts, boundary loops and quality of a mesh file
    Inspect(InspectArgs),
}

/// Counts and grading of a graded mesh.
#[derive(Clone, Debug, Args)]
pub struct GradedArgs {
    /// Number of nodes, met exactly
    #[arg(long)]
    pub nodes: usize,
    /// Number of nodes on the boundary, met exactly; derived if absent
    #[arg(long)]
    pub boundary_nodes: Option<usize>,
    /// Number of radial lines of edges
    #[arg(long)]
    pub seams: Option<usize>,
    /// Seed of the pseudo-random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Ratio of the edge length in the middle to that at the edges (0.2 to 10); derived if absent
    #[arg(long)]
    pub grading: Option<f64>,
}

/// Arguments of `mesh annulus`.
#[derive(Clone, Debug, Args)]
pub struct AnnulusArgs {
    /// [m] Radius of the hole
    #[arg(long)]
    pub inner: f64,
    /// [m] Radius of the outer edge
    #[arg(long)]
    pub outer: f64,
    /// counts and grading
    #[command(flatten)]
    pub graded: GradedArgs,
    /// the output
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Arguments of `mesh disc`.
#[derive(Clone, Debug, Args)]
pub struct DiscArgs {
    /// [m] Radius
    #[arg(long)]
    pub radius: f64,
    /// counts and grading
    #[command(flatten)]
    pub graded: GradedArgs,
    /// the output
    #[command(flatten)]
    pub output: OutputArgs,
}

/// How `mesh rectangle` cuts its cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum PatternArg {
    /// One diagonal per cell
    #[default]
    Regular,
    /// Both diagonals and a node where they cross
    Crossed,
}

/// Arguments of `mesh rectangle`.
#[derive(Clone, Debug, Args)]
pub struct RectangleArgs {
    /// [m] Extent along x
    #[arg(long)]
    pub width: f64,
    /// [m] Extent along y
    #[arg(long)]
    pub height: f64,
    /// Cells along x
    #[arg(long)]
    pub columns: usize,
    /// Cells along y
    #[arg(long)]
    pub rows: usize,
    /// How the cells are cut
    #[arg(long, value_enum, default_value_t)]
    pub pattern: PatternArg,
    /// the output
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Arguments of `mesh chain`.
#[derive(Clone, Debug, Args)]
pub struct ChainArgs {
    /// [m] First end, x y z
    #[arg(long, num_args = 3, value_names = ["X", "Y", "Z"], allow_negative_numbers = true)]
    pub from: Vec<f64>,
    /// [m] Last end, x y z
    #[arg(long, num_args = 3, value_names = ["X", "Y", "Z"], allow_negative_numbers = true)]
    pub to: Vec<f64>,
    /// Number of edges
    #[arg(long)]
    pub segments: usize,
    /// the output
    #[command(flatten)]
    pub output: OutputArgs,
}

/// A mesh file, placed and repaired in the order axes, scale, translate, edge, merge, orient.
#[derive(Clone, Debug, Args)]
pub struct FileArgs {
    /// Mesh file to read
    pub input: PathBuf,
    /// Further file of the same mesh, such as one with lines; may be given several times
    #[arg(long, value_name = "FILE")]
    pub with: Vec<PathBuf>,
    /// Factor on all coordinates, e.g. 0.001 for a file in millimetres; by the header of a .dxf if not given
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    pub scale: Option<f64>,
    /// Axis of the file that points up
    #[arg(long, value_enum, default_value_t)]
    pub axes: Axes,
    /// [m] Added to all coordinates, after --scale
    #[arg(long, num_args = 3, value_names = ["X", "Y", "Z"], allow_negative_numbers = true)]
    pub translate: Option<Vec<f64>>,
    /// [m] Fill closed polylines of a .dxf file with triangles whose edges are about this long
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub edge: Option<f64>,
    /// [m] Join nodes at most this far apart, and the ends of lines with them
    #[arg(long, value_name = "DISTANCE", allow_negative_numbers = true)]
    pub merge: Option<f64>,
    /// Turn triangles so that all normals of a part are on one side
    #[arg(long)]
    pub orient: bool,
    /// Diagonals of quads that become edges
    #[arg(long, value_enum, default_value_t)]
    pub diagonals: Diagonals,
    /// Refuse a file with a face that crosses itself, rather than leave the face out
    #[arg(long)]
    pub strict: bool,
    /// Seams of flat pieces, as a case has them: '[{"gores": ["LAYER"], "copies": 12}]'
    #[arg(long, value_parser = seams, value_name = "JSON")]
    pub sew: Option<Seams>,
}

/// Seams as JSON.
#[derive(Clone, Debug)]
pub struct Seams(Vec<Seam>);

fn seams(text: &str) -> Result<Seams, String> {
    serde_json::from_str(text).map(Seams).map_err(|error| error.to_string())
}

impl FileArgs {
    /// The mesh, and what the reader changed, asked for or not.
    fn read(&self) -> Result<(Mesh, Vec<String>), MeshCliError> {
        let file = MeshFile {
            file: self.input.display().to_string(),
            with: self.with.iter().map(|path| path.display().to_string()).collect(),
            scale: self.scale,
            axes: self.axes,
            translate: self.translate.as_deref().and_then(|list| list.try_into().ok()).unwrap_or_default(),
            edge: self.edge,
            merge: self.merge,
            orient: self.orient,
            diagonals: self.diagonals,
            strict: self.strict,
            sew: self.sew.clone().map(|Seams(list)| list).unwrap_or_default(),
        };
        let Imported { mesh, notes, repairs } = file.read(Path::new("")).map_err(MeshCliError::Input)?;
        Ok((mesh, [repairs, notes].concat()))
    }
}

/// Arguments of `mesh convert`.
#[derive(Clone, Debug, Args)]
pub struct ConvertArgs {
    /// the mesh
    #[command(flatten)]
    pub mesh: FileArgs,
    /// File to write: .vtu, .vtp, .msh, .obj, .ply, .stl, .inp, .bdf, .mdpa or .glb
    pub output: PathBuf,
    /// Replace the file if it exists
    #[arg(long)]
    pub force: bool,
}

/// Arguments of `mesh inspect`.
#[derive(Clone, Debug, Args)]
pub struct InspectArgs {
    /// the mesh
    #[command(flatten)]
    pub mesh: FileArgs,
    /// Print everything as JSON
    #[arg(long)]
    pub json: bool,
}

/// Runs `canopy-fem mesh`; returns what goes to standard output.
///
/// # Errors
/// Parameters out of range, unreadable or bad mesh files, and files that cannot be written.
pub fn run(args: &MeshArgs) -> Result<String, MeshCliError> {
    match &args.command {
        MeshCommand::Annulus(a) => {
            let GradedArgs { nodes, boundary_nodes, seams, seed, grading } = a.graded;
            let (inner_radius, outer_radius) = (a.inner, a.outer);
            let source = AnnulusParameters { inner_radius, outer_radius, nodes, boundary_nodes, seams, seed, grading };
            make(&MeshSource::Annulus(source), &a.output)
        }
        MeshCommand::Disc(a) => {
            let GradedArgs { nodes, boundary_nodes, seams, seed, grading } = a.graded;
            let source = DiscParameters { radius: a.radius, nodes, boundary_nodes, seams, seed, grading };
            make(&MeshSource::Disc(source), &a.output)
        }
        MeshCommand::Rectangle(a) => {
            let pattern = match a.pattern {
                PatternArg::Regular => RectanglePattern::Regular,
                PatternArg::Crossed => RectanglePattern::Crossed,
            };
            let RectangleArgs { width, height, columns, rows, .. } = *a;
            make(&MeshSource::Rectangle(RectangleParameters { width, height, columns, rows, pattern }), &a.output)
        }
        MeshCommand::Chain(a) => {
            let end = |values: &[f64]| <[f64; 3]>::try_from(values).map_err(|_| MeshCliError::ChainEnds);
            let source = ChainParameters { from: end(&a.from)?, to: end(&a.to)?, segments: a.segments };
            make(&MeshSource::Chain(source), &a.output)
        }
        MeshCommand::Parachute(a) => {
            let parameters = a.parameters();
            let source = MeshSource::Parachute(Box::new(parameters.clone()));
            let mesh = source.build(Path::new("")).map_err(MeshCliError::Input)?;
            let sizes = parameters.describe_sizes(&mesh).map_err(MeshCliError::Input)?;
            let lines = sizes.iter().map(|(what, text)| format!("{what:<13}{text}\n"));
            Ok(lines.collect::<String>() + &finish(&mesh, &a.output)?)
        }
        MeshCommand::Convert(a) => {
            let (mesh, notes) = a.mesh.read()?;
            Ok(describe(&mesh, &Topology::of_checked(&mesh), &notes) + &write(&mesh, &a.output, a.force)?)
        }
        MeshCommand::Inspect(a) => {
            let (mesh, notes) = a.mesh.read()?;
            let topology = Topology::of_checked(&mesh);
            Ok(if a.json { to_json(&mesh, &topology, &notes) } else { describe(&mesh, &topology, &notes) })
        }
    }
}

fn make(source: &MeshSource, output: &OutputArgs) -> Result<String, MeshCliError> {
    finish(&source.build(Path::new("")).map_err(MeshCliError::Input)?, output)
}

/// Describes a mesh, and writes it if a file is named.
fn finish(mesh: &Mesh, output: &OutputArgs) -> Result<String, MeshCliError> {
    let topology = Topology::new(mesh).map_err(MeshCliError::Input)?;
    let text = describe(mesh, &topology, &[]);
    match &output.output {
        Some(path) => Ok(text + &write(mesh, path, output.force)?),
        None => Ok(text),
    }
}

fn write(mesh: &Mesh, path: &Path, replace: bool) -> Result<String, MeshCliError> {
    let notes = write_mesh(mesh, path, replace).map_err(MeshCliError::Output)?;
    let notes: String = notes.iter().map(|note| format!("note: {note}\n")).collect();
    Ok(format!("{notes}written to {}\n", path.display()))
}

/// Most loops that have a line of their own.
const LOOPS: usize = 10;

/// A line for each of the first loops, and one for the rest.
fn loops(all: &[BoundaryLoop]) -> Vec<String> {
    let told = |l: &BoundaryLoop| {
        let kind = if l.outer { "outer" } else { "inner" };
        let open = if l.closed { "" } else { ", not closed" };
        let nodes = l.nodes.len();
        format!("{kind} loop   {nodes} nodes, length {:.6} m, extent {:.6} m{open}", l.length, l.extent)
    };
    let mut lines: Vec<String> = all.iter().take(LOOPS).map(told).collect();
    let rest = all.get(LOOPS..).unwrap_or_default();
    if !rest.is_empty() {
        let outer = rest.iter().filter(|l| l.outer).count();
        let length: f64 = rest.iter().map(|l| l.length).sum();
        let inner = rest.len() - outer;
        lines.push(format!("more loops   {outer} outer, {inner} inner, length {length:.6} m in all"));
    }
    lines
}

/// Counts, loops, quality, histogram, and faults that matter for a simulation.
fn describe(mesh: &Mesh, topology: &Topology, notes: &[String]) -> String {
    let quality = Quality::with_topology(mesh, topology);
    let count = |kind| (0..mesh.edges.len()).filter(|&e| topology.edge_kind(e) == kind).count();
    let mut lines = vec![
        format!("nodes        {}", mesh.nodes.len()),
        format!(
            "edges        {} ({} boundary, {} interior, {} lines; {} on seams)",
            mesh.edges.len(),
            count(EdgeKind::Boundary),
            count(EdgeKind::Interior),
            count(EdgeKind::Line),
            mesh.seams.len()
        ),
        format!("triangles    {}", mesh.triangles.len()),
        format!("components   {}, Euler characteristic {}", quality.components, quality.euler_characteristic),
    ];
    let Bounds { low, high } = Bounds::of(&mesh.nodes);
    let side = |k: usize| format!("{} {} to {} m", ["x", "y", "z"][k], figures(low[k], 7), figures(high[k], 7));
    lines.push(format!("box          {}", [0, 1, 2].map(side).join(", ")));
    lines.extend(loops(topology.loops()));
    lines.push(format!(
        "edge length  {:.6} to {:.6} m, mean {:.6} m",
        quality.min_edge, quality.max_edge, quality.mean_edge
    ));
    lines.extend(describe_groups(mesh).iter().map(|group| format!("group        {group}")));
    let canopies = Canopy::of_groups(mesh);
    let sizes = canopies.iter().filter_map(|(name, canopy)| Some((name, canopy.as_ref().ok()?.sizes())));
    lines.extend(sizes.map(|(name, sizes)| format!("{name:<13}{sizes}")));
    if !mesh.triangles.is_empty() {
        lines.push(format!(
            "angles       {:.2} to {:.2} degrees, mean smallest {:.2}",
            quality.min_angle, quality.max_angle, quality.mean_min_angle
        ));
        lines.push(format!(
            "radius ratio {:.4} smallest, {:.4} mean (1 is equilateral)",
            quality.min_radius_ratio, quality.mean_radius_ratio
        ));
        lines.push(format!("area         {:.6} m^2, smallest {:.3e} m^2", quality.total_area, quality.min_area));
        lines.push("angle histogram (degrees, count)".to_owned());
    }
    let mut text = lines.join("\n") + "\n" + &quality.histogram_text();
    for note in doubts(mesh, topology, notes) {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "note: {note}");
    }
    text
}
