//! Animations of a run, read back: shapes, times and cells are those of its frames.

use canopy_fem::mesh::read::read_mesh;
use serde_json::Value;

use crate::bench::Bench;

/// A sail with a line, in eleven frames.
fn bench() -> Bench {
    let bench = Bench::new();
    let ended = bench.solve(&["--set", "output.frames.every=0.05", "--end", "0.5", "--quiet"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    bench
}

fn export(bench: &Bench, arguments: &[&str]) -> String {
    let ended = bench.run(&[&["export"], arguments].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    ended.stdout.trim().to_owned()
}

/// A .glb file in its two parts.
struct Glb {
    json: Value,
    numbers: Vec<u8>,
}

impl Glb {
    fn read(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
        assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
        let text = word(12);
        assert_eq!((&bytes[16..20], &bytes[24 + text..28 + text]), (&b"JSON"[..], &b"BIN\0"[..]));
        assert_eq!(28 + text + word(20 + text), bytes.len());
        let json = serde_json::from_slice(&bytes[20..20 + text]).expect("JSON");
        Self { json, numbers: bytes[28 + text..].to_vec() }
    }

    /// The words of four bytes of an accessor.
    fn words(&self, accessor: &Value) -> Vec<[u8; 4]> {
        let accessor = &self.json["accessors"][accessor.as_u64().expect("a number") as usize];
        let view = &self.json["bufferViews"][accessor["bufferView"].as_u64().expect("a number") as usize];
        let [at, length] = ["byteOffset", "byteLength"].map(|key| view[key].as_u64().expect("a number") as usize);
        let words = self.numbers[at..at + length].as_chunks().0.to_vec();
        let per = if accessor["type"] == "VEC3" { 3 } else { 1 };
        assert_eq!(accessor["count"].as_u64().expect("a count") as usize * per, words.len());
        words
    }

    fn reals(&self, accessor: &Value) -> Vec<f32> {
        self.words(accessor).into_iter().map(f32::from_le_bytes).collect()
    }

    /// Positions with +Z up.
    fn places(&self, accessor: &Value) -> Vec<[f32; 3]> {
        self.reals(accessor).as_chunks().0.iter().map(|[x, y, z]: &[f32; 3]| [*x, -z, *y]).collect()
    }
}

fn near(found: &[[f32; 3]], expected: &[f64]) {
    assert_eq!(3 * found.len(), expected.len());
    for (x, expected) in found.as_flattened().iter().zip(expected) {
        assert!((f64::from(*x) - expected).abs() < 1e-6, "{x} for {expected}");
    }
}

#[test]
fn shapes_of_a_glb_are_the_frames() {
    let bench = bench();
    assert_eq!(export(&bench, &["out", "--to", "glb"]), "out/sail.glb");
    let bytes = std::fs::read(bench.path("out/sail.glb")).expect("a file");
    let glb = Glb::read(&bytes);
    let frames = bench.results().frames();
    assert_eq!(frames.len(), 11);
    let mesh = &glb.json["meshes"][0];
    let primitives = mesh["primitives"].as_array().expect("parts");
    let base = glb.places(&primitives[0]["attributes"]["POSITION"]);
    near(&base, &frames[0].1.floats("Points"));
    let targets = primitives[0]["targets"].as_array().expect("shapes");
    assert_eq!(targets.len(), 10);
    for (target, (_, frame)) in targets.iter().zip(&frames[1..]) {
        let moved = glb.places(&target["POSITION"]);
        let places: Vec<[f32; 3]> =
            base.iter().zip(&moved).map(|(x, u)| std::array::from_fn(|axis| x[axis] + u[axis])).collect();
        near(&places, &frame.floats("Points"));
    }
    // At the time of a frame its shape alone has a weight.
    let sampler = &glb.json["animations"][0]["samplers"][0];
    let (times, weights) = (glb.reals(&sampler["input"]), glb.reals(&sampler["output"]));
    let expected: Vec<f32> = frames.iter().map(|(t, _)| *t as f32).collect();
    assert_eq!(times, expected);
    for (at, row) in weights.chunks(10).enumerate() {
        assert!(row.iter().enumerate().all(|(shape, weight)| *weight == if shape + 1 == at { 1.0 } else { 0.0 }));
    }
    // Triangles, and the lines that are no sides of them.
    let kinds = frames[0].1.bytes("kind");
    let count = |kind: u8| kinds.iter().filter(|k| **k == kind).count();
    let corners: Vec<usize> = primitives.iter().map(|part| glb.words(&part["indices"]).len()).collect();
    let expected: Vec<usize> = [3 * count(0), 2 * count(2)].into_iter().filter(|count| *count > 0).collect();
    assert_eq!(corners, expected);
    assert!(glb.json["materials"].as_array().expect("materials").iter().all(|of| of["doubleSided"] == true));
    // As a mesh file it is the first frame.
    let read = read_mesh(&bench.path("out/sail.glb")).expect("a mesh").mesh;
    assert_eq!(read.triangles.len(), count(0));
    let mut found = read.nodes;
    let mut expected: Vec<[f64; 3]> = frames[0].1.floats("Points").as_chunks().0.to_vec();
    found.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    expected.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.as_flattened().iter().zip(expected.as_flattened()) {
        assert!((a - b).abs() < 1e-6, "{a} for {b}");
    }
}

#[test]
fn points_of_usd_are_the_frames() {
    let bench = bench();
    assert_eq!(export(&bench, &["out/sail.pvd", "--to", "usda", "-o", "sail.usda"]), "sail.usda");
    let text = std::fs::read_to_string(bench.path("sail.usda")).expect("a file");
    let frames = bench.results().frames();
    for line in ["#usda 1.0", "    metersPerUnit = 1", "    upAxis = \"Z\"", "    timeCodesPerSecond = 24"] {
        assert!(text.lines().any(|found| found == line), "{line}");
    }
    let cloth = text.split("def Mesh \"cloth\"").nth(1).expect("a mesh");
    let samples = cloth.split("points.timeSamples = {").nth(1).and_then(|rest| rest.split('}').next()).expect("points");
    let rows: Vec<&str> = samples.lines().filter(|line| line.contains('(')).collect();
    assert_eq!(rows.len(), frames.len());
    for (row, (t, frame)) in rows.iter().zip(&frames) {
        let (code, points) = row.split_once(':').expect("a time");
        let code: f64 = code.trim().parse().expect("a number");
        assert!((code - 24.0 * t).abs() < 1e-9);
        let numbers: Vec<f32> = points
            .split(|c: char| "[](), ".contains(c))
            .filter(|word| !word.is_empty())
            .map(|word| word.parse().expect("a number"))
            .collect();
        near(numbers.as_chunks().0, &frame.floats("Points"));
    }
}

/// Long runs are thinned, and it is said; other numbers of frames are refused.
#[test]
fn at_most_so_many_frames() {
    let bench = bench();
    let ended = bench.run(&["export", "out", "--to", "usda", "--frames", "4"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stderr.contains("4 of 11 frames are in it; --frames 11 takes all"), "{}", ended.stderr);
    let text = std::fs::read_to_string(bench.path("out/sail.usda")).expect("a file");
    assert!(text.contains("startTimeCode = 0\n") && text.contains("endTimeCode = 12\n"));
    assert_eq!(bench.run(&["export", "out", "--to", "glb", "--frames", "1"]).code, Some(2));
    assert_eq!(bench.run(&["export", "out"]).code, Some(2));
    let none = bench.run(&["export", "nowhere", "--to", "glb"]);
    assert!(none.code != Some(0) && none.stderr.contains("nowhere"), "{}", none.stderr);
}
