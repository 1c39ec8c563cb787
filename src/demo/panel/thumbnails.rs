//! Pictures of the built-in scenes for the menu, drawn by `scripts/thumbnails`, and which scenes lack their models.

use std::path::{Path, PathBuf};

use egui::{ColorImage, Context, TextureHandle, TextureOptions};

use crate::builtin;
use crate::formats::missing_asset;

/// A built-in scene in the menu.
pub(super) struct KnownScene {
    pub name: &'static str,
    pub picture: TextureHandle,
    /// The first of its models that is not installed.
    pub missing: Option<PathBuf>,
}

/// All built-in scenes, once they were asked for.
#[derive(Default)]
pub(super) struct Thumbnails {
    scenes: Vec<KnownScene>,
}

impl Thumbnails {
    /// The built-in scenes; `assets`: folder of the downloaded models.
    pub fn scenes(&mut self, context: &Context, assets: Option<&Path>) -> &[KnownScene] {
        if self.scenes.is_empty() {
            let known = builtin::NAMES.into_iter().map(|name| KnownScene {
                name,
                picture: context.load_texture(name, decoded(name), TextureOptions::LINEAR),
                missing: missing_asset(name, assets),
            });
            self.scenes.extend(known);
        }
        &self.scenes
    }
}

/// The picture of a scene; grey where there is none.
fn decoded(name: &str) -> ColorImage {
    let picture = image::load_from_memory(file(name)).map(|picture| picture.to_rgb8());
    match picture {
        Ok(picture) => {
            let size = [picture.width() as usize, picture.height() as usize];
            ColorImage::from_rgb(size, picture.as_raw())
        }
        Err(_) => ColorImage::filled([1, 1], egui::Color32::DARK_GRAY),
    }
}

/// The embedded file of a scene's picture.
fn file(name: &str) -> &'static [u8] {
    macro_rules! files {
        ($($name:literal)*) => {
            match name {
                $($name => include_bytes!(concat!("thumbnails/", $name, ".png")),)*
                _ => &[],
            }
        };
    }
    files! {
        "playroom" "cornell-box" "atrium" "atrium-drapery" "cathedral" "meeting-room" "material-grid" "sponza"
        "sibenik" "sibenik-spot" "conference" "conference-torus" "classroom" "living-room"
        "damaged-helmet"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_scene_whose_models_are_at_hand_has_a_picture() {
        for name in builtin::NAMES.into_iter().filter(|name| *name != "crytek-sponza") {
            assert_eq!(decoded(name).size, [128, 72], "{name}");
        }
    }
}
