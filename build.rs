//! Compiles every shader of `shaders/` to SPIR-V and sets `GLOWWORM_COMMIT`.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use glslang::include::{IncludeHandler, IncludeResult, IncludeType};
use glslang::{
    Compiler, CompilerOptions, ShaderInput, ShaderSource, ShaderStage, SourceLanguage, SpirvVersion, Target,
    VulkanVersion,
};

/// Finds `#include "x"` in `shaders/include/` or beside the shader.
struct Includes {
    folders: [PathBuf; 2],
}

impl IncludeHandler for Includes {
    fn include(&mut self, _: IncludeType, name: &str, _: &str, _: usize) -> Option<IncludeResult> {
        let data = self.folders.iter().find_map(|folder| std::fs::read_to_string(folder.join(name)).ok())?;
        // The #line directive makes messages name the included file.
        let data = format!("#line 1 \"{name}\"\n{data}\n");
        Some(IncludeResult { name: name.to_owned(), data })
    }
}

fn main() {
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("set by cargo"));
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("set by cargo"));
    compile_shaders(&root.join("shaders"), &out);
    set_commit(&root);
}

fn compile_shaders(folder: &Path, out: &Path) {
    println!("cargo:rerun-if-changed={}", folder.display());
    let mut rust = String::new();
    let mut failed = false;
    for path in files(folder) {
        let Some(stage) = stage_of(&path) else { continue };
        let name = path.file_name().expect("a file").to_string_lossy().into_owned();
        match compile_variants(&path, stage, &folder.join("include"), &out.join(&name)) {
            Ok(value) => {
                let constant = name.replace('.', "_").to_uppercase();
                writeln!(rust, "/// `{name}`, compiled.\npub const {constant}: {value};")
                    .expect("writing to a string");
            }
            Err(message) => {
                failed = true;
                report(&path, &message);
            }
        }
    }
    assert!(!failed, "shaders did not compile; the messages are above");
    std::fs::write(out.join("shaders.rs"), rust).expect("OUT_DIR is writable");
}

/// All files in a folder, recursively.
fn files(folder: &Path) -> BTreeSet<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return BTreeSet::new() };
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    paths.flat_map(|path| if path.is_dir() { files(&path) } else { BTreeSet::from([path]) }).collect()
}

fn stage_of(path: &Path) -> Option<ShaderStage> {
    match path.extension()?.to_str()? {
        "comp" => Some(ShaderStage::Compute),
        "vert" => Some(ShaderStage::Vertex),
        "frag" => Some(ShaderStage::Fragment),
        _ => None,
    }
}

/// Compiles a shader; one that traces rays, once for each tracer. Returns type and value of its constant.
fn compile_variants(path: &Path, stage: ShaderStage, include: &Path, out: &Path) -> Result<String, String> {
    let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
    let compile_to = |text: String, extension: &str| {
        let words = compile(text, stage, [include, path.parent().unwrap_or(include)])?;
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let target = out.with_added_extension(extension);
        std::fs::write(&target, bytes).expect("OUT_DIR is writable");
        Ok::<String, String>(format!("include_bytes!({target:?})"))
    };
    if !text.contains("#include \"tracer.glsl\"") {
        return Ok(format!("&[u8] = {}", compile_to(text, "spv")?));
    }
    let (version, rest) = text.split_once('\n').ok_or("a shader must begin with #version")?;
    let hardware = "#extension GL_EXT_ray_query : require\n#define TRACER_HARDWARE\n#line 2";
    let hardware = compile_to(format!("{version}\n{hardware}\n{rest}"), "hardware.spv")?;
    let software = compile_to(text, "software.spv")?;
    Ok(format!("PerTracer = PerTracer {{ software: {software}, hardware: {hardware} }}"))
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

/// Prints glslang's messages as `file:line: message`; it calls the main file `0`.
fn report(path: &Path, message: &str) {
    for line in message.lines().filter(|line| !line.trim().is_empty()) {
        let line = line.replace("ERROR: 0:", &format!("ERROR: {}:", path.display()));
        println!("cargo:warning={line}");
        eprintln!("{line}");
    }
}

fn set_commit(root: &Path) {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").arg("-C").arg(root).args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]) {
        println!("cargo:rerun-if-changed={}", root.join(log).display());
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"]).unwrap_or_else(|| "unknown".to_owned());
    println!("cargo:rustc-env=GLOWWORM_COMMIT={commit}");
}
