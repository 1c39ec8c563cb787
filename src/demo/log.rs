//! What happened in the window, frame by frame: with `--json` in a file, with `-v` on standard error,
//! with `-vv` each frame too.

use serde::Serialize;
use serde_json::{Value, json};

use super::DemoError;
use super::history::Sample;
use crate::output::{Growing, OutputFile};
use crate::report::COMMIT;

/// The log. It goes to disk as it grows, so a long session costs no memory.
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

    /// Something happened.
    pub fn event(&mut self, name: &str, details: impl Serialize) {
        let details = serde_json::to_value(details).unwrap_or(Value::Null);
        let entry = json!({ "frame": self.frame, "event": name, "details": details });
        log::info!("{entry}");
        self.entry(&entry);
    }

    /// A frame is on its way to the screen; what was measured is of the last frame that is known.
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

    /// Closes the file and puts it in its place.
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
