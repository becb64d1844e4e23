//! Reads arrays of the solvers' VTK XML files by the rules of "VTK File Formats" for appended raw data: an array is at its
//! offset behind the underscore, after its length in bytes as a UInt64.

/// The numbers of an array.
pub fn array(file: &[u8], name: &str) -> Vec<f64> {
    array_in(file, name, "<Piece")
}

/// The numbers of the first array of this name after `section`.
pub fn array_in(file: &[u8], name: &str, section: &str) -> Vec<f64> {
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let end = file.windows(mark.len()).position(|bytes| bytes == mark);
    let (markup, appended) = file.split_at(end.expect("there is appended data"));
    let markup = std::str::from_utf8(markup).expect("markup is text");
    assert!(markup.contains("header_type=\"UInt64\""), "{markup}");
    let (_, after) = markup.split_once(section).expect("the section is there");
    let tag = after
        .split("<DataArray ")
        .find(|tag| tag.contains(&format!("Name=\"{name}\"")));
    let tag = tag.unwrap_or_else(|| panic!("there is no {name}: {after}"));
    let offset: usize = value(tag, "offset").parse().expect("a number");
    let bytes = &appended[mark.len() + offset..];
    let length = u64::from_le_bytes(bytes[..8].try_into().expect("eight bytes"));
    numbers(value(tag, "type"), &bytes[8..8 + length as usize])
}

fn value<'a>(tag: &'a str, attribute: &str) -> &'a str {
    let (_, rest) = tag
        .split_once(&format!("{attribute}=\""))
        .expect("it is there");
    rest.split('"').next().expect("it ends")
}

fn numbers(kind: &str, bytes: &[u8]) -> Vec<f64> {
    match kind {
        "Float64" => words(bytes).map(f64::from_le_bytes).collect(),
        "Int64" => words(bytes).map(|b| i64::from_le_bytes(b) as f64).collect(),
        "Int32" => words(bytes).map(|b| i32::from_le_bytes(b).into()).collect(),
        "Int8" => words(bytes).map(|b| i8::from_le_bytes(b).into()).collect(),
        "UInt8" => bytes.iter().map(|b| f64::from(*b)).collect(),
        _ => panic!("the solvers do not write the type {kind}"),
    }
}

fn words<const N: usize>(bytes: &[u8]) -> impl Iterator<Item = [u8; N]> {
    assert!(bytes.len().is_multiple_of(N), "{} bytes", bytes.len());
    bytes
        .chunks_exact(N)
        .map(|b| b.try_into().expect("its size"))
}
