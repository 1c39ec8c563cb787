//! OpenEXR images of any layout.
//!
//! In: a file. Out: the texels of its display window, black and transparent outside the data window; or what is wrong, which
//! completes a sentence. The channels are R, G and B, without a layer's name where there are such, else those of the layer
//! `Combined` (Blender's picture), else of the first one; a file without any has one grey channel.

use std::io::{Read, Seek};

use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel, Text, Vec2};

/// Channels of a name, up to the last dot of which it is that of their layer.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Channels {
    /// Red, green, blue and alpha; of a grey image green and blue are no names of the file.
    names: [String; 4],
    is_grey: bool,
}

impl Channels {
    /// The best of a file whose parts have these channels, and the index of their part.
    fn best(parts: &[Vec<String>]) -> Result<(usize, Self), String> {
        let colours = parts.iter().enumerate().flat_map(|(part, names)| {
            let layers = names.iter().filter_map(|name| layer_of(name, "r").map(|layer| (layer, name)));
            layers.filter_map(move |(layer, red)| {
                let of = |end| names.iter().find(|name| layer_of(name, end) == Some(layer)).cloned();
                let alpha = of("a").unwrap_or_else(|| format!("{layer}A"));
                let names = [red.clone(), of("g")?, of("b")?, alpha];
                Some((part, layer, Self { names, is_grey: false }))
            })
        });
        let rank = |layer: &str| match layer {
            "" => 0,
            "Combined." => 1,
            _ if layer.ends_with(".Combined.") => 1,
            _ => 2,
        };
        if let Some((part, _, channels)) = colours.min_by_key(|(part, layer, _)| (rank(layer), *part)) {
            return Ok((part, channels));
        }
        let has = |names: &[String], end| names.iter().any(|name| layer_of(name, end).is_some());
        let greys = parts.iter().enumerate().filter(|(_, names)| !has(names, "ry") && !has(names, "by"));
        let mut found = greys.filter_map(|(part, names)| {
            // X, Y and Z are a vector, and Z alone is a depth.
            let has_x = |layer: &str| names.iter().any(|name| layer_of(name, "x") == Some(layer));
            let is_luminance = |name: &&String| layer_of(name, "y").is_some_and(|layer| !has_x(layer));
            let luminance = names.iter().find(is_luminance);
            let others = names.iter().filter(|name| layer_of(name, "a").is_none());
            let alone = others.filter(|_| !has(names, "z")).collect::<Vec<_>>();
            let grey = luminance.or(if let [only] = alone[..] { Some(only) } else { None })?;
            let names = [grey.clone(), format!("{grey} (green)"), format!("{grey} (blue)"), "A".to_owned()];
            Some((part, Self { names, is_grey: true }))
        });
        found.next().ok_or_else(|| {
            format!("its channels are {}, must be R, G, B or one of grey", parts.concat().join(", "))
        })
    }
}

/// The layer of a channel, with its dot, if the channel is called `end`.
fn layer_of<'a>(name: &'a str, end: &str) -> Option<&'a str> {
    let (layer, own) = name.split_at(name.rfind('.').map_or(0, |dot| dot + 1));
    own.eq_ignore_ascii_case(end).then_some(layer)
}

/// What is read of a file.
pub(super) struct Layout {
    channels: Channels,
    /// Width and height of the display window.
    pub size: [usize; 2],
    /// Width and height of the data window.
    pub data_size: [usize; 2],
    /// Where the data window begins in the display window.
    start: [i64; 2],
}

impl Layout {
    /// Reads the headers of a file.
    pub fn read(file: impl Read) -> Result<Self, String> {
        let meta = MetaData::read_from_unbuffered(file, false).map_err(|error| error.to_string())?;
        let names = |header: &Header| header.channels.list.iter().map(|c| c.name.to_string()).collect();
        let parts: Vec<Vec<String>> = meta.headers.iter().map(names).collect();
        let (part, channels) = Channels::best(&parts)?;
        let header = &meta.headers[part];
        let (window, data) = (header.shared_attributes.display_window, header.own_attributes.layer_position);
        let start = [data.x() - window.position.x(), data.y() - window.position.y()].map(i64::from);
        let of = |size: Vec2<usize>| [size.x(), size.y()];
        Ok(Self { channels, size: of(window.size), data_size: of(header.layer_size), start })
    }

    /// Reads the texels into what `create` makes: `set` is given place and RGBA of each that is in both windows.
    pub fn texels<T: 'static>(
        &self,
        file: impl Read + Seek,
        create: impl Fn() -> T + 'static,
        set: impl Fn(&mut T, [usize; 2], [f32; 4]) + 'static,
    ) -> Result<T, String> {
        let (Channels { names, is_grey }, start, size) = (&self.channels, self.start, self.size);
        let is_grey = *is_grey;
        let [red, green, blue, alpha] = names.each_ref().map(|name| Text::from(&**name));
        let set = move |image: &mut T, at: Vec2<usize>, (r, g, b, a): (f32, f32, f32, f32)| {
            let place = [at.x() as i64 + start[0], at.y() as i64 + start[1]];
            let [x, y] = place.map(|place| usize::try_from(place).unwrap_or(usize::MAX));
            if x < size[0] && y < size[1] {
                set(image, [x, y], if is_grey { [r, r, r, a] } else { [r, g, b, a] });
            }
        };
        let read = exr::prelude::read().no_deep_data().largest_resolution_level().specific_channels();
        let read = read.required(red).optional(green, 0.0f32).optional(blue, 0.0f32).optional(alpha, 1.0f32);
        let read = read.collect_pixels(move |_, _| create(), set).first_valid_layer();
        let image = read.all_attributes().non_parallel().from_unbuffered(file);
        Ok(image.map_err(|error| error.to_string())?.layer_data.channel_data.pixels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_is_found_in_any_layout() {
        for (parts, expected) in [
            (&["A B G R"][..], Some((0, "R", false))),
            (&["Depth.Z", "r g b"], Some((1, "r", false))),
            (
                &["ViewLayer.Combined.A ViewLayer.Combined.B ViewLayer.Combined.G ViewLayer.Combined.R"],
                Some((0, "ViewLayer.Combined.R", false)),
            ),
            (&["a.B a.G a.R x.Combined.B x.Combined.G x.Combined.R"], Some((0, "x.Combined.R", false))),
            (&["diffuse.B diffuse.G diffuse.R diffuse.X"], Some((0, "diffuse.R", false))),
            (&["Y"], Some((0, "Y", true))),
            (&["A V"], Some((0, "V", true))),
            (&["N.X N.Y N.Z", "A luminance.Y"], Some((1, "luminance.Y", true))),
            (&["BY RY Y"], None),
            (&["G R"], None),
            (&["Z"], None),
        ] {
            let names = |part: &&str| part.split(' ').map(str::to_owned).collect();
            let parts: Vec<Vec<String>> = parts.iter().map(names).collect();
            let found = Channels::best(&parts);
            let told = found.as_ref().ok().map(|(part, of)| (*part, &*of.names[0], of.is_grey));
            assert_eq!(told, expected, "{parts:?}");
        }
    }
}
