//! Errors of the system, with what to do about them.

use std::fmt;
use std::io::{self, ErrorKind};

use nix::errno::Errno;

/// An error of the system and, where one is known, its cure.
pub struct WithCure<'a>(pub &'a io::Error);

impl fmt::Display for WithCure<'_> {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        write!(out, "{}", self.0)?;
        cure(self.0).map_or(Ok(()), |cure| write!(out, "; {cure}"))
    }
}

fn cure(error: &io::Error) -> Option<&'static str> {
    let code = error.raw_os_error().map(Errno::from_raw);
    match (error.kind(), code) {
        (ErrorKind::StorageFull, _) => Some(
            "free some space, or some files if `df -i` shows none left, or choose another place (--out, TMPDIR)",
        ),
        (ErrorKind::QuotaExceeded, _) => {
            Some("this user's share of the disk is used up: choose another place (--out, TMPDIR)")
        }
        (ErrorKind::FileTooLarge, _) => Some(
            "raise the limit on the size of files (ulimit -f), or set run.output.exchange = false",
        ),
        (ErrorKind::ReadOnlyFilesystem, _) => Some("choose another place (--out, TMPDIR)"),
        (_, Some(Errno::EMFILE | Errno::ENFILE)) => {
            Some("raise the limit on open files (ulimit -n)")
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_for_lack_of_room_names_its_cure() {
        for (code, word) in [
            (Errno::ENOSPC, "df -i"),
            (Errno::EDQUOT, "share of the disk"),
            (Errno::EFBIG, "ulimit -f"),
            (Errno::EROFS, "--out"),
            (Errno::EMFILE, "ulimit -n"),
        ] {
            let error = io::Error::from(code);
            let text = WithCure(&error).to_string();
            assert!(text.starts_with(&error.to_string()), "{text}");
            assert!(text.contains(word), "{text}");
        }
        let other = io::Error::from(Errno::ENOENT);
        assert_eq!(WithCure(&other).to_string(), other.to_string());
    }
}
