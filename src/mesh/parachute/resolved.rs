//! The parameters with what follows from others filled in: D0 from a constructed diameter, the lines by the type.

use super::parts::LineParameters;
use super::{MOST_VENT, ParachuteParameters};
use crate::MeshError;
use std::borrow::Cow;

/// [-] relative error at which a constructed diameter counts as met
const SIZE_TOLERANCE: f64 = 1e-14;
/// [-] most patterns that are cut to meet it; the size of most is found by the second
const MOST_PATTERNS: usize = 100;

impl ParachuteParameters {
    /// [m] D0; not a number before [`ParachuteParameters::resolved`], if it is not given
    pub(super) fn d0(&self) -> f64 {
        self.nominal_diameter.unwrap_or(f64::NAN)
    }

    /// The suspension lines.
    pub(super) fn lines(&self) -> Option<LineParameters> {
        self.lines.as_ref()?.known()
    }

    /// The riser.
    pub(super) fn riser(&self) -> Option<LineParameters> {
        self.riser.as_ref()?.known()
    }

    /// The centre line.
    pub(super) fn centre(&self) -> Option<LineParameters> {
        self.centre_line.as_ref()?.known()
    }

    /// The same parachute with `nominal_diameter` in place of `constructed_diameter`, and with a length of its lines;
    /// the parameters must have passed [`ParachuteParameters::check`].
    ///
    /// # Errors
    /// A pattern that cannot be cut, such as one with too large a vent.
    pub fn resolved(&self) -> Result<Cow<'_, Self>, MeshError> {
        let bare = self.lines.as_ref().is_some_and(|lines| lines.length.is_none());
        if self.constructed_diameter.is_none() && !bare {
            return Ok(Cow::Borrowed(self));
        }
        let mut whole = self.clone();
        if let Some(wanted) = whole.constructed_diameter.take() {
            whole.nominal_diameter = Some(self.nominal_of(wanted)?);
        }
        let d0 = whole.d0();
        if let (Some(lines), Some(ratio)) = (&mut whole.lines, self.kind.numbers().line_length) {
            lines.length.get_or_insert(ratio * d0);
        }
        Ok(Cow::Owned(whole))
    }

    /// [m] The D0 whose pattern has this constructed diameter.
    fn nominal_of(&self, wanted: f64) -> Result<f64, MeshError> {
        let mut pattern = Self { constructed_diameter: None, ..self.clone() };
        // With its vent of a given size, a pattern is nearly as wide as D0 is large.
        let mut d0 = wanted.max(self.vent_diameter.unwrap_or(0.0) / MOST_VENT.sqrt());
        for _ in 0..MOST_PATTERNS {
            pattern.nominal_diameter = Some(d0);
            let found = pattern.sizes_of_pattern()?.constructed_diameter;
            d0 *= wanted / found;
            if (found / wanted - 1.0).abs() < SIZE_TOLERANCE {
                break;
            }
        }
        if self.vent_diameter.is_some_and(|vent| vent > d0 * MOST_VENT.sqrt()) {
            return Err(MeshError::Parameter {
                pointer: "/parachute/vent_diameter".to_owned(),
                value: self.vent_diameter.unwrap_or_default().to_string(),
                allowed: format!("at most {:.6}, half of the nominal area", d0 * MOST_VENT.sqrt()),
                hint: "the canopy would be more vent than cloth; make the vent smaller".to_owned(),
            });
        }
        Ok(d0)
    }
}

impl ParachuteParameters {
    /// The same parachute without the names of materials, which its mesh does not depend on.
    #[must_use]
    pub fn without_materials(&self) -> Self {
        let mut bare = Self { cloth: None, tapes: None, ..self.clone() };
        for line in [&mut bare.lines, &mut bare.riser, &mut bare.centre_line].into_iter().flatten() {
            line.material = None;
        }
        bare.inner_lines.iter_mut().for_each(|lines| lines.material = None);
        bare
    }
}
