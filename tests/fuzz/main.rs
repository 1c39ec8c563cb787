//! Mutated files of every kind that is read: each gives a scene or an error of one line, in seconds and bounded memory.
//!
//! `GLOWWORM_FUZZ` is the number of mutations (800, or 2,000 where all is tested), `GLOWWORM_FUZZ_SEED` the first seed; `scripts/fuzz` runs more. A failure
//! names its seed and leaves the files.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../support/compressed.rs"]
mod compressed;
#[path = "../support/depth.rs"]
mod depth;
mod inputs;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::mpsc::channel;
use std::time::Duration;

use glowworm::formats::load_scene;
use glowworm::reference::{Reference, ReferenceSettings};
use glowworm::settings::Settings;
use serde_json::{Value, json};

use inputs::{Files, all, mend_png};

/// Longest time to load one input.
const LIMIT: Duration = Duration::from_secs(5);

/// Most memory of the whole run, kB.
const MOST_MEMORY: u64 = 3_000_000;

/// SplitMix64 (Steele et al. 2014).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ mixed >> 31) % end.max(1) as u64) as usize
    }

    fn of<'a, T>(&mut self, choices: &'a [T]) -> &'a T {
        &choices[self.below(choices.len())]
    }
}

/// Words that readers stumble over.
const WORDS: [&str; 22] = [
    "-1",
    "0",
    "1",
    "4294967296",
    "99999999999999999999",
    "1e39",
    "-1e30",
    "nan",
    "inf",
    "1e-40",
    "\"",
    "\u{1b}[31m",
    "\u{7}",
    "/",
    "//",
    "..",
    "\\",
    "#",
    "\0",
    "\u{feff}",
    "{}",
    "é日",
];

/// Changes some bytes or words.
fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..1 + random.below(4) {
        let (at, length) = (random.below(bytes.len()), 1 + random.below(16));
        let end = (at + length).min(bytes.len());
        match random.below(8) {
            _ if bytes.is_empty() => bytes.push(random.below(256) as u8),
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at] = random.below(256) as u8,
            2 => bytes[at] = *random.of(&[0, 1, 0x7f, 0x80, 0xff, b' ', b'\n', b'-', b'9']),
            3 => _ = bytes.drain(at..end),
            4 => _ = bytes.splice(at..at, bytes[at..end].to_vec()),
            5 => bytes.truncate(at),
            _ => {
                // Replace a whole word.
                let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || b"._-".contains(byte);
                let start = bytes[..at].iter().rposition(|byte| !is_word(byte)).map_or(0, |place| place + 1);
                let end = bytes[at..]
                    .iter()
                    .position(|byte| !is_word(byte))
                    .map_or(bytes.len(), |place| at + place);
                bytes.splice(start..end.max(start), random.of(&WORDS).bytes());
            }
        }
    }
}

/// Changes a value of a document, or removes it.
fn mutate_json(value: &mut Value, random: &mut Random) {
    let goes_deeper = random.below(8) > 0;
    match value {
        Value::Object(members) if goes_deeper && !members.is_empty() => {
            let key = members.keys().nth(random.below(members.len())).cloned().unwrap();
            match random.below(12) {
                0 => _ = members.remove(&key),
                _ => mutate_json(&mut members[&key], random),
            }
        }
        Value::Array(entries) if goes_deeper && !entries.is_empty() => {
            let place = random.below(entries.len());
            match random.below(12) {
                0 => _ = entries.remove(place),
                1 => entries.push(entries[place].clone()),
                _ => mutate_json(&mut entries[place], random),
            }
        }
        _ => {
            let small = random.below(12);
            let values = [
                json!(small),
                json!(small),
                json!(-1),
                json!(4_294_967_295u32),
                json!(1e38),
                json!(1e-40),
                json!(0.5),
                json!(5123),
                json!([]),
                json!({}),
                json!([0, 1, 2]),
                json!("\u{1b}[31m\n"),
                json!("SCALAR"),
                json!("MAT4"),
                json!("weights"),
                json!("pointer"),
                json!(true),
                Value::Null,
            ];
            *value = random.of(&values).clone();
        }
    }
}

/// Mutates one file of an input, documents as often by their structure as by their bytes.
fn mutate_input(files: &mut Files, random: &mut Random) {
    let place = if random.below(2) == 0 { files.len() - 1 } else { random.below(files.len()) };
    let (name, bytes) = &mut files[place];
    if name.ends_with(".gltf") && random.below(4) > 0 {
        let mut document = serde_json::from_slice(bytes).unwrap();
        (0..1 + random.below(2)).for_each(|_| mutate_json(&mut document, random));
        *bytes = document.to_string().into_bytes();
        return;
    }
    mutate(bytes, random);
    if bytes.starts_with(b"\x89PNG") && random.below(8) > 0 {
        mend_png(bytes);
    }
}

/// The fault in how an input is handled, if there is one.
fn fault(scene: &Path, renders: bool) -> Option<String> {
    let (sender, receiver) = channel();
    let path = scene.to_str().unwrap().to_owned();
    std::thread::spawn(move || {
        let loaded = catch_unwind(AssertUnwindSafe(|| {
            let scene = load_scene(&path, None).map_err(|error| error.to_string())?;
            // A scene that loads can be rendered.
            if !renders {
                return Ok(scene.warnings);
            }
            let settings = Settings { size: [4, 4], ..Settings::default() };
            let pose = scene.pose(0.25);
            let reference = Reference::new(&scene, &pose, &ReferenceSettings::like(&settings));
            let mut film = reference.film().map_err(|error| error.to_string())?;
            reference.add_sample(&mut film, &false.into());
            Ok::<_, String>(scene.warnings)
        }));
        let _ = sender.send(loaded);
    });
    let lines = match receiver.recv_timeout(LIMIT) {
        Err(_) => return Some(format!("takes more than {LIMIT:?}")),
        Ok(Err(panic)) => {
            let what = panic.downcast_ref::<String>().map(String::as_str);
            return Some(format!("panic: {}", what.or(panic.downcast_ref().copied()).unwrap_or("?")));
        }
        Ok(Ok(Ok(warnings))) => warnings,
        Ok(Ok(Err(error))) => vec![error],
    };
    lines.into_iter().find(|line| line.chars().any(char::is_control) || line.len() > 5000)
}

/// The peak of this program's memory, kB; none where the system does not tell.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.split_whitespace().next()?.parse().ok()
}

fn number(variable: &str, default: u64) -> u64 {
    std::env::var(variable).map_or(default, |text| text.parse().unwrap())
}

#[test]
fn mutated_files_give_a_scene_or_a_line() {
    std::panic::set_hook(Box::new(|_| {}));
    let (inputs, first) = (all(), number("GLOWWORM_FUZZ_SEED", 0));
    let folder = tempfile::tempdir().unwrap();
    let write = |files: &Files| {
        files.iter().for_each(|(name, bytes)| std::fs::write(folder.path().join(name), bytes).unwrap());
        folder.path().join(&files[0].0)
    };
    let mut faults = Vec::new();
    for files in &inputs {
        let loaded = load_scene(write(files).to_str().unwrap(), None);
        faults.extend(loaded.err().map(|error| format!("whole: {error}")));
    }
    for seed in first..first + number("GLOWWORM_FUZZ", depth::quick_or_all(800, 2000)) {
        let mut random = Random(seed << 20);
        let mut files = inputs[seed as usize % inputs.len()].clone();
        mutate_input(&mut files, &mut random);
        let scene = write(&files);
        if let Some(what) = fault(&scene, seed.is_multiple_of(4)) {
            let kept = std::env::temp_dir().join(format!("glowworm-fuzz-{seed}"));
            std::fs::create_dir_all(&kept).unwrap();
            files.iter().for_each(|(name, bytes)| std::fs::write(kept.join(name), bytes).unwrap());
            faults.push(format!("seed {seed}, {}: {what}", kept.join(&files[0].0).display()));
        }
    }
    let _ = std::panic::take_hook();
    assert!(faults.is_empty(), "{} of them:\n{}", faults.len(), faults.join("\n"));
    assert!(peak_memory().is_none_or(|peak| peak < MOST_MEMORY), "{:?} kB", peak_memory());
}
