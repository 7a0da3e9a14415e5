//! Saving a plot: SVG, PDF, PNG and CSV, all or none of them half-written, the same bytes every time.

use super::error::FigureError;
use super::pdf::Page;
use super::raster::{Raster, canvas, encoded};
use super::style;
use dpn_io::{ResultPath, write_file};
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::prelude::SVGBackend;
use plotters::style::WHITE;
use plotters_backend::DrawingBackend;

/// What a plot is drawn on.
pub(crate) type Area<DB> = DrawingArea<DB, Shift>;

/// Drawn, or what a back-end says when it cannot draw.
pub(crate) type Painted<DB> = Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

/// The numbers a plot shows: a header and rows of the same length.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// Names of the columns, units among them or in a column of their own.
    pub header: Vec<&'static str>,
    /// Numbers in the shortest form that reads back to the same `f64`.
    pub rows: Vec<Vec<String>>,
}

/// A row of [`Drawn`]: every value as `to_string` writes it.
macro_rules! row {
    ($($value:expr),+ $(,)?) => {
        vec![$($value.to_string()),+]
    };
}
pub(super) use row;

/// Something to look at.
pub trait Plot {
    /// Width and height in pixels of the drawing.
    fn size(&self) -> (u32, u32);

    /// Draws onto an area of [`Plot::size`].
    ///
    /// # Errors
    /// Those of the back-end.
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Painted<DB>;

    /// The numbers that are drawn.
    fn csv(&self) -> Drawn;
}

/// Endings of the files that [`save`] writes, in its order.
pub const ENDINGS: [&str; 4] = ["svg", "pdf", "png", "csv"];

/// Writes `path` with each of [`ENDINGS`], making the folder if need be, and returns the paths.
///
/// # After the call
/// Each file is new and whole, or as it was. All are made before the first is written; should writing fail midway, the files are of
/// two ages.
///
/// # Errors
/// [`FigureError::Write`], [`FigureError::Draw`].
pub fn save(
    plot: &impl Plot,
    path_without_extension: impl Into<ResultPath>,
) -> Result<Vec<ResultPath>, FigureError> {
    let path = path_without_extension.into();
    let files = [svg(plot)?, pdf(plot)?, png(plot)?, csv(&plot.csv())?];
    ENDINGS
        .into_iter()
        .zip(files)
        .map(|(extension, bytes)| {
            let path = path.with_ending(extension);
            write_file(&path, &bytes)?;
            Ok(path)
        })
        .collect()
}

/// The plot, where there is something to draw.
///
/// # Errors
/// Any fault but [`FigureError::Empty`].
pub fn if_any<P>(plot: Result<P, FigureError>) -> Result<Option<P>, FigureError> {
    match plot {
        Err(FigureError::Empty { .. }) => Ok(None),
        plot => plot.map(Some),
    }
}

/// [`save`], where there is something to draw: no files of a figure that is [`FigureError::Empty`].
///
/// # Errors
/// As [`save`], and any other fault of `plot`.
pub fn save_if_any(
    plot: Result<impl Plot, FigureError>,
    path_without_extension: impl Into<ResultPath>,
) -> Result<Vec<ResultPath>, FigureError> {
    if_any(plot)?.map_or_else(|| Ok(Vec::new()), |plot| save(&plot, path_without_extension))
}

/// The plot on white paper.
fn paint<DB: DrawingBackend>(plot: &impl Plot, back_end: DB) -> Result<(), FigureError> {
    style::prepare()?;
    let area = back_end.into_drawing_area();
    area.fill(&WHITE)
        .and_then(|()| plot.draw(&area))
        .and_then(|()| area.present())
        .map_err(|error| FigureError::Draw { reason: error.to_string() })
}

/// The plot as an SVG file, text as text.
///
/// # Errors
/// [`FigureError::Draw`].
pub fn svg(plot: &impl Plot) -> Result<Vec<u8>, FigureError> {
    let mut text = String::new();
    paint(plot, SVGBackend::with_string(&mut text, plot.size()))?;
    Ok(text.into_bytes())
}

fn pdf(plot: &impl Plot) -> Result<Vec<u8>, FigureError> {
    let mut page = Page::new(plot.size());
    paint(plot, page.back_end())?;
    page.finish()
}

fn png(plot: &impl Plot) -> Result<Vec<u8>, FigureError> {
    let size = plot.size();
    let mut memory = canvas(size);
    paint(plot, Raster::new(&mut memory, size))?;
    encoded(&memory, size, png::Compression::High)
}

fn csv(drawn: &Drawn) -> Result<Vec<u8>, FigureError> {
    let reason = |reason: String| FigureError::Draw { reason };
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer
        .write_record(&drawn.header)
        .and_then(|()| drawn.rows.iter().try_for_each(|row| writer.write_record(row)))
        .map_err(|error| reason(error.to_string()))?;
    writer.into_inner().map_err(|error| reason(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::style::Anchor;
    use std::fs;

    struct Dot;

    impl Plot for Dot {
        fn size(&self) -> (u32, u32) {
            (120, 60)
        }

        fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Painted<DB> {
            area.draw_text("σ [m/s²]", &style::text(20.0, style::INK, Anchor::Centre), (60, 30))
        }

        fn csv(&self) -> Drawn {
            Drawn { header: vec!["x", "y"], rows: vec![vec!["1".into(), "0.1".into()]] }
        }
    }

    fn names(folder: &std::path::Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn saving_twice_gives_the_same_bytes_and_four_files() {
        let folder = tempfile::tempdir().unwrap();
        let read = |name: &str| -> Vec<Vec<u8>> {
            let paths = save(&Dot, folder.path().join("new").join(name)).unwrap();
            paths.iter().map(|path| path.read_existing().unwrap()).collect()
        };
        assert_eq!(read("v1.0"), read("v1.1"));
        assert_eq!(read("v1.0")[3], b"x,y\n1,0.1\n");
        let expected: Vec<String> = ["v1.0", "v1.1"]
            .iter()
            .flat_map(|stem| ["csv", "pdf", "png", "svg"].map(|ending| format!("{stem}.{ending}")))
            .collect();
        assert_eq!(names(&folder.path().join("new")), expected);
    }

    #[test]
    fn the_png_holds_the_letters() {
        let mut pixels = Vec::new();
        let bytes = png(&Dot).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        pixels.resize(reader.output_buffer_size().unwrap(), 0);
        reader.next_frame(&mut pixels).unwrap();
        let dark = pixels.chunks(3).filter(|p| p[0] < 128).count();
        // "σ [m/s²]" at 20 px covers some 500 of the 7200 pixels' area; tofu or nothing would not.
        assert!((200..900).contains(&dark), "{dark}");
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_named_and_nothing_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "in the way").unwrap();
        let error = save(&Dot, file.join("plot")).unwrap_err();
        assert!(matches!(&error, FigureError::Write(_)), "{error:?}");
        let cause = std::error::Error::source(&error).unwrap().to_string();
        assert!(cause.contains(&file.display().to_string()), "{cause}");
        assert_eq!(names(folder.path()), ["file"]);
    }

    #[test]
    fn a_target_that_is_a_folder_is_an_error_without_remains() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("plot.svg")).unwrap();
        let error = save(&Dot, folder.path().join("plot")).unwrap_err();
        assert!(matches!(error, FigureError::Write(_)), "{error:?}");
        assert_eq!(names(folder.path()), ["plot.svg"]);
    }
}
