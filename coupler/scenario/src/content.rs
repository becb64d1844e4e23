//! Bytes of files and their hashes.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The bytes of a file; `None` if it cannot be read, or is a pipe or a device, which may have no end.
pub fn contents(path: &Path) -> Option<Vec<u8>> {
    path.is_file().then(|| fs::read(path).ok()).flatten()
}

/// blake3 of the [`contents`] of a file, in hexadecimal.
pub fn content_hash(path: &Path) -> Option<String> {
    contents(path).map(|bytes| blake3::hash(&bytes).to_hex().to_string())
}

/// The first of these files, absolute or in a folder, whose [`content_hash`] differs from its entry.
pub fn changed<'a>(files: &'a BTreeMap<String, String>, folder: &Path) -> Option<&'a str> {
    let mut files = files.iter();
    let other = |(name, hash): &(&String, &String)| {
        content_hash(&folder.join(name)).as_ref() != Some(*hash)
    };
    files.find(other).map(|(name, _)| name.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::scratch::Scratch;

    /// A device has no end, and a missing file counts as changed.
    #[test]
    fn files_that_changed_are_found_and_devices_are_not_read() {
        assert_eq!(contents(Path::new("/dev/zero")), None);
        let scratch = Scratch::new("contents", 1);
        fs::create_dir_all(scratch.path()).expect("a folder");
        let file = scratch.path().join("grains");
        fs::write(&file, "1 2").expect("it is writable");
        let hash = content_hash(&file).expect("it is there");
        let files = BTreeMap::from([("grains".to_string(), hash)]);
        assert_eq!(changed(&files, scratch.path()), None);
        fs::write(&file, "1 3").expect("it is writable");
        assert_eq!(changed(&files, scratch.path()), Some("grains"));
        fs::remove_file(&file).expect("it is there");
        assert_eq!(changed(&files, scratch.path()), Some("grains"));
    }
}
