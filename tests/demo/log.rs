//! The program's standard error: events as JSON, and other lines.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use serde_json::Value;

/// The program's log. A file, not a pipe, so that writes are visible at once.
pub struct Log {
    file: BufReader<File>,
    line: String,
    events: Vec<Value>,
    other: String,
}

impl Log {
    pub fn open(path: &Path) -> Self {
        let file = BufReader::new(File::open(path).unwrap());
        Self { file, line: String::new(), events: Vec::new(), other: String::new() }
    }

    /// All events so far.
    pub fn events(&mut self) -> &[Value] {
        // The last line may be half written.
        while self.file.read_line(&mut self.line).unwrap() > 0 && self.line.ends_with('\n') {
            let line = std::mem::take(&mut self.line);
            let json =
                ["note", "detail"].iter().find_map(|kind| line.strip_prefix(&format!("glowworm: {kind}: ")));
            match json.and_then(|json| serde_json::from_str(json).ok()) {
                Some(event) => self.events.push(event),
                None => self.other += &line,
            }
        }
        &self.events
    }

    /// All other lines.
    pub fn other(&self) -> &str {
        &self.other
    }
}
