//! An animation as glTF 2.0 in one binary file: a mesh whose shapes (morph targets) are the frames, and an animation of
//! their weights. Between two frames nodes move along straight lines.
//!
//! Source: Khronos, "glTF 2.0 Specification", sections 3.7.2.2 (morph targets), 3.11 (animations) and 4.4 (.glb).

use super::Animation;
use serde_json::{Value, json};

/// Numbers of the specification: types of numbers, what a view is for, and how corners are joined.
const FLOAT: u32 = 5126;
const UNSIGNED: u32 = 5125;
const VERTICES: u32 = 34962;
const CORNERS: u32 = 34963;
const POINTS: u32 = 0;
const LINES: u32 = 1;
const TRIANGLES: u32 = 4;

/// The arrays of a file, and what it says of them.
#[derive(Default)]
struct Arrays {
    views: Vec<Value>,
    accessors: Vec<Value>,
    bytes: Vec<u8>,
}

impl Arrays {
    /// Adds an array; its number.
    fn add(&mut self, bytes: Vec<u8>, target: Option<u32>, mut accessor: Value) -> usize {
        let mut view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        target.into_iter().for_each(|target| view["target"] = target.into());
        accessor["bufferView"] = self.views.len().into();
        self.views.push(view);
        self.bytes.extend(bytes);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds vectors with their bounds.
    fn vectors(&mut self, vectors: &[[f32; 3]]) -> usize {
        let first = vectors.first().copied().unwrap_or_default();
        let bound = |pick: fn(f32, f32) -> f32| {
            vectors.iter().fold(first, |a, b| std::array::from_fn(|axis| pick(a[axis], b[axis])))
        };
        let (min, max) = (bound(f32::min), bound(f32::max));
        let about = json!({
            "componentType": FLOAT, "type": "VEC3", "count": vectors.len(), "min": min, "max": max
        });
        self.add(vectors.iter().flatten().flat_map(|x| x.to_le_bytes()).collect(), Some(VERTICES), about)
    }

    fn numbers(&mut self, numbers: &[f32], bounds: Option<[f32; 2]>) -> usize {
        let mut about = json!({"componentType": FLOAT, "type": "SCALAR", "count": numbers.len()});
        if let Some([min, max]) = bounds {
            (about["min"], about["max"]) = (json!([min]), json!([max]));
        }
        self.add(numbers.iter().flat_map(|x| x.to_le_bytes()).collect(), None, about)
    }

    fn corners(&mut self, corners: &[u32]) -> usize {
        let about = json!({"componentType": UNSIGNED, "type": "SCALAR", "count": corners.len()});
        self.add(corners.iter().flat_map(|node| node.to_le_bytes()).collect(), Some(CORNERS), about)
    }
}

/// A place with +Y up, as the format asks for, in single precision.
fn upright([x, y, z]: [f64; 3]) -> [f32; 3] {
    [x as f32, z as f32, -y as f32]
}

/// The file.
///
/// # Errors
/// An animation of more than 4 GiB.
pub(super) fn encode(animation: &Animation) -> Result<Vec<u8>, String> {
    let mut arrays = Arrays::default();
    let Some((first, later)) = animation.frames.split_first() else { return Err("has no frames".to_owned()) };
    let base: Vec<[f32; 3]> = first.iter().copied().map(upright).collect();
    let positions = arrays.vectors(&base);
    let mut targets = Vec::new();
    for frame in later {
        let moved = frame.iter().zip(first).map(|(x, x0)| upright(std::array::from_fn(|axis| x[axis] - x0[axis])));
        targets.push(json!({"POSITION": arrays.vectors(&moved.collect::<Vec<_>>())}));
    }
    let parts = [
        (TRIANGLES, "cloth", animation.triangles.as_flattened()),
        (LINES, "lines", animation.lines.as_flattened()),
        (POINTS, "nodes", &animation.dots),
    ];
    let (mut primitives, mut materials) = (Vec::new(), Vec::new());
    for (mode, name, corners) in parts.into_iter().filter(|(.., corners)| !corners.is_empty()) {
        let mut primitive = json!({
            "attributes": {"POSITION": positions}, "indices": arrays.corners(corners), "mode": mode,
            "material": materials.len()
        });
        if !targets.is_empty() {
            primitive["targets"] = json!(targets);
        }
        primitives.push(primitive);
        let colour = if mode == TRIANGLES { [0.9, 0.45, 0.15, 1.0] } else { [0.1, 0.1, 0.1, 1.0] };
        materials.push(json!({
            "name": name, "doubleSided": true,
            "pbrMetallicRoughness": {"baseColorFactor": colour, "metallicFactor": 0.0, "roughnessFactor": 0.8}
        }));
    }
    let names: Vec<String> = animation.times.iter().skip(1).map(|t| format!("t = {t} s")).collect();
    let mut mesh = json!({"name": animation.name, "primitives": primitives});
    let mut file = json!({
        "asset": {"version": "2.0", "generator": "canopy-fem"},
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"name": animation.name, "mesh": 0}],
        "materials": materials
    });
    if !targets.is_empty() {
        mesh["weights"] = json!(vec![0.0; targets.len()]);
        mesh["extras"] = json!({"targetNames": names});
        file["animations"] = json!([weights(animation, &mut arrays)]);
    }
    file["meshes"] = json!([mesh]);
    file["accessors"] = arrays.accessors.into();
    file["bufferViews"] = arrays.views.into();
    file["buffers"] = json!([{"byteLength": arrays.bytes.len()}]);
    pack(file.to_string().into_bytes(), arrays.bytes)
}

/// The animation: at the time of a frame its shape has the weight 1, and all others 0.
fn weights(animation: &Animation, arrays: &mut Arrays) -> Value {
    let times: Vec<f32> = animation.times.iter().map(|t| *t as f32).collect();
    let bounds = times.first().zip(times.last()).map(|(first, last)| [*first, *last]);
    let input = arrays.numbers(&times, bounds);
    let targets = times.len() - 1;
    let all: Vec<f32> =
        (0..times.len()).flat_map(|at| (1..=targets).map(move |shape| if at == shape { 1.0 } else { 0.0 })).collect();
    let output = arrays.numbers(&all, None);
    json!({
        "name": "motion",
        "samplers": [{"input": input, "output": output, "interpolation": "LINEAR"}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}]
    })
}

/// The two chunks of a .glb: text padded with blanks, numbers with zeros.
fn pack(mut text: Vec<u8>, mut numbers: Vec<u8>) -> Result<Vec<u8>, String> {
    text.resize(text.len().next_multiple_of(4), b' ');
    numbers.resize(numbers.len().next_multiple_of(4), 0);
    let length = |n: usize| u32::try_from(n).map_err(|_| "makes more than the 4 GiB of a .glb; give fewer --frames");
    let mut file = b"glTF".to_vec();
    file.extend(2_u32.to_le_bytes());
    file.extend(length(12 + 8 + text.len() + 8 + numbers.len())?.to_le_bytes());
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", numbers)] {
        file.extend(length(chunk.len())?.to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    Ok(file)
}
