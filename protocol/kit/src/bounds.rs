//! The bounds of a check of plausibility.

use protocol::{Cause, Finding};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::keys::ConfigError;

/// The two bounds of a check, written `[warn, suspect]` in a scenario: a value above the first is worth a warning, one above
/// the second makes the run suspect. A huge number switches a bound off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(from = "[f64; 2]", into = "[f64; 2]")]
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

impl From<Bounds> for [f64; 2] {
    fn from(bounds: Bounds) -> [f64; 2] {
        [bounds.warn, bounds.suspect]
    }
}

impl Bounds {
    /// Judges a value, larger being worse; `text` says what it is and what to do. A value that is no number passes both bounds.
    pub fn judge(&self, code: &str, value: f64, text: impl FnOnce() -> String) -> Option<Finding> {
        let beyond = |bound: f64| value > bound || value.is_nan();
        beyond(self.warn.min(self.suspect)).then(|| {
            let suspect = beyond(self.suspect);
            let bound = if suspect { self.suspect } else { self.warn };
            Finding {
                code: code.into(),
                text: text(),
                value: if value.is_finite() { value } else { f64::MAX },
                bound: bound.min(f64::MAX),
                suspect,
            }
        })
    }

    /// Refuses the first of these bounds, by their keys below `table`, that are not in order.
    pub fn check_all<const N: usize>(
        table: &str,
        all: [(&str, Bounds); N],
    ) -> Result<(), ConfigError> {
        let in_order = |bounds: &Bounds| bounds.warn >= 0.0 && bounds.warn <= bounds.suspect;
        let Some((key, Bounds { warn, suspect })) =
            all.into_iter().find(|(_, bounds)| !in_order(bounds))
        else {
            return Ok(());
        };
        let problem = format!("[{warn}, {suspect}] are not two bounds in rising order");
        Err(ConfigError::new(&format!("{table}.{key}"), problem)
            .because(Cause::OutOfRange)
            .help("write [warn, suspect], for instance [0.1, 1.0]; 1e300 switches a bound off"))
    }
}

/// [`Bounds::judge`] with a text as `format!` takes it: `judge!(bounds, "code", value; "the value is {value}")`.
#[macro_export]
macro_rules! judge {
    ($bounds:expr, $code:expr, $value:expr; $($text:tt)+) => {
        $bounds.judge($code, $value, || format!($($text)+))
    };
}

/// A table `plausible`: a type with the bounds of checks, each written `field = [warn, suspect]` with the values where a scenario has
/// none. Its `check` refuses the first that are not in order, by their keys below `table`.
#[macro_export]
macro_rules! plausible_bounds {
    ($(#[$about:meta])* $name:ident { $($(#[$doc:meta])* $field:ident = $default:expr,)* }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct $name {
            $($(#[$doc])* pub $field: $crate::bounds::Bounds,)*
        }

        impl Default for $name {
            fn default() -> $name {
                $name { $($field: $crate::bounds::Bounds::from($default),)* }
            }
        }

        impl $name {
            pub(crate) fn check(&self, table: &str) -> Result<(), $crate::keys::ConfigError> {
                $crate::bounds::Bounds::check_all(table, [$((stringify!($field), self.$field)),*])
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Bounds = Bounds {
        warn: 0.1,
        suspect: 1.0,
    };

    fn judged(value: f64) -> Option<(bool, f64, f64)> {
        let finding = BOUNDS.judge("code", value, || "text".into());
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
    fn what_is_no_number_passes_every_bound_and_can_be_written() {
        assert_eq!(judged(f64::NAN), Some((true, f64::MAX, 1.0)));
        assert_eq!(judged(f64::INFINITY), Some((true, f64::MAX, 1.0)));
        let off = Bounds::from([f64::INFINITY; 2]);
        assert_eq!(off.judge("code", 1e300, String::new), None);
        let finding = off.judge("code", f64::NAN, String::new).expect("no number");
        let text = serde_json::to_string(&finding).expect("numbers");
        assert_eq!(
            serde_json::from_str::<Finding>(&text).expect("numbers"),
            finding
        );
    }

    #[test]
    fn bounds_are_refused_out_of_order() {
        let check =
            |second| Bounds::check_all("plausible", [("gap_rel", BOUNDS), ("overlap_rel", second)]);
        assert!(check(BOUNDS).is_ok());
        for wrong in [[1.0, 0.1], [-1.0, 1.0], [f64::NAN, 1.0], [0.1, f64::NAN]] {
            let error = check(Bounds::from(wrong));
            assert_eq!(
                error.expect_err("out of order").key,
                "plausible.overlap_rel"
            );
        }
    }
}
