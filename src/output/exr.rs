//! OpenEXR: linear radiance and layers, 32-bit float, lossless.

use std::fs::File;
use std::io::{BufReader, Read, Seek, Write};
use std::path::Path;

use exr::meta::attribute::AttributeValue;
use exr::prelude::*;

use super::error::OutputError;
use super::file::OutputFile;
use super::picture::{Layer, Picture};
use crate::untrusted::guarded;

impl OutputFile {
    /// Writes `picture.colour` as the first part of the file, and each layer as a further part with its name.
    pub fn save_exr(&self, picture: &Picture) -> std::result::Result<(), OutputError> {
        self.save(|writer| {
            encode(picture, writer).map_err(|error| match error {
                Error::Io(source) => self.error(source),
                other => OutputError::Encode(self.path().to_path_buf(), other.to_string()),
            })
        })
    }
}

impl Picture {
    /// Reads an `.exr` that glowworm wrote: colour, layers and notes, but no display values.
    ///
    /// # Errors
    /// If the file cannot be read or is not a valid OpenEXR picture.
    pub fn read_exr(path: &Path) -> std::result::Result<Self, OutputError> {
        let read_error = |source| OutputError::Read { path: path.to_owned(), source };
        let file = File::open(path).map_err(read_error)?;
        let decoded = guarded(|| read_picture(BufReader::new(file)));
        decoded.unwrap_or_else(|why| Err(Error::Invalid(why.into()))).map_err(|error| match error {
            Error::Io(source) => read_error(source),
            other => OutputError::Decode(path.to_owned(), other.to_string()),
        })
    }
}

fn encode(picture: &Picture, writer: impl Write + Seek) -> exr::error::UnitResult {
    let colour = Layer::colour("colour", &picture.colour);
    let parts = std::iter::once(&colour).chain(&picture.layers);
    let mut layers: Vec<_> = parts.map(|part| layer(picture, part)).collect();
    let notes = picture.notes.iter().map(|(name, note)| (text(name), AttributeValue::Text(text(note))));
    layers[0].attributes.other.extend(notes);
    let window = IntegerBounds::from_dimensions((picture.width, picture.height));
    Image::from_layers(ImageAttributes::new(window), layers).write().to_buffered(writer)
}

fn layer(picture: &Picture, part: &Layer) -> exr::image::Layer<AnyChannels<FlatSamples>> {
    let channels = part
        .channels
        .iter()
        .map(|(name, samples)| AnyChannel::new(text(name), FlatSamples::F32(samples.clone())));
    exr::image::Layer::new(
        (picture.width, picture.height),
        LayerAttributes::named(text(&part.name)),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels.collect()),
    )
}

/// A text of the file, which holds Latin-1 alone: what is beyond ASCII becomes the escapes of JSON, as which notes are read.
fn text(text: &str) -> Text {
    let mut ascii = String::with_capacity(text.len());
    for c in text.chars() {
        match c.is_ascii() {
            true => ascii.push(c),
            false => {
                c.encode_utf16(&mut [0; 2]).iter().for_each(|unit| ascii.push_str(&format!("\\u{unit:04x}")))
            }
        }
    }
    Text::new_or_panic(ascii)
}

/// Reads a file of [`OutputFile::save_exr`]; it does not contain `display`.
fn read_picture(reader: impl Read + Seek) -> exr::error::Result<Picture> {
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(reader)?;
    let mut picture = Picture::default();
    for (index, part) in image.layer_data.into_iter().enumerate() {
        let channel = |channel: AnyChannel<FlatSamples>| {
            (channel.name.to_string(), channel.sample_data.values_as_f32().collect())
        };
        let channels: Vec<(String, Vec<f32>)> = part.channel_data.list.into_iter().map(channel).collect();
        if index > 0 {
            let name = part.attributes.layer_name.map(|name| name.to_string()).unwrap_or_default();
            picture.layers.push(Layer { name, channels });
            continue;
        }
        (picture.width, picture.height) = (part.size.0, part.size.1);
        let of = |letter: &str| channels.iter().find(|(name, _)| name == letter);
        if let (Some((_, r)), Some((_, g)), Some((_, b))) = (of("R"), of("G"), of("B")) {
            picture.colour = (0..r.len()).map(|pixel| [r[pixel], g[pixel], b[pixel]]).collect();
        }
        for (name, value) in part.attributes.other {
            if let AttributeValue::Text(note) = value {
                picture.notes.insert(name.to_string(), note.to_string());
            }
        }
    }
    Ok(picture)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::output::Layer as PictureLayer;

    fn picture() -> Picture {
        let values = [0.0, -1.5, 1.0e-30, 12_345.678, 3.0e38, 0.1];
        Picture {
            width: 3,
            height: 2,
            colour: values.iter().map(|&v| [v, v + 1.0, v * 0.5]).collect(),
            display: Vec::new(),
            layers: vec![
                PictureLayer {
                    name: "normal".to_owned(),
                    channels: ["X", "Y", "Z"].map(|name| (name.to_owned(), values.to_vec())).into(),
                },
                PictureLayer {
                    name: "depth".to_owned(),
                    channels: vec![("Z".to_owned(), values.iter().map(|v| v + 2.0).collect())],
                },
            ],
            notes: [("say".to_owned(), "{\"a\": 1}".to_owned())].into(),
        }
    }

    fn encoded(picture: &Picture) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        encode(picture, &mut bytes).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn all_layers_round_trip_bit_for_bit() {
        let picture = picture();
        let bytes = encoded(&picture);
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .from_buffered(Cursor::new(&bytes))
            .unwrap();
        let mut read_layers = image.layer_data.iter();
        let colour = read_layers.next().unwrap();
        assert_eq!(colour.attributes.layer_name, Some(Text::from("colour")));
        assert_eq!(colour.size, Vec2(3, 2));
        for (channel, index) in colour.channel_data.list.iter().zip([2, 1, 0]) {
            let expected: Vec<_> = picture.colour.iter().map(|pixel| pixel[index]).collect();
            assert_eq!(channel.sample_data, FlatSamples::F32(expected));
        }
        for (read, expected) in read_layers.by_ref().zip(&picture.layers) {
            assert_eq!(read.attributes.layer_name, Some(Text::from(expected.name.as_str())));
            for (channel, (name, samples)) in read.channel_data.list.iter().zip(&expected.channels) {
                assert_eq!(channel.name, Text::from(name.as_str()));
                assert_eq!(channel.sample_data, FlatSamples::F32(samples.clone()));
            }
        }
        assert_eq!(image.layer_data.len(), 3);
    }

    #[test]
    fn pictures_round_trip() {
        let picture = picture();
        assert_eq!(read_picture(Cursor::new(encoded(&picture))).unwrap(), picture);
        let mut bytes = encoded(&picture);
        bytes.truncate(bytes.len() / 2);
        assert!(read_picture(Cursor::new(bytes)).is_err());
    }

    #[test]
    fn notes_in_any_script_are_read_as_json() {
        let names = ["日本", "\u{e9}", "\u{1f600} \"a\"\n"];
        let note = serde_json::to_string(&names).unwrap();
        let picture = Picture { notes: [("名前".to_owned(), note)].into(), ..picture() };
        let read = read_picture(Cursor::new(encoded(&picture))).unwrap();
        let note = &read.notes["\\u540d\\u524d"];
        assert_eq!(serde_json::from_str::<Vec<String>>(note).unwrap(), names);
    }

    #[test]
    fn other_programs_see_the_colour_first() {
        let picture = picture();
        let decoded = image::load_from_memory(&encoded(&picture)).unwrap().into_rgb32f();
        let pixels: Vec<_> = decoded.pixels().map(|pixel| pixel.0).collect();
        assert_eq!(pixels, picture.colour);
    }

    #[test]
    fn the_same_picture_gives_the_same_bytes() {
        let side = 256;
        let colour = (0..side * side).map(|i| [i as f32, (i * i) as f32, 1.0 / (i + 1) as f32]);
        let picture = Picture { width: side, height: side, colour: colour.collect(), ..Picture::default() };
        assert_eq!(encoded(&picture), encoded(&picture));
    }
}
