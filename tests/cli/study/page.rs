//! The pages of studies in a browser: what marks tell, what the legend hides, and that nothing goes wrong.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::bench::{Bench, Results};

/// Visits every mark, presses every switch, and writes what is seen into the page.
const VISITOR: &str = r#"
<script>
(function () {
  var root = document.documentElement;
  var seen = { errors: window.pageErrors, marks: [], switches: [], width: root.scrollWidth, window: root.clientWidth };
  var shown = function (node) { return node.getClientRects().length > 0; };
  var tip = document.querySelector(".tip");
  document.querySelectorAll("figure svg").forEach(function (svg) {
    if (!shown(svg)) { return; }
    svg.querySelectorAll("g[data-run]").forEach(function (mark) {
      svg.scrollIntoView();
      var box = mark.getBoundingClientRect();
      var at = { clientX: box.x + box.width / 2, clientY: box.y + box.height / 2, bubbles: true, pointerType: "mouse" };
      svg.dispatchEvent(new PointerEvent("pointermove", at));
      var place = tip.getBoundingClientRect();
      seen.marks.push({ run: mark.getAttribute("data-run"), text: tip.hidden ? null : tip.textContent,
        inside: place.left >= 0 && place.right <= document.documentElement.clientWidth });
      svg.dispatchEvent(new PointerEvent("pointerleave", { pointerType: "mouse" }));
      if (!tip.hidden) { seen.errors.push("the text stays"); }
    });
  });
  document.querySelectorAll("button[data-switch]").forEach(function (button) {
    var name = button.getAttribute("data-switch");
    var count = function () {
      return Array.prototype.filter.call(document.querySelectorAll("figure g[data-series]"), function (group) {
        return group.getAttribute("data-series") === name && shown(group);
      }).length;
    };
    var before = count();
    button.click();
    var off = count();
    button.click();
    seen.switches.push({ name: name, before: before, off: off, after: count() });
  });
  var value = document.querySelector(".wide-table td.n");
  seen.value = value ? value.getBoundingClientRect().right : null;
  var out = document.createElement("pre");
  out.id = "seen";
  out.textContent = JSON.stringify(seen);
  document.body.appendChild(out);
})();
</script>
"#;
/// Before all other scripts.
const LISTENER: &str = r#"<script>window.pageErrors = []; window.onerror = function (what) { window.pageErrors.push(String(what)); };
console.error = window.onerror;</script>"#;

/// A window of any width: that of a browser is at least 500 px wide. It takes over what the visitor saw.
fn host(width: u32) -> String {
    format!(
        r#"<!DOCTYPE html><body><iframe src="visited.html" style="border: 0; width: {width}px; height: 900px"></iframe><script>
window.onload = function () {{
  document.body.appendChild(document.querySelector("iframe").contentDocument.getElementById("seen"));
}};</script></body>"#
    )
}

/// A browser without a window, if there is one: CANOPY_FEM_BROWSER names another.
pub(crate) fn browser() -> Option<PathBuf> {
    let named = std::env::var_os("CANOPY_FEM_BROWSER").map(PathBuf::from);
    let all = ["chromium", "chromium-browser", "google-chrome"].map(PathBuf::from);
    named
        .into_iter()
        .chain(all)
        .find(|program| Command::new(program).arg("--version").output().is_ok_and(|done| done.status.success()))
}

/// What the visitor saw of a page in a window so many pixels wide.
fn visit(browser: &Path, page: &Path, width: u32) -> Value {
    let text = std::fs::read_to_string(page).expect("a page");
    let visited = page.with_file_name("visited.html");
    let text =
        text.replacen("<head>", &format!("<head>{LISTENER}"), 1).replace("</body>", &format!("{VISITOR}</body>"));
    std::fs::write(&visited, text).expect("written");
    let host_page = page.with_file_name("host.html");
    std::fs::write(&host_page, host(width)).expect("written");
    let profile = tempfile::TempDir::new().expect("a folder");
    let done = Command::new(browser)
        .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--dump-dom"])
        .args(["--allow-file-access-from-files", "--window-size=1500,1000"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{}", host_page.display()))
        .output()
        .expect("the browser starts");
    let dom = String::from_utf8_lossy(&done.stdout);
    let seen = dom.split("<pre id=\"seen\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let seen = seen.unwrap_or_else(|| panic!("the page ended early: {}", String::from_utf8_lossy(&done.stderr)));
    let seen = seen.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    serde_json::from_str(&seen).expect("JSON")
}

/// No error; every mark tells; every switch hides what is its own and shows it again; nothing is wider than the window.
fn check(seen: &Value, width: u32) {
    assert_eq!(seen["errors"], serde_json::json!([]));
    let marks = seen["marks"].as_array().expect("marks");
    assert!(!marks.is_empty(), "no mark is shown");
    assert!(marks.iter().all(|mark| mark["text"].is_string() && mark["inside"] == true), "{marks:#?}");
    for one in seen["switches"].as_array().expect("switches") {
        let count = |key: &str| one[key].as_u64().expect("a number");
        assert!(count("before") > 0 && count("off") == 0 && count("after") == count("before"), "{one}");
    }
    // A bar for scrolling down takes some of the width.
    let [page, window] = ["width", "window"].map(|key| seen[key].as_u64().expect("pixels"));
    assert!(page <= window && window <= u64::from(width), "{page} px in a window of {window} px");
}

/// A number of the csv file as the page rounds it.
fn rounded(number: f64) -> String {
    canopy_fem::format_number::figures(number, 6)
}

fn told(seen: &Value, run: &str, wanted: &str) {
    let marks = seen["marks"].as_array().expect("marks").iter().filter(|mark| mark["run"] == run);
    let texts: Vec<&str> = marks.filter_map(|mark| mark["text"].as_str()).collect();
    assert!(!texts.is_empty() && texts.iter().all(|text| text.contains(wanted)), "{run}: {wanted} is not in {texts:?}");
}

#[test]
fn pages_of_studies_in_a_browser() {
    let Some(browser) = browser() else {
        println!("skipped: no browser was found (apt install chromium; CANOPY_FEM_BROWSER names another)");
        return;
    };
    let bench = Bench::new();
    let vary = ["--vary", "system.network.springs.0.stiffness=40,50,60", "--vary", "time.method=rk4,newmark"];
    let ended = bench.run(&[&["sweep", "sail.json", "--out", "s", "--plot", "max_speed"][..], &vary].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let table = Results(bench.path("s")).table("sweep.csv");
    for width in [1440, 390] {
        let seen = visit(&browser, &bench.path("s/sweep.html"), width);
        check(&seen, width);
        assert_eq!(seen["switches"].as_array().map(Vec::len), Some(2));
        for (row, speed) in table.rows.iter().zip(table.column("max_speed")) {
            let run = format!("{:05}-{}-{}", row[0].parse::<usize>().expect("a number"), row[1], row[2]);
            told(&seen, &run, &rounded(speed));
            told(&seen, &run, &row[2]);
        }
    }
    let flags = ["--methods", "rk4,newmark,explicit-euler", "--steps", "1e-2,5e-1", "--repeat", "1", "--out", "t"];
    let ended = bench.run(&[&["tradeoff", "sail.json"], &flags[..]].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let study = super::table::study(&bench.path("t"));
    for width in [1440, 390] {
        let seen = visit(&browser, &bench.path("t/tradeoff.html"), width);
        check(&seen, width);
        assert_eq!(seen["switches"].as_array().map(Vec::len), Some(3));
        for row in &study.rows {
            told(&seen, &row.job.id, &row.label());
            if let Some(error) = row.measured.error {
                told(&seen, &row.job.id, &rounded(error));
            }
            told(&seen, &row.job.id, &row.cpu_seconds.map(rounded).unwrap_or_default());
        }
    }
    let flags = ["--methods", "rk4,newmark,euler-cromer", "--end", "0.2", "--out", "l"];
    let ended = bench.run(&[&["stability", "sail.json"], &flags[..]].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let table = Results(bench.path("l")).table("stability.csv");
    for width in [1440, 390] {
        let seen = visit(&browser, &bench.path("l/stability.html"), width);
        check(&seen, width);
        for (row, predicted) in table.rows.iter().zip(table.column("predicted")).filter(|(_, step)| step.is_finite()) {
            told(&seen, &row[0], &rounded(predicted));
            told(&seen, &row[0], &rounded(row[2].parse().expect("a measured limit")));
        }
    }
}

/// The page of a fit is no wider than a window, and shows the first value beside its key, however long that is.
#[test]
fn the_page_of_a_fit_in_a_browser() {
    let Some(browser) = browser() else {
        println!("skipped: no browser was found (apt install chromium; CANOPY_FEM_BROWSER names another)");
        return;
    };
    let bench = Bench::new();
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide/cases");
    let case = cases.join("drop-100kg.json").display().to_string();
    let data = format!("--data={}:riser.tension*981", cases.join("drop-100kg.csv").display());
    let area = "--vary=system.network.aero.canopy.schedule.drag_area=5..80";
    let time = "--vary=system.network.aero.canopy.schedule.filling_time=0.2..2";
    let ended = bench.run(&["fit", &case, &data, area, time, "--offset=0.31..0.9", "--starts=2", "--out=f"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    for width in [1440, 390] {
        let seen = visit(&browser, &bench.path("f/fit.html"), width);
        assert_eq!(seen["errors"], serde_json::json!([]));
        let [page, window] = ["width", "window"].map(|key| seen[key].as_u64().expect("pixels"));
        assert!(page <= window && window <= u64::from(width), "{page} px in a window of {window} px");
        assert!(seen["value"].as_f64().is_some_and(|right| right <= window as f64), "{seen}");
    }
}
