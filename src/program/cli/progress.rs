//! The progress line on standard error: time, share done, steps per second, step size, Newton iterations, time left.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use super::complain;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, Point, UpcomingStep, Wants};
use crate::statics::SearchProgress;

/// Time between two updates of the line.
const REDRAW: Duration = Duration::from_millis(100);
/// The clock is read at least once in this many steps: reading it less often would save nothing, and the line would
/// stop when steps become slow.
const RAREST: u64 = 64;
/// [-] weight of the newest interval in the smoothed rates
const NEWEST: f64 = 0.3;
/// [s] Start-ups longer than this are printed phase by phase.
pub const LONG_START: f64 = 1.0;
/// Length of the bar.
const TICKS: f64 = 1000.0;

/// When a progress line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Display {
    /// if standard error is a terminal
    Terminal,
    /// never
    Quiet,
}

/// An observer that draws the progress of a run and records nothing.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    end: f64,
    clock: Option<RefreshClock>,
    /// steps until the clock is read next
    countdown: u64,
    every: u64,
    since: WorkSince,
}

/// Counted since the line was drawn last.
#[derive(Clone, Copy, Debug, Default)]
struct WorkSince {
    steps: u64,
    newton: u64,
}

/// State of the line at its last update; exists once a run has started and its progress is shown.
#[derive(Clone, Copy, Debug)]
struct RefreshClock {
    start: f64,
    looked: Instant,
    drawn: Instant,
    t: f64,
    rates: Rates,
}

/// Smoothed speeds.
#[derive(Clone, Copy, Debug, Default)]
struct Rates {
    /// [1/s] steps per second of clock time
    steps: f64,
    /// [-] simulated seconds per second of clock time
    time: f64,
}

/// What the line shows.
#[derive(Clone, Copy, Debug)]
struct ProgressLine {
    t: f64,
    end: f64,
    step_size: f64,
    newton: f64,
    rates: Rates,
}

impl Progress {
    /// A progress line for a run until `end` [s].
    pub fn new(end: f64, display: Display) -> Self {
        let target = if display == Display::Terminal && std::io::stderr().is_terminal() {
            ProgressDrawTarget::stderr_with_hz(10)
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(Some(TICKS as u64), target);
        if let Ok(style) = ProgressStyle::with_template("{percent:>3}% [{bar:24}] {wide_msg}") {
            bar.set_style(style.progress_chars("=> "));
        }
        Self { bar, end, clock: None, countdown: 1, every: 1, since: WorkSince::default() }
    }

    /// Shows what is being done.
    pub(super) fn say(&self, what: &str) {
        self.bar.set_message(what.to_owned());
    }

    /// Removes the line.
    pub(super) fn clear(&self) {
        self.bar.finish_and_clear();
    }

    /// After a step to `t` [s].
    fn stepped(&mut self, t: f64, step_size: f64, newton: u32) {
        if self.clock.is_some() {
            self.since.steps += 1;
            self.since.newton += u64::from(newton);
            self.countdown -= 1;
            if self.countdown == 0 {
                self.refresh(t, step_size);
            }
        }
    }

    /// Reads the clock and draws the line when due. Adapts the number of steps between readings, so that there are
    /// several per update.
    fn refresh(&mut self, t: f64, step_size: f64) {
        let Some(clock) = &mut self.clock else { return };
        let now = Instant::now();
        let gap = now.duration_since(clock.looked);
        clock.looked = now;
        if gap < REDRAW / 10 {
            self.every = (self.every * 2).min(RAREST);
        } else if gap > REDRAW / 3 {
            // Reduced at once, not by halves: steps may have become a thousand times slower.
            self.every = 1;
        }
        self.countdown = self.every;
        let interval = now.duration_since(clock.drawn);
        if interval < REDRAW {
            return;
        }
        let seconds = interval.as_secs_f64();
        clock.rates.steps = smooth(clock.rates.steps, self.since.steps as f64 / seconds);
        clock.rates.time = smooth(clock.rates.time, (t - clock.t) / seconds);
        (clock.drawn, clock.t) = (now, t);
        let line = ProgressLine {
            t,
            end: self.end,
            step_size,
            newton: self.since.newton as f64 / self.since.steps.max(1) as f64,
            rates: clock.rates,
        };
        let done = ((t - clock.start) / (self.end - clock.start)).clamp(0.0, 1.0);
        self.since = WorkSince::default();
        // A share that is NaN becomes 0.
        self.bar.set_position((done * TICKS) as u64);
        self.bar.set_message(line.text());
    }
}

impl Observer for Progress {
    fn started(&mut self, at: &Point, _ledger: Energies) -> Result<(), ObserveError> {
        let startup = crate::startup::ready().filter(|startup| startup.wall_seconds > LONG_START);
        if !self.bar.is_hidden() {
            if let Some(startup) = startup {
                self.bar.suspend(|| complain(&format!("start-up {}", startup.text())));
            }
            let (now, t) = (Instant::now(), at.state.t);
            self.clock = Some(RefreshClock { start: t, looked: now, drawn: now, t, rates: Rates::default() });
        }
        Ok(())
    }

    fn resumed(&mut self, at: &Point, ledger: Energies) -> Result<(), ObserveError> {
        self.started(at, ledger)
    }

    fn wants(&self, _step: UpcomingStep) -> Wants {
        Wants::ACCOUNT
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.stepped(step.t, step.h(), step.newton_iterations);
        Ok(())
    }

    fn finished(&mut self, _last: &Point) -> Result<(), ObserveError> {
        self.clock = None;
        self.bar.finish_and_clear();
        Ok(())
    }
}

/// A line that shows how far the search for an equilibrium has come.
#[derive(Debug)]
pub struct SearchLine(ProgressBar);

impl SearchLine {
    /// Nothing is drawn yet.
    pub fn new(display: Display) -> Self {
        let shown = display == Display::Terminal && std::io::stderr().is_terminal();
        let target = if shown { ProgressDrawTarget::stderr_with_hz(10) } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(None, target);
        if let Ok(style) = ProgressStyle::with_template("{spinner} {wide_msg}") {
            bar.set_style(style);
        }
        SearchLine(bar)
    }

    /// After a solve.
    pub fn show(&self, progress: SearchProgress) {
        if !self.0.is_hidden() {
            self.0.set_message(search_text(progress));
            self.0.tick();
        }
    }
}

impl Drop for SearchLine {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

fn search_text(SearchProgress { iterations, residual, scale, level }: SearchProgress) -> String {
    let mut text = format!("Newton {iterations}  {} of {} N left", short(residual), short(scale));
    if level < 1.0 {
        text += &format!("  {} % of the loads", short(100.0 * level));
    }
    text
}

impl Drop for Progress {
    /// Clears the line, so that an error message is not mixed with it.
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl ProgressLine {
    fn text(&self) -> String {
        let Self { t, end, step_size, newton, rates } = *self;
        let mut text = format!("t {} of {} s  {} steps/s", short(t), short(end), short(rates.steps));
        text += &format!("  h {} s", short(step_size));
        if newton > 0.0 {
            text += &format!("  Newton {newton:.1}");
        }
        if let Some(left) = time_left(end - t, rates.time) {
            text += &format!("  {left} left");
        }
        text
    }
}

fn smooth(old: f64, new: f64) -> f64 {
    if old == 0.0 { new } else { old + NEWEST * (new - old) }
}

/// Four digits, with an exponent where that is shorter.
fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".to_owned()
    } else if !(1e-3..1e6).contains(&size) {
        format!("{value:.2e}")
    } else {
        let digits = (3.0 - size.log10().floor()).clamp(0.0, 6.0) as usize;
        let text = format!("{value:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    }
}

/// Hours, minutes and seconds for `remaining` seconds of simulated time at `rate`.
fn time_left(remaining: f64, rate: f64) -> Option<String> {
    let seconds = (remaining.max(0.0) / rate).round();
    if !(0.0..=1e9).contains(&seconds) {
        return None;
    }
    let seconds = seconds as u64;
    let (hours, minutes, rest) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    Some(match (hours, minutes) {
        (0, 0) => format!("{rest} s"),
        (0, _) => format!("{minutes} min {rest:02} s"),
        _ => format!("{hours} h {minutes:02} min"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The line shows the progress, and leaves out quantities that the scheme does not have.
    #[test]
    fn line_reads_well() {
        let rates = Rates { steps: 12_345.6, time: 0.01 };
        let line = ProgressLine { t: 0.5, end: 2.0, step_size: 1e-5, newton: 2.345, rates };
        assert_eq!(line.text(), "t 0.5 of 2 s  12346 steps/s  h 1.00e-5 s  Newton 2.3  2 min 30 s left");
        let still = ProgressLine { newton: 0.0, rates: Rates { steps: 0.0, time: 0.0 }, ..line };
        assert_eq!(still.text(), "t 0.5 of 2 s  0 steps/s  h 1.00e-5 s");
        assert_eq!(time_left(7200.0, 1.0).as_deref(), Some("2 h 00 min"));
        assert_eq!(time_left(1.0, f64::NAN), None);
    }

    /// What is left of the forces, and the level of the loads where they grow.
    #[test]
    fn search_line_reads_well() {
        let progress = SearchProgress { iterations: 123, residual: 4.5e-5, scale: 678.9, level: 1.0 };
        assert_eq!(search_text(progress), "Newton 123  4.50e-5 of 678.9 N left");
        let some = SearchProgress { level: 0.3, ..progress };
        assert_eq!(search_text(some), "Newton 123  4.50e-5 of 678.9 N left  30 % of the loads");
    }

    /// While steps are quick, the clock is read less and less often; when they become slow, it is read often again at
    /// once.
    #[test]
    fn clock_is_read_sparsely() {
        let view = AcceptedStep { step: 1, t: 0.1, newton_iterations: 3, ..AcceptedStep::default() };
        let mut progress = Progress::new(1.0, Display::Quiet);
        let now = Instant::now();
        progress.clock = Some(RefreshClock { start: 0.0, looked: now, drawn: now, t: 0.0, rates: Rates::default() });
        for _ in 0..1000 {
            progress.accepted(view).expect("a progress line cannot fail");
        }
        assert!(progress.every == RAREST, "{}", progress.every);
        std::thread::sleep(REDRAW * 2);
        progress.refresh(0.1, 0.1);
        assert_eq!(progress.every, 1);
        assert_eq!(progress.bar.position(), 100);
        assert_eq!(progress.since.steps, 0, "counted anew after drawing");
    }
}
