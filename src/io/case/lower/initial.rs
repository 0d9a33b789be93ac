//! Initial displacement and velocity.

use super::geometry::Geometry;
use super::prestress::Prestress;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{FrameFile, Initial, InitialFrom, Keep, Vectors};
use crate::drive::Status;
use crate::format_number::{figures, first_few};
use crate::input_file;
use crate::mesh::frames::{FramePlace, FrameReader, holds_all, last_in, last_of};
use crate::model::spec::SpringGroup;
use crate::vtk::read::{DataSet, FrameLines, FramePoints, LINE_ARRAYS, POINT_ARRAYS, frame_lines, frame_points};
use crate::vtk::{FRAMES, SUMMARY};
use crate::warning::WarningCode;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// The network with which the initial state is checked.
#[derive(Debug)]
pub(super) struct Network<'a> {
    /// the mesh
    pub geometry: &'a Geometry,
    /// which of x, y, z is fixed, `[n_nodes][3]`
    pub fixed: &'a [[bool; 3]],
    /// [m/s] velocity of supports at t = 0, `[n_nodes][3]`; empty if none moves
    pub moved: &'a [[f64; 3]],
    /// springs, whose ends must not meet
    pub springs: &'a [SpringGroup],
}

/// The state of an earlier run, and what springs keep of it.
#[derive(Debug)]
pub(super) struct EarlierRun {
    state: InitialState,
    /// of its springs, if asked for
    pub prestress: Option<Prestress>,
}

/// Initial vectors of every node, `[n_nodes][3]`; empty = zero.
#[derive(Debug, Default)]
pub(super) struct InitialState {
    /// [m]
    pub displacement: Vec<[f64; 3]>,
    /// [m/s]
    pub velocity: Vec<[f64; 3]>,
}

/// Checks and resolves the `initial` section.
pub(super) fn initial(
    at: &Pointer,
    section: Option<&Initial>,
    earlier: Option<InitialState>,
    network: &Network<'_>,
    faults: &mut Faults<'_>,
) -> InitialState {
    let mut start =
        InitialState { displacement: network.geometry.mesh.displacement.clone(), ..InitialState::default() };
    if let Some(earlier) = earlier {
        check_lengths(&at.key("from"), &earlier.displacement, network, faults);
        start = earlier;
    }
    let (displacement, velocity) = section.map_or((None, None), |s| (s.displacement.as_ref(), s.velocity.as_ref()));
    if let Some(vectors) = displacement {
        let given = each(&at.key("displacement"), vectors, network.fixed, faults);
        start.displacement = sum(given, &start.displacement);
    }
    check_lengths(&at.key("displacement"), &start.displacement, network, faults);
    if let Some(vectors) = velocity {
        let at = at.key("velocity");
        let mut given = each(&at, vectors, network.fixed, faults);
        if let Vectors::Each(_) = vectors {
            check_held(&at, &mut given, network, faults);
        }
        start.velocity = sum(given, &start.velocity);
    }
    start
}

/// The sum of two vectors of every node; an empty second one is zero.
fn sum(mut given: Vec<[f64; 3]>, of_mesh: &[[f64; 3]]) -> Vec<[f64; 3]> {
    for (given, more) in given.iter_mut().zip(of_mesh) {
        given.iter_mut().zip(more).for_each(|(given, more)| *given += more);
    }
    given
}

/// One vector per node, `[n_nodes][3]`; a uniform one acts on the free degrees of freedom only.
fn each(at: &Pointer, vectors: &Vectors, fixed: &[[bool; 3]], faults: &mut Faults<'_>) -> Vec<[f64; 3]> {
    match vectors {
        Vectors::Same(v) => fixed.iter().map(|f| std::array::from_fn(|i| if f[i] { 0.0 } else { v[i] })).collect(),
        Vectors::Each(list) if list.len() == fixed.len() => list.clone(),
        Vectors::Each(list) => {
            let value = format!("{} vectors", list.len());
            faults.add_value(at, value, format!("one vector, or a list of {} (one per node)", fixed.len()), None);
            Vec::new()
        }
    }
}

/// Velocities that are held must be those of the supports; they become 0.
fn check_held(at: &Pointer, velocity: &mut [[f64; 3]], network: &Network<'_>, faults: &mut Faults<'_>) {
    for (i, (v, fixed)) in velocity.iter_mut().zip(network.fixed).enumerate() {
        let support = network.moved.get(i).copied().unwrap_or_default();
        let differs = |c: usize| fixed[c] && (v[c] - support[c]).abs() > SAME_SPEED * support[c].abs();
        if (0..3).any(differs) && support == [0.0; 3] {
            faults.add_hint(
                &at.index(i),
                "0 in the directions in which the node is held",
                "a support holds its node at rest; set the component to 0 or free it in the supports section",
            );
        } else if let Some(c) = (0..3).find(|c| differs(*c)) {
            let allowed = format!("{} m/s in {}, the velocity of its support", support[c], ["x", "y", "z"][c]);
            faults.add_hint(&at.index(i), allowed, "the motion of the support says how fast the node is at t = 0");
        }
        v.iter_mut().zip(fixed).filter(|(_, held)| **held).for_each(|(v, _)| *v = 0.0);
    }
}

/// A displacement must not move both ends of a spring to the same position, where the spring has no direction.
fn check_lengths(at: &Pointer, displacement: &[[f64; 3]], network: &Network<'_>, faults: &mut Faults<'_>) {
    // Empty if it was refused already: then the mesh as given is checked, which is no fault of the displacement.
    if displacement.is_empty() {
        return;
    }
    let meet = |edge: u32| network.geometry.start_length(edge, displacement).is_some_and(|length| !length.is_normal());
    let edges: Vec<u32> = network.springs.iter().flat_map(|g| g.edges.iter().copied()).filter(|e| meet(*e)).collect();
    if !edges.is_empty() {
        let value = format!("springs without length on edges {}", first_few(&edges));
        let hint = "the displaced ends of a spring coincide, or are farther apart than a double can hold".to_owned();
        faults.add_value(at, value, "a displacement after which every spring has a length", Some(hint));
    }
}

/// [-] Relative difference of velocities that count as the same.
const SAME_SPEED: f64 = 1e-9;

/// Largest distance between the nodes of two meshes that count as the same, as a share of their largest coordinate.
///
/// Displacements in frames may be in single precision.
const SAME: f64 = 1e-6;

/// The state with which another run ended, or that a frame shows; `fixed` says which of x, y, z is fixed,
/// `[n_nodes][3]`, and files are found from the folder `base`.
pub(super) fn earlier(
    at: &Pointer,
    section: &Initial,
    (geometry, fixed, base): (&Geometry, &[[bool; 3]], &Path),
    faults: &mut Faults<'_>,
) -> Option<EarlierRun> {
    let Some(from) = &section.from else {
        if section.keep.is_some() {
            let hint = "name the run whose springs are kept: \"from\": \"out/NAME\"";
            faults.add_hint(&at.key("keep"), "only together with from", hint);
        }
        return None;
    };
    let at_keep = at.key("keep");
    let at = &at.key("from");
    let (place, wanted) = match from {
        InitialFrom::Frame(FrameFile { frame }) => (frame_at(base.join(frame)), "a frame (.vtu) of a run"),
        InitialFrom::Folder(folder) => {
            (last_in(&base.join(folder)), "a folder with the results of a run, its frames among them")
        }
    };
    let place = match place {
        Ok(place) => place,
        Err(why) => {
            faults.add_hint(at, wanted, why);
            return None;
        }
    };
    let path = place.file.clone();
    let [[u, v], [tension, rest_length]] = [POINT_ARRAYS, LINE_ARRAYS];
    let names = if section.keep.is_some() { vec![u, v, tension, rest_length] } else { vec![u, v] };
    let read = FrameReader::default().read(&place, &names).map_err(|fault| fault.to_string());
    let lines = |frame: &DataSet| section.keep.map(|_| frame_lines(frame)).transpose();
    let (frame, lines) = match read.and_then(|frame| Ok((frame_points(&frame)?, lines(&frame)?))) {
        Ok(read) => read,
        Err(why) => {
            faults.add_hint(at, "a frame (.vtu) of a run", format!("{}: {why}", path.display()));
            return None;
        }
    };
    let nodes = &geometry.mesh.nodes;
    let FramePoints { positions, displacements, velocities } = frame;
    if positions.len() != nodes.len() {
        let hint = format!("{} has {} nodes, the mesh of this case {}", path.display(), positions.len(), nodes.len());
        faults.add_hint(at, "a run on the mesh of this case", hint);
        return None;
    }
    let size = nodes.as_flattened().iter().chain(positions.as_flattened()).fold(0.0, |most: f64, x| most.max(x.abs()));
    let apart = |((x, u), node): ((&[f64; 3], &[f64; 3]), &[f64; 3])| {
        // Not the opposite, which is false for a number that is not finite.
        !(0..3).all(|i| (x[i] - u[i] - node[i]).abs() <= SAME * size)
    };
    let elsewhere = displacements.and_then(|u| positions.iter().zip(&u).zip(nodes).position(apart));
    if let Some(node) = elsewhere {
        let hint = format!("node {node} is elsewhere on the mesh of {}", path.display());
        faults.add_hint(at, "a run on the mesh of this case", hint);
        return None;
    }
    let displacement = positions.iter().zip(nodes).map(|(x, node)| std::array::from_fn(|i| x[i] - node[i])).collect();
    let mut velocity = velocities.unwrap_or_else(|| vec![[0.0; 3]; nodes.len()]);
    // A support holds its node at rest.
    let held = velocity.as_flattened_mut().iter_mut().zip(fixed.as_flattened()).filter(|(_, held)| **held);
    held.for_each(|(v, _)| *v = 0.0);
    warn_of_failure(at, &path, faults);
    let state = InitialState { displacement, velocity };
    let kept = section.keep.zip(lines).map(|(keep, lines)| prestress(keep, lines, &state, geometry));
    let prestress = match kept.transpose() {
        Ok(kept) => kept,
        Err(missing) => {
            faults.add_hint(&at_keep, "a frame with what is kept", format!("{} {missing}", path.display()));
            None
        }
    };
    Some(EarlierRun { state, prestress })
}

impl EarlierRun {
    /// The state, and what springs keep.
    pub(super) fn split(self) -> (InitialState, Option<Prestress>) {
        (self.state, self.prestress)
    }
}

/// What the springs of a frame keep; else what it lacks, as the end of a sentence.
fn prestress(
    keep: Keep,
    lines: FrameLines,
    state: &InitialState,
    geometry: &Geometry,
) -> Result<Prestress, &'static str> {
    let edges = &geometry.mesh.edges;
    let same = edges.len() == lines.ends.len()
        && edges.iter().zip(&lines.ends).all(|(edge, ends)| edge.map(u64::from) == *ends);
    if !same {
        return Err("has other edges than the mesh of this case");
    }
    let FrameLines { tensions, rest_lengths, .. } = lines;
    let (tension, rest_length) = match (keep, tensions, rest_lengths) {
        (Keep::Tensions, Some(tensions), lengths) => (tensions, lengths.unwrap_or_else(|| vec![-1.0; edges.len()])),
        (Keep::Tensions, None, _) => return Err("has no array tension: name it in output.fields of the run"),
        (Keep::RestLengths, _, Some(lengths)) => (Vec::new(), lengths),
        (Keep::RestLengths, _, None) => {
            return Err("has no array rest_length: name rest-length in output.fields of the run");
        }
    };
    let length = (0..edges.len() as u32).filter_map(|edge| geometry.start_length(edge, &state.displacement));
    let (length, rigidity) = (length.collect(), vec![0.0; edges.len()]);
    Ok(Prestress { keep, length, tension, rest_length, rigidity })
}

/// The frame in a file, or the last one in a file that holds all frames of a run.
fn frame_at(file: PathBuf) -> Result<FramePlace, String> {
    match holds_all(&file) {
        true => last_of(&file).map_err(|what| format!("{}: {what}", file.display())),
        false => Ok(FramePlace { file, number: None }),
    }
}

/// How the summary of a run says that it ended.
#[derive(Deserialize)]
struct Ended {
    status: Status,
    t_end: f64,
}

/// Warns of a frame of a run that failed, by the summary in its folder.
fn warn_of_failure(at: &Pointer, frame: &Path, faults: &mut Faults<'_>) {
    let folder = match frame.parent() {
        Some(folder) if holds_all(frame) => Some(folder),
        frames => frames.filter(|frames| frames.ends_with(FRAMES)).and_then(Path::parent),
    };
    let Some(folder) = folder else { return };
    let summary = input_file::read(&folder.join(SUMMARY)).ok();
    let ended: Option<Ended> = summary.and_then(|bytes| serde_json::from_slice(&bytes).ok());
    let Some(Ended { status: status @ (Status::Diverged | Status::NotConverged), t_end }) = ended else { return };
    let how = if status == Status::Diverged { "diverged" } else { "could not be solved" };
    let text = format!(
        "{at}: the run in {} {how} after t = {} s, and what it shows last may be far from right: start from a run that \
         has completed, or from an early frame",
        folder.display(),
        figures(t_end, 6)
    );
    faults.warn(WarningCode::FailedStart, text);
}
