//! The options of `canopy-fem sweep` for values that are drawn from distributions.

use crate::study::StudyError;
use crate::study::sweep::sample::{Input, Rule, Sampled, Sampling, is_drawn};

/// How values are drawn.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Distributions")]
pub struct SampleArgs {
    /// Draw so many values from the distributions of --vary, in place of a grid; with --until, at most so many. Values
    /// of a list or a range are then equally likely
    #[arg(long, value_name = "N", conflicts_with_all = ["shard", "merge"],
          value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub samples: Option<u32>,
    /// How they are chosen
    #[arg(long, value_enum, default_value = "lhs", requires = "samples")]
    pub sampling: Sampling,
    /// Seed of the random numbers; a row follows from it and from its number
    #[arg(long, value_name = "N", default_value = "1", requires = "samples")]
    pub seed: u64,
    /// Stop after the batch of 64 rows after which a number is known: "2% of p99 COLUMN"; p99 may be another
    /// percentile, mean or sd. Shares make all rows, and --merge counts those that would have been made
    #[arg(long, value_name = "RULE", requires = "samples", conflicts_with = "indices")]
    pub until: Option<String>,
    /// Find first-order and total sensitivity indices by Saltelli's design: N (keys + 2) runs. Without it, first-order
    /// indices come from the rows as they are
    #[arg(long, requires = "samples")]
    pub indices: bool,
    /// Two columns whose ellipse is drawn [default: landing.x,landing.y, where runs land]
    #[arg(long, value_name = "X,Y", requires = "samples", value_delimiter = ',', num_args = 1)]
    pub ellipse: Vec<String>,
    /// Leave out the runs at the medians with other steps and meshes, whose errors are compared with the scatter
    #[arg(long, requires = "samples")]
    pub no_errors: bool,
}

impl SampleArgs {
    /// What is drawn; `None` for a grid.
    pub(super) fn sampled(&self, vary: &[String]) -> Result<Option<Sampled>, StudyError> {
        let Some(samples) = self.samples else {
            return match vary.iter().find(|text| is_drawn(text)) {
                Some(text) => Err(StudyError::Usage(format!("--vary {text}: how many values? Give --samples N"))),
                None => Ok(None),
            };
        };
        let ellipse = match self.ellipse.as_slice() {
            [] => None,
            [x, y] => Some([x.trim().to_owned(), y.trim().to_owned()]),
            _ => return Err(StudyError::Usage("--ellipse: expected two columns, X,Y".to_owned())),
        };
        Ok(Some(Sampled {
            inputs: Input::parse_all(vary)?,
            samples: samples as usize,
            sampling: self.sampling,
            seed: self.seed,
            indices: self.indices,
            until: self.until.as_deref().map(Rule::parse).transpose()?,
            ellipse,
        }))
    }
}
