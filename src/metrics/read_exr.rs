//! Reads one layer of an OpenEXR file.
//!
//! A layer is a part of the file or, within a part, the channels that share a prefix (`direct.R`). Its pixels
//! are placed in the display window; pixels outside the data window are black. Alpha is ignored.

use std::io::Cursor;
use std::path::Path;

use exr::image::read::any_channels::ReadAnyChannels;
use exr::image::read::samples::ReadFlatSamples;
use exr::meta::header::Header;
use exr::prelude::*;

use super::error::MetricsError;
use crate::untrusted::guarded;

/// The largest side of a picture, pixels; the same as for `--size`.
const MAX_SIDE: usize = 16_384;

/// Location of the colours: a part, and its channels for red, green and blue.
struct Place {
    header: Header,
    channels: [String; 3],
}

/// Reads only the part that has this header.
struct OnePart {
    header: Header,
    channels: ReadAnyChannels<ReadFlatSamples>,
}

impl<'s> ReadChannels<'s> for OnePart {
    type Reader = <ReadAnyChannels<ReadFlatSamples> as ReadChannels<'s>>::Reader;

    fn create_channels_reader(&'s self, header: &Header) -> Result<Self::Reader> {
        if *header == self.header {
            self.channels.create_channels_reader(header)
        } else {
            Err(Error::NotSupported("another part".into()))
        }
    }
}

/// Width, height and pixels of `layer`, or of the first layer with colours.
pub(super) fn read_exr(
    path: &Path,
    bytes: &[u8],
    layer: Option<&str>,
) -> std::result::Result<([usize; 2], Vec<[f32; 3]>), MetricsError> {
    let decode = || decode(path, bytes, layer);
    guarded(decode).unwrap_or_else(|why| Err(MetricsError::Decode(path.to_path_buf(), why)))
}

fn decode(
    path: &Path,
    bytes: &[u8],
    layer: Option<&str>,
) -> std::result::Result<([usize; 2], Vec<[f32; 3]>), MetricsError> {
    let decode_error = |error: Error| MetricsError::Decode(path.to_path_buf(), error.to_string());
    let chunks = exr::block::read(Cursor::new(bytes), false).map_err(decode_error)?;
    let Place { header, channels } = find(chunks.headers(), layer).ok_or_else(|| {
        let layer = layer.map(|layer| format!(" {layer}")).unwrap_or_default();
        MetricsError::NoColours(path.to_path_buf(), layer, describe(chunks.headers()))
    })?;
    let window = header.shared_attributes.display_window;
    for Vec2(width, height) in [window.size, header.layer_size] {
        check_size(path, [width, height])?;
    }
    let part = OnePart { header, channels: read().no_deep_data().largest_resolution_level().all_channels() };
    let image =
        part.first_valid_layer().all_attributes().non_parallel().from_chunks(chunks).map_err(decode_error)?;
    let pixels = placed(&image.layer_data, &channels, window)
        .ok_or_else(|| decode_error(Error::NotSupported("subsampled channels".into())))?;
    Ok(([window.size.0, window.size.1], pixels))
}

/// Checks the size before allocating, since a corrupt file may claim any.
pub(super) fn check_size(path: &Path, [width, height]: [usize; 2]) -> std::result::Result<(), MetricsError> {
    if width.max(height) > MAX_SIDE {
        return Err(MetricsError::TooLarge(path.to_path_buf(), width, height, MAX_SIDE));
    }
    Ok(())
}

/// Finds R, G and B, or else Y.
fn find(headers: &[Header], layer: Option<&str>) -> Option<Place> {
    let flat = || headers.iter().filter(|header| !header.deep);
    let names = [["R", "G", "B"], ["Y"; 3]];
    names.iter().find_map(|names| {
        flat().find_map(|header| {
            prefixes(header, layer).into_iter().find_map(|prefix| {
                let channels = names.map(|name| format!("{prefix}{name}"));
                let there = channels.iter().all(|name| has_channel(header, name));
                // Beside X, Y belongs to a vector.
                let vector = names[0] == "Y" && has_channel(header, &format!("{prefix}X"));
                (there && !vector).then(|| Place { header: header.clone(), channels })
            })
        })
    })
}

/// Possible prefixes of the channels of `layer` in this part.
fn prefixes(header: &Header, layer: Option<&str>) -> Vec<String> {
    let Some(layer) = layer else { return vec![String::new()] };
    let is_part = header.own_attributes.layer_name.as_ref().is_some_and(|name| *name == *layer);
    is_part.then(String::new).into_iter().chain([format!("{layer}.")]).collect()
}

fn has_channel(header: &Header, name: &str) -> bool {
    header.channels.list.iter().any(|channel| channel.name == *name)
}

/// The parts of a file with their channels.
fn describe(headers: &[Header]) -> String {
    let part = |header: &Header| {
        let name = header.own_attributes.layer_name.as_ref().map_or("a part".to_owned(), ToString::to_string);
        let channels: Vec<_> = header.channels.list.iter().map(|channel| channel.name.to_string()).collect();
        format!("{name} ({})", channels.join(" "))
    };
    headers.iter().map(part).collect::<Vec<_>>().join(", ")
}

/// The pixels of the display window. None if a channel is subsampled.
fn placed(
    layer: &Layer<AnyChannels<FlatSamples>>,
    channels: &[String; 3],
    window: IntegerBounds,
) -> Option<Vec<[f32; 3]>> {
    let (Vec2(width, height), from) = (layer.size, layer.attributes.layer_position);
    let mut pixels = vec![[0.0; 3]; window.size.0 * window.size.1];
    for (lane, name) in channels.iter().enumerate() {
        let channel = layer.channel_data.list.iter().find(|channel| channel.name == **name)?;
        if channel.sample_data.len() != width * height {
            return None;
        }
        for (at, value) in channel.sample_data.values_as_f32().enumerate() {
            let x = (at % width) as i64 + i64::from(from.0) - i64::from(window.position.0);
            let y = (at / width) as i64 + i64::from(from.1) - i64::from(window.position.1);
            let inside = |at: i64, length: usize| usize::try_from(at).ok().filter(|&at| at < length);
            if let (Some(x), Some(y)) = (inside(x, window.size.0), inside(y, window.size.1)) {
                pixels[y * window.size.0 + x][lane] = value;
            }
        }
    }
    Some(pixels)
}
