//! One page with all frames of one or two runs.

use super::curves::Curves;
use super::packed::{FrameHead, PackedFrame};
use super::recording::{Recording, fault_of};
use super::scene::{FIELDS, Field, PartGroup, Scene};
use crate::StudyError;
use crate::mesh::frames::{FrameFault, FrameReader};
use crate::plot::PlotError;
use crate::template::render;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;
use std::io::Write;

/// [byte] Largest page with frames.
pub const LARGEST_PAGE: usize = 20_000_000;
/// [byte] Codes of the frames of a page before they are compressed.
const LARGEST_CODES: usize = 64 << 20;
/// [byte] Codes of the frames in an answer of the server.
const LARGEST_PART: usize = 8 << 20;

const PAGE: &str = include_str!("../templates/view/view.html");
const STYLE: &str = include_str!("../templates/view/view.css");
/// In the order in which the page runs them.
const SCRIPTS: [&str; 5] = [
    include_str!("../templates/view/data.js"),
    include_str!("../templates/view/camera.js"),
    include_str!("../templates/view/scene.js"),
    include_str!("../templates/view/curves.js"),
    include_str!("../templates/view/page.js"),
];

/// A run on a page.
#[derive(Clone, Debug, Serialize)]
pub struct View {
    /// name of its case
    name: String,
    /// name of its method, where the run has ended
    method: String,
    /// [-] number of nodes, triangles, edges and nodes without either
    counts: [usize; 4],
    /// named parts
    groups: Vec<PartGroup>,
    /// what colours can show
    fields: Vec<Field>,
    /// cells and classes
    topology: String,
    /// frames and curves
    part: Part,
}

/// Some frames of a run, and all its curves.
#[derive(Clone, Debug, Serialize)]
pub struct Part {
    /// how the run ended; empty while it goes on
    status: String,
    /// what a viewer must know of it, sentences
    notes: Vec<String>,
    /// number of frames in the list
    listed: usize,
    /// number of the first frame of the list that was not looked at
    next: usize,
    /// what the codes of each frame mean
    frames: Vec<FrameHead>,
    /// codes of all frames
    data: String,
    /// gauges
    curves: Curves,
}

/// [-] Extent of a scene over that of its first frame above which it has blown up.
const BLOWN_UP: f64 = 1000.0;
/// Frames below which there is hardly anything to play.
const FEW: usize = 5;

/// What a page is filled with.
#[derive(Serialize)]
struct Context<'a> {
    version: &'a str,
    title: &'a str,
    style: minijinja::Value,
    script: minijinja::Value,
    runs: minijinja::Value,
    live: bool,
}

/// Bytes compressed by zlib, in base64.
pub(super) fn encoded(bytes: &[u8]) -> String {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    // Nothing fails that writes into memory.
    let packed = encoder.write_all(bytes).and_then(|()| encoder.finish()).unwrap_or_default();
    STANDARD.encode(packed)
}

/// Whether a frame shows a scene that is far larger than in the first one.
fn blown_up(before: &[PackedFrame], frame: &PackedFrame) -> bool {
    let first = before.first().map_or(0.0, PackedFrame::extent);
    first > 0.0 && frame.extent() > BLOWN_UP * first
}

/// Frames of a run in memory.
struct Frames {
    scene: Scene,
    packed: Vec<PackedFrame>,
    /// every so many of the list
    stride: usize,
    /// frames without finite positions
    dropped: usize,
    /// frames of a scene that has blown up
    apart: usize,
    next: usize,
}

impl Frames {
    /// Reads frames of a run from number `from` of its list on, as many as fit into so many bytes: the first ones, or
    /// with `spread` every second, third, … of all of them, and the last.
    fn read(run: &Recording, from: usize, most: usize, spread: bool) -> Result<Self, PlotError> {
        let bad = |at: usize, what| fault_of(&run.frames[at].1, FrameFault::Content(what));
        let mut reader = FrameReader::default();
        let mut frame = |place, names: &[&str]| reader.read(place, names).map_err(|fault| fault_of(place, fault));
        let Some((_, first)) = run.frames.first() else {
            return Err(PlotError::NotThere(format!("{} lists no frames yet", run.folder.display())));
        };
        let scene = Scene::new(frame(first, &FIELDS.map(|field| field.array))?).map_err(|what| bad(0, what))?;
        let names: Vec<&str> = scene.fields.iter().map(|field| field.array).collect();
        let fit = (most / scene.frame_bytes().max(1)).max(2);
        let left = run.frames.len().saturating_sub(from);
        let stride = if spread { left.div_ceil(fit).max(1) } else { 1 };
        let end = if spread { run.frames.len() } else { run.frames.len().min(from + fit) };
        let mut numbers: Vec<usize> = (from..end).step_by(stride).collect();
        if numbers.last().is_some_and(|last| last + 1 < end) {
            numbers.push(end - 1);
        }
        let (mut packed, mut dropped, mut apart): (Vec<PackedFrame>, _, _) = (Vec::new(), 0, 0);
        for at in numbers {
            let (t, place) = &run.frames[at];
            match PackedFrame::new(&scene, *t, frame(place, &names)?).map_err(|what| bad(at, what))? {
                Some(frame) if blown_up(&packed, &frame) => apart += 1,
                Some(frame) => packed.push(frame),
                None => dropped += 1,
            }
        }
        Ok(Frames { scene, packed, stride, dropped, apart, next: end })
    }

    /// Leaves out every second frame, but not the last.
    fn halve(&mut self) {
        let last = self.packed.len().saturating_sub(1);
        let mut at = 0..;
        self.packed.retain(|_| at.next().is_some_and(|i| i % 2 == 0 || i == last));
        self.stride *= 2;
    }

    fn view(&self, run: &Recording) -> Result<View, PlotError> {
        let Scene { nodes, triangles, edges, dots, groups, fields, .. } = &self.scene;
        Ok(View {
            name: run.name.clone(),
            method: run.word("/method").unwrap_or_default().to_owned(),
            counts: [*nodes, triangles.len() / 3, edges.len() / 2, dots.len()],
            groups: groups.clone(),
            fields: fields.clone(),
            topology: encoded(&self.scene.bytes()),
            part: self.part(run)?,
        })
    }

    fn part(&self, run: &Recording) -> Result<Part, PlotError> {
        let codes: Vec<u8> = self.packed.iter().flat_map(|frame| &frame.codes).copied().collect();
        Ok(Part {
            status: run.word("/status").unwrap_or_default().to_owned(),
            notes: self.notes(run),
            listed: run.frames.len(),
            next: self.next,
            frames: self.packed.iter().map(|frame| frame.head.clone()).collect(),
            data: encoded(&codes),
            curves: Curves::read(&run.folder, run.summary.as_ref())?,
        })
    }

    /// What a viewer must know: how the run ended, and what the page leaves out.
    fn notes(&self, run: &Recording) -> Vec<String> {
        let mut notes = Vec::new();
        let last = run.frames.last().map_or(0.0, |frame| frame.0);
        match run.word("/status") {
            None => {
                notes.push(format!("The run has no summary: it goes on, or was killed. Frames end at t = {last} s."))
            }
            Some("completed") => {}
            Some(status) => {
                let cause = run.word("/failure/cause").map(|cause| format!(": {cause}")).unwrap_or_default();
                notes.push(format!("The run ended at t = {last} s, {}{cause}.", status.replace('-', " ")));
            }
        }
        if self.stride > 1 {
            notes.push(format!(
                "One in {} of {} frames is shown, so that the page stays small.",
                self.stride,
                run.frames.len()
            ));
        }
        if self.dropped > 0 {
            let [are, they] = if self.dropped == 1 { ["frame is", "it has"] } else { ["frames are", "they have"] };
            notes.push(format!("{} {are} left out: {they} positions that are not finite.", self.dropped));
        }
        if self.apart > 0 {
            let are = if self.apart == 1 { "frame is" } else { "frames are" };
            notes.push(format!(
                "{} {are} left out, in which the scene is {BLOWN_UP} times as large as at first.",
                self.apart
            ));
        }
        if run.word("/status").is_some() && run.frames.len() < FEW {
            notes.push(format!("The run wrote {} frames; \"output.frames\" of its case gives more.", run.frames.len()));
        }
        notes
    }
}

/// A page with all frames of some runs beside each other, and its notes with the names of their runs. A page of a run
/// that goes on asks the server that it came from for more.
///
/// # Errors
/// Frames that cannot be read, or none that can be shown.
pub fn page(runs: &[Recording], live: bool) -> Result<(String, Vec<String>), StudyError> {
    let share = runs.len().max(1);
    let mut frames: Vec<Frames> =
        runs.iter().map(|run| Frames::read(run, 0, LARGEST_CODES / share, true)).collect::<Result<_, _>>()?;
    if let Some((run, _)) = runs.iter().zip(&frames).find(|(_, frames)| frames.packed.is_empty()) {
        let what = format!("no frame of {} can be shown: positions are not finite", run.folder.display());
        return Err(PlotError::NotThere(what).into());
    }
    loop {
        let mut views: Vec<View> =
            runs.iter().zip(&frames).map(|(run, frames)| frames.view(run)).collect::<Result<_, _>>()?;
        // Runs of one case are told apart by their folders.
        let same = |run: &Recording| runs.iter().filter(|other| other.name == run.name).count() > 1;
        for (view, run) in views.iter_mut().zip(runs).filter(|(_, run)| same(run)) {
            view.name = format!("{}, {}", run.name, run.folder.display());
        }
        let text = filled(&views, live)?;
        let longest = frames.iter_mut().max_by_key(|frames| frames.packed.len() * frames.scene.frame_bytes());
        match longest.filter(|longest| text.len() > LARGEST_PAGE && longest.packed.len() > 2) {
            Some(longest) => longest.halve(),
            None => {
                let note =
                    |view: &View| view.part.notes.iter().map(|n| format!("{}: {n}", view.name)).collect::<Vec<_>>();
                return Ok((text, views.iter().flat_map(note).collect()));
            }
        }
    }
}

/// What a page of a run that goes on asks for: its frames from a number on, as JSON.
///
/// # Errors
/// Frames that cannot be read.
pub fn part(run: &Recording, from: usize) -> Result<String, StudyError> {
    let part = Frames::read(run, from.min(run.frames.len()), LARGEST_PART, false)?.part(run)?;
    json(&part)
}

fn json(value: &impl Serialize) -> Result<String, StudyError> {
    // Within a script element no text may end it.
    let text = serde_json::to_string(value).map_err(|error| StudyError::Page(error.to_string()))?;
    Ok(text.replace('<', "\\u003c"))
}

fn filled(views: &[View], live: bool) -> Result<String, StudyError> {
    let title = views.iter().map(|view| view.name.as_str()).collect::<Vec<_>>().join(" and ");
    let safe = minijinja::Value::from_safe_string;
    let context = Context {
        version: env!("CARGO_PKG_VERSION"),
        title: &title,
        style: safe(STYLE.to_owned()),
        script: safe(SCRIPTS.join("\n")),
        runs: safe(json(&views)?),
        live,
    };
    render("view.html", PAGE, &context)
}
