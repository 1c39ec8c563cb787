//! Event log of the window: `--json` writes it to a file, `-v` logs events to standard error, `-vv` also frames.

use serde::Serialize;
use serde_json::{Value, json};

use super::error::DemoError;
use super::history::Sample;
use crate::output::{Growing, OutputFile};
use crate::report::COMMIT;

/// The log, streamed to disk.
pub(super) struct Log {
    file: Option<Growing>,
    frame: u64,
    first: bool,
    failed: Option<DemoError>,
}

impl Log {
    /// A log to `file`, which must be writable.
    pub fn new(file: Option<&std::path::Path>) -> Result<Self, DemoError> {
        let file = file.map(|path| OutputFile::new(path)?.grow()).transpose()?;
        let mut log = Self { file, frame: 0, first: true, failed: None };
        let head = format!("{{\"commit\": {}, \"events\": [", json!(COMMIT));
        log.write(head.as_bytes());
        Ok(log)
    }

    /// Logs an event.
    pub fn event(&mut self, name: &str, details: impl Serialize) {
        let details = serde_json::to_value(details).unwrap_or(Value::Null);
        let entry = json!({ "frame": self.frame, "event": name, "details": details });
        log::info!("{entry}");
        self.entry(&entry);
    }

    /// Logs a presented frame, with the latest measurements.
    pub fn shown(&mut self, sample: &Sample) {
        let entry = json!({
            "frame": self.frame,
            "event": "frame",
            "interval_ms": sample.interval_ms,
            "ui_cpu_ms": sample.ui_cpu_ms,
            "ui_device_ms": sample.ui_device_ms,
            "measured": sample.report,
        });
        log::debug!("{entry}");
        self.entry(&entry);
        self.frame += 1;
    }

    /// Completes the file and moves it to its target.
    pub fn finish(mut self) -> Result<(), DemoError> {
        self.write(b"\n]}\n");
        if let Some(error) = self.failed {
            return Err(error);
        }
        Ok(self.file.map(Growing::finish).transpose().map(|_| ())?)
    }

    fn entry(&mut self, entry: &Value) {
        let separator = if std::mem::take(&mut self.first) { "\n" } else { ",\n" };
        self.write(format!("{separator}{entry}").as_bytes());
    }

    fn write(&mut self, bytes: &[u8]) {
        if let Some(Err(error)) = self.file.as_mut().map(|file| file.write(bytes)) {
            self.failed.get_or_insert(error.into());
        }
    }
}
