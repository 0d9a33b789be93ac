//! The numbers of the page on nets: those by hand follow from its formulas, and those computed from the shipped case.

use crate::pages::{ROOT, pages};
use canopy_fem::case::Case;
use canopy_fem::output::summary::EquilibriumReport;
use canopy_fem::simulation::{EarlierResults, StaticSettings, record_static};
use canopy_fem::vtk::read::{DataSet, FrameLines, LINE_ARRAYS, POINT_ARRAYS, frame_lines, frame_points, read};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// An equilibrium, and its frame.
struct Found {
    report: EquilibriumReport,
    lines: FrameLines,
    /// [m] `[n_nodes][3]`
    positions: Vec<[f64; 3]>,
}

fn frame_in(file: &Path) -> DataSet {
    let bytes = std::fs::read(file).expect("a frame");
    read(&bytes, &[POINT_ARRAYS, LINE_ARRAYS].concat()).expect("a data set")
}

fn find(case: &str, at: f64) -> Found {
    let case = Case::from_file(&Path::new(ROOT).join(case), &[]).expect("a case");
    let folder = tempfile::tempdir().expect("a folder");
    let how = StaticSettings {
        out: folder.path(),
        earlier: EarlierResults::Replace,
        threads: 1,
        at,
        load_steps: 1,
        modes: 0,
    };
    let found = record_static(&case, how, &AtomicBool::new(false)).expect("files");
    assert!(found.equilibrium.failure.is_none() && found.warnings.is_empty(), "{:?}", found.warnings);
    let frame = folder.path().join(format!("frames/{}_000000.vtu", case.problem().name));
    let frame = frame_in(&frame);
    let positions = frame_points(&frame).expect("points").positions;
    let report = found.summary.equilibrium.expect("a report");
    Found { report, lines: frame_lines(&frame).expect("lines"), positions }
}

impl Found {
    /// [N] Tensions of all edges.
    fn tensions(&self) -> &[f64] {
        self.lines.tensions.as_deref().expect("tensions")
    }

    /// [N] Tension between two nodes.
    fn tension(&self, ends: [u64; 2]) -> f64 {
        let edge = self.lines.ends.iter().position(|edge| *edge == ends).expect("an edge");
        self.tensions()[edge]
    }

    fn largest(&self, quantity: &str) -> f64 {
        self.report.largest.iter().find(|value| value.quantity == quantity).expect("a value").value
    }
}

#[test]
fn the_saddle_net_is_what_the_hand_says() {
    let (prestress, snow) = (find("assets/cases/saddle-net.json", 0.0), find("assets/cases/saddle-net.json", 1.0));
    // [N] and [m]: 20 kN/m times 2 m, EA, a, f and the snow per metre of cable on 5 % more than the plan
    let (h, ea, a, f) = (20e3 * 2.0, 22.5e6, 10.0, 2.0);
    let area = 420.4;
    let w = 750.0 * area / 400.0 * 2.0;
    let change = 0.5 * w * (2.0_f64 * a).powi(2) / (8.0 * f);
    let sag = (55..66).map(|node| prestress.positions[node][2] - snow.positions[node][2]).sum::<f64>() / 10.0;
    let rows = [
        ("largest tension", 1e-3 * h * 1.0_f64.hypot(0.36), 1e-3 * prestress.largest("tension")),
        ("sum of the snow", 1e-3 * 750.0 * area, 1e-3 * snow.report.reaction_sum[2]),
        ("carrying cable", 1e-3 * (h + change), 1e-3 * snow.tension([60, 61])),
        ("bracing cable", 1e-3 * (h - change), 1e-3 * snow.tension([60, 71])),
        ("mean sag", 1e3 * change * a * a / (2.0 * f * ea), 1e3 * sag),
    ];
    let pages = pages();
    let page = pages.iter().find(|page| page.name == "nets.md").expect("the page");
    let table = page.text.split("| quantity | by hand | computed |").nth(1).expect("the table");
    for (what, by_hand, computed) in rows {
        let row = table.lines().find(|line| line.contains(what)).expect(what);
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let told = |cell: &str| cell.split(' ').next().expect("a number").to_owned();
        assert_eq!([told(cells[2]), told(cells[3])], [format!("{by_hand:.1}"), format!("{computed:.1}")], "{what}");
        assert!((computed / by_hand - 1.0).abs() < 0.05, "{what}: {computed} for {by_hand}");
    }
}

/// The frame beside the case is what the form's case makes, and the net begins in its equilibrium.
#[test]
fn the_saddle_net_keeps_its_form() {
    let form = find("docs/guide/cases/saddle-form.json", 0.0);
    let shipped = frame_in(&Path::new(ROOT).join("assets/cases/meshes/saddle-form.vtu"));
    let shipped = (frame_lines(&shipped).expect("lines"), frame_points(&shipped).expect("points"));
    let far = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    let net = find("assets/cases/saddle-net.json", 0.0);
    let [lines, points] = [&form.lines, &net.lines].map(|lines| lines.tensions.as_deref().expect("tensions"));
    assert!(far(lines, shipped.0.tensions.as_deref().expect("tensions")) < 1e-9 * 42e3);
    assert!(far(lines, points) < 1e-9 * 42e3, "{}", far(lines, points));
    assert!(far(form.positions.as_flattened(), shipped.1.positions.as_flattened()) < 1e-12);
    assert!(far(form.positions.as_flattened(), net.positions.as_flattened()) < 1e-9);
    // On the hypar, z = f (x^2 - y^2)/a^2.
    let off = form.positions.iter().map(|[x, y, z]| (z - 2.0 * (x * x - y * y) / 100.0).abs());
    assert!(off.fold(0.0, f64::max) < 1e-12);
    assert!(net.largest("displacement") < 1e-9 && net.report.residual < 1e-6, "{:?}", net.report);
}
