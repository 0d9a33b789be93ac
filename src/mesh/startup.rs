//! The time before the first step, by phases.
//!
//! Phases belong to many folders, whose code should not depend on clocks. So each phase is timed where it is called,
//! and recorded for the thread that prepares a run. Without a [`StartupTimer`] nothing is measured. The times are only
//! reported.

use std::cell::RefCell;
use std::fmt::Write as _;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::process::{self, Cost, Stopwatch};

/// A phase before the first step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// reading the case file and checking its sections
    Parse,
    /// generating or reading the mesh
    Mesh,
    /// adjacency, boundary loops, lengths and areas
    Topology,
    /// renumbering the nodes, and how far the scene may reach
    Numbering,
    /// force terms and masses in the new numbering
    Scene,
    /// the largest stable step and the warnings
    CriticalStep,
    /// the folder and the files of the results
    Files,
    /// the first pass over the forces
    Forces,
    /// pattern of the tangent matrix and slots of the elements
    Pattern,
    /// fill-reducing ordering
    Ordering,
    /// symbolic factorisation
    Symbolic,
    /// the first factorisation, which is part of the first step
    Factorization,
}

/// [s] Processor time by phase (wall time if the system does not report it), without the phases inside it; 0 for a
/// phase that did not take place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Startup {
    /// [s] wall time up to the first step
    pub wall_seconds: f64,
    /// [s] processor time up to the first step: all phases but the first factorisation, and the rest
    pub cpu_seconds: f64,
    /// [s] reading and checking the case without its mesh
    pub parse: f64,
    /// [s] generating or reading the mesh
    pub mesh: f64,
    /// [s] adjacency, boundary loops, lengths and areas
    pub topology: f64,
    /// [s] renumbering the nodes, and how far the scene may reach
    pub numbering: f64,
    /// [s] force terms and masses
    pub scene: f64,
    /// [s] the largest stable step at the start
    pub critical_step: f64,
    /// [s] folder and files of the results
    pub files: f64,
    /// [s] the first pass over the forces
    pub forces: f64,
    /// [s] pattern of the tangent matrix
    pub pattern: f64,
    /// [s] fill-reducing ordering
    pub ordering: f64,
    /// [s] symbolic factorisation
    pub symbolic: f64,
    /// [s] the first factorisation; it belongs to the first step, not to the sums above
    pub factorization: f64,
}

impl Phase {
    fn name(self) -> &'static str {
        match self {
            Phase::Parse => "case read",
            Phase::Mesh => "mesh made",
            Phase::Topology => "topology found",
            Phase::Numbering => "nodes numbered",
            Phase::Scene => "scene built",
            Phase::CriticalStep => "critical step searched",
            Phase::Files => "files opened",
            Phase::Forces => "first force pass",
            Phase::Pattern => "matrix pattern found",
            Phase::Ordering => "matrix ordered",
            Phase::Symbolic => "symbolic factorisation",
            Phase::Factorization => "factorisation",
        }
    }

    /// Factorisations are part of steps, so there may be many; searches for critical steps make many small ones.
    fn level(self) -> log::Level {
        if matches!(self, Phase::Symbolic | Phase::Factorization) { log::Level::Debug } else { log::Level::Info }
    }
}

impl Startup {
    fn of(&mut self, phase: Phase) -> &mut f64 {
        match phase {
            Phase::Parse => &mut self.parse,
            Phase::Mesh => &mut self.mesh,
            Phase::Topology => &mut self.topology,
            Phase::Numbering => &mut self.numbering,
            Phase::Scene => &mut self.scene,
            Phase::CriticalStep => &mut self.critical_step,
            Phase::Files => &mut self.files,
            Phase::Forces => &mut self.forces,
            Phase::Pattern => &mut self.pattern,
            Phase::Ordering => &mut self.ordering,
            Phase::Symbolic => &mut self.symbolic,
            Phase::Factorization => &mut self.factorization,
        }
    }

    /// The phases of `cpu_seconds` by name, in the order they take place.
    pub fn phases(&self) -> [(&'static str, f64); 11] {
        [
            ("parse", self.parse),
            ("mesh", self.mesh),
            ("topology", self.topology),
            ("numbering", self.numbering),
            ("scene", self.scene),
            ("critical step", self.critical_step),
            ("files", self.files),
            ("forces", self.forces),
            ("pattern", self.pattern),
            ("ordering", self.ordering),
            ("symbolic", self.symbolic),
        ]
    }

    /// A line of text; small phases are summed as `other`.
    ///
    /// ```
    /// use canopy_fem_mesh::startup::Startup;
    /// let startup = Startup { wall_seconds: 4.5, cpu_seconds: 4.0, mesh: 2.5, symbolic: 1.25, parse: 0.001, ..Startup::default() };
    /// assert_eq!(startup.text(), "4.00 s CPU, 4.50 s wall: mesh 2.50, symbolic 1.25, other 0.25");
    /// ```
    pub fn text(&self) -> String {
        let mut text = format!("{:.2} s CPU, {:.2} s wall", self.cpu_seconds, self.wall_seconds);
        let (mut rest, mut mark) = (self.cpu_seconds, ':');
        let mut tell = |name: &str, seconds: f64| {
            // Writing to a String cannot fail.
            let _ = write!(text, "{mark} {name} {seconds:.2}");
            mark = ',';
        };
        for (name, seconds) in self.phases() {
            if seconds > 0.01 * self.cpu_seconds {
                tell(name, seconds);
                rest -= seconds;
            }
        }
        if rest > 0.005 {
            tell("other", rest);
        }
        text
    }
}

/// A time on both clocks.
#[derive(Clone, Copy, Debug)]
struct Timestamps {
    wall: Instant,
    cpu: Option<f64>,
}

impl Timestamps {
    fn now() -> Self {
        Timestamps { wall: Instant::now(), cpu: process::cpu_seconds() }
    }

    /// [s] wall and processor time since then
    fn elapsed(self) -> (f64, f64) {
        let wall = self.wall.elapsed().as_secs_f64();
        let cpu = self.cpu.and_then(|then| Some(process::cpu_seconds()? - then));
        (wall, cpu.unwrap_or(wall))
    }
}

/// The measurements of a thread.
#[derive(Clone, Copy, Debug)]
struct PhaseTimes {
    began: Timestamps,
    found: Startup,
    /// [s] time in phases inside the current one
    inside: f64,
    /// whether the current phase includes all phases inside it
    whole: bool,
}

thread_local! {
    static BOOK: RefCell<Option<PhaseTimes>> = const { RefCell::new(None) };
}

/// Runs `work` and adds its time to the timer of this thread, if there is one. Of factorisations only the first counts;
/// matrices of the search for the largest stable step belong to that phase. The log gets every phase.
pub fn timed<T>(phase: Phase, work: impl FnOnce() -> T) -> T {
    let began = log::log_enabled!(phase.level()).then(Instant::now);
    let done = counted(phase, work);
    if let Some(began) = began {
        log::log!(phase.level(), "{} in {:.3} ms", phase.name(), 1e3 * began.elapsed().as_secs_f64());
    }
    done
}

fn counted<T>(phase: Phase, work: impl FnOnce() -> T) -> T {
    let outside = BOOK.with_borrow_mut(|book| {
        let first = |b: &PhaseTimes| phase != Phase::Factorization || b.found.factorization == 0.0;
        let book = book.as_mut().filter(|b| !b.whole && first(b))?;
        book.whole = phase == Phase::CriticalStep;
        Some(std::mem::take(&mut book.inside))
    });
    let Some(outside) = outside else { return work() };
    let began = Timestamps::now();
    let done = work();
    let (_, seconds) = began.elapsed();
    BOOK.with_borrow_mut(|book| {
        if let Some(book) = book {
            *book.found.of(phase) += (seconds - book.inside).max(0.0);
            book.inside = outside + seconds;
            book.whole = false;
        }
    });
    done
}

/// The timer of this thread while it prepares a run; removed when the one that started it is dropped.
#[derive(Debug)]
pub struct StartupTimer {
    /// whether this one started it
    owner: bool,
}

impl StartupTimer {
    /// Starts a timer, or takes part in one that this thread has already.
    pub fn open() -> Self {
        match BOOK.with_borrow(Option::is_some) {
            true => StartupTimer { owner: false },
            false => Self::begun(Timestamps::now()),
        }
    }

    /// The same in a process that makes one run: all processor time that it has used belongs to the run.
    pub fn of_process() -> Self {
        let Timestamps { wall, cpu } = Timestamps::now();
        Self::begun(Timestamps { wall, cpu: cpu.map(|_| 0.0) })
    }

    fn begun(began: Timestamps) -> Self {
        BOOK.set(Some(PhaseTimes { began, found: Startup::default(), inside: 0.0, whole: false }));
        StartupTimer { owner: true }
    }

    /// Does work that is not part of the run: neither its phases nor its time count.
    pub fn without<T>(&self, work: impl FnOnce() -> T) -> T {
        let book = BOOK.take();
        let began = Timestamps::now();
        let done = work();
        let (wall, cpu) = began.elapsed();
        BOOK.set(book.map(|mut book| {
            book.began.wall += Duration::from_secs_f64(wall);
            book.began.cpu = book.began.cpu.map(|then| then + cpu);
            book
        }));
        done
    }

    /// The measurements so far.
    pub fn read(&self) -> Startup {
        BOOK.with_borrow(|book| book.map(|book| book.found)).unwrap_or_default()
    }
}

impl Drop for StartupTimer {
    fn drop(&mut self) {
        if self.owner {
            BOOK.set(None);
        }
    }
}

/// Measures the cost of a run from where the timer of this thread started, or from now; `before` is that of its earlier
/// parts.
pub fn stopwatch(before: Cost) -> Stopwatch {
    BOOK.with_borrow(|book| match book {
        Some(PhaseTimes { began: Timestamps { wall, cpu }, .. }) => Stopwatch::since(before, *wall, *cpu),
        None => Stopwatch::start(before),
    })
}

/// Ends the timer when a run is ready: returns the times with their sums, if this thread has a timer.
pub fn ready() -> Option<Startup> {
    BOOK.with_borrow_mut(|book| {
        let book = book.as_mut()?;
        (book.found.wall_seconds, book.found.cpu_seconds) = book.began.elapsed();
        Some(book.found)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A phase inside another counts once, the first factorisation only, and nothing without a timer.
    #[test]
    fn phases_are_counted_once() {
        // Other tests of this process only add to its time.
        let work = || {
            let began = Timestamps::now();
            while began.elapsed().1 < 0.02 {}
        };
        timed(Phase::Mesh, work);
        let account = StartupTimer::open();
        assert_eq!(account.read(), Startup::default());
        drop(StartupTimer::open());
        timed(Phase::Parse, || {
            timed(Phase::Mesh, work);
            timed(Phase::Mesh, work);
        });
        let first = account.read();
        assert!(first.mesh >= 0.04 && first.parse < first.mesh, "{first:?}");
        timed(Phase::CriticalStep, || timed(Phase::Pattern, work));
        let searched = account.read();
        assert!(searched.critical_step >= 0.02 && searched.pattern == 0.0, "{searched:?}");
        timed(Phase::Factorization, work);
        let once = account.read().factorization;
        timed(Phase::Factorization, work);
        assert!(once >= 0.02 && account.read().factorization == once);
        let ready = ready().expect("an account");
        let sum: f64 = ready.phases().iter().map(|(_, seconds)| seconds).sum();
        assert!(ready.cpu_seconds >= 0.999 * (sum + once) && ready.wall_seconds > 0.0, "{ready:?}");
        drop(account);
        assert_eq!(super::ready(), None);
    }
}
