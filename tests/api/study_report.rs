//! The report of a tradeoff study, from studies made by hand: every run is a row and a mark, whatever became of it, and
//! every name comes through as it was.

mod sample;
mod svg;

use std::path::PathBuf;

use canopy_fem::study::Study;
use canopy_fem::study::options::{StudyOptions, TypedOptions};
use canopy_fem::study::recommendations::Recommendations;
use canopy_fem::study::report::{Machine, Rerun, write};
use canopy_fem::study::row::{Row, RowStatus, StepSetting, label};
use sample::{Law, laws, method, some_laws, study, with_ends};
use svg::{Element, axis, elements, frames, marks};
use tempfile::TempDir;

const HEADER: &str = "method,step,tolerance,status,error,error_max,energy_error,cpu_seconds,force_evaluations,tangent_assemblies,factorizations,linear_solves,pareto";
const FAILURES: [RowStatus; 4] = [RowStatus::Diverged, RowStatus::NotConverged, RowStatus::Refused, RowStatus::NotRun];

/// A folder with the report of a study.
struct Report {
    folder: TempDir,
    files: Vec<PathBuf>,
}

fn how() -> Rerun {
    let machine = Machine {
        processor: Some("An <Old> Processor & Co".to_owned()),
        date: Some("2026-11-21".to_owned()),
        ..Machine::default()
    };
    Rerun { command: "canopy-fem tradeoff a.json --methods '{\"hht\": {\"alpha\": -0.2}}'".to_owned(), machine }
}

impl Report {
    fn of(study: &Study) -> Self {
        let folder = TempDir::new().expect("a folder");
        let files = Self::into(&folder, study, &how());
        Report { folder, files }
    }

    fn into(folder: &TempDir, study: &Study, how: &Rerun) -> Vec<PathBuf> {
        let answers = Recommendations::of(&study.plan, &study.rows).expect("answers");
        write(folder.path(), study, &answers, how).expect("a report")
    }

    fn text(&self, file: &str) -> String {
        std::fs::read_to_string(self.folder.path().join(file)).expect("written")
    }

    fn picture(&self, file: &str) -> Vec<Element> {
        let svg = self.text(file);
        assert!(!svg.contains("NaN") && !svg.contains("inf\"") && !svg.contains("inf,"), "a number that is none");
        elements(&svg)
    }
}

/// The table as other programs read it: its header to the letter, its cells as short as they can be, nothing where
/// there is nothing.
#[test]
fn the_table_is_what_the_contract_says() {
    let mut study = study("table", &[1.0], &some_laws(&["hht"]), None);
    study.rows.truncate(3);
    let [a, b, c] = study.rows.as_mut_slice() else { panic!("three rows") };
    (a.job.setting, a.measured.error, a.measured.error_max, a.measured.energy_error) =
        (StepSetting::Step(0.001), Some(2.5e-7), Some(1e-6), Some(0.0));
    (a.cpu_seconds, a.measured.counters.force_evaluations, a.measured.counters.tangent_assemblies) =
        (Some(0.125), 17, 5);
    (a.measured.counters.factorizations, a.measured.counters.linear_solves, a.pareto) = (3, 9, true);
    b.job.method = method("rk4", &[]);
    (b.job.setting, b.measured.status, b.measured.error, b.measured.error_max) =
        (StepSetting::Tolerance(1e-4), RowStatus::Diverged, None, Some(f64::NAN));
    (b.measured.energy_error, b.cpu_seconds, b.pareto) = (Some(1e300), Some(1e-5), false);
    b.measured.counters = Default::default();
    *c = Row { pareto: false, cpu_seconds: None, measured: Default::default(), ..c.clone() };
    let expected = format!(
        "{HEADER}\n\
         \"{{\"\"hht\"\":{{\"\"alpha\"\":-0.2}}}}\",0.001,,completed,2.5e-7,1e-6,0.0,0.125,17,5,3,9,true\n\
         rk4,,0.0001,diverged,,,1e300,1e-5,0,0,0,0,false\n\
         \"{{\"\"hht\"\":{{\"\"alpha\"\":-0.2}}}}\",0.01,,not-run,,,,,0,0,0,0,false\n"
    );
    assert_eq!(Report::of(&study).text("tradeoff.csv"), expected);
}

/// What stands in the column of methods can be given to `--methods` again.
#[test]
fn methods_can_be_given_again() {
    let study = study("again", &[1.0], &some_laws(&["hht", "rk4"]), None);
    let table = Report::of(&study).text("tradeoff.csv");
    for (line, row) in table.lines().skip(1).zip(&study.rows) {
        let cell = match line.strip_prefix('"') {
            Some(quoted) => quoted.split_once("\",").expect("the quote ends").0.replace("\"\"", "\""),
            None => line.split_once(',').expect("a cell").0.to_owned(),
        };
        let options = StudyOptions::of(&TypedOptions { methods: Some(cell.clone()), ..TypedOptions::default() }, None)
            .expect("a method");
        assert_eq!(options.methods, Some(vec![row.job.method.clone()]), "{cell}");
    }
    assert_eq!(table.lines().count(), 1 + study.rows.len());
}

/// No run is missing: each way to end has its rows, its marks in the strip, its word in the legend and its reason on
/// the page.
#[test]
fn every_status_is_a_row_and_a_mark() {
    let ends = [RowStatus::Completed, RowStatus::Completed].into_iter().chain(FAILURES).chain(FAILURES);
    let study = with_ends(study("ends", &[1.0], &some_laws(&["newmark"]), None), &ends.collect::<Vec<_>>());
    assert_eq!(study.rows.len(), 10);
    let report = Report::of(&study);
    let (table, page) = (report.text("tradeoff.csv"), report.text("tradeoff.html"));
    for status in FAILURES {
        assert_eq!(table.matches(&format!(",{},", status.word())).count(), 2, "{table}");
        let noted = format!("<td class=\"note\"><div tabindex=\"0\">because of {}", status.word());
        assert_eq!(page.matches(&noted).count(), 2);
        let reasons = page.split("<h2>Notes on runs</h2>").nth(1).and_then(|rest| rest.split("</dl>").next());
        assert!(reasons.is_some_and(|text| text.contains(&format!("ecause of {}", status.word()))), "{status:?}");
    }
    for file in ["tradeoff.svg", "work.svg"] {
        let picture = report.picture(file);
        let frames = frames(&picture);
        assert_eq!(frames.len(), 2, "the chart and its strip");
        assert_eq!(marks(&picture, frames[1]).len(), 8, "{file}");
        for word in ["diverged", "not converged", "refused", "not run", "no result", "newmark", "implicit"] {
            assert!(picture.iter().any(|e| e.name == "text" && e.text == word), "{word} in {file}");
        }
    }
}

/// The colours that the methods have on all pages.
const DOP853: &str = "#332288";
const RK4: &str = "#E69F00";

/// Runs stand where their error and their cost are, and those more exact than the reference on its bound.
#[test]
fn runs_are_drawn_where_they_belong() {
    let study = study("places", &[1.0], &some_laws(&["dop853"]), None);
    let picture = Report::of(&study).picture("tradeoff.svg");
    let (x, y) = (axis(&picture, "middle", |p| p.0), axis(&picture, "end", |p| p.1));
    let mut expected: Vec<(f64, f64)> = study
        .rows
        .iter()
        .filter(|r| matches!(r.job.setting, StepSetting::Step(_)))
        .filter_map(|r| Some((r.measured.error?.max(2.3e-9), r.cpu_seconds?)))
        .collect();
    expected.sort_by(|a, b| a.1.total_cmp(&b.1));
    assert!(expected.len() == 5 && expected[4].0 == 2.3e-9, "the last ones are better than the reference can tell");
    // Runs in adaptive steps are a dashed line.
    let full = |e: &&Element| e.get("stroke") == DOP853 && e.get("stroke-dasharray").is_empty();
    let mut lines = picture.iter().filter(|e| e.name == "polyline").filter(full).map(Element::points);
    let line = lines.rfind(|p| p.len() == expected.len()).expect("its line");
    for (point, (error, cost)) in line.iter().zip(expected) {
        let off = (x(point.0) / error).ln().abs().max((y(point.1) / cost).ln().abs());
        assert!(off < 0.02, "{point:?} is {}, {}, not {error}, {cost}", x(point.0), y(point.1));
    }
    assert!(picture.iter().any(|e| e.text == "reference 2.3e-9") && picture.iter().any(|e| e.text == "Pareto front"));
}

/// Names are people's: they come through all files, and nothing in them is taken for markup.
#[test]
fn names_survive() {
    let name = "a <b>&amp; \"c\" 'd', {{ e }} </script>";
    let mut study = study(name, &[1.0], &some_laws(&["rk4"]), None);
    for row in &mut study.rows {
        row.job.method = method("x<y>&\"z\"'q', w", &[("p", 0.5)]);
        row.measured.note = "<i>never</i>".to_owned();
    }
    study.plan.case_file = "<case>.json".to_owned();
    let report = Report::of(&study);
    let picture = report.picture("tradeoff.svg");
    assert!(picture.iter().any(|e| e.text == format!("{name}: what accuracy costs")));
    assert!(picture.iter().any(|e| e.text == label(&study.rows[0].job.method)));
    let json: serde_json::Value = serde_json::from_str(&report.text("tradeoff.json")).expect("JSON");
    assert_eq!(json["plan"]["name"], name);
    assert_eq!(json["rows"][0]["method"]["x<y>&\"z\"'q', w"]["p"], 0.5);
    let page = report.text("tradeoff.html");
    for markup in ["<b>", "<y>", "<i>never", "<case>", "<Old>", "{{"] {
        let inside = if markup == "{{" { page.matches("{{ e }}").count() } else { 0 };
        assert_eq!(page.matches(markup).count(), inside, "{markup}");
    }
    assert_eq!(page.matches("</script>").count(), 2, "the page's own: what marks tell, and the script");
    assert!(page.contains("a &lt;b&gt;&amp;amp; &quot;c&quot;"), "the name in full");
}

/// One page that needs nothing beside it, with the figures for wide and narrow screens, and the same bytes for the same
/// study. Every run that has a mark tells its numbers, and every method has a switch.
#[test]
fn the_page_stands_alone_and_repeats() {
    let study = study("cloth", &[1.0], &laws(), None);
    let report = Report::of(&study);
    let names: Vec<_> =
        report.files.iter().map(|f| f.file_name().expect("a name").to_string_lossy().into_owned()).collect();
    assert_eq!(
        names,
        ["tradeoff.csv", "tradeoff.json", "tradeoff.svg", "work.svg", "convergence.svg", "tradeoff.html"]
    );
    let page = report.text("tradeoff.html");
    for file in ["tradeoff.svg", "work.svg", "convergence.svg"] {
        assert!(page.contains(&format!("href=\"{file}\"")), "the page leads to {file}");
    }
    assert_eq!(page.matches("class=\"wide\"><svg").count(), 3);
    assert_eq!(page.matches("class=\"narrow\"><svg").count(), 3);
    let outside = page.replace("http://www.w3.org/2000/svg", "");
    for word in ["http:", "https:", "src=", "url(", "@import"] {
        assert!(!outside.contains(word), "{word}");
    }
    assert_eq!(page.matches("href=").count(), 5, "to the files beside it");
    let told = page.split("id=\"told\">").nth(1).and_then(|rest| rest.split("</script>").next()).expect("there");
    let told: serde_json::Value = serde_json::from_str(told).expect("JSON");
    for row in &study.rows {
        let pairs: Vec<(&str, &str)> = told[&row.job.id]
            .as_array()
            .expect("a run")
            .iter()
            .map(|pair| (pair[0].as_str().expect("a name"), pair[1].as_str().expect("a text")))
            .collect();
        let method = label(&row.job.method);
        assert!(pairs.contains(&("method", method.as_str())), "{pairs:?}");
        if let Some(error) = row.measured.error {
            let text = pairs.iter().find(|pair| pair.0 == "error [-]").expect("an error").1;
            assert!((text.parse::<f64>().expect("a number") / error - 1.0).abs() < 5e-3, "{text} is not {error}");
        }
        assert!(page.contains(&format!("data-run=\"{}\"", row.job.id)), "{} has a mark", row.job.id);
    }
    let switches = study.rows.iter().map(|row| label(&row.job.method)).collect::<std::collections::BTreeSet<_>>();
    assert_eq!(page.matches("data-switch=").count(), switches.len());
    for answer in &Recommendations::of(&study.plan, &study.rows).expect("answers").targets {
        assert!(page.contains(&answer.sentence["for ".len()..]), "{}", answer.sentence);
    }
    assert_eq!(page.matches("<tr class=\"front\">").count(), study.rows.iter().filter(|r| r.pareto).count());
    assert!(page.contains("dop853 at tolerance 1e-13 against") && page.contains("2.3e-9"), "the reference's account");
    assert!(page.contains("--methods &#x27;{&quot;hht&quot;"), "the command as typed");
    let again = Report::of(&study);
    for file in &names {
        assert_eq!(report.text(file), again.text(file), "{file}");
    }
    let other = TempDir::new().expect("a folder");
    let tomorrow = Rerun { machine: Machine { date: Some("2026-11-22".to_owned()), ..how().machine }, ..how() };
    Report::into(&other, &study, &tomorrow);
    let other = std::fs::read_to_string(other.path().join("tradeoff.html")).expect("written");
    assert_eq!(page.lines().zip(other.lines()).filter(|(a, b)| a != b).count(), 1, "one line tells the day");
}

/// A sweep has the factor in its table, a table and a figure over stiffness; a later study without one leaves neither
/// behind.
#[test]
fn sweeps_over_stiffness() {
    let swept = study("sweep", &[1.0, 100.0, 1e5, 1e6], &some_laws(&["velocity-verlet", "newmark"]), None);
    let mut report = Report::of(&swept);
    let table = report.text("tradeoff.csv");
    assert_eq!(table.lines().next(), Some(format!("stiffness_factor,{HEADER}").as_str()));
    for (factor, start) in [(1.0, "1.0,"), (100.0, "100.0,"), (1e5, "100000.0,"), (1e6, "1000000.0,")] {
        let variant = swept.plan.variants.iter().position(|v| v.stiffness_factor == factor);
        let rows = swept.rows.iter().filter(|r| Some(r.job.variant) == variant).count();
        assert_eq!(table.lines().filter(|l| l.starts_with(start)).count(), rows);
    }
    let answers = Recommendations::of(&swept.plan, &swept.rows).expect("answers");
    let stiffness = report.text("stiffness.csv");
    assert_eq!(stiffness.lines().count(), 1 + answers.stiffness.len());
    assert!(stiffness.starts_with("stiffness_factor,wanted,explicit,explicit_cpu_seconds,implicit,implicit_cpu_seconds\n1.0,0.1,velocity-verlet at "));
    let crossings = answers.stiffness_crossovers.iter().filter(|c| c.stiffness_factor.is_some()).count();
    assert!(crossings > 0);
    let picture = report.picture("stiffness.svg");
    // A star has ten corners; the legend explains it with one more.
    let stars = picture.iter().filter(|e| e.name == "polygon" && e.points().len() == 10).count();
    assert_eq!(stars, crossings + 1);
    assert_eq!(frames(&report.picture("tradeoff.svg")).len(), 8, "four charts, each with its strip");
    let page = report.text("tradeoff.html");
    assert!(page.contains("100 times the stiffness") && page.contains("stiffness.svg"));

    let plain = study("plain", &[1.0], &some_laws(&["newmark"]), None);
    report.files = Report::into(&report.folder, &plain, &how());
    assert!(["stiffness.csv", "stiffness.svg"].iter().all(|f| !report.folder.path().join(f).exists()));
}

/// A study of failures is still told in full.
#[test]
fn studies_without_a_result_say_so() {
    for status in FAILURES {
        let mut failed = study("failed", &[1.0], &some_laws(&["rk4", "newmark"]), Some(status));
        for row in failed.rows.iter_mut().filter(|_| matches!(status, RowStatus::Refused | RowStatus::NotRun)) {
            row.cpu_seconds = None;
        }
        let report = Report::of(&failed);
        let picture = report.picture("tradeoff.svg");
        assert!(picture.iter().any(|e| e.text == "no run reached its end"));
        assert_eq!(marks(&picture, frames(&picture)[1]).len(), failed.rows.len(), "{status:?}");
        assert!(report.text("tradeoff.html").contains("No run of this study reached"));
    }
    let report = Report::of(&study("none", &[1.0], &[], None));
    assert!(report.picture("tradeoff.svg").iter().any(|e| e.text == "no runs"));
    assert_eq!(report.text("tradeoff.csv"), format!("{HEADER}\n"));
    assert!(report.text("tradeoff.html").contains("0 of 0 runs"));
    let swept = Report::of(&study("none", &[1.0, 10.0], &[], None));
    assert!(swept.picture("stiffness.svg").iter().any(|e| e.text == "no accuracy was reached at any stiffness"));
    // A clock too coarse to see a run, and an error of nothing: no place on logarithmic axes, and still there.
    let mut quick = study("quick", &[1.0], &some_laws(&["rk4"]), None);
    quick.plan.variants[0].reference.error = 0.0;
    for row in &mut quick.rows {
        (row.cpu_seconds, row.measured.error) = (Some(0.0), row.measured.error.map(|_| 0.0));
    }
    let picture = Report::of(&quick).picture("tradeoff.svg");
    let line = picture.iter().filter(|e| e.name == "polyline" && e.get("stroke") == RK4).map(Element::points);
    assert!(line.filter(|p| p.len() == 5).count() >= 1, "five runs with fixed steps");
}

/// Forty methods: all in the legend, one row each, beside the charts; and no mark in the strip covers another.
#[test]
fn forty_methods_do_not_overlap() {
    let mut many = laws();
    for k in 1..6 {
        let more = laws().into_iter().take(5).map(|law| {
            let method = method(&law.method.name, &[("variant", f64::from(k))]);
            Law { method, cost: law.cost * f64::from(k), ..law }
        });
        many.extend(more);
    }
    assert_eq!(many.len(), 40);
    let crowd = study("crowd", &[1.0], &many, None);
    let picture = Report::of(&crowd).picture("tradeoff.svg");
    let frames = frames(&picture);
    let right = frames.iter().map(|f| f[2]).fold(0.0, f64::max);
    let legend: Vec<&Element> = picture
        .iter()
        .filter(|e| e.name == "text" && e.get("text-anchor") == "start" && e.points()[0].0 > right)
        .collect();
    for law in &many {
        assert_eq!(legend.iter().filter(|e| e.text == label(&law.method)).count(), 1, "{}", label(&law.method));
    }
    let height =
        picture[0].get("viewBox").split_whitespace().nth(3).and_then(|h| h.parse::<f64>().ok()).expect("a height");
    let places: Vec<f64> = legend.iter().map(|e| e.points()[0].1).collect();
    assert!(places.windows(2).all(|w| w[1] - w[0] > 190.0), "19 px a row at least, in tenths");
    assert!(places.last().is_some_and(|last| last + 100.0 < height), "the last row is in the picture");
    let failed = crowd.rows.iter().filter(|r| r.measured.status != RowStatus::Completed).count();
    assert!(failed > 30);
    assert_eq!(marks(&picture, frames[1]).len(), failed, "all apart by more than a pixel");
    for (i, a) in marks(&picture, frames[1]).iter().enumerate() {
        for b in marks(&picture, frames[1]).iter().skip(i + 1) {
            assert!((a.0 - b.0).abs().max((a.1 - b.1).abs()) > 100.0, "{a:?} covers {b:?}");
        }
    }
}
