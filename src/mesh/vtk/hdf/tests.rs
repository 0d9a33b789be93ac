//! What is written comes back, a file that is cut back has the bytes of one that was never longer, and a damaged file
//! is refused.

use super::super::read::{DataSet, named_array};
use super::super::write::{Array, Cells, FixedArrays, Snapshot, Values};
use super::super::{Compression, Precision, VtuFormat};
use super::region::word;
use super::{HdfFrames, HdfScene, HdfWriter};
use std::error::Error;
use std::fs;
use std::path::Path;

type Tested = Result<(), Box<dyn Error>>;

const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [1, 3, 2]];
const EDGES: [[u32; 2]; 3] = [[0, 1], [1, 2], [3, 4]];

/// The numbers of a frame.
struct Numbers {
    points: Vec<[f64; 3]>,
    tension: Vec<f64>,
    crossing: Vec<u8>,
}

fn numbers(step: usize) -> Numbers {
    let wave = |i: usize| (i as f64 + 0.37 * step as f64).sin();
    Numbers {
        points: (0..5).map(|i| [wave(i), wave(i + 7) * 1e3, -wave(i + 13)]).collect(),
        tension: (0..5).map(|i| wave(i + 20) * 1e-3).collect(),
        crossing: (0..5).map(|i| u8::from((i + step).is_multiple_of(3))).collect(),
    }
}

/// Makes a file go on to so many frames, after those that it has.
fn go_on(path: &Path, compression: Compression, from: u64, to: u64) -> Tested {
    let writer = go_on_and(path, compression, from, to, |writer, frame| Ok(writer.frame(frame)?))?;
    assert_eq!(writer.frames(), to);
    Ok(())
}

/// Opens a file after so many frames, and does something with each of the next ones.
fn go_on_and(
    path: &Path,
    compression: Compression,
    from: u64,
    to: u64,
    then: impl Fn(&mut HdfWriter, &Snapshot<'_>) -> Tested,
) -> Result<HdfWriter, Box<dyn Error>> {
    let cells = Cells { points: 5, triangles: &TRIANGLES, edges: &EDGES };
    let field = [("group cloth/2".to_owned(), vec![1, 2])];
    let kind = [0, 0, 1, 1, 2];
    let flags: [(&str, &[u8]); 1] = [("kind", &kind)];
    let fixed = FixedArrays {
        cell_numbers: Some(("group", &[1, 1, 2, 2, 0])),
        cell_flags: &flags,
        field: &field,
        ..FixedArrays::default()
    };
    let format = VtuFormat { compression, precision: Precision::F64, ..VtuFormat::default() };
    let write = |step: usize, then: &mut dyn FnMut(&Snapshot<'_>) -> Tested| {
        let Numbers { points, tension, crossing } = numbers(step);
        let speed = points.iter().map(|x| x.map(|x| 2.0 * x)).collect::<Vec<_>>();
        then(&Snapshot {
            time: Some(0.25 * step as f64),
            points: &points,
            point_data: &[Array { name: "velocity", values: Values::Vectors(&speed) }],
            cell_data: &[
                Array { name: "tension", values: Values::Scalars(&tension) },
                Array { name: "crossing", values: Values::Flags(&crossing) },
            ],
        })
    };
    let mut opened = None;
    write(0, &mut |frame| {
        let scene = HdfScene { cells: &cells, fixed: &fixed, format, frame };
        if from == 0 {
            fs::write(path, HdfWriter::empty(&scene)?)?;
        }
        let mut writer = HdfWriter::open(path, &scene, from)?;
        for step in from..to {
            write(step as usize, &mut |frame| then(&mut writer, frame))?;
        }
        opened = Some(writer);
        Ok(())
    })?;
    opened.ok_or_else(|| "no writer".into())
}

fn check(data: &DataSet, step: usize) -> Tested {
    let Numbers { points, tension, crossing } = numbers(step);
    let piece = data.pieces.first().ok_or("no piece")?;
    assert_eq!(piece.points, points);
    let cells: Vec<(u8, Vec<u64>)> = piece.cells.iter().map(|(kind, points)| (kind, points.to_vec())).collect();
    assert_eq!(cells[1], (5, vec![1, 3, 2]));
    assert_eq!(cells[4], (3, vec![3, 4]));
    assert_eq!(named_array(&piece.cell_data, "tension"), Some(tension));
    assert_eq!(named_array(&piece.cell_data, "crossing"), Some(crossing.iter().map(|flag| f64::from(*flag)).collect()));
    assert_eq!(named_array(&piece.cell_data, "kind"), Some(vec![0.0, 0.0, 1.0, 1.0, 2.0]));
    assert_eq!(named_array(&piece.point_data, "velocity").map(|v| v[4]), Some(2.0 * points[1][1]));
    assert_eq!(data.fields, [("group cloth/2".to_owned(), vec![1, 2])]);
    Ok(())
}

#[test]
fn frames_come_back() -> Tested {
    let folder = tempfile::tempdir()?;
    for compression in [Compression::None, Compression::Zlib] {
        let path = folder.path().join("run.vtkhdf");
        go_on(&path, compression, 0, 300)?;
        let mut frames = HdfFrames::of(fs::File::open(&path)?)?;
        assert_eq!(frames.times().len(), 300);
        for step in [0, 1, 15, 16, 63, 64, 255, 256, 299] {
            assert_eq!(frames.times()[step], 0.25 * step as f64);
            check(&frames.frame(step, &["velocity", "tension"])?, step)?;
        }
        assert!(frames.frame(300, &[]).is_err());
    }
    Ok(())
}

/// A file that was longer, is cut back and goes on has the bytes of one that was written without a break.
#[test]
fn a_file_that_is_cut_back_is_as_if_it_was_never_longer() -> Tested {
    let folder = tempfile::tempdir()?;
    let (whole, path) = (folder.path().join("whole.vtkhdf"), folder.path().join("run.vtkhdf"));
    for compression in [Compression::None, Compression::Zlib] {
        for (kept, end) in [(0, 1), (1, 20), (15, 18), (16, 17), (64, 70), (255, 258), (256, 300)] {
            go_on(&whole, compression, 0, end)?;
            for longer in [kept + 1, kept + 280] {
                go_on(&path, compression, 0, longer)?;
                go_on(&path, compression, kept, end)?;
                assert!(fs::read(&whole)? == fs::read(&path)?, "{longer} frames, cut back to {kept}, then {end}");
            }
        }
    }
    Ok(())
}

/// A kill before the last write of a frame leaves as many times as steps. VTK writes over its memory if there are more.
#[test]
fn a_frame_that_is_not_finished_does_not_lengthen_the_lists_of_steps() -> Tested {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("run.vtkhdf");
    for frames in [0, 1, 3, 64] {
        go_on(&path, Compression::Zlib, 0, frames)?;
        let writer = go_on_and(&path, Compression::Zlib, frames, frames + 1, |writer, frame| Ok(writer.add(frame)?))?;
        let bytes = fs::read(&path)?;
        let rows = writer.lists.stored.iter().map(|list| list.rows_at).chain(writer.lists.same_rows_at);
        for at in rows.chain([writer.lists.steps_at]) {
            assert_eq!(word(&bytes[at as usize..]), frames, "{frames} frames, at {at}");
        }
        assert_eq!(HdfFrames::of(fs::File::open(&path)?)?.times().len(), frames as usize);
    }
    Ok(())
}

/// Whatever byte is wrong or missing, reading ends, with an error or with numbers.
#[test]
fn a_damaged_file_is_read_to_an_end() -> Tested {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("run.vtkhdf");
    go_on(&path, Compression::Zlib, 0, 20)?;
    let bytes = fs::read(&path)?;
    let read = |bytes: &[u8]| -> Result<usize, Box<dyn Error>> {
        fs::write(&path, bytes)?;
        let Ok(mut frames) = HdfFrames::of(fs::File::open(&path)?) else { return Ok(0) };
        Ok((0..frames.times().len().min(20)).filter(|step| frames.frame(*step, &["tension"]).is_ok()).count())
    };
    assert_eq!(read(&bytes)?, 20);
    let mut refused = 0;
    for place in (0..bytes.len()).step_by(11) {
        for wrong in [0, 0xff, bytes[place] ^ 1] {
            let mut bytes = bytes.clone();
            bytes[place] = wrong;
            refused += usize::from(read(&bytes)? < 20);
        }
        refused += usize::from(read(&bytes[..place])? < 20);
    }
    assert!(refused > bytes.len() / 11, "{refused}");
    Ok(())
}
