//! A data set on disk: which frames it has, and their files.

use std::path::{Path, PathBuf};

use super::DatasetError;
use super::files::{self, FrameState};
use super::matrices::Matrices;
use crate::output::{NumberedPath, OutputError, Picture};
use crate::renderer::DenoiserFrame;

/// Which files of a data set are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Layout {
    /// The inputs of the renderer's own denoiser, bit for bit: live{f}.exr of render --dataset.
    Live,
    /// The light apart, of which indirect light is denoised: indirect{f}.exr and the others of dataset.
    Parts,
    /// All light, demodulated by the albedo: color{f}.exr and the others of BMFR's data set, whose frames tell no motion of objects.
    Bmfr,
}

impl Layout {
    /// In the order of preference.
    const ALL: [Self; 3] = [Self::Live, Self::Parts, Self::Bmfr];

    /// The files of each frame, name and ending, the one first that tells the layout.
    fn files(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Live => &[("live", "exr"), ("frame", "json")],
            Self::Parts => &[
                ("indirect", "exr"),
                ("direct", "exr"),
                ("reflected", "exr"),
                ("diffuse", "exr"),
                ("roughness", "exr"),
                ("shading_normal", "exr"),
                ("world_position", "exr"),
                ("instance", "exr"),
                ("motion", "exr"),
                ("frame", "json"),
            ],
            Self::Bmfr => {
                &[("color", "exr"), ("albedo", "exr"), ("shading_normal", "exr"), ("world_position", "exr")]
            }
        }
    }
}

/// The frames of a data set.
#[derive(Clone, Debug)]
pub struct DatasetFrames {
    pub(super) folder: PathBuf,
    layout: Layout,
    frames: u32,
    pub(super) size: [usize; 2],
    /// Matrices of BMFR's layout.
    pub(super) matrices: Option<Matrices>,
    has_references: bool,
}

impl DatasetFrames {
    /// Looks what a folder holds. Without a `layout` it is the first of [`Layout`] whose files are there.
    ///
    /// # Errors
    /// If it is no data set, or a file lacks.
    pub fn open(folder: &Path, layout: Option<Layout>) -> Result<Self, DatasetError> {
        if !folder.is_dir() {
            return Err(DatasetError::of(folder, "there is no such folder; give that of a data set"));
        }
        let present = |(name, ending): &(&str, &str)| on_disk(folder, name, ending);
        let mut layouts = layout.map_or(Layout::ALL.to_vec(), |layout| vec![layout]);
        let mut found = None;
        for layout in layouts.drain(..) {
            if !present(&layout.files()[0])?.is_empty() {
                found = Some(layout);
                break;
            }
        }
        let Some(found) = found else {
            let lacks = layout.map_or_else(
                || "is no data set: it has no live0.exr, indirect0.exr or color0.exr".to_owned(),
                |layout| format!("has no {}0.exr", layout.files()[0].0),
            );
            let what_to_do = "glowworm dataset and glowworm render --dataset write data sets";
            return Err(DatasetError::of(folder, format!("{lacks}; {what_to_do}")));
        };
        let frames = frames_of(folder, found.files())?;
        let references = on_disk(folder, "reference", "exr")?;
        if !references.is_empty() {
            let complete = (0..frames).find(|frame| !references.contains(frame));
            complete.map_or(Ok(()), |lacking| {
                Err(missing(folder, ("reference", "exr"), lacking, ("reference", "exr"), references[0]))
            })?;
        }
        let matrices = if found == Layout::Bmfr { Some(Matrices::read(folder, frames)?) } else { None };
        let first = Picture::read_exr(&files::path_of(folder, found.files()[0].0, 0, "exr"))?;
        Ok(Self {
            folder: folder.to_owned(),
            layout: found,
            frames,
            size: [first.width, first.height],
            matrices,
            has_references: !references.is_empty(),
        })
    }

    /// The layout of the files.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// How many frames it has, from 0 on.
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// Width and height of all pictures, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size.map(|side| u32::try_from(side).unwrap_or(u32::MAX))
    }

    /// Reads what a denoiser is given in a frame.
    ///
    /// # Errors
    /// If a file cannot be read, or does not fit the others.
    pub fn frame(&self, frame: u32) -> Result<DenoiserFrame, DatasetError> {
        match self.layout {
            Layout::Live => self.live(frame),
            Layout::Parts => self.parts(frame),
            Layout::Bmfr => self.bmfr(frame),
        }
    }

    /// The file with the reference of a frame; none where the data set has no references.
    pub fn reference(&self, frame: u32) -> Option<PathBuf> {
        self.has_references.then(|| files::path_of(&self.folder, "reference", frame, "exr"))
    }

    /// Reads a picture, which has the size of all.
    pub(super) fn picture(&self, name: &str, frame: u32) -> Result<(PathBuf, Picture), DatasetError> {
        let path = files::path_of(&self.folder, name, frame, "exr");
        let picture = Picture::read_exr(&path)?;
        self.check_size(&path, [picture.width, picture.height])?;
        Ok((path, picture))
    }

    /// Reads the colours of a picture.
    pub(super) fn rgb(&self, name: &str, frame: u32) -> Result<Vec<[f32; 3]>, DatasetError> {
        let (path, picture) = self.picture(name, frame)?;
        if picture.colour.len() != picture.width * picture.height {
            return Err(DatasetError::of(&path, "has no channels R, G and B; write the file anew"));
        }
        Ok(picture.colour)
    }

    /// Reads where everything stands.
    pub(super) fn state(&self, frame: u32) -> Result<FrameState, DatasetError> {
        let path = files::path_of(&self.folder, "frame", frame, "json");
        let text = std::fs::read(&path).map_err(|source| OutputError::Read { path: path.clone(), source })?;
        let state: FrameState = serde_json::from_slice(&text).map_err(|why| {
            DatasetError::of(
                &path,
                format!("does not tell where everything stands ({why}); write the data set anew"),
            )
        })?;
        self.check_size(&path, state.size.map(|side| side as usize))?;
        Ok(state)
    }

    fn check_size(&self, path: &Path, size: [usize; 2]) -> Result<(), DatasetError> {
        let ([width, height], [all_width, all_height]) = (size, self.size);
        if size == self.size {
            return Ok(());
        }
        let (first, _) = self.layout.files()[0];
        Err(DatasetError::of(
            path,
            format!(
                "is of {width}x{height} pixels, but {first}0.exr is of {all_width}x{all_height}; all files of a data set have one size"
            ),
        ))
    }
}

/// The frames of which a folder has a file, in ascending order.
fn on_disk(folder: &Path, name: &str, ending: &str) -> Result<Vec<u32>, DatasetError> {
    let named = NumberedPath::new(folder.join(format!("{name}{{frame}}.{ending}")))?;
    let frames =
        named.frames_on_disk().map_err(|source| OutputError::Read { path: folder.to_owned(), source })?;
    Ok(frames.into_iter().filter_map(|frame| u32::try_from(frame).ok()).collect())
}

/// How many frames a folder has of which it has all files.
fn frames_of(folder: &Path, files: &[(&'static str, &'static str)]) -> Result<u32, DatasetError> {
    let present = files.iter().map(|(name, ending)| on_disk(folder, name, ending));
    let present = present.collect::<Result<Vec<_>, _>>()?;
    let Some(last) = present.iter().filter_map(|frames| frames.last().copied()).max() else { return Ok(0) };
    let has_last = files.iter().zip(&present).find(|(_, frames)| frames.last() == Some(&last));
    let there = has_last.map_or(files[0], |(file, _)| *file);
    for (file, frames) in files.iter().zip(&present) {
        // They are in order, so the first that is not at its place tells the gap.
        let gap = (0..=last).find(|&frame| frames.get(frame as usize) != Some(&frame));
        if let Some(lacking) = gap {
            return Err(missing(folder, *file, lacking, there, last));
        }
    }
    Ok(last + 1)
}

fn missing(folder: &Path, file: (&str, &str), frame: u32, there: (&str, &str), last: u32) -> DatasetError {
    let there = format!("{}{last}.{}", there.0, there.1);
    let path = files::path_of(folder, file.0, frame, file.1);
    DatasetError::of(
        &path,
        format!("is missing, but there is {there}; a data set has all files of each frame, from 0 on"),
    )
}
