//! The results and signals of a program, each explained beside the code that computes it. The report of a run, `thirdbody explain` and
//! the page `reference/results.md` of the book are made from them.

use crate::finding::paragraphs;

/// A list of results, as [`macro@crate::results`] makes it.
#[derive(Debug)]
pub struct ResultList {
    /// Its source file.
    pub file: &'static str,
    /// Its text: headings of groups, and a point for each result.
    pub doc: &'static str,
}

inventory::collect!(ResultList);

/// Declares results: headings of groups, and a point for each result below them.
///
/// ```
/// kit::results! {
///     /// # Heat
///     /// - `temperature_k`: Highest temperature of a grain.
/// }
/// let all = kit::results::results();
/// assert!(all.iter().any(|result| result.name == "temperature_k"));
/// ```
#[macro_export]
macro_rules! results {
    ($(#[doc = $doc:literal])+) => {
        $crate::inventory::submit! {
            $crate::results::ResultList { file: file!(), doc: concat!($($doc, "\n"),+) }
        }
    };
}

/// A result or a signal.
#[derive(Clone, Debug)]
pub struct ResultKind {
    /// Heading of its group.
    pub group: String,
    /// Its name, which may begin with `<set>`.
    pub name: String,
    /// Its explanation; the name ends with its unit.
    pub sentence: String,
}

/// All results and signals of this program, file by file.
pub fn results() -> Vec<ResultKind> {
    let mut lists: Vec<&ResultList> = inventory::iter::<ResultList>().collect();
    lists.sort_by_key(|list| (list.file, list.doc));
    let mut all = Vec::new();
    for list in lists {
        let mut group = String::new();
        for paragraph in paragraphs(list.doc) {
            if let Some(title) = paragraph.strip_prefix("# ") {
                group = title.into();
            } else if let Some((name, sentence)) = paragraph
                .strip_prefix("- `")
                .and_then(|point| point.split_once("`: "))
            {
                all.push(ResultKind {
                    group: group.clone(),
                    name: name.into(),
                    sentence: sentence.into(),
                });
            }
        }
    }
    all
}
