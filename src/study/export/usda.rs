//! An animation as USD in text: cloth as a mesh, lines as curves of two points, with points over time.
//!
//! Source: Pixar, "UsdGeom" of the OpenUSD documentation: Mesh, BasisCurves, Points, and metersPerUnit.

use super::Animation;
use std::fmt::Write as _;

/// [1/s] Units of time of the file; a frame between two of them keeps its time.
const PER_SECOND: f64 = 24.0;
/// [m] Drawn width of lines and nodes
const WIDTH: f64 = 0.01;

/// The file.
pub(super) fn encode(animation: &Animation) -> String {
    let name = identifier(&animation.name);
    let end = animation.times.last().map_or(0.0, |t| t * PER_SECOND);
    let mut text = format!(
        "#usda 1.0\n(\n    defaultPrim = \"{name}\"\n    doc = \"A run of canopy-fem; metres and seconds.\"\n    \
         endTimeCode = {end}\n    framesPerSecond = {PER_SECOND}\n    metersPerUnit = 1\n    startTimeCode = {}\n    \
         timeCodesPerSecond = {PER_SECOND}\n    upAxis = \"Z\"\n)\n\ndef Xform \"{name}\"\n{{\n",
        animation.times.first().map_or(0.0, |t| t * PER_SECOND)
    );
    let Animation { triangles, lines, dots, .. } = animation;
    if !triangles.is_empty() {
        text.push_str("    def Mesh \"cloth\"\n    {\n        uniform bool doubleSided = 1\n");
        whole(&mut text, "int[] faceVertexCounts", triangles.iter().map(|_| 3));
        whole(&mut text, "int[] faceVertexIndices", triangles.as_flattened().iter().copied());
        text.push_str("        uniform token subdivisionScheme = \"none\"\n");
        points(&mut text, animation, None, [0.9, 0.45, 0.15]);
    }
    if !lines.is_empty() {
        text.push_str("    def BasisCurves \"lines\"\n    {\n        uniform token type = \"linear\"\n");
        whole(&mut text, "int[] curveVertexCounts", lines.iter().map(|_| 2));
        width(&mut text);
        points(&mut text, animation, Some(lines.as_flattened()), [0.1; 3]);
    }
    if !dots.is_empty() {
        text.push_str("    def Points \"nodes\"\n    {\n");
        width(&mut text);
        points(&mut text, animation, Some(dots), [0.1; 3]);
    }
    text.push_str("}\n");
    text
}

/// A name that USD takes: letters, digits and underscores, no digit first.
fn identifier(name: &str) -> String {
    let mut text: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if text.starts_with(|c: char| c.is_ascii_digit()) || text.is_empty() {
        text.insert(0, '_');
    }
    text
}

fn whole(text: &mut String, name: &str, numbers: impl Iterator<Item = u32>) {
    let numbers: Vec<String> = numbers.map(|number| number.to_string()).collect();
    let _ = writeln!(text, "        {name} = [{}]", numbers.join(", "));
}

fn width(text: &mut String) {
    let _ = writeln!(text, "        float[] widths = [{WIDTH}] (interpolation = \"constant\")");
}

/// The points of a shape over time, all nodes or some, with their bounds; then the shape ends.
fn points(text: &mut String, animation: &Animation, nodes: Option<&[u32]>, [red, green, blue]: [f64; 3]) {
    let _ = writeln!(text, "        color3f[] primvars:displayColor = [({red}, {green}, {blue})]");
    let (mut bounds, mut places) = (String::new(), String::new());
    for (t, frame) in animation.times.iter().zip(&animation.frames) {
        let chosen: Vec<[f32; 3]> = match nodes {
            None => frame.iter().map(|x| x.map(|x| x as f32)).collect(),
            Some(nodes) => nodes.iter().filter_map(|node| Some(frame.get(*node as usize)?.map(|x| x as f32))).collect(),
        };
        let bound = |start: f32, pick: fn(f32, f32) -> f32| {
            tuple(&chosen.iter().fold([start; 3], |a, b| std::array::from_fn(|axis| pick(a[axis], b[axis]))))
        };
        let code = t * PER_SECOND;
        let (low, high) = (bound(f32::INFINITY, f32::min), bound(f32::NEG_INFINITY, f32::max));
        let _ = writeln!(bounds, "            {code}: [{low}, {high}],");
        let all: Vec<String> = chosen.iter().map(tuple).collect();
        let _ = writeln!(places, "            {code}: [{}],", all.join(", "));
    }
    let _ = writeln!(text, "        float3[] extent.timeSamples = {{\n{bounds}        }}");
    let _ = writeln!(text, "        point3f[] points.timeSamples = {{\n{places}        }}\n    }}");
}

fn tuple([x, y, z]: &[f32; 3]) -> String {
    format!("({x}, {y}, {z})")
}
