//! The kinds of findings and warnings. Each stands beside the code that judges it, in the documentation of a constant: what it says, why
//! it comes, what to do, and its bounds. `thirdbody explain`, `coupler/ERRORS.md`, the keys of `plausible` and the manual's table of
//! bounds are made from these.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, de::Error};
use serde_json::Map;

use crate::Bounds;
use crate::keys::ConfigError;

/// A kind of finding, as [`findings!`](crate::findings) makes it.
#[derive(Debug)]
pub struct FindingKind {
    /// Its word in summary.json.
    pub code: &'static str,
    /// Its documentation: a sentence, then the points `Why`, `Do` and, where a value is judged, `Judged`, `Valid` and `Wrong`.
    pub doc: &'static str,
    /// The bounds `[warn, suspect]` where no scenario gives others.
    pub bounds: [f64; 2],
    /// The key of a scenario's `plausible` that gives others; empty where there is none.
    pub key: &'static str,
    /// The tables that have this key: `run`, or kinds of participants.
    pub tables: &'static [&'static str],
}

inventory::collect!(&'static FindingKind);

/// Declares kinds of findings; their documentation is what a user reads of them.
///
/// ```
/// kit::findings! {
///     /// Grains are hot.
///     ///
///     /// - Why: they rub.
///     /// - Do: let them cool.
///     HOT = "hot";
///     /// Grains are far too hot.
///     ///
///     /// - Why: they rub fast.
///     /// - Do: lower the speed.
///     /// - Judged: largest temperature over that of melting.
///     MOLTEN = "molten": melt_rel in dem = [0.5, 1.0];
/// }
/// assert_eq!(MOLTEN.code, "molten");
/// ```
#[macro_export]
macro_rules! findings {
    ($($(#[doc = $doc:literal])+ $name:ident = $code:literal
        $(: $($key:ident in $($table:ident)+ =)? [$warn:expr, $suspect:expr])?;)+) => {
        $($(#[doc = $doc])+
        pub static $name: $crate::finding::FindingKind = $crate::finding::FindingKind {
            code: $code,
            doc: concat!($($doc, "\n"),+),
            bounds: $crate::first!($([$warn, $suspect],)? [f64::INFINITY; 2]),
            key: $crate::first!($($(stringify!($key),)?)? ""),
            tables: &[$($($(stringify!($table)),+)?)?],
        };
        $crate::inventory::submit! { &$name })+
    };
}

/// The first of its arguments.
#[doc(hidden)]
#[macro_export]
macro_rules! first {
    ($first:expr $(, $rest:expr)*) => {
        $first
    };
}

/// All kinds that this program has, in the order of their codes.
pub fn finding_kinds() -> Vec<&'static FindingKind> {
    let mut all: Vec<_> = inventory::iter::<&'static FindingKind>().copied().collect();
    all.sort_by_key(|kind| kind.code);
    all
}

impl FindingKind {
    /// The text of a point of its documentation, on one line; empty where it has no such point.
    pub fn point(&self, name: &str) -> String {
        let head = format!("- {name}: ");
        let of = |line: &String| line.strip_prefix(&head).map(str::to_string);
        paragraphs(self.doc).iter().find_map(of).unwrap_or_default()
    }

    /// Its bounds as a person writes them.
    pub fn bounds_in_words(&self) -> [String; 2] {
        self.bounds.map(|bound| match bound {
            huge if huge >= 1e6 => format!("{huge:e}"),
            bound => bound.to_string(),
        })
    }
}

/// The headings, paragraphs and points of a documentation, each on one line.
pub fn paragraphs(doc: &str) -> Vec<String> {
    let mut all = vec![String::new()];
    for line in doc.lines().map(str::trim) {
        let last = all.last_mut().expect("there is one");
        let begins = ["- ", "# "].iter().any(|mark| line.starts_with(mark));
        if line.is_empty() || begins {
            all.push(line.into());
        } else {
            *last += if last.is_empty() { "" } else { " " };
            *last += line;
        }
    }
    all.retain(|paragraph| !paragraph.is_empty());
    all
}

/// A table of bounds that a scenario has: `run`, or the kind of a participant.
pub trait Table: Clone + Debug + PartialEq {
    /// Its name in [`findings!`](crate::findings).
    const NAME: &'static str;
}

/// The table `plausible`: bounds `[warn, suspect]` of checks, larger values being worse, each where a scenario gives others.
#[derive(Clone, Debug, PartialEq)]
pub struct Plausible<T> {
    given: BTreeMap<String, Bounds>,
    table: PhantomData<T>,
}

impl<T> Default for Plausible<T> {
    fn default() -> Plausible<T> {
        Plausible {
            given: BTreeMap::new(),
            table: PhantomData,
        }
    }
}

impl<T: Table> Plausible<T> {
    /// The bounds of a kind.
    pub fn of(&self, kind: &FindingKind) -> Bounds {
        let given = self.given.get(kind.key).copied();
        given.unwrap_or_else(|| kind.bounds.into())
    }

    /// Refuses the first of these bounds, by their keys below `table`, that are not in order.
    ///
    /// # Errors
    /// Names the key and the two bounds.
    pub fn check(&self, table: &str) -> Result<(), ConfigError> {
        let mut given = self.given.iter();
        given.try_for_each(|(key, bounds)| bounds.check(&format!("{table}.{key}")))
    }

    fn kinds() -> impl Iterator<Item = &'static FindingKind> {
        let all = finding_kinds().into_iter();
        all.filter(|kind| kind.tables.contains(&T::NAME))
    }
}

impl<'de, T: Table> Deserialize<'de> for Plausible<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Plausible<T>, D::Error> {
        let given = BTreeMap::<String, Bounds>::deserialize(from)?;
        let keys: Vec<&str> = Plausible::<T>::kinds().map(|kind| kind.key).collect();
        match given.keys().find(|key| !keys.contains(&key.as_str())) {
            Some(key) => Err(D::Error::custom(format!(
                "unknown field `{key}`, expected one of `{}`",
                keys.join("`, `")
            ))),
            None => Ok(Plausible {
                given,
                table: PhantomData,
            }),
        }
    }
}

impl<T: Table> JsonSchema for Plausible<T> {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        format!("Plausible_{}", T::NAME).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut properties = Map::new();
        for kind in Plausible::<T>::kinds() {
            let mut bounds = generator.subschema_for::<Bounds>();
            bounds.insert("description".into(), kind.point("Judged").into());
            bounds.insert("default".into(), kind.bounds.to_vec().into());
            properties.insert(kind.key.into(), bounds.to_value());
        }
        json_schema!({ "type": "object", "additionalProperties": false, "properties": properties })
    }
}

findings! {
    /// Windows or steps were accepted without having converged.
    ///
    /// - Why: `on_not_converged = "accept"`.
    /// - Do: raise `repeats_max` or `solver.max_iterations`, or shorten the window.
    /// - Judged: Windows that were accepted without having converged, over all.
    /// - Valid: 0.
    /// - Wrong: 0.99 (two sweeps).
    NOT_CONVERGED = "not_converged": not_converged_rel in run dem = [0.0, 0.01];
    /// The force on the wheel is not its load during the hold.
    ///
    /// - Why: the load came too fast, and the wheel still bounces.
    /// - Do: make `wheel.ramp_s` or `wheel.hold_s` longer, or the wheel lighter.
    /// - Judged: Largest distance of the wheel's force from its load in the second half of the
    ///   hold, over the load.
    /// - Valid: 0.006.
    /// - Wrong: 0.11 (hold of 0.02 ms).
    WHEEL_AT_REST = "wheel_at_rest": wheel_force_rel in dem fem = [0.05, 0.2];
}

#[cfg(test)]
mod tests {
    use super::*;

    findings! {
        /// A value is
        /// large.
        ///
        /// - Why: it
        ///   grew.
        /// - Do: wait.
        /// - Judged: the value
        ///   over one.
        LARGE = "large": large_rel in dem fem = [0.1, 1.0];
        /// Nothing.
        NOTHING = "nothing";
    }

    #[derive(Clone, Debug, PartialEq)]
    struct Dem;

    impl Table for Dem {
        const NAME: &'static str = "dem";
    }

    #[test]
    fn a_kind_is_read_from_its_documentation() {
        assert_eq!(paragraphs(LARGE.doc)[0], "A value is large.");
        assert_eq!(LARGE.point("Why"), "it grew.");
        assert_eq!(LARGE.point("Judged"), "the value over one.");
        assert_eq!(
            (LARGE.key, LARGE.tables),
            ("large_rel", &["dem", "fem"][..])
        );
        assert_eq!((NOTHING.key, NOTHING.bounds), ("", [f64::INFINITY; 2]));
        assert!(finding_kinds().iter().any(|kind| kind.code == "large"));
    }

    #[test]
    fn a_table_has_the_keys_of_its_kinds_alone() {
        let read = |text: &str| serde_json::from_str::<Plausible<Dem>>(text);
        let given = read("{ \"large_rel\": [0.2, 0.3] }").expect("a key");
        assert_eq!(given.of(&LARGE).warn, 0.2);
        assert_eq!(Plausible::<Dem>::default().of(&LARGE).warn, 0.1);
        let problem = read("{ \"larg_rel\": [0.2, 0.3] }").expect_err("no key");
        assert!(problem.to_string().starts_with("unknown field `larg_rel`"));
        let wrong = read("{ \"large_rel\": [0.2, 0.1] }").expect("a key");
        let error = wrong.check("plausible").expect_err("not in order");
        assert_eq!(error.key, "plausible.large_rel");
    }
}
