//! Compiles every shader of `shaders/` to SPIR-V with glslang.

#[path = "../sources.rs"]
pub mod sources;

use std::fs;
use std::path::{Path, PathBuf};

use glslang::include::{IncludeHandler, IncludeResult, IncludeType};
use glslang::{
    Compiler, CompilerOptions, ShaderInput, ShaderSource, ShaderStage, SourceLanguage, SpirvVersion, Target,
    VulkanVersion,
};
use sources::Shader;

/// Compiles all shaders below the folder `shaders` into the folder `out`, and writes the manifest of their sources there.
/// What `out` held before is deleted.
///
/// # Errors
/// Lines to print, `file:line: message` for what glslang refuses.
pub fn compile_all(shaders: &Path, out: &Path) -> Result<(), Vec<String>> {
    let failed = |error: std::io::Error| vec![format!("{}: {error}", out.display())];
    if out.exists() {
        fs::remove_dir_all(out).map_err(failed)?;
    }
    fs::create_dir_all(out).map_err(failed)?;
    let mut errors = Vec::new();
    for shader in sources::shaders(shaders).map_err(failed)? {
        match compile_variants(&shader, &shaders.join("include")) {
            Ok(variants) => {
                for (file, words) in shader.spirv_files().into_iter().zip(variants) {
                    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
                    fs::write(out.join(file), bytes).map_err(failed)?;
                }
            }
            Err(message) => errors.extend(readable(&shader.path, &message)),
        }
    }
    if errors.is_empty() {
        let manifest = sources::manifest(shaders).map_err(failed)?;
        fs::write(out.join(sources::MANIFEST), manifest).map_err(failed)
    } else {
        Err(errors)
    }
}

/// Compiles a shader into the contents of its SPIR-V files.
fn compile_variants(shader: &Shader, include: &Path) -> Result<Vec<Vec<u32>>, String> {
    let text = fs::read_to_string(&shader.path).map_err(|error| error.to_string())?;
    let stage = match shader.path.extension().and_then(|extension| extension.to_str()) {
        Some("vert") => ShaderStage::Vertex,
        Some("frag") => ShaderStage::Fragment,
        _ => ShaderStage::Compute,
    };
    let folders = [include, shader.path.parent().unwrap_or(include)];
    let mut variants = Vec::new();
    if shader.traces_rays {
        let (version, rest) = text.split_once('\n').ok_or("a shader must begin with #version")?;
        let hardware = "#extension GL_EXT_ray_query : require\n#define TRACER_HARDWARE\n#line 2";
        variants.push(compile(text.clone(), stage, folders)?);
        variants.push(compile(format!("{version}\n{hardware}\n{rest}"), stage, folders)?);
    } else {
        variants.push(compile(text, stage, folders)?);
    }
    Ok(variants)
}

fn compile(text: String, stage: ShaderStage, folders: [&Path; 2]) -> Result<Vec<u32>, String> {
    let compiler = Compiler::acquire().ok_or("glslang did not start")?;
    let options = CompilerOptions {
        source_language: SourceLanguage::GLSL,
        // 1.2 rather than 1.3: later versions write the group size as LocalSizeId, which needs maintenance4.
        target: Target::Vulkan { version: VulkanVersion::Vulkan1_2, spirv_version: SpirvVersion::SPIRV1_5 },
        ..CompilerOptions::default()
    };
    let mut includes = Includes { folders: folders.map(Path::to_owned) };
    let source = ShaderSource::from(text);
    let no_defines: Option<&[(&str, Option<&str>)]> = None;
    let input = ShaderInput::new(&source, stage, &options, no_defines, Some(&mut includes))
        .map_err(|error| error.to_string())?;
    let shader = compiler.create_shader(input).map_err(|error| error.to_string())?;
    shader.compile().map_err(|error| error.to_string())
}

/// Finds `#include "x"` in `shaders/include/` or beside the shader.
struct Includes {
    folders: [PathBuf; 2],
}

impl IncludeHandler for Includes {
    fn include(&mut self, _: IncludeType, name: &str, _: &str, _: usize) -> Option<IncludeResult> {
        let data = self.folders.iter().find_map(|folder| fs::read_to_string(folder.join(name)).ok())?;
        // The #line directive makes messages name the included file.
        let data = format!("#line 1 \"{name}\"\n{data}\n");
        Some(IncludeResult { name: name.to_owned(), data })
    }
}

/// The messages of glslang with the shader's path, which glslang calls `0`.
fn readable(path: &Path, message: &str) -> Vec<String> {
    let lines = message.lines().filter(|line| !line.trim().is_empty());
    lines.map(|line| line.replace("ERROR: 0:", &format!("ERROR: {}:", path.display()))).collect()
}
