//! The data of a page read back by the page's own description of it, and what they are against the frames.

use std::fs;
use std::io::Read;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

use super::{bench, page};
use crate::bench::Bench;

/// The runs of a page.
pub(super) fn runs(page: &str) -> Vec<Value> {
    let text = page.split("<script type=\"application/json\" id=\"runs\">").nth(1).expect("data");
    serde_json::from_str(text.split("</script>").next().expect("an end")).expect("JSON")
}

pub(super) fn frame_count(run: &Value) -> usize {
    run["part"]["frames"].as_array().expect("frames").len()
}

/// Changes a coordinate of a frame.
pub(super) fn spoil_point(frame: &Path, coordinate: f64) {
    let mut bytes = fs::read(frame).expect("a frame");
    let head = String::from_utf8_lossy(&bytes).into_owned();
    let tag = head.lines().find(|line| line.contains("Name=\"Points\"")).expect("points");
    let offset: usize =
        crate::common::read_vtu::attribute(tag, "offset").expect("an offset").parse().expect("a number");
    let mark = b"<AppendedData";
    let section = bytes.windows(mark.len()).position(|window| window == mark).expect("appended data");
    let begin = section + bytes[section..].iter().position(|byte| *byte == b'_').expect("a mark") + 1 + offset + 8;
    bytes[begin..begin + 8].copy_from_slice(&coordinate.to_le_bytes());
    fs::write(frame, bytes).expect("written");
}

fn inflated(text: &Value) -> Vec<u8> {
    let packed = STANDARD.decode(text.as_str().expect("text")).expect("base64");
    let mut bytes = Vec::new();
    flate2::read::ZlibDecoder::new(packed.as_slice()).read_to_end(&mut bytes).expect("zlib");
    bytes
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// All frames are there: positions to half a step, values to 0.8 % of their range in the frame.
#[test]
fn frames_come_back_to_quantisation() {
    let bench = bench();
    assert_eq!(bench.solve(&[]).code, Some(0));
    let run = runs(&page(&bench, &["out"])).remove(0);
    let counts: Vec<usize> = run["counts"].as_array().expect("four").iter().map(|n| number(n) as usize).collect();
    assert_eq!(counts, [6, 4, 9, 0]);
    let corners: Vec<u32> =
        inflated(&run["topology"]).as_chunks().0.iter().take(12 + 18).map(|word| u32::from_le_bytes(*word)).collect();
    assert_eq!(&corners[..6], [0, 1, 4, 0, 4, 3]);
    assert_eq!(&corners[12..16], [0, 1, 1, 2]);
    let codes = inflated(&run["part"]["data"]);
    let frames = bench.results().frames();
    assert_eq!(frame_count(&run), frames.len());
    let mut at = 0;
    for (head, (t, vtu)) in run["part"]["frames"].as_array().expect("frames").iter().zip(&frames) {
        assert_eq!(number(&head["t"]), *t);
        for (i, x) in vtu.floats("Points").iter().enumerate() {
            let code = u16::from_le_bytes([codes[at + 2 * i], codes[at + 2 * i + 1]]);
            let step = number(&head["step"][i % 3]);
            let error = number(&head["low"][i % 3]) + step * f64::from(code) - x;
            assert!(error.abs() <= 0.5 * step * (1.0 + 1e-6) && step < 1e-4, "{t}: {error}");
        }
        at += 36;
        for (field, range) in
            run["fields"].as_array().expect("fields").iter().zip(head["ranges"].as_array().expect("ranges"))
        {
            let name = field["name"].as_str().expect("a name");
            let values = match name {
                "speed" => {
                    vtu.floats("velocity").chunks(3).map(|v| v.iter().map(|c| c * c).sum::<f64>().sqrt()).collect()
                }
                "pressure" => vtu.floats(name)[..4].to_vec(),
                _ => vtu.floats(name),
            };
            let (low, high) = (number(&range[0]), number(&range[1]));
            for (value, code) in values.iter().zip(&codes[at..]) {
                let root = low.cbrt() + (high.cbrt() - low.cbrt()) * f64::from(*code) / 254.0;
                let error = root.powi(3) - value;
                assert!(error.abs() <= 0.008 * (high - low) + 1e-12, "{name} at {t}: {error}");
            }
            at += values.len();
        }
        at += at % 2;
    }
    assert_eq!(at, codes.len());
    let names: Vec<&str> =
        run["fields"].as_array().expect("fields").iter().filter_map(|f| f["name"].as_str()).collect();
    assert_eq!(names, ["pressure", "tension", "speed", "strain"]);
    let units: Vec<&str> =
        run["fields"].as_array().expect("fields").iter().filter_map(|f| f["unit"].as_str()).collect();
    assert_eq!(units, ["Pa", "N", "m/s", "-"]);
    let groups: Vec<&str> =
        run["groups"].as_array().expect("groups").iter().filter_map(|g| g["name"].as_str()).collect();
    assert_eq!(groups, ["hem <&>", "sheet", "clew"]);
}

/// All gauges are there, with the peaks of the summary.
#[test]
fn gauges_come_back() {
    let bench = bench();
    assert_eq!(bench.solve(&[]).code, Some(0));
    let curves = runs(&page(&bench, &["out"]))[0]["part"]["curves"].clone();
    let numbers = inflated(&curves["data"]);
    let numbers: Vec<f32> = numbers.as_chunks().0.iter().map(|word| f32::from_le_bytes(*word)).collect();
    let table = bench.results().table("gauges.csv");
    let peaks = bench.results().summary()["peaks"].as_array().expect("peaks").clone();
    let mut at = 0;
    for (head, peak) in curves["heads"].as_array().expect("heads").iter().zip(&peaks) {
        let quantity = peak["quantity"].as_str().expect("a quantity");
        assert_eq!(head["name"], peak["name"]);
        assert_eq!(head["quantity"], quantity.replace('_', " "));
        assert_eq!(head["unit"], peak["unit"]);
        let label = head["label"].as_str().expect("words");
        assert!(
            label.ends_with(&format!("({})", peak["name"].as_str().expect("a name"))) && !label.contains('_'),
            "{label}"
        );
        assert_eq!((&head["peak"][1], &head["peak"][0]), (&peak["value"], &peak["t"]));
        let rows: Vec<_> =
            table.rows.iter().filter(|row| row[2] == quantity && peak["name"] == row[1].as_str()).collect();
        assert_eq!(head["points"], rows.len());
        for row in rows {
            for cell in [&row[0], &row[3]] {
                let value: f64 = cell.parse().expect("a number");
                assert!((f64::from(numbers[at]) - value).abs() <= 1e-6 * value.abs(), "{row:?}");
                at += 1;
            }
        }
    }
    let last: Vec<&str> =
        curves["heads"].as_array().expect("heads").iter().filter_map(|h| h["quantity"].as_str()).collect();
    assert_eq!(&last[last.len() - 3..], ["largest speed", "kinetic energy", "elastic energy"]);
}

/// A scene of 10,000 nodes: twenty frames take less than a fifth of what a hundred may, and a page stays below 20 MB by
/// leaving out frames, which it says.
#[test]
fn large_scenes() {
    let case = r#"{"name": "sheet", "system": {"network": {
      "mesh": {"rectangle": {"width": 1, "height": 1, "columns": 99, "rows": 99}}, "mass": {"areal_density": 0.1},
      "springs": [{"on": "all", "stiffness": 100}], "gravity": [0, 0, -9.81], "supports": [{"on": "boundary", "fix": "xyz"}]}},
      "time": {"end": 0.02, "method": "velocity-verlet", "step": 1e-4},
      "output": {"frames": {"every": 1e-3}, "fields": ["tension"], "crossings": "none"}}"#;
    let bench = Bench::new();
    fs::write(bench.path("sheet.json"), case).expect("written");
    let ended = bench.run(&["solve", "sheet.json", "--out", "out", "--quiet"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let text = page(&bench, &["out"]);
    let run = runs(&text).remove(0);
    assert_eq!((&run["counts"][0], frame_count(&run)), (&Value::from(10_000), 21));
    assert!(text.len() < 4_000_000, "{} bytes", text.len());
    // The same frames many times over, as a long run has them.
    let list = fs::read_to_string(bench.path("out/sheet.pvd")).expect("a list");
    let lines: Vec<&str> = list.lines().filter(|line| line.starts_with("<DataSet")).collect();
    let many: String = (0..800)
        .map(|i| {
            let file = lines[i % 20].split("file=").nth(1).expect("a file");
            format!("<DataSet timestep=\"{}\" group=\"\" part=\"0\" file={file}\n", i as f64 * 1e-3)
        })
        .collect();
    fs::write(bench.path("out/sheet.pvd"), list.replace(&lines.join("\n"), &many)).expect("written");
    let ended = bench.run(&["view", "out"]);
    let text = fs::read_to_string(bench.path("out/view.html")).expect("a page");
    let run = runs(&text).remove(0);
    let frames = run["part"]["frames"].as_array().expect("frames");
    assert!(text.len() <= 20_000_000 && frames.len() < 800, "{} bytes, {} frames", text.len(), frames.len());
    assert_eq!(frames[frames.len() - 1]["t"], 0.799);
    assert!(ended.stderr.contains("of 800 frames is shown, so that the page stays small"), "{}", ended.stderr);
}

/// The peaks of the stages of a run are on its curves, but for the one that is the peak of the whole run.
#[test]
fn peaks_of_stages_are_marked() {
    let bench = bench();
    let gauge = r#"output.gauges=[{"name": "pole", "on": {"ids": [0, 3]}, "of": "reaction"}]"#;
    let ended = bench.solve(&["--set", gauge, "--set", "system.network.supports.0.until=0.6"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let (run, summary) = (runs(&page(&bench, &["out"])).remove(0), bench.results().summary());
    let heads = run["part"]["curves"]["heads"].as_array().expect("curves").clone();
    let head = heads.iter().find(|head| head["quantity"] == "reaction total").expect("a curve");
    let peak = |stage: &Value| {
        let all = stage["peaks"].as_array().expect("peaks");
        let own = all.iter().find(|peak| peak["quantity"] == "reaction_total").expect("a peak");
        [number(&own["t"]), number(&own["value"])]
    };
    let stages = summary["stages"].as_array().expect("stages");
    assert_eq!([&stages[0]["name"], &stages[1]["name"]], ["start", "release 1"]);
    // Nothing reacts after the release: the peak of the run is that of the first stage, and the other one is 0.
    assert_eq!(head["peak"], serde_json::json!(peak(&stages[0])));
    assert_eq!(peak(&stages[1])[1], 0.0);
    assert_eq!(head["stages"], serde_json::json!([]));

    let ended = bench.solve(&["--force", "--set", gauge, "--set", "system.network.springs.0.cut=0.6"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let (run, summary) = (runs(&page(&bench, &["out"])).remove(0), bench.results().summary());
    let heads = run["part"]["curves"]["heads"].as_array().expect("curves").clone();
    let head = heads.iter().find(|head| head["quantity"] == "reaction total").expect("a curve");
    let both: Vec<[f64; 2]> = summary["stages"].as_array().expect("stages").iter().map(peak).collect();
    let smaller = both.iter().position(|peak| head["peak"] != serde_json::json!(peak)).expect("a smaller one");
    assert_eq!(head["stages"][0]["at"], serde_json::json!(both[smaller]));
    assert_eq!(head["stages"].as_array().expect("a list").len(), 1);
}
