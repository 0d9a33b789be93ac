//! Frames of a scene far from the origin: neighbours stay apart, whatever the digits of the fields.

use serde_json::json;

use super::program::program;
use crate::common::read_vtu::parse;

/// A rope in 20 segments of 0.05 m at 1000 km, with fields of seven digits, of which a coordinate there has steps of
/// 0.06 m.
#[test]
fn positions_keep_their_digits_far_from_the_origin() {
    let folder = tempfile::tempdir().expect("a folder");
    for compression in ["none", "zlib"] {
        let case = json!({"name": "rope", "system": {"network": {
            "mesh": {"chain": {"from": [1e6, 0, 0], "to": [1000001, 0, 0], "segments": 20}}, "mass": {"nodal": 0.01},
            "springs": [{"on": "all", "stiffness": 1e3}], "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "gravity": [0, 0, -9.81]}},
            "time": {"end": 0.1, "method": "newmark", "step": 1e-3},
            "output": {"precision": "f32", "compression": compression, "probes": [{"name": "all", "on": "all"}]}});
        let ended = program(folder.path(), &case, &["solve", "--force"]);
        assert_eq!((ended.status, ended.stderr.as_str()), (Some(0), ""));
        let out = folder.path().join("out/rope");
        let rows = std::fs::read_to_string(out.join("probes.csv")).expect("rows");
        let number = |cell: &str| cell.parse::<f64>().expect("a number");
        let last: Vec<Vec<&str>> = rows.lines().rev().take(21).map(|row| row.split(',').collect()).collect();
        let frame = parse(&std::fs::read(out.join("frames/rope_000001.vtu")).expect("a frame"));
        let points = frame.floats("Points");
        for row in &last {
            let node = number(row[2]) as usize;
            let probed = [number(row[3]), number(row[4]), number(row[5])];
            assert_eq!(points[3 * node..3 * node + 3], probed, "{compression}, node {node}");
        }
        assert_eq!(last.len(), 21);
        // The fields are as short as asked for.
        assert_eq!(frame.bytes("velocity").len(), 21 * 12);
    }
}
