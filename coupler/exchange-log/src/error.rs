//! Errors of logs.

use std::error::Error;
use std::path::{Path, PathBuf};

use protocol::WithCure;
use thiserror::Error as ThisError;

/// Reasons why a log cannot be written or read.
#[derive(Debug, ThisError)]
#[allow(missing_docs)]
pub enum LogError {
    #[error("{path} cannot be written: {why}", path = .path.display())]
    Write { path: PathBuf, why: String },
    #[error("{path}: the disk took no data for {seconds} s", path = .path.display())]
    Stalled { path: PathBuf, seconds: u64 },
    #[error("{path} was closed by an earlier error", path = .path.display())]
    Closed { path: PathBuf },
    #[error("a message of {doubles} doubles is too long: a log takes at most {capacity}")]
    TooLong { doubles: usize, capacity: usize },
    #[error("{path} cannot be read: {source}", path = .path.display())]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("{path} is not an exchange log: {why}", path = .path.display())]
    NotALog {
        path: PathBuf,
        why: String,
        torn: bool,
    },
    #[error(
        "{path} {found} at byte {offset}, in {part}: {why}; the part before is valid, and --recover accepts it", path = .path.display(),
        found = if *.torn { "was cut off by the end of its writer" } else { "is damaged" }
    )]
    Damaged {
        path: PathBuf,
        offset: u64,
        part: String,
        why: String,
        torn: bool,
    },
}

impl LogError {
    /// True for a file that is only the beginning of a log, as after a killed writer; false for damage inside.
    pub fn is_torn(&self) -> bool {
        let (LogError::NotALog { torn, .. } | LogError::Damaged { torn, .. }) = self else {
            return false;
        };
        *torn
    }

    pub(super) fn write<E: Error + 'static>(path: &Path) -> impl FnOnce(E) -> LogError {
        move |error| LogError::Write {
            path: path.into(),
            why: chain(&error),
        }
    }

    pub(super) fn read(path: &Path) -> impl FnOnce(std::io::Error) -> LogError {
        let path = path.into();
        move |source| LogError::Read { path, source }
    }
}

/// Reasons why a log or its times cannot be exported.
#[derive(Debug, ThisError)]
#[allow(missing_docs)]
pub enum ExportError {
    #[error(transparent)]
    Log(#[from] LogError),
    #[error("{path}: {}", WithCure(.source), path = .path.display())]
    Write {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("windows {first}..{last}: the run has no such window; it has {has}")]
    NoWindow { first: u64, last: u64, has: String },
}

impl ExportError {
    pub(super) fn write(path: &Path) -> impl FnOnce(std::io::Error) -> ExportError {
        move |source| ExportError::Write {
            path: path.into(),
            source,
        }
    }
}

/// An error with its causes: messages of mcap leave out the reason of the system.
pub(super) fn chain(error: &(dyn Error + 'static)) -> String {
    let mut text = text_of(error);
    let mut cause = error.source();
    while let Some(error) = cause {
        let reason = text_of(error);
        if !text.contains(&reason) {
            text = format!("{text}: {reason}");
        }
        cause = error.source();
    }
    text
}

fn text_of(error: &(dyn Error + 'static)) -> String {
    let of_system = error.downcast_ref().map(WithCure);
    of_system.map_or_else(|| error.to_string(), |error| error.to_string())
}
