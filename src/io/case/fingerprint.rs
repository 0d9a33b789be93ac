//! All parts of a case that determine the bits of its results. A checkpoint of another case is refused with the parts
//! that differ. The interval of checkpoints and, in fixed steps, the end are not included: a run may be resumed with
//! others. A default that follows from the end, such as the interval of rows, counts as equal for every end: the
//! resumed run keeps the one with which it began.
//!
//! Parts are compared as resolved, not as written: a mesh file with other nodes is another mesh, and a default value
//! that is given explicitly is the same case.

use std::collections::BTreeMap;
use std::fmt::{self, Display};
use std::io::BufWriter;

use serde::{Deserialize, Serialize};

use super::spec::{OutputSpec, Problem, RowEvery, SystemSpec};
use crate::checksum::{FilePrefix, RunningChecksum};
use crate::drive::clock::Step;
use crate::model::spec::NetworkSpec;

/// The part that says for which step masses are scaled.
const SCALED: &str = "time.mass_scaling.step";

/// The parts of a case.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fingerprint {
    parts: Vec<FingerprintPart>,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct FingerprintPart {
    /// key of the case file
    key: String,
    value: Value,
}

/// The value of a part: its text if that is short, else a checksum of its numbers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Value {
    Text(String),
    /// follows from the length of the run
    Derived(String),
    Digest {
        crc: u32,
        bytes: u64,
    },
}

/// The parts in which two cases differ; at least one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Differences(Vec<String>);

/// A part of the case that has no checksum.
#[derive(Debug, thiserror::Error)]
#[error("the case has no checksum for checkpoints, at {key}: {reason}")]
pub struct FingerprintError {
    key: &'static str,
    reason: String,
}

impl Fingerprint {
    /// The fingerprint of a case whose system has not been taken out.
    ///
    /// # Errors
    /// A number that cannot be serialised, which does not happen for those of a case.
    pub fn of(problem: &Problem) -> Result<Self, FingerprintError> {
        let mut made = Fingerprint::default();
        made.text("name", &problem.name)?;
        match &problem.system {
            SystemSpec::Pendulum(spec) => made.sum("system.pendulum", spec)?,
            SystemSpec::Network(spec) => made.network(spec)?,
        }
        let method = &problem.method;
        made.text("time.method", &(method.info.name, method.parameters().collect::<BTreeMap<_, _>>()))?;
        match problem.time.step {
            Step::Fixed(step) => made.text("time.step", &step)?,
            Step::Adaptive(tolerance) => {
                made.text("time.tolerance", &tolerance)?;
                // The tolerance is divided over the run.
                made.text("time.end", &problem.time.end)?;
            }
        }
        made.text("solver", &problem.solver)?;
        let OutputSpec {
            frames_every,
            fields,
            edges,
            crossings,
            probes,
            gauges,
            quantities,
            // They follow from the system.
            stages: _,
            history_every,
            history_derived,
            checkpoint_every: _,
            format,
        } = &problem.output;
        made.text("output.frames.every", frames_every)?;
        made.text("output.fields", fields)?;
        made.text("output.edges", edges)?;
        made.text("output.crossings", crossings)?;
        made.text("output.format", &format.file)?;
        made.text("output.compression", &format.compression)?;
        made.text("output.precision", &format.precision)?;
        match history_every {
            RowEvery::Steps(steps) => made.text("output.history.every", steps)?,
            RowEvery::Time(every) => made.text("output.history.every", &format!("{every:e} s"))?,
        }
        if *history_derived {
            made.last_follows();
        }
        for probe in probes {
            made.sum("output.probes", &(&probe.name, &probe.nodes))?;
        }
        for gauge in gauges {
            made.sum("output.gauges", gauge)?;
        }
        // They are measured from the start of a run on.
        for quantity in quantities {
            made.sum("study.quantities", &quantity.text)?;
        }
        Ok(made)
    }

    /// A checksum over all parts, such as `"5f3a…-1234"`: two cases have the same one with a probability of 2^-32.
    /// Parts that follow from the length of the run are left out.
    pub fn digest(&self) -> String {
        let mut sum = RunningChecksum::default();
        let mut add = |bytes: &[u8]| {
            // With its length, so that the parts are separated.
            sum.add(&(bytes.len() as u64).to_le_bytes());
            sum.add(bytes);
        };
        for FingerprintPart { key, value } in &self.parts {
            add(key.as_bytes());
            match value {
                Value::Text(text) => add(text.as_bytes()),
                Value::Derived(_) => add(&[]),
                Value::Digest { crc, bytes } => add(format!("{crc:08x}-{bytes}").as_bytes()),
            }
        }
        let FilePrefix { crc, bytes } = sum.mark();
        format!("{crc:08x}-{bytes}")
    }

    /// Adds the end of the runs, for a study: its runs cannot be continued to a later end.
    pub fn note_end(&mut self, end: f64) {
        self.parts.retain(|part| part.key != "time.end");
        self.parts.push(FingerprintPart { key: "time.end".to_owned(), value: Value::Text(format!("{end:e}")) });
    }

    fn network(&mut self, spec: &NetworkSpec) -> Result<(), FingerprintError> {
        // All fields by name, so that a new field is not forgotten.
        let NetworkSpec {
            mesh,
            mass,
            fixed,
            releases,
            events,
            motions,
            springs,
            membranes,
            bending,
            gravity,
            base_acceleration,
            air,
            surface_pressures,
            stream,
            canopies,
            line_drag,
            node_drag,
            gases,
            contacts,
            pressures,
            forces,
            rayleigh,
            mass_scaling,
            displacement,
            velocity,
        } = spec;
        self.sum("system.network.mesh", mesh)?;
        self.sum("system.network.mass", mass)?;
        self.sum("system.network.supports", fixed)?;
        if !releases.is_empty() {
            self.sum("system.network.supports", releases)?;
        }
        let events: Vec<_> = events.iter().filter(|event| event.acts()).collect();
        if !events.is_empty() {
            self.sum("system.network.when", &events)?;
        }
        self.sum("system.network.springs", springs)?;
        if !membranes.is_empty() {
            self.sum("system.network.membranes", membranes)?;
        }
        if !bending.is_empty() {
            self.sum("system.network.bending", bending)?;
        }
        if !motions.is_empty() {
            self.sum("system.network.supports", motions)?;
        }
        if base_acceleration.is_some() {
            self.sum("system.network.base_acceleration", base_acceleration)?;
        }
        self.text("system.network.gravity", gravity)?;
        self.sum("system.network.aero", air)?;
        if !surface_pressures.is_empty() {
            self.sum("system.network.aero", surface_pressures)?;
        }
        if stream.is_some() {
            self.sum("system.network.aero", &(stream, canopies, line_drag, node_drag))?;
        }
        if !contacts.is_empty() {
            self.sum("system.network.contact", contacts)?;
        }
        if !gases.is_empty() {
            self.sum("system.network.gas", gases)?;
        }
        self.sum("system.network.loads", &(pressures, forces))?;
        self.text("system.network.damping.rayleigh", rayleigh)?;
        if mass_scaling.is_some() {
            self.text(SCALED, mass_scaling)?;
        }
        self.sum("system.network.initial", &(displacement, velocity))
    }

    fn text(&mut self, key: &'static str, value: &impl Serialize) -> Result<(), FingerprintError> {
        let text = serde_json::to_string(value).map_err(|e| FingerprintError { key, reason: e.to_string() })?;
        self.parts.push(FingerprintPart { key: key.to_owned(), value: Value::Text(text) });
        Ok(())
    }

    /// Marks the last part as derived from the length of the run.
    fn last_follows(&mut self) {
        if let Some(FingerprintPart { value, .. }) = self.parts.last_mut()
            && let Value::Text(text) = value
        {
            *value = Value::Derived(std::mem::take(text));
        }
    }

    fn sum(&mut self, key: &'static str, value: &impl Serialize) -> Result<(), FingerprintError> {
        let sum = || {
            let sum = BufWriter::with_capacity(1 << 16, RunningChecksum::default());
            let sum = postcard::to_io(value, sum)?;
            sum.into_inner().map_err(|_| postcard::Error::SerializeBufferFull)
        };
        let sum = sum().map_err(|e| FingerprintError { key, reason: e.to_string() })?;
        let FilePrefix { crc, bytes } = sum.mark();
        self.parts.push(FingerprintPart { key: key.to_owned(), value: Value::Digest { crc, bytes } });
        Ok(())
    }

    /// Whether another case has the same scene over the same time, whatever its method, steps and output.
    pub fn same_scene(&self, other: &Fingerprint) -> bool {
        let scene = |of: &Fingerprint| -> Vec<FingerprintPart> {
            let others = ["time.end", SCALED];
            let part = |part: &&FingerprintPart| part.key.starts_with("system.") || others.contains(&part.key.as_str());
            of.parts.iter().filter(part).cloned().collect()
        };
        scene(self) == scene(other)
    }

    /// The differences of another case from this one; `None` if there are none.
    pub fn differences(&self, now: &Fingerprint) -> Option<Differences> {
        let mut found = Vec::new();
        let keys = self.parts.iter().chain(&now.parts).map(|part| part.key.as_str());
        for key in keys {
            let (before, after) = (self.at(key), now.at(key));
            let same =
                before.len() == after.len() && before.iter().zip(&after).all(|(before, after)| before.agrees(after));
            let words = if same { None } else { Some(describe(key, &before, &after)) };
            found.extend(words.filter(|words| !found.contains(words)));
        }
        (!found.is_empty()).then_some(Differences(found))
    }

    fn at(&self, key: &str) -> Vec<&Value> {
        self.parts.iter().filter(|part| part.key == key).map(|part| &part.value).collect()
    }
}

impl Value {
    fn agrees(&self, other: &Value) -> bool {
        match (self, other) {
            (Value::Derived(_), Value::Derived(_)) => true,
            (Value::Text(a) | Value::Derived(a), Value::Text(b) | Value::Derived(b)) => a == b,
            _ => self == other,
        }
    }
}

fn describe(key: &str, before: &[&Value], after: &[&Value]) -> String {
    match (before, after) {
        ([Value::Text(before) | Value::Derived(before)], [Value::Text(after) | Value::Derived(after)]) => {
            format!("{key} was {before} and is {after} now")
        }
        _ => format!("{key} is not what it was"),
    }
}

impl Display for Differences {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.join("; "))
    }
}
