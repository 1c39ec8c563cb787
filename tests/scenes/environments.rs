//! Environments of scene files: maps of any content, and what is wrong with broken ones.

use super::*;

/// A scene file with this environment, and the map `sky.exr` of 4 x 2 texels.
fn folder(environment: &str, texels: &[[f32; 3]; 8]) -> Folder {
    let text = format!(
        "[environment]\n{environment}\n[[models]]\nname = \"m\"\npath = \"m.obj\"\n[[instances]]\nmodel = \"m\"\n"
    );
    let folder = Folder::new().with("s.toml", text).with("m.obj", TRIANGLE);
    let image = image::Rgb32FImage::from_fn(4, 2, |x, y| image::Rgb(texels[(y * 4 + x) as usize]));
    image.save(folder.path().join("sky.exr")).unwrap();
    folder
}

#[test]
fn environments_are_constant_or_maps() {
    let grey = [[0.5, 0.25, 1.0]; 8];
    let scene = folder("colour = [1, 2, 3]\nstrength = 2", &grey).load("s.toml").unwrap();
    assert_eq!(scene.environment.as_ref().unwrap().radiance(Vec3::X), Vec3::new(2.0, 4.0, 6.0));
    // There is light, so nothing warns of darkness; the material is missing.
    assert!(!scene.warnings.iter().any(|warning| warning.contains("no light")), "{:?}", scene.warnings);

    let mut texels = grey;
    texels[1] = [f32::NAN, 1.0, 1.0];
    texels[6] = [f32::INFINITY, 1.0, 1.0];
    let scene = folder("map = \"sky.exr\"\nrotation_deg = 90", &texels).load("s.toml").unwrap();
    assert!(
        scene.warnings.iter().any(|warning| warning.contains("sky.exr: 2 texels")),
        "{:?}",
        scene.warnings
    );
    let environment = scene.environment.unwrap();
    for direction in [Vec3::X, Vec3::Y, Vec3::NEG_Z, Vec3::new(0.6, -0.8, 0.0)] {
        let radiance = environment.radiance(direction);
        assert!(radiance.is_finite() && radiance.max_element() <= 1.0, "{radiance}");
    }
    let scene = folder("asset = \"sky.exr\"\ncolour = [2, 2, 2]", &grey).load("s.toml").unwrap();
    let radiance = scene.environment.unwrap().radiance(Vec3::NEG_Z);
    assert!(radiance.distance(Vec3::new(1.0, 0.5, 2.0)) < 1e-3, "{radiance}");
}

#[test]
fn broken_environments_say_what_is_wrong() {
    for (environment, parts) in [
        ("strength = 1", &["s.toml:1", "environment", "a colour, a map, an asset or a builtin"][..]),
        ("colour = [1, -1, 1]", &["colour", "negative"]),
        ("colour = [1, 1, 1]\nstrength = -1", &["strength", "negative"]),
        ("colour = [3e38, 1, 1]\nstrength = 9", &["too large"]),
        ("map = \"sky.exr\"\nasset = \"sky.exr\"", &["map, asset and builtin"]),
        ("builtin = \"moon\"", &["moon", "\"sky\""]),
        ("asset = \"gone.exr\"\ndownload = \"https://a\"", &["gone.exr", "GLOWWORM_ASSETS", "https://a"]),
        ("map = \"gone.hdr\"", &["gone.hdr", "could not be read"]),
        ("map = \"m.obj\"", &["m.obj", "could not be decoded"]),
        ("map = \"depth.exr\"", &["depth.exr", "could not be decoded"]),
        ("fog = 1", &["s.toml:2", "fog"]),
    ] {
        let folder = folder(environment, &[[1.0; 3]; 8]);
        let channels = exr::prelude::SpecificChannels::build()
            .with_channel::<f32>("Z")
            .with_pixel_fn(|_: exr::prelude::Vec2<usize>| (1.0f32,));
        let image = exr::prelude::Image::from_channels((4, 2), channels);
        exr::prelude::WritableImage::write(&image).to_file(folder.path().join("depth.exr")).unwrap();
        let error = folder.load("s.toml").unwrap_err().to_string();
        assert!(!error.contains('\n'), "{error}");
        for part in parts {
            assert!(error.contains(part), "\"{error}\" should say \"{part}\"");
        }
    }
}

/// An EXR of these channels: red is 1, green 2, blue 4, luminance 3, others 9. Its data window has `size` texels and begins at `start`
/// of a display window of 4 x 2.
fn exr_of(names: &str, start: (i32, i32), size: (usize, usize)) -> Vec<u8> {
    use exr::prelude::*;
    let channel = |name: &str| {
        let texel = match name.rsplit('.').next() {
            Some("R") => 1.0,
            Some("G") => 2.0,
            Some("B") => 4.0,
            Some("Y") => 3.0,
            _ => 9.0,
        };
        AnyChannel::new(name, FlatSamples::F32(vec![texel; size.0 * size.1]))
    };
    let channels = AnyChannels::sort(names.split(' ').map(channel).collect());
    let attributes = LayerAttributes { layer_position: start.into(), ..LayerAttributes::default() };
    let layer = Layer::new(size, attributes, Encoding::UNCOMPRESSED, channels);
    let mut image = Image::from_layer(layer);
    image.attributes.display_window = IntegerBounds::new((0, 0), (4, 2));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn maps_are_read_whatever_their_layout() {
    let rgb = Vec3::new(1.0, 2.0, 4.0);
    let whole = ((0, 0), (4, 2));
    for (names, (start, size), [above, below]) in [
        ("A B G R", whole, [rgb; 2]),
        ("B G R", ((0, 1), (4, 1)), [Vec3::ZERO, rgb]),
        ("B G R", ((-3, -5), (9, 6)), [rgb, Vec3::ZERO]),
        ("Y", whole, [Vec3::splat(3.0); 2]),
        ("V", ((0, 0), (4, 1)), [Vec3::splat(9.0), Vec3::ZERO]),
        ("L.Combined.A L.Combined.B L.Combined.G L.Combined.R L.Depth.Z", whole, [rgb; 2]),
    ] {
        let folder = folder("map = \"sky.exr\"", &[[1.0; 3]; 8]).with("sky.exr", exr_of(names, start, size));
        // As a texture, too, of which masks see what is outside the data window as absent.
        let folder = folder.with("m.mtl", "newmtl a\nKd 1 1 1\nmap_Ke sky.exr\nKe 1 1 1\n");
        let scene = folder.load("s.toml").unwrap();
        let environment = scene.environment.unwrap();
        for (direction, expected) in [(Vec3::Y, above), (Vec3::NEG_Y, below)] {
            let radiance = environment.radiance(direction);
            assert!(radiance.distance(expected) < 1e-5, "{names} {start:?}: {radiance}");
        }
        let [top, bottom] = [0.25, 0.75].map(|v| scene.textures[0].sample(glam::Vec2::new(0.5, v)));
        assert!(top.distance(above) < 1e-2 && bottom.distance(below) < 1e-2, "{names}: {top} {bottom}");
    }
    let luma = folder("map = \"sky.exr\"", &[[1.0; 3]; 8]).with("sky.exr", exr_of("BY RY Y", (0, 0), (4, 2)));
    let error = luma.load("s.toml").unwrap_err().to_string();
    assert!(error.contains("channels are BY, RY, Y"), "{error}");
}

#[test]
fn radiance_is_what_it_was_before_the_exposure() {
    for (header, factor) in
        [("", 1.0), ("EXPOSURE=2\n", 0.5), ("EXPOSURE=4\nEXPOSURE=0.25\nCOLORCORR=2 2 2\n", 0.5)]
    {
        let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n{header}\n-Y 2 +X 4\n").into_bytes();
        bytes.extend([128, 64, 32, 129].repeat(8));
        let folder = folder("map = \"sky.hdr\"", &[[1.0; 3]; 8]).with("sky.hdr", bytes);
        let radiance = folder.load("s.toml").unwrap().environment.unwrap().radiance(Vec3::X);
        assert!(radiance.distance(Vec3::new(1.0, 0.5, 0.25) * factor) < 1e-5, "{header}: {radiance}");
    }
}
