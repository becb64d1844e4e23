//! A finished drawing with its words.

/// A drawing with its file name and words.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Name of its file.
    pub file: String,
    /// Text below it.
    pub caption: String,
    /// Description with numbers, for a reader who cannot see it.
    pub alternative: String,
    /// The drawing itself.
    pub svg: String,
}
