//! A page in a browser: it draws, its frames differ, keys and switches work, and nothing is wider than the window.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use super::bench;
use crate::study::page::browser;

/// Plays the page and writes what is seen into it.
const VISITOR: &str = r##"
<script type="module">
const view = await new Promise((done) => { const look = () => (window.canopyView ? done(window.canopyView) : setTimeout(look, 20)); look(); });
const picture = () => {
  const { gl } = view.pictures[0], pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
  gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let drawn = 0, sum = 0;
  for (let i = 0; i < pixels.length; i += 4) { if (pixels[i + 3]) { drawn++; sum = (sum * 31 + pixels[i] + 7 * pixels[i + 1] + i) % 1e9; } }
  return { drawn: drawn / (pixels.length / 4), sum };
};
const press = (key) => document.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
const settle = () => new Promise((done) => setTimeout(done, 300));
const root = document.documentElement, clock = document.getElementById("clock");
const seen = { errors: window.pageErrors, frames: [], clocks: [], width: root.scrollWidth, window: root.clientWidth };
for (const frame of view.runs[0].frames) { view.seek(frame.t); seen.frames.push(picture()); }
press("Home"); await settle(); seen.clocks.push(clock.textContent);
press("ArrowRight"); await settle(); seen.clocks.push(clock.textContent);
press("End"); await settle(); seen.clocks.push(clock.textContent);
press(" "); await settle(); seen.plays = document.getElementById("play").getAttribute("aria-pressed"); press(" ");
press("Home"); await settle();
const whole = picture().drawn;
document.querySelectorAll("#groups button").forEach((button) => { if (button.getAttribute("aria-pressed") === "true") { button.click(); } });
await settle();
seen.hidden = [whole, picture().drawn];
seen.charts = document.querySelectorAll("#charts figure").length;
seen.peaks = document.querySelectorAll("#charts circle.peak").length;
seen.bar = document.getElementById("bar").textContent;
seen.fields = [...document.getElementById("field").options].map((option) => option.textContent);
const before = performance.now();
for (let i = 0; i < 50; i++) { view.seek(view.runs[0].frames[i % view.runs[0].frames.length].t); }
seen.milliseconds = (performance.now() - before) / 50;
const out = document.createElement("pre");
out.id = "seen";
out.textContent = JSON.stringify(seen);
document.body.appendChild(out);
parent.postMessage(out.textContent, "*");
</script>
"##;
/// Before all other scripts.
const LISTENER: &str = r#"<script>window.pageErrors = []; window.onerror = (what) => { window.pageErrors.push(String(what)); };
window.onunhandledrejection = (event) => { window.pageErrors.push(String(event.reason)); };</script>"#;

/// What the visitor saw in a window so many pixels wide.
fn visit(browser: &Path, page: &Path, width: u32, dark: bool) -> Value {
    let text = fs::read_to_string(page).expect("a page");
    let text =
        text.replacen("<head>", &format!("<head>{LISTENER}"), 1).replace("</body>", &format!("{VISITOR}</body>"));
    fs::write(page.with_file_name("visited.html"), text).expect("written");
    let host = page.with_file_name("host.html");
    let frame = format!("<iframe src=\"visited.html\" style=\"border: 0; width: {width}px; height: 900px\"></iframe>");
    let take = "<script>onmessage = (event) => { const out = document.createElement(\"pre\"); out.id = \"seen\"; \
                out.textContent = event.data; document.body.appendChild(out); };</script>";
    fs::write(&host, format!("<!DOCTYPE html><body>{frame}{take}</body>")).expect("written");
    let profile = tempfile::TempDir::new().expect("a folder");
    let scheme =
        if dark { "--blink-settings=preferredColorScheme=0" } else { "--blink-settings=preferredColorScheme=1" };
    let done = Command::new(browser)
        .args([
            "--headless=new",
            "--no-sandbox",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            "--dump-dom",
        ])
        .args(["--allow-file-access-from-files", "--window-size=1500,1000", "--virtual-time-budget=60000", scheme])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{}", host.display()))
        .output()
        .expect("the browser starts");
    let dom = String::from_utf8_lossy(&done.stdout);
    let seen = dom.split("<pre id=\"seen\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let seen = seen.unwrap_or_else(|| panic!("the page ended early: {dom}\n{}", String::from_utf8_lossy(&done.stderr)));
    let seen = seen.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    serde_json::from_str(&seen).expect("JSON")
}

#[test]
fn pages_of_runs_in_a_browser() {
    let Some(browser) = browser() else {
        println!("skipped: no browser was found (apt install chromium; CANOPY_FEM_BROWSER names another)");
        return;
    };
    let bench = bench();
    assert_eq!(bench.solve(&["--view"]).code, Some(0));
    for (width, dark) in [(1440, false), (390, true)] {
        let seen = visit(&browser, &bench.path("out/view.html"), width, dark);
        assert_eq!(seen["errors"], serde_json::json!([]));
        let frames = seen["frames"].as_array().expect("frames");
        assert_eq!(frames.len(), 11);
        assert!(frames.iter().all(|frame| frame["drawn"].as_f64().expect("a share") > 0.02), "{frames:?}");
        let mut pictures: Vec<u64> = frames.iter().map(|frame| frame["sum"].as_u64().expect("a sum")).collect();
        pictures.dedup();
        assert_eq!(pictures.len(), 11, "frames look the same");
        assert_eq!(
            seen["clocks"],
            serde_json::json!(["t = 0 s · frame 1/11", "t = 0.1 s · frame 2/11", "t = 1 s · frame 11/11"])
        );
        assert_eq!(seen["plays"], "true");
        let hidden = &seen["hidden"];
        assert!(hidden[0].as_f64() > Some(0.02) && hidden[1].as_f64() < Some(0.01), "switches hide little: {hidden}");
        assert!(seen["charts"].as_u64() >= Some(1) && seen["charts"] == seen["peaks"], "{seen}");
        assert!(seen["bar"].as_str().is_some_and(|bar| bar.starts_with("pressure [Pa]")), "{seen}");
        assert_eq!(
            seen["fields"],
            serde_json::json!(["pressure [Pa]", "tension [N]", "speed [m/s]", "strain", "nothing"])
        );
        // A frame at 30 a second has 33 ms; what the graphics card does is not in it.
        assert!(seen["milliseconds"].as_f64() < Some(33.0), "{seen}");
        let [page, window] = ["width", "window"].map(|key| seen[key].as_u64().expect("pixels"));
        assert!(page <= window && window <= u64::from(width), "{page} px in a window of {window} px");
    }
}
