//! A page in a browser: it draws, its frames differ, keys and switches work, and nothing is wider than the window.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, TcpListener};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

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
seen.bar = document.getElementById("bar").textContent;
const whole = picture().drawn;
document.querySelectorAll("#groups button").forEach((button) => { if (button.getAttribute("aria-pressed") === "true") { button.click(); } });
await settle();
seen.hidden = [whole, picture().drawn];
seen.charts = document.querySelectorAll("#charts figure").length;
seen.peaks = document.querySelectorAll("#charts circle.peak").length;
seen.fields = [...document.getElementById("field").options].map((option) => option.textContent);
const before = performance.now();
for (let i = 0; i < 50; i++) { view.seek(view.runs[0].frames[i % view.runs[0].frames.length].t); }
seen.milliseconds = (performance.now() - before) / 50;
seen.dark = matchMedia("(prefers-color-scheme: dark)").matches;
await fetch("seen", { method: "POST", body: JSON.stringify(seen) });
</script>
"##;
/// Before all other scripts.
const LISTENER: &str = r#"<script>window.pageErrors = []; window.onerror = (what) => { window.pageErrors.push(String(what)); };
window.onunhandledrejection = (event) => { window.pageErrors.push(String(event.reason)); };</script>"#;

/// A browser that ends with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Answers the browser until it sends what the visitor saw: the pages are served, as a browser that prints a page does
/// not wait for what a page does after it has loaded.
fn serve(listener: &TcpListener, pages: &[(&str, String)]) -> String {
    let until = Instant::now() + Duration::from_secs(120);
    while Instant::now() < until {
        let Ok((mut stream, _)) = listener.accept() else {
            std::thread::sleep(Duration::from_millis(20));
            continue;
        };
        stream.set_nonblocking(false).expect("set");
        stream.set_read_timeout(Some(Duration::from_secs(20))).expect("set");
        let mut reader = BufReader::new(stream.try_clone().expect("a stream"));
        let (mut first, mut length) = (String::new(), 0);
        if reader.read_line(&mut first).is_err() {
            continue;
        }
        for line in reader.by_ref().lines().map_while(Result::ok).take_while(|line| !line.is_empty()) {
            let lower = line.to_lowercase();
            length = lower.strip_prefix("content-length:").map_or(length, |n| n.trim().parse().expect("a number"));
        }
        if first.starts_with("POST /seen ") {
            let mut body = vec![0; length];
            reader.read_exact(&mut body).expect("what was seen");
            return String::from_utf8(body).expect("text");
        }
        let page = pages.iter().find(|(name, _)| first.starts_with(&format!("GET /{name} "))).map_or("", |(_, p)| p);
        let kind = "HTTP/1.1 200 OK\r\nContent-Type: text/html; charset=utf-8\r\nConnection: close";
        let _ = write!(stream, "{kind}\r\nContent-Length: {}\r\n\r\n{page}", page.len());
    }
    panic!("the browser has told nothing within two minutes");
}

/// What the visitor saw in a window so many pixels wide.
fn visit(browser: &Path, page: &Path, width: u32, dark: bool) -> Value {
    let text = fs::read_to_string(page).expect("a page");
    let text =
        text.replacen("<head>", &format!("<head>{LISTENER}"), 1).replace("</body>", &format!("{VISITOR}</body>"));
    // A window of a browser is at least 500 px wide, a frame may be of any width.
    let frame = format!("<iframe src=\"visited\" style=\"border: 0; width: {width}px; height: 900px\"></iframe>");
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
    listener.set_nonblocking(true).expect("set");
    let address = listener.local_addr().expect("an address");
    let profile = tempfile::TempDir::new().expect("a folder");
    let scheme = if dark { 0 } else { 1 };
    let mut command = Command::new(browser);
    command
        .args(["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
        .args(["--window-size=1500,1000", "--remote-debugging-port=0"])
        .arg(format!("--blink-settings=preferredColorScheme={scheme}"))
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("http://{address}/host"))
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let _running = Running(command.spawn().expect("the browser starts"));
    let host = format!("<!DOCTYPE html><body>{frame}</body>");
    let seen = serve(&listener, &[("host", host), ("visited", text)]);
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
        assert_eq!((&seen["errors"], &seen["dark"]), (&serde_json::json!([]), &Value::from(dark)));
        let frames = seen["frames"].as_array().expect("frames");
        assert_eq!(frames.len(), 11);
        assert!(frames.iter().all(|frame| frame["drawn"].as_f64().expect("a share") > 0.002), "{frames:?}");
        let mut pictures: Vec<u64> = frames.iter().map(|frame| frame["sum"].as_u64().expect("a sum")).collect();
        pictures.dedup();
        assert_eq!(pictures.len(), 11, "frames look the same");
        assert_eq!(
            seen["clocks"],
            serde_json::json!(["t = 0 s · frame 1/11", "t = 0.1 s · frame 2/11", "t = 1 s · frame 11/11"])
        );
        assert_eq!(seen["plays"], "true");
        let [whole, hidden] = [0, 1].map(|i| seen["hidden"][i].as_f64().expect("a share"));
        assert!(whole > 0.002 && hidden < whole / 4.0, "switches hide little: {whole} and {hidden}");
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
