//! Pictures as other programs write them, and invalid files.

use std::fs;
use std::path::{Path, PathBuf};

use exr::image::Encoding as ExrEncoding;
use exr::prelude::*;
use glowworm::metrics::{Encoding, Image, MetricsError};
use image::{DynamicImage, ImageBuffer, Luma, LumaA, Rgb, Rgba};
use tempfile::TempDir;

const WIDTH: usize = 4;
const HEIGHT: usize = 3;

struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn png(&self, picture: impl Into<DynamicImage>) -> Image {
        let path = self.path("a.png");
        picture.into().save(&path).unwrap();
        Image::read(&path, None).unwrap()
    }

    /// Writes an EXR of these parts.
    fn exr(&self, name: &str, parts: impl IntoIterator<Item = Part>) -> PathBuf {
        let path = self.path(name);
        let window = IntegerBounds::from_dimensions((WIDTH, HEIGHT));
        let layers: Vec<_> = parts.into_iter().map(Part::layer).collect();
        exr::image::Image::from_layers(ImageAttributes::new(window), layers).write().to_file(&path).unwrap();
        path
    }
}

/// A part of an EXR and its channels, each of one value.
struct Part {
    name: Option<&'static str>,
    channels: Vec<(&'static str, FlatSamples)>,
    size: (usize, usize),
    position: (i32, i32),
    encoding: ExrEncoding,
}

fn part(name: Option<&'static str>, channels: &[(&'static str, f32)]) -> Part {
    let samples = |value: f32| FlatSamples::F32(vec![value; WIDTH * HEIGHT]);
    Part {
        name,
        channels: channels.iter().map(|&(name, value)| (name, samples(value))).collect(),
        size: (WIDTH, HEIGHT),
        position: (0, 0),
        encoding: ExrEncoding::SMALL_LOSSLESS,
    }
}

impl Part {
    fn layer(self) -> Layer<AnyChannels<FlatSamples>> {
        let channels = self.channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples));
        let mut attributes =
            LayerAttributes { layer_name: self.name.map(Text::from), ..LayerAttributes::default() };
        attributes.layer_position = Vec2(self.position.0, self.position.1);
        Layer::new(self.size, attributes, self.encoding, AnyChannels::sort(channels.collect()))
    }
}

#[track_caller]
fn assert_constant(image: &Image, expected: [f32; 3]) {
    assert_eq!(image.size(), [WIDTH, HEIGHT]);
    // Decoders divide or multiply by a reciprocal.
    let same =
        |pixel: &[f32; 3]| (0..3).all(|i| (pixel[i] - expected[i]).abs() <= f32::EPSILON * expected[i].abs());
    assert!(image.pixels().iter().all(same), "{:?}", image.pixels());
}

fn read(path: &Path) -> Image {
    Image::read(path, None).unwrap()
}

fn error(path: &Path, layer: Option<&str>) -> String {
    let error = Image::read(path, layer).unwrap_err();
    let message = error.to_string();
    assert!(message.contains(path.to_str().unwrap()) && !message.contains('\n'), "{message}");
    message
}

#[test]
fn pngs_of_all_depths_are_display_values() {
    let folder = Folder::new();
    let (width, height) = (WIDTH as u32, HEIGHT as u32);
    let image = folder.png(ImageBuffer::from_pixel(width, height, Rgb([51_u8, 0, 255])));
    assert_eq!(image.encoding(), Encoding::Display);
    assert_constant(&image, [51.0 / 255.0, 0.0, 1.0]);
    let image = folder.png(ImageBuffer::from_pixel(width, height, Rgb([257_u16, 0, 65_535])));
    assert_constant(&image, [257.0 / 65_535.0, 0.0, 1.0]);
    assert_constant(&folder.png(ImageBuffer::from_pixel(width, height, Luma([51_u8]))), [0.2; 3]);
    assert_constant(&folder.png(ImageBuffer::from_pixel(width, height, LumaA([51_u8, 7]))), [0.2; 3]);
    assert_constant(&folder.png(ImageBuffer::from_pixel(width, height, Rgba([51_u8, 51, 51, 7]))), [0.2; 3]);
}

#[test]
fn rows_and_columns_stay_in_place() {
    let folder = Folder::new();
    let picture =
        ImageBuffer::from_fn(WIDTH as u32, HEIGHT as u32, |x, y| Rgb([(10 * x) as u8, (20 * y) as u8, 0]));
    assert_eq!(folder.png(picture).pixels()[WIDTH + 2], [20.0 / 255.0, 20.0 / 255.0, 0.0]);
    let mut gradient = part(None, &[("R", 0.0), ("G", 0.0), ("B", 0.0)]);
    gradient.channels[0].1 = FlatSamples::F32((0..WIDTH * HEIGHT).map(|i| i as f32).collect());
    let image = read(&folder.exr("a.exr", [gradient]));
    assert_eq!(image.pixels()[WIDTH + 2], [(WIDTH + 2) as f32, 0.0, 0.0]);
}

#[test]
fn exrs_of_all_sample_types_and_compressions_are_linear() {
    let folder = Folder::new();
    let pixels = WIDTH * HEIGHT;
    let channels = vec![
        ("R", FlatSamples::F16(vec![f16::from_f32(1.5); pixels])),
        ("G", FlatSamples::F32(vec![-1.0e-9; pixels])),
        ("B", FlatSamples::U32(vec![7; pixels])),
        ("A", FlatSamples::F32(vec![f32::NAN; pixels])),
    ];
    for compression in
        [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::ZIP16, Compression::PIZ]
    {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(2, 2))] {
            let encoding = ExrEncoding { compression, blocks, line_order: LineOrder::Increasing };
            let picture = Part { channels: channels.clone(), encoding, ..part(None, &[]) };
            let image = read(&folder.exr("a.exr", [picture]));
            assert_eq!(image.encoding(), Encoding::Linear);
            assert_constant(&image, [1.5, -1.0e-9, 7.0]);
        }
    }
}

#[test]
fn luminance_alone_is_grey() {
    let folder = Folder::new();
    assert_constant(&read(&folder.exr("a.exr", [part(None, &[("Y", 3.0), ("A", 1.0)])])), [3.0; 3]);
    // The Y of a vector is not luminance.
    let path = folder.exr("a.exr", [part(None, &[("X", 1.0), ("Y", 2.0), ("Z", 3.0)])]);
    assert!(
        error(&path, None).ends_with("has no layer with channels R, G and B, or Y; it has a part (X Y Z)")
    );
}

#[test]
fn layers_are_parts_or_prefixes() {
    let folder = Folder::new();
    let rgb = |value: f32| [("R", value), ("G", value), ("B", value)];
    let path = folder.exr(
        "parts.exr",
        [
            part(Some("normal"), &[("X", 9.0), ("Y", 9.0), ("Z", 9.0)]),
            part(Some("direct"), &rgb(1.0)),
            part(Some("indirect"), &rgb(2.0)),
            part(Some("depth"), &[("Y", 4.0)]),
        ],
    );
    assert_constant(&read(&path), [1.0; 3]);
    for (layer, value) in [("direct", 1.0), ("indirect", 2.0), ("depth", 4.0)] {
        let image = Image::read(&path, Some(layer)).unwrap();
        assert_constant(&image, [value; 3]);
        assert!(image.name().ends_with(&format!("parts.exr, layer {layer}")));
    }
    let message = error(&path, Some("emission"));
    assert!(message.contains("has no layer emission with channels"), "{message}");
    assert!(message.contains("normal (X Y Z), direct (B G R), indirect (B G R), depth (Y)"), "{message}");
    assert!(error(&path, Some("normal")).contains("has no layer normal with"));

    let prefixed = [("direct.R", 1.0), ("direct.G", 1.0), ("direct.B", 1.0), ("indirect.Y", 2.0)];
    let path = folder.exr("prefixes.exr", [part(None, &prefixed)]);
    assert_constant(&Image::read(&path, Some("direct")).unwrap(), [1.0; 3]);
    assert_constant(&Image::read(&path, Some("indirect")).unwrap(), [2.0; 3]);
    assert!(error(&path, None).contains("direct.R"));
}

#[test]
fn glowworms_own_layers_are_read() {
    use glowworm::output::{Layer, Picture, PictureTarget};
    let folder = Folder::new();
    let plane = |value: f32| vec![value; WIDTH * HEIGHT];
    let picture = Picture {
        width: WIDTH,
        height: HEIGHT,
        colour: vec![[1.0, 2.0, 3.0]; WIDTH * HEIGHT],
        display: Vec::new(),
        layers: vec![Layer {
            name: "indirect".to_owned(),
            channels: ["R", "G", "B"].map(|name| (name.to_owned(), plane(0.25))).into(),
        }],
        ..Picture::default()
    };
    let path = PictureTarget::new(&folder.path("a.exr"), true).unwrap().write(&picture, 0).unwrap();
    assert_constant(&read(&path), [1.0, 2.0, 3.0]);
    assert_constant(&Image::read(&path, Some("colour")).unwrap(), [1.0, 2.0, 3.0]);
    assert_constant(&Image::read(&path, Some("indirect")).unwrap(), [0.25; 3]);
}

#[test]
fn the_data_window_is_placed_into_the_display_window() {
    let folder = Folder::new();
    let cropped = |size: (usize, usize), position: (i32, i32)| {
        let samples = FlatSamples::F32((1..=size.0 * size.1).map(|i| i as f32).collect());
        Part { size, position, channels: vec![("Y", samples)], ..part(None, &[]) }
    };
    let red = |part: Part| -> Vec<f32> {
        read(&folder.exr("a.exr", [part])).pixels().iter().map(|pixel| pixel[0]).collect()
    };
    assert_eq!(red(cropped((2, 1), (1, 1))), [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    // Overscan: one pixel more on every side.
    let inner = [8.0, 9.0, 10.0, 11.0, 14.0, 15.0, 16.0, 17.0, 20.0, 21.0, 22.0, 23.0];
    assert_eq!(red(cropped((WIDTH + 2, HEIGHT + 2), (-1, -1))), inner);
}

#[test]
fn an_hdr_holds_linear_values() {
    let folder = Folder::new();
    let pixels = [[0.5, 2.0, 0.25], [16.0, 4.0, 1.0]];
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&pixels.map(Rgb), 2, 1).unwrap();
    let path = folder.path("a.hdr");
    fs::write(&path, bytes).unwrap();
    let read = read(&path);
    assert_eq!((read.pixels(), read.encoding()), (&pixels[..], Encoding::Linear));
}

#[test]
fn what_is_no_picture_is_named() {
    let folder = Folder::new();
    let path = folder.path("a.png");
    assert!(error(&path, None).contains("cannot be read: No such file"));
    for bytes in [&b""[..], b"hello", b"\xff\xd8\xff\xe0 a JPEG", &[0; 100]] {
        fs::write(&path, bytes).unwrap();
        assert!(error(&path, None).ends_with("neither a PNG nor a Radiance HDR nor an OpenEXR file"));
    }
    fs::create_dir(folder.path("folder")).unwrap();
    assert!(error(&folder.path("folder"), None).contains("cannot be read"));
    folder.png(ImageBuffer::from_pixel(2, 2, Rgb([0_u8; 3])));
    let result = Image::read(&path, Some("direct"));
    assert!(matches!(result, Err(error @ MetricsError::NoLayers(_)) if error.is_usage()));
}

#[test]
fn pixels_that_are_not_finite_are_named() {
    let folder = Folder::new();
    let mut broken = part(Some("indirect"), &[("R", 0.0), ("G", 0.0), ("B", 0.0)]);
    let FlatSamples::F32(blue) = &mut broken.channels[2].1 else { panic!("not f32") };
    blue[2 * WIDTH + 1] = f32::INFINITY;
    let path = folder.exr("a.exr", [part(Some("direct"), &[("Y", 0.0)]), broken]);
    let message = error(&path, Some("indirect"));
    assert!(message.contains("a.exr, layer indirect: pixel (1, 2) has a blue of inf"), "{message}");
}

/// Changed bytes and truncation give an error or a picture, never a panic.
#[test]
fn broken_files_are_errors() {
    let folder = Folder::new();
    folder.png(ImageBuffer::from_fn(16, 9, |x, y| Rgb([(x * y) as u8, x as u8, y as u8])));
    let rgb = [("R", 1.0), ("G", 2.0), ("B", 3.0)];
    folder.exr("a.exr", [part(Some("direct"), &rgb), part(Some("indirect"), &rgb)]);
    for (name, layer) in [("a.png", None), ("a.exr", Some("indirect"))] {
        let path = folder.path(name);
        let bytes = fs::read(&path).unwrap();
        let decode = |bytes: &[u8]| Image::decode(&path, bytes, layer);
        let errors = (0..bytes.len()).filter(|&end| decode(&bytes[..end]).is_err()).count();
        assert!(errors > bytes.len() * 9 / 10, "{name}: {errors} of {}", bytes.len());
        for at in 0..bytes.len() {
            for value in [0, 1, 0x7f, 0xff, bytes[at] ^ 0x10] {
                let mut bytes = bytes.clone();
                bytes[at] = value;
                if let Err(error) = decode(&bytes) {
                    assert!(error.to_string().contains(name), "{error}");
                }
            }
        }
    }
}
