//! Saving a plot: SVG, PNG and CSV, all or none of them half-written, the same bytes every time.

use super::error::FigureError;
use super::raster::{Raster, canvas, encoded};
use super::style;
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::prelude::SVGBackend;
use plotters::style::WHITE;
use plotters_backend::DrawingBackend;
use std::ffi::OsString;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use tempfile::{Builder, NamedTempFile};

/// What a plot is drawn on.
pub type Area<DB> = DrawingArea<DB, Shift>;

/// Drawn, or what a back-end says when it cannot draw.
pub type Painted<DB> = Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

/// The numbers a plot shows: a header and rows of the same length.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// Names of the columns, units among them or in a column of their own.
    pub header: Vec<&'static str>,
    /// Numbers in the shortest form that reads back to the same `f64`.
    pub rows: Vec<Vec<String>>,
}

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

/// Writes `path.svg`, `path.png` and `path.csv`, making the folder if need be, and returns the three paths.
///
/// # After the call
/// Either all three files are new, or an error is returned and no half-written file is left. Files are written beside their
/// place and renamed; should a rename fail after another succeeded, the files are whole but of two ages.
///
/// # Errors
/// [`FigureError::Folder`], [`FigureError::DiskFull`], [`FigureError::Write`], [`FigureError::Draw`].
pub fn save(plot: &impl Plot, path_without_extension: &Path) -> Result<Vec<PathBuf>, FigureError> {
    let files = [("svg", svg(plot)?), ("png", png(plot)?), ("csv", csv(&plot.csv())?)];
    let folder = match path_without_extension.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let in_folder = |source| FigureError::Folder { path: folder.to_owned(), source };
    fs::create_dir_all(folder).map_err(in_folder)?;
    let mut written: Vec<(NamedTempFile, PathBuf, usize)> = Vec::new();
    for (extension, bytes) in &files {
        let path = with(path_without_extension, extension);
        let mut file = temporary(folder).map_err(in_folder)?;
        file.write_all(bytes)
            .and_then(|()| file.as_file().sync_all())
            .map_err(|source| FigureError::write(&path, bytes.len(), source))?;
        written.push((file, path, bytes.len()));
    }
    written
        .into_iter()
        .map(|(file, path, bytes)| match file.persist(&path) {
            Ok(_) => Ok(path),
            Err(failed) => Err(FigureError::write(&path, bytes, failed.error)),
        })
        .collect()
}

/// `path.extension`; a point in the name stays.
fn with(path: &Path, extension: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(".");
    name.push(extension);
    name.into()
}

/// A file in `folder` that goes away unless it is kept, with the rights of an ordinary new file.
fn temporary(folder: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = Builder::new();
    builder.prefix(".figure-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666)); // the umask takes its share
        builder.tempfile_in(folder)
    }
    #[cfg(not(unix))]
    builder.tempfile_in(folder)
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

pub(super) fn svg(plot: &impl Plot) -> Result<Vec<u8>, FigureError> {
    let mut text = String::new();
    paint(plot, SVGBackend::with_string(&mut text, plot.size()))?;
    Ok(text.into_bytes())
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

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn saving_twice_gives_the_same_bytes_and_three_files() {
        let folder = tempfile::tempdir().unwrap();
        let read = |name: &str| -> Vec<Vec<u8>> {
            let paths = save(&Dot, &folder.path().join("new").join(name)).unwrap();
            paths.iter().map(|path| fs::read(path).unwrap()).collect()
        };
        assert_eq!(read("v1.0"), read("v1.1"));
        assert_eq!(read("v1.0")[2], b"x,y\n1,0.1\n");
        let expected = ["v1.0.csv", "v1.0.png", "v1.0.svg", "v1.1.csv", "v1.1.png", "v1.1.svg"];
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
        let error = save(&Dot, &file.join("plot")).unwrap_err();
        assert!(matches!(&error, FigureError::Folder { path, .. } if path == &file), "{error:?}");
        assert_eq!(names(folder.path()), ["file"]);
    }

    #[test]
    fn a_target_that_is_a_folder_is_an_error_without_remains() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("plot.svg")).unwrap();
        let error = save(&Dot, &folder.path().join("plot")).unwrap_err();
        assert!(matches!(error, FigureError::Write { .. }), "{error:?}");
        assert_eq!(names(folder.path()), ["plot.svg"]);
    }
}
