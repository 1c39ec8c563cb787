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
