//! Quantities of interest: the numbers that a run reports, and the accuracy of which is asked for.
//!
//! A quantity has one name in the terminal, in `summary.json` and in studies:
//! ```text
//! GAUGE.COLUMN.STATISTIC     riser.tension.peak, payload.speed.last, canopy.drag.mean
//! GAUGE.COLUMN@TIME          tip.z@0.5                                            at 0.5 s
//! opening_load               canopy.drag.peak, of the only canopy or the one with the largest
//! displacement_end           [m] largest displacement of a node at the end
//! landing.time, landing.speed, landing.drift, landing.heading, landing.x, landing.y   of a run that ends on the ground
//! max_displacement, max_speed, max_strain, max_stress                            the largest of the run
//! energy.kinetic.STATISTIC   [J] and elastic, gravity, external_work, dissipated, numerical
//! motion                     the motion of all nodes in all frames; it has an error and no value
//! ```
//! GAUGE is a gauge of the case, a canopy, or a probe; COLUMN one of `gauges.csv` or of `probes.csv`, or what the gauge
//! measures (`tension` for `tension_max`). Between two steps a value is interpolated linearly.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// A number made of a series of values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Statistic {
    /// the largest value; of components and speeds along an axis, that of the largest magnitude
    Peak,
    /// [s] when it was reached first
    PeakTime,
    /// the smallest value
    Min,
    /// the value at the end
    Last,
    /// mean over the time of the run
    Mean,
    /// mean over the last tenth of the run
    Steady,
    /// the value at this time [s]
    At(f64),
}

impl Statistic {
    const WORDS: [(&'static str, Statistic); 6] = [
        ("peak", Statistic::Peak),
        ("peak_time", Statistic::PeakTime),
        ("min", Statistic::Min),
        ("last", Statistic::Last),
        ("mean", Statistic::Mean),
        ("steady", Statistic::Steady),
    ];
}

/// The name of a quantity, read.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityName {
    /// as it was written
    pub text: String,
    /// what it names
    pub names: Named,
}

/// What a name names.
#[derive(Clone, Debug, PartialEq)]
pub enum Named {
    /// the motion of all nodes
    Motion,
    /// [m] the largest displacement at the end
    DisplacementEnd,
    /// [N] the peak of a canopy's drag
    OpeningLoad,
    /// a largest value over the whole scene
    Largest(OfScene),
    /// a number of the landing
    Landing(OfLanding),
    /// a statistic of a column of a gauge
    Series {
        /// the gauge, canopy or probe
        gauge: String,
        /// its column, or what it measures
        column: String,
        /// what is made of it
        statistic: Statistic,
    },
}

/// A series of the whole scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OfScene {
    /// [m] displacement of a node
    Displacement,
    /// [m/s] speed of a node
    Speed,
    /// [-] strain of a spring
    Strain,
    /// [Pa] stress of a membrane
    Stress,
}

impl OfScene {
    const ALL: [(&'static str, OfScene); 4] = [
        ("max_displacement", OfScene::Displacement),
        ("max_speed", OfScene::Speed),
        ("max_strain", OfScene::Strain),
        ("max_stress", OfScene::Stress),
    ];

    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            OfScene::Displacement => "m",
            OfScene::Speed => "m/s",
            OfScene::Strain => "-",
            OfScene::Stress => "Pa",
        }
    }
}

/// A number of the landing, in a run that ends on the ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum OfLanding {
    /// [s] when
    Time,
    /// [m/s] speed at touchdown
    Speed,
    /// [m] horizontal distance from the start
    Drift,
    /// [deg] direction of the drift, from the y axis (north) to the x axis (east); none without a drift
    Heading,
    /// [m] x of the place
    X,
    /// [m] y of the place
    Y,
}

impl OfLanding {
    /// All of them.
    pub const ALL: [OfLanding; 6] =
        [OfLanding::Time, OfLanding::Speed, OfLanding::Drift, OfLanding::Heading, OfLanding::X, OfLanding::Y];

    /// The name of the quantity.
    pub fn name(self) -> &'static str {
        match self {
            OfLanding::Time => "landing.time",
            OfLanding::Speed => "landing.speed",
            OfLanding::Drift => "landing.drift",
            OfLanding::Heading => "landing.heading",
            OfLanding::X => "landing.x",
            OfLanding::Y => "landing.y",
        }
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            OfLanding::Time => "s",
            OfLanding::Speed => "m/s",
            OfLanding::Heading => "deg",
            OfLanding::Drift | OfLanding::X | OfLanding::Y => "m",
        }
    }
}

/// Why a text is no name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{name}\" is no quantity: expected GAUGE.COLUMN.STATISTIC with peak, peak_time, min, last, mean or steady, \
     GAUGE.COLUMN@TIME, or one of opening_load, displacement_end, max_displacement, max_speed, max_strain, max_stress, motion, \
     landing.time, landing.speed, landing.drift, landing.heading, landing.x, landing.y"
)]
pub struct NoQuantity {
    /// as it was written
    pub name: String,
}

impl FromStr for QuantityName {
    type Err = NoQuantity;

    fn from_str(text: &str) -> Result<Self, NoQuantity> {
        let text = text.trim();
        let wrong = || NoQuantity { name: text.to_owned() };
        let of_scene = OfScene::ALL.iter().find(|(word, _)| *word == text).map(|(_, of)| Named::Largest(*of));
        let of_landing = OfLanding::ALL.iter().find(|of| of.name() == text).map(|of| Named::Landing(*of));
        let names = match (text, of_scene.or(of_landing)) {
            ("motion", _) => Named::Motion,
            ("displacement_end", _) => Named::DisplacementEnd,
            ("opening_load", _) => Named::OpeningLoad,
            (_, Some(of)) => of,
            _ => {
                let (series, statistic) = match text.rsplit_once('@') {
                    Some((series, time)) => {
                        let time = time.trim().trim_end_matches('s').trim_end().parse().map_err(|_| wrong())?;
                        (series, Statistic::At(time))
                    }
                    None => {
                        let (series, word) = text.rsplit_once('.').ok_or_else(wrong)?;
                        let known = Statistic::WORDS.iter().find(|(known, _)| *known == word);
                        (series, known.ok_or_else(wrong)?.1)
                    }
                };
                let (gauge, column) = series.rsplit_once('.').ok_or_else(wrong)?;
                Named::Series { gauge: gauge.to_owned(), column: column.to_owned(), statistic }
            }
        };
        Ok(QuantityName { text: text.to_owned(), names })
    }
}

impl fmt::Display for QuantityName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl QuantityName {
    /// Whether it is the motion of all nodes, which is compared frame by frame.
    pub fn is_motion(&self) -> bool {
        self.names == Named::Motion
    }
}

/// Reads a list of names, each kept once.
///
/// # Errors
/// The first name that cannot be read.
pub fn read_names(names: &[String]) -> Result<Vec<QuantityName>, NoQuantity> {
    let mut once: Vec<QuantityName> = Vec::new();
    for name in names {
        let name: QuantityName = name.parse()?;
        if !once.contains(&name) {
            once.push(name);
        }
    }
    Ok(once)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read() {
        let series = |text: &str| match text.parse::<QuantityName>().map(|name| name.names) {
            Ok(Named::Series { gauge, column, statistic }) => Some((gauge, column, statistic)),
            _ => None,
        };
        let [riser, tip, line] =
            ["riser.tension.peak", "tip.z@0.5", "springs[5] lines.tension_max.peak_time"].map(series);
        assert_eq!(riser, Some(("riser".into(), "tension".into(), Statistic::Peak)));
        assert_eq!(tip, Some(("tip".into(), "z".into(), Statistic::At(0.5))));
        assert_eq!(line, Some(("springs[5] lines".into(), "tension_max".into(), Statistic::PeakTime)));
        assert_eq!("motion".parse::<QuantityName>().map(|name| name.is_motion()), Ok(true));
        let landing = "landing.x".parse::<QuantityName>().map(|name| name.names);
        assert_eq!(landing, Ok(Named::Landing(OfLanding::X)));
        for wrong in ["", "riser", "riser.peak", "riser.tension.top", "tip.z@soon", "Motion", "landing.z"] {
            assert!(wrong.parse::<QuantityName>().is_err(), "{wrong}");
        }
    }
}
