//! The bounds of a plausibility check.

use protocol::{Cause, Finding, larger};
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error;
use serde::{Deserialize, Deserializer};
use serde_json::Map;

use crate::finding::{FindingKind, finding_kinds};
use crate::keys::ConfigError;

/// The two bounds of a check, written `[warn, suspect]` in a scenario: a value above the first gives a warning, a value above
/// the second makes the run suspect. A huge number switches a bound off.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(from = "[f64; 2]")]
pub struct Bounds {
    /// Largest value without a warning.
    pub warn: f64,
    /// Largest value of a run that is not suspect.
    pub suspect: f64,
}

impl From<[f64; 2]> for Bounds {
    fn from([warn, suspect]: [f64; 2]) -> Bounds {
        Bounds { warn, suspect }
    }
}

impl Bounds {
    /// Judges a value; larger is worse. `text` says what the value is and what to do. NaN passes both bounds.
    pub fn judge(
        &self,
        kind: &FindingKind,
        value: f64,
        text: impl FnOnce() -> String,
    ) -> Option<Finding> {
        let beyond = |bound: f64| value > bound || value.is_nan();
        beyond(self.warn.min(self.suspect)).then(|| {
            let suspect = beyond(self.suspect);
            let bound = if suspect { self.suspect } else { self.warn };
            Finding {
                code: kind.code.into(),
                text: text(),
                value: if value.is_finite() { value } else { f64::MAX },
                bound: bound.min(f64::MAX),
                suspect,
            }
        })
    }

    /// Refuses bounds that are not in order; the error names their key.
    ///
    /// # Errors
    /// Names the key and the bounds.
    pub fn check(&self, key: &str) -> Result<(), ConfigError> {
        let Bounds { warn, suspect } = self;
        if *warn >= 0.0 && warn <= suspect {
            return Ok(());
        }
        let problem = format!("[{warn}, {suspect}] are not two bounds in ascending order");
        Err(ConfigError::new(key, problem)
            .because(Cause::OutOfRange)
            .help("write [warn, suspect], for instance [0.1, 1.0]; 1e300 switches a bound off"))
    }
}

/// A range with one value more; NaN from the first NaN on.
pub fn wider(range: Option<[f64; 2]>, value: f64) -> [f64; 2] {
    let [low, high] = range.unwrap_or([value; 2]);
    [-larger(-low, -value), larger(high, value)]
}

/// [`Bounds::judge`] with a text in the form of `format!`. The bounds are given, `judge!(bounds, KIND, value; "the value is {value}")`, or come
/// from a scenario's table for the kind, `judge!(plausible => KIND, value; ...)`, or are the kind's own, `judge!(KIND, value; ...)`.
#[macro_export]
macro_rules! judge {
    ($plausible:expr => $kind:expr, $value:expr; $($text:tt)+) => {
        $plausible.of(&$kind).judge(&$kind, $value, || format!($($text)+))
    };
    ($kind:expr, $value:expr; $($text:tt)+) => {
        $crate::bounds::Bounds::from($kind.bounds).judge(&$kind, $value, || format!($($text)+))
    };
    ($bounds:expr, $kind:expr, $value:expr; $($text:tt)+) => {
        $bounds.judge(&$kind, $value, || format!($($text)+))
    };
}

/// A table of bounds in a scenario: `run`, or the kind of a participant.
pub trait Table: Clone + Debug + PartialEq {
    /// Its name in [`findings!`](crate::findings).
    const NAME: &'static str;
}

/// The table `plausible`: bounds `[warn, suspect]` of checks that replace the default ones; larger values are worse.
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

    /// Refuses the first bounds that are not in order; the error names their key below `table`.
    ///
    /// # Errors
    /// Names the key and the two bounds.
    pub fn check(&self, table: &str) -> Result<(), ConfigError> {
        let mut given = self.given.iter();
        given.try_for_each(|(key, bounds)| bounds.check(&format!("{table}.{key}")))
    }

    /// Warnings about the given bounds of checks that a scene does not have: conditions, reasons and keys.
    ///
    /// # Panics
    /// A key is no key of the table.
    pub fn idle(&self, idle: &[(bool, &str, &[&str])]) -> Vec<String> {
        let all = idle.iter().flat_map(|(.., keys)| *keys);
        let unknown = |key: &&&str| !Plausible::<T>::kinds().any(|kind| kind.key == **key);
        assert_eq!(all.into_iter().find(unknown), None, "a key of no check");
        let idle = idle.iter().filter(|(is_idle, ..)| *is_idle);
        let keys = idle.flat_map(|(_, reason, keys)| keys.iter().map(move |key| (key, reason)));
        let given = keys.filter(|(key, _)| self.given.contains_key(**key));
        let texts = given.map(|(key, reason)| {
            format!("plausible.{key}: has no effect {reason} and is not used")
        });
        texts.collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Bounds = Bounds {
        warn: 0.1,
        suspect: 1.0,
    };

    crate::findings! {
        /// A value is large.
        ///
        /// - Judged: the value.
        LARGE = "large": large_rel in dem = [0.1, 1.0];
    }

    fn judged(value: f64) -> Option<(bool, f64, f64)> {
        let finding = BOUNDS.judge(&LARGE, value, || "text".into());
        finding.map(|finding| (finding.suspect, finding.value, finding.bound))
    }

    #[test]
    fn a_value_on_a_bound_has_not_passed_it() {
        assert_eq!(judged(0.1), None);
        assert_eq!(judged(0.1001), Some((false, 0.1001, 0.1)));
        assert_eq!(judged(1.0), Some((false, 1.0, 0.1)));
        assert_eq!(judged(1.0001), Some((true, 1.0001, 1.0)));
    }

    #[test]
    fn nan_passes_every_bound_and_can_be_written() {
        assert_eq!(judged(f64::NAN), Some((true, f64::MAX, 1.0)));
        assert_eq!(judged(f64::INFINITY), Some((true, f64::MAX, 1.0)));
        let off = Bounds::from([f64::INFINITY; 2]);
        assert_eq!(off.judge(&LARGE, 1e300, String::new), None);
        let finding = off.judge(&LARGE, f64::NAN, String::new).expect("no number");
        let text = serde_json::to_string(&finding).expect("numbers");
        assert_eq!(
            serde_json::from_str::<Finding>(&text).expect("numbers"),
            finding
        );
    }

    #[test]
    fn bounds_are_refused_out_of_order() {
        assert!(BOUNDS.check("plausible.gap_rel").is_ok());
        for wrong in [[1.0, 0.1], [-1.0, 1.0], [f64::NAN, 1.0], [0.1, f64::NAN]] {
            let error = Bounds::from(wrong).check("plausible.gap_rel");
            assert_eq!(error.expect_err("out of order").key, "plausible.gap_rel");
        }
    }

    #[derive(Clone, Debug, PartialEq)]
    struct Dem;

    impl Table for Dem {
        const NAME: &'static str = "dem";
    }

    #[test]
    fn a_table_has_only_the_keys_of_its_kinds() {
        let read = |text: &str| serde_json::from_str::<Plausible<Dem>>(text);
        let given = read("{ \"large_rel\": [0.2, 0.3] }").expect("a key");
        assert_eq!(given.of(&LARGE).warn, 0.2);
        assert_eq!(Plausible::<Dem>::default().of(&LARGE).warn, 0.1);
        let problem = read("{ \"larg_rel\": [0.2, 0.3] }").expect_err("no key");
        assert!(problem.to_string().starts_with("unknown field `larg_rel`"));
        let idle = |is_idle| given.idle(&[(is_idle, "without a wheel", &["large_rel"])]);
        let said = "plausible.large_rel: has no effect without a wheel and is not used";
        assert_eq!((idle(true), idle(false)), (vec![said.into()], vec![]));
        let wrong = read("{ \"large_rel\": [0.2, 0.1] }").expect("a key");
        let error = wrong.check("plausible").expect_err("not in order");
        assert_eq!(error.key, "plausible.large_rel");
    }
}
