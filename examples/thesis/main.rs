//! Reruns the thesis: Tables 1, 2 and 4 and the figures with data between 4 and 40, into a folder with an index page.
//! It fails where a sentence of the page is not borne out by the numbers.
//!
//! ```text
//! cargo run --release --example thesis              # into out/thesis
//! cargo run --release --example thesis -- DIR       # elsewhere
//! cargo run --release --example thesis -- --full    # Newmark and HHT on the cloths at the thesis' own steps: ten minutes
//! ```

mod cloth;
mod oscillator;
mod page;
mod parachute;
mod pendulum;
mod readings;
mod runs;
mod spring_pendulum;
mod wire;
mod words;

use page::Page;
use runs::Failed;
use std::path::PathBuf;
use std::time::Instant;

fn main() -> Result<(), Failed> {
    let (flags, folders): (Vec<String>, Vec<String>) = std::env::args().skip(1).partition(|a| a.starts_with('-'));
    if let Some(unknown) = flags.iter().find(|f| *f != "--full") {
        return Err(format!("unknown flag {unknown}; there is --full").into());
    }
    let full = !flags.is_empty();
    let out = folders.first().map_or_else(|| PathBuf::from("out/thesis"), PathBuf::from);
    std::fs::create_dir_all(&out)?;
    let started = Instant::now();
    let mut page = Page { version: env!("CARGO_PKG_VERSION"), ..Page::default() };
    let mut add = |section: Result<page::Section, Failed>| -> Result<(), Failed> {
        let section = section?;
        eprintln!("{:>6.1} s  {}", started.elapsed().as_secs_f64(), section.title);
        page.sections.push(section);
        Ok(())
    };
    add(pendulum::section(&out))?;
    add(spring_pendulum::section(&out))?;
    add(parachute::section(&out))?;
    add(cloth::section(&out, full))?;
    add(oscillator::section(&out))?;
    page.seconds = started.elapsed().as_secs_f64();
    page.write(&out)?;
    println!("{}", out.join("index.html").display());
    let untrue: Vec<&str> = page.sections.iter().flat_map(|section| &section.untrue).map(String::as_str).collect();
    if untrue.is_empty() { Ok(()) } else { Err(format!("no longer so:\n  {}", untrue.join("\n  ")).into()) }
}
