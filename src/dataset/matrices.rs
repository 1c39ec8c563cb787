//! `camera_matrices.h`: the cameras of all frames, as C, as BMFR's programs include it.
//!
//! For a row vector p = (position, 1), p times `camera_matrices[f]` is the point in clip space.

use std::fmt::Write as _;
use std::path::Path;

use glam::{Mat3, Mat4, Vec2, Vec3};

use super::{DatasetError, MATRICES_FILE};
use crate::output::{OutputError, OutputFile};
use crate::scene::Camera;

/// Most distance between two positions that a denoiser's reprojection takes for one surface, as a fraction of the
/// scene's radius.
const POSITION_LIMIT: f32 = 0.005;
/// Most length of the difference between two unit normals of one surface.
const NORMAL_LIMIT: f32 = 0.5;

/// World to clip space: x to the right, y down, each from -w to w; w is the view depth.
pub(super) fn camera_matrix(camera: &Camera, aspect: f32) -> Mat4 {
    camera.projection_matrix(aspect) * camera.view_matrix()
}

/// Writes the file. `radius`: of the scene's bounding sphere, world units.
pub(super) fn save(folder: &Path, scene: &str, matrices: &[Mat4], radius: f32) -> Result<(), OutputError> {
    OutputFile::new(folder.join(MATRICES_FILE))?.save_text(&header(scene, matrices, radius))
}

fn header(scene: &str, matrices: &[Mat4], radius: f32) -> String {
    let frames = matrices.len();
    let mut text = format!(
        "// {scene}, {frames} frames, by glowworm.\n\
         // (x, y, z, w) = (position, 1) * camera_matrices[f], row vector times matrix;\n\
         // pixel, from the top left = ((x, y) / w + 1) / 2 * size - offset.\n\n\
         const float position_limit_squared = {:?};\n\
         const float normal_limit_squared = {:?};\n\n\
         const float camera_matrices[{frames}][4][4] = {{\n",
        (POSITION_LIMIT * radius).powi(2),
        NORMAL_LIMIT.powi(2),
    );
    // Writing to a String cannot fail. The memory of a matrix by columns is that of its transpose by rows.
    for matrix in matrices {
        text += "  {\n";
        for [x, y, z, w] in matrix.to_cols_array_2d().map(|row| row.map(decimal)) {
            let _ = writeln!(text, "    {{ {x}, {y}, {z}, {w} }},");
        }
        text += "  },\n";
    }
    let _ = writeln!(text, "}};\n\nconst float pixel_offsets[{frames}][2] = {{");
    text += &"  { 0.5, 0.5 },\n".repeat(frames);
    text + "};\n"
}

/// Without an exponent, which not every parser of such files accepts, and with a decimal point.
fn decimal(value: f32) -> String {
    let text = value.to_string();
    if text.contains('.') { text } else { text + ".0" }
}

/// The cameras of a data set.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Matrices {
    /// World to clip space, a frame each.
    pub matrices: Vec<Mat4>,
    /// Offset from the top left of a pixel to where it is sampled, x to the right, y up from its lower edge, a frame each.
    pub offsets: Vec<Vec2>,
}

impl Matrices {
    /// Reads the file of a folder, which must have at least `frames` frames.
    pub fn read(folder: &Path, frames: u32) -> Result<Self, DatasetError> {
        let path = folder.join(MATRICES_FILE);
        let text = std::fs::read_to_string(&path)
            .map_err(|source| OutputError::Read { path: path.clone(), source })?;
        let code = without_comments(&text);
        let array = |name: &str, numbers: usize| {
            let values = c_array(&code, name).unwrap_or_default();
            let needed = numbers * frames as usize;
            let lacks = || {
                let reason =
                    format!("has no {name} of {frames} frames, {needed} numbers; it has {}", values.len());
                DatasetError::of(&path, reason)
            };
            if values.len() >= needed && values.iter().all(|value| value.is_finite()) {
                Ok(values)
            } else {
                Err(lacks())
            }
        };
        let matrices = array("camera_matrices", 16)?;
        let offsets = array("pixel_offsets", 2)?;
        Ok(Self {
            matrices: matrices.chunks_exact(16).map(Mat4::from_cols_slice).collect(),
            offsets: offsets.chunks_exact(2).map(Vec2::from_slice).collect(),
        })
    }

    /// Where a point is seen in a frame with the offset of another one, pixels from the middle of the first one; `size` in pixels.
    pub fn pixel(&self, frame: usize, offset_of: usize, size: Vec2, position: Vec3) -> Vec2 {
        let clip = self.matrices[frame] * position.extend(1.0);
        let Vec2 { x, y } = self.offsets[offset_of];
        (clip.truncate().truncate() / clip.w + 1.0) / 2.0 * size - Vec2::new(x, 1.0 - y)
    }

    /// The eye, and rays so that a pixel at (x, y) in -1..1 sees `eye + depth * (ray + x ray_x + y ray_y)`; none of a matrix that is not
    /// that of a perspective camera.
    pub fn eye_and_rays(&self, frame: usize) -> Option<(Vec3, [Vec3; 3])> {
        let rows = self.matrices[frame].transpose();
        let [x, y, w] = [rows.x_axis, rows.y_axis, rows.w_axis];
        // x, y and w of a point are those of its place seen from the eye, where they are all 0.
        let linear = Mat3::from_cols(x.truncate(), y.truncate(), w.truncate()).transpose();
        let inverse = linear.inverse();
        let eye = -(inverse * Vec3::new(x.w, y.w, w.w));
        let rays = [inverse.z_axis, inverse.x_axis, inverse.y_axis];
        (eye.is_finite() && inverse.is_finite()).then_some((eye, rays))
    }
}

/// C without its comments.
fn without_comments(text: &str) -> String {
    let mut code = String::new();
    let mut parts = text.split("/*");
    code.push_str(parts.next().unwrap_or_default());
    for part in parts {
        code.push_str(part.split_once("*/").map_or("", |(_, after)| after));
    }
    code.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// The numbers within the braces of a C array, in order.
fn c_array(text: &str, name: &str) -> Option<Vec<f32>> {
    let (_, rest) = text.split_once(&format!("{name}["))?;
    let (_, rest) = rest.split_once('=')?;
    let body = rest.split(';').next()?;
    let numbers = body.split(|c: char| !(c.is_ascii_digit() || ".-+eE".contains(c)));
    Some(numbers.filter_map(|number| number.parse().ok()).collect())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
mod tests {
    use super::*;

    fn cameras() -> Vec<Camera> {
        let looking = |x: f32| Camera::looking(Vec3::new(x, 1.0, 4.0), Vec3::new(0.5, 0.25, -1.0));
        vec![looking(0.5), looking(1e-6)]
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let matrices: Vec<Mat4> = cameras().iter().map(|camera| camera_matrix(camera, 1.5)).collect();
        save(folder.path(), "a scene", &matrices, 3.0).unwrap();
        let read = Matrices::read(folder.path(), 2).unwrap();
        assert_eq!(read, Matrices { matrices, offsets: vec![Vec2::splat(0.5); 2] });
        let error = Matrices::read(folder.path(), 3).unwrap_err().to_string();
        assert!(error.contains("has no camera_matrices of 3 frames, 48 numbers; it has 32"), "{error}");
    }

    #[test]
    fn the_camera_of_a_matrix_is_found() {
        let camera = cameras()[0];
        let matrices =
            Matrices { matrices: vec![camera_matrix(&camera, 1.5)], offsets: vec![Vec2::splat(0.5)] };
        let (eye, rays) = matrices.eye_and_rays(0).unwrap();
        assert!(eye.distance(camera.eye) < 1e-4, "{eye}");
        for (found, expected) in rays.iter().zip(camera.pixel_rays(1.5)) {
            assert!(found.distance(expected) < 1e-4, "{found} is not {expected}");
        }
    }

    #[test]
    fn numbers_may_have_exponents_and_suffixes() {
        let text = "const float a[1] = {9};\nconst float b[2][2] = {{1.f, -2.5e-1f}, {+3, .5}};";
        assert_eq!(c_array(text, "b"), Some(vec![1.0, -0.25, 3.0, 0.5]));
        assert_eq!(c_array(text, "c"), None);
        assert_eq!(without_comments("a // b[\nc /* d[\n */ e"), "a \nc  e");
    }
}
