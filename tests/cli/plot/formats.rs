//! Pictures as PNG and PDF, of a program that has them: `cargo test --release --features pictures --test cli plot`.

use super::Desk;
use resvg::tiny_skia::Pixmap;

/// The PNG has twice the pixels of the SVG, text and the curve's colour in it; the PDF has one page with a font.
#[test]
fn pictures_in_other_formats() {
    let desk = Desk::new();
    assert_eq!(desk.solve("oscillator", "out", &["--end", "5"]), Some(0));
    let files = ["out/displacement.png", "out/displacement.pdf", "out/displacement.svg"];
    desk.plot(&["out", "--kind", "displacement", "--format", "png,pdf", "--format", "svg,png"], &files);
    let read = |file| std::fs::read(desk.path(file)).expect("written");
    let pixels = Pixmap::decode_png(&read(files[0])).expect("a PNG");
    assert_eq!((pixels.width(), pixels.height()), (1800, 1080));
    let of = |ink: [u8; 3]| pixels.pixels().iter().filter(|p| [p.red(), p.green(), p.blue()] == ink).count();
    let (white, blue, letters) = (of([255; 3]), of([0x00, 0x72, 0xB2]), of([0x33; 3]));
    // The curve is 3.6 pixels wide and longer than the picture; the frame alone has 2 (1580 + 880) dark pixels.
    assert!(white > 1_000_000 && blue > 4000 && letters > 6000, "{white} white, {blue} blue, {letters} dark");
    let pdf = read(files[1]);
    let has = |what: &str| pdf.windows(what.len()).filter(|part| *part == what.as_bytes()).count();
    assert!(pdf.starts_with(b"%PDF-"));
    assert_eq!((has("/Type /Pages"), has("/Count 1"), has("/Type /FontDescriptor")), (1, 1, 1));
    desk.plot(&["out", "--kind", "phase", "--format", "png", "--scale", "0.5"], &["out/phase.png"]);
    let small = Pixmap::decode_png(&read("out/phase.png")).expect("a PNG");
    assert_eq!((small.width(), small.height()), (450, 270));
}
