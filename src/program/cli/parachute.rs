//! The options of `canopy-fem mesh parachute`: the parameters of `mesh.parachute`.

use super::mesh_output::OutputArgs;
use crate::mesh::parachute::{
    CanopyType, ClusterParameters, InnerLineParameters, ParachuteParameters, PayloadParameters, ReefingParameters,
    RigLineParameters, Start, StartShape,
};
use clap::Args;

/// Arguments of `mesh parachute`; the parameters are those of `mesh.parachute` in a case file.
#[derive(Clone, Debug, Args)]
pub struct ParachuteArgs {
    /// flat-circular, conical, biconical, triconical, hemispherical, extended-skirt, annular, cruciform, ringslot,
    /// ribbon, ringsail, disk-gap-band, elliptical, toroidal, square or triangular
    #[arg(long = "type", value_parser = word::<CanopyType>)]
    pub kind: CanopyType,
    /// [m] Nominal diameter D0; it or the constructed one is needed
    #[arg(long)]
    pub nominal_diameter: Option<f64>,
    /// [m] Constructed diameter: that of the skirt as it is cut, from which D0 follows
    #[arg(long)]
    pub constructed_diameter: Option<f64>,
    /// Number of gores and of lines
    #[arg(long)]
    pub gores: usize,
    /// [m] Diameter of the circle through the vent's corners
    #[arg(long)]
    pub vent_diameter: Option<f64>,
    /// Rows of cloth from the vent to the skirt
    #[arg(long)]
    pub radial_segments: usize,
    /// Edges across a gore
    #[arg(long, default_value_t = 1)]
    pub gore_segments: usize,
    /// Fewer edges in rows towards the apex; an edge of radials or vent lines may then stand for several
    #[arg(long)]
    pub coarsen: bool,
    /// [rad] Angle of a cone's surface below the horizontal
    #[arg(long)]
    pub cone_angle: Option<f64>,
    /// [rad] Angles of two or three cones, from the apex outwards
    #[arg(long, num_args = 2..=3)]
    pub cone_angles: Option<Vec<f64>>,
    /// Where the cone angle changes, as parts of the gore's length
    #[arg(long, num_args = 1..=2)]
    pub cone_breaks: Option<Vec<f64>>,
    /// Length of an extended skirt over the diameter of the flat part
    #[arg(long)]
    pub skirt_extension: Option<f64>,
    /// [rad] Angle of an extended skirt below the horizontal: pi/2 a cylinder, less a growing cone, more drawn in
    #[arg(long)]
    pub skirt_angle: Option<f64>,
    /// Width over length of the strips of a cruciform canopy
    #[arg(long)]
    pub arm_ratio: Option<f64>,
    /// Number of rings of a ringslot canopy or a ringsail, of ribbons of a ribbon canopy
    #[arg(long)]
    pub rings: Option<usize>,
    /// Area of the slots between these over the nominal area
    #[arg(long)]
    pub slot_porosity: Option<f64>,
    /// Number of tapes across the ribbons in each gore
    #[arg(long)]
    pub verticals: Option<usize>,
    /// Number of the rings of a ringsail that are sails
    #[arg(long)]
    pub sails: Option<usize>,
    /// Length of a sail's lower edge over the width of the gore there, less 1
    #[arg(long)]
    pub fullness: Option<f64>,
    /// [rad] Part of the sphere on which a ringsail is cut; pi/3 if absent
    #[arg(long)]
    pub cap_angle: Option<f64>,
    /// Height of an elliptical or toroidal canopy's crest above the skirt over the skirt's radius
    #[arg(long)]
    pub height_ratio: Option<f64>,
    /// Depth of a toroidal canopy's vent below the crest over that of the skirt; 1 if absent
    #[arg(long)]
    pub pull_down: Option<f64>,
    /// Part of a side at which a square's or triangle's corners are cut off
    #[arg(long)]
    pub corner_cut: Option<f64>,
    /// Diameter of the disc of a disk-gap-band canopy over D0
    #[arg(long)]
    pub disk: Option<f64>,
    /// Height of its gap over D0
    #[arg(long)]
    pub gap: Option<f64>,
    /// Height of its band over D0
    #[arg(long)]
    pub band: Option<f64>,
    /// Whether lines cross the vent
    #[arg(long)]
    pub vent_lines: Option<bool>,
    /// [m] Length of the suspension lines
    #[arg(long)]
    pub lines: Option<f64>,
    /// Edges of each suspension line
    #[arg(long, default_value_t = 1, requires = "lines")]
    pub line_segments: usize,
    /// Edges of each line from the vent to the confluence; without it there are none
    #[arg(long, requires = "lines")]
    pub inner_line_segments: Option<usize>,
    /// [m] Length of each of these lines; that of the suspension lines if absent
    #[arg(long, requires = "inner_line_segments")]
    pub inner_line_length: Option<f64>,
    /// [m] Length of a line from the confluence to the apex, which pulls it down
    #[arg(long, requires = "lines")]
    pub centre_line: Option<f64>,
    /// Edges of this line
    #[arg(long, default_value_t = 1, requires = "centre_line")]
    pub centre_line_segments: usize,
    /// [m] Length of the riser
    #[arg(long)]
    pub riser: Option<f64>,
    /// Edges of the riser
    #[arg(long, default_value_t = 1, requires = "riser")]
    pub riser_segments: usize,
    /// [m] Edges of a rigid payload, a box of even density
    #[arg(long, num_args = 3, value_names = ["X", "Y", "Z"], requires = "payload_below_riser")]
    pub payload_box: Option<Vec<f64>>,
    /// [m] Radii of gyration of a rigid payload
    #[arg(long, num_args = 3, value_names = ["X", "Y", "Z"], requires = "payload_below_riser")]
    pub payload_radii_of_gyration: Option<Vec<f64>>,
    /// [m] Distance from the end of the riser down to the centre of a rigid payload
    #[arg(long)]
    pub payload_below_riser: Option<f64>,
    /// Number of such parachutes on one payload
    #[arg(long)]
    pub canopies: Option<usize>,
    /// [m] Length of a reefing line over pi
    #[arg(long)]
    pub reefing_diameter: Option<f64>,
    /// Direction from the payload to the apex
    #[arg(long, num_args = 3, value_names = ["X", "Y", "Z"], allow_negative_numbers = true)]
    pub axis: Option<Vec<f64>>,
    /// [m] Place of the payload
    #[arg(long, num_args = 3, value_names = ["X", "Y", "Z"], allow_negative_numbers = true)]
    pub at: Option<Vec<f64>>,
    /// flat, inflated, stretched or packed; with sizes as in a case: '{"packed": {"length": 0.6, "bag": true}}'
    #[arg(long, default_value = "flat", value_parser = start)]
    pub start: Start,
    /// Radius of the skirt over D0 at the start "stretched"; 0.025 if absent
    #[arg(long, allow_negative_numbers = true)]
    pub start_radius: Option<f64>,
    /// the output
    #[command(flatten)]
    pub output: OutputArgs,
}

/// A word of the case file.
fn word<T: serde::de::DeserializeOwned>(word: &str) -> Result<T, String> {
    serde_json::from_value(serde_json::Value::from(word)).map_err(|error| error.to_string())
}

/// A start as in a case file: a word, or an object with sizes.
fn start(text: &str) -> Result<Start, String> {
    if !text.trim_start().starts_with('{') {
        return word::<StartShape>(text).map(Start::Shape);
    }
    serde_json::from_str(text).map(Start::Sized).map_err(|error| error.to_string())
}

impl ParachuteArgs {
    pub(super) fn parameters(&self) -> ParachuteParameters {
        let three = |list: &Option<Vec<f64>>| list.as_deref().and_then(|list| <[f64; 3]>::try_from(list).ok());
        let line = |length: Option<f64>, segments| {
            length.is_some().then_some(RigLineParameters { length, segments, material: None })
        };
        ParachuteParameters {
            kind: self.kind,
            nominal_diameter: self.nominal_diameter,
            constructed_diameter: self.constructed_diameter,
            cloth: None,
            tapes: None,
            gores: self.gores,
            vent_diameter: self.vent_diameter,
            radial_segments: self.radial_segments,
            gore_segments: self.gore_segments,
            coarsen: self.coarsen,
            cone_angle: self.cone_angle,
            cone_angles: self.cone_angles.clone(),
            cone_breaks: self.cone_breaks.clone(),
            skirt_extension: self.skirt_extension,
            skirt_angle: self.skirt_angle,
            arm_ratio: self.arm_ratio,
            rings: self.rings,
            slot_porosity: self.slot_porosity,
            verticals: self.verticals,
            sails: self.sails,
            fullness: self.fullness,
            cap_angle: self.cap_angle,
            height_ratio: self.height_ratio,
            pull_down: self.pull_down,
            corner_cut: self.corner_cut,
            centre_line: line(self.centre_line, self.centre_line_segments),
            disk: self.disk,
            gap: self.gap,
            band: self.band,
            vent_lines: self.vent_lines,
            lines: line(self.lines, self.line_segments),
            inner_lines: self.inner_line_segments.map(|segments| InnerLineParameters {
                length: self.inner_line_length,
                segments,
                material: None,
            }),
            riser: line(self.riser, self.riser_segments),
            payload: self.payload_below_riser.map(|below_riser| PayloadParameters {
                sides: three(&self.payload_box),
                radii_of_gyration: three(&self.payload_radii_of_gyration),
                below_riser,
            }),
            cluster: self.canopies.map(|canopies| ClusterParameters { canopies }),
            reefing: self.reefing_diameter.map(|diameter| ReefingParameters { diameter }),
            start: self.start,
            start_radius: self.start_radius,
            axis: three(&self.axis),
            at: three(&self.at),
        }
    }
}
