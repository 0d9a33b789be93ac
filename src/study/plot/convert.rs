//! SVG pictures in other formats, in a program that was built with the feature `pictures`: its crates take two minutes
//! of processor time to compile. Texts are in DejaVu Sans, which is part of such a program, so that pictures are the
//! same on all machines.

use super::PlotError;
use std::borrow::Cow;

/// A file format of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// lines and texts, for browsers
    Svg,
    /// pixels, for texts and slides
    Png,
    /// lines and texts, for print and LaTeX
    Pdf,
}

impl Format {
    /// The ending of its files.
    pub fn ending(self) -> &'static str {
        match self {
            Format::Svg => "svg",
            Format::Png => "png",
            Format::Pdf => "pdf",
        }
    }

    /// Refuses a format that this program does not have.
    ///
    /// # Errors
    /// The program was built without it.
    pub fn check(self) -> Result<(), PlotError> {
        let there = self == Format::Svg || cfg!(feature = "pictures");
        if there { Ok(()) } else { Err(PlotError::NoFormat(self.ending())) }
    }
}

/// An SVG picture in a format, with `scale` pixels of a PNG for each of its own.
///
/// # Errors
/// The program was built without the format, or the picture is too large for it.
#[cfg_attr(not(feature = "pictures"), expect(unused_variables))]
pub fn convert(svg: &str, format: Format, scale: f32) -> Result<Cow<'_, [u8]>, PlotError> {
    match format {
        Format::Svg => Ok(Cow::Borrowed(svg.as_bytes())),
        #[cfg(feature = "pictures")]
        Format::Png => pictures::png(svg, scale).map(Cow::Owned),
        #[cfg(feature = "pictures")]
        Format::Pdf => pictures::pdf(svg).map(Cow::Owned),
        #[cfg(not(feature = "pictures"))]
        Format::Png | Format::Pdf => Err(PlotError::NoFormat(format.ending())),
    }
}

#[cfg(feature = "pictures")]
mod pictures {
    use super::PlotError;
    use resvg::tiny_skia::{Pixmap, Transform};
    use resvg::usvg::{Options, Tree, fontdb};
    use std::sync::Arc;
    use svg2pdf::{ConversionOptions, PageOptions, to_pdf};

    pub(super) fn png(svg: &str, scale: f32) -> Result<Vec<u8>, PlotError> {
        let tree = tree(svg, "PNG")?;
        let [width, height] = [tree.size().width(), tree.size().height()].map(|length| (length * scale).ceil());
        let too_large = || format!("{width} by {height} pixels are too many; take a smaller --scale");
        let mut pixels = Pixmap::new(width as u32, height as u32).ok_or_else(|| fault("PNG", too_large()))?;
        resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
        pixels.encode_png().map_err(|error| fault("PNG", error.to_string()))
    }

    pub(super) fn pdf(svg: &str) -> Result<Vec<u8>, PlotError> {
        // A pixel of CSS is 1/96 inch.
        let page = PageOptions { dpi: 96.0 };
        to_pdf(&tree(svg, "PDF")?, ConversionOptions::default(), page).map_err(|error| fault("PDF", error.to_string()))
    }

    /// The picture with its texts set. Fonts of the system are not asked for, as they differ between machines.
    fn tree(svg: &str, format: &'static str) -> Result<Tree, PlotError> {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_source(fontdb::Source::Binary(Arc::new(dejavu::sans::regular())));
        fonts.set_sans_serif_family("DejaVu Sans");
        let options = Options { fontdb: Arc::new(fonts), ..Options::default() };
        Tree::from_str(svg, &options).map_err(|error| fault(format, error.to_string()))
    }

    fn fault(format: &'static str, what: String) -> PlotError {
        PlotError::Convert { format, what }
    }
}
