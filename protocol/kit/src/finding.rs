//! The kinds of findings and warnings. Each stands beside the code that judges it, in the documentation of a constant: its meaning, its
//! reason, what to do, and its bounds. `thirdbody explain`, the page `reference/findings.md` of the book and the keys of `plausible` are
//! made from them.

/// A kind of finding, as [`findings!`](crate::findings) makes it.
#[derive(Debug)]
pub struct FindingKind {
    /// Its word in summary.json.
    pub code: &'static str,
    /// Its documentation: a sentence, then the points `Why`, `Do` and, if a value is judged, `Judged`, `Valid` and `Wrong`.
    pub doc: &'static str,
    /// The default bounds `[warn, suspect]`.
    pub bounds: [f64; 2],
    /// The key of a scenario's `plausible` that replaces the bounds; empty if there is no key.
    pub key: &'static str,
    /// The tables that have this key: `run`, or kinds of participants.
    pub tables: &'static [&'static str],
}

inventory::collect!(&'static FindingKind);

/// Declares kinds of findings; users read their documentation.
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
///     /// - Judged: largest temperature over the melting temperature.
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

/// All kinds in this program, in the order of their codes.
pub fn finding_kinds() -> Vec<&'static FindingKind> {
    let mut all: Vec<_> = inventory::iter::<&'static FindingKind>().copied().collect();
    all.sort_by_key(|kind| kind.code);
    all
}

impl FindingKind {
    /// The text of a point of its documentation, on one line; empty if there is no such point.
    pub fn point(&self, name: &str) -> String {
        let head = format!("- {name}: ");
        let of = |line: &String| line.strip_prefix(&head).map(str::to_string);
        paragraphs(self.doc).iter().find_map(of).unwrap_or_default()
    }

    /// Its bounds in readable form.
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

findings! {
    /// Windows or steps were accepted without convergence.
    ///
    /// - Why: `on_not_converged = "accept"`.
    /// - Do: raise `repeats_max` or `solver.max_iterations`, or shorten the window.
    /// - Judged: Windows that were accepted without convergence, over all windows.
    /// - Valid: 0.
    /// - Wrong: 0.99 (two sweeps).
    NOT_CONVERGED = "not_converged": not_converged_rel in run dem = [0.0, 0.01];
    /// Heat was lost, or made without a loss.
    ///
    /// - Why: an error of the program.
    /// - Do: report it.
    /// - Judged: Heat produced, less stored and conducted away, and less its share of the losses in the ledger, over the sum of their sizes.
    /// - Valid: 1e-13.
    /// - Wrong: 4e-4 (impacts of a sliding disk without the part of the scheme).
    HEAT_BALANCE = "heat_balance": heat_balance_rel in dem fem = [1e-9, 1e-6];
    /// A temperature below 0 K.
    ///
    /// - Why: more heat is taken than there is, or a step of heat crosses a steep factor on the capacity.
    /// - Do: look at the fluxes of `heat.edges` and their units, and at `heat.capacity_factor`.
    /// - Judged: Lowest temperature of a grain or a point of a body, below 0 K (K).
    /// - Valid: 0.
    /// - Wrong: 260 (`heat/half-space` that gives 2e8 W/m2).
    BELOW_ZERO = "below_zero": below_zero_k in dem fem = [0.0, 0.0];
    /// Heat passes in few steps.
    ///
    /// - Why: `heat.every_steps` is large for the run, or a factor changes within a step.
    /// - Do: lower `heat.every_steps`, or make a steep table of factors gentler.
    /// - Judged: One over the number of steps of heat, where these are longer than a step of the participant. Or the most that a factor on the capacity which
    ///   changed within a step made of a temperature, over the largest change so far; or the change of a factor on the yield stress in a step.
    /// - Valid: 0.01.
    /// - Wrong: 1 (`heat/column` with `heat.every_steps` beyond its end, 10 % off after 0.2 s).
    HEAT_STEPS = "heat_steps": heat_steps_rel in dem fem = [0.05, 1e300];
    /// The force on the wheel is not its load during the hold.
    ///
    /// - Why: the load grew too fast, and the wheel still bounces.
    /// - Do: make `wheel.ramp_s` or `wheel.hold_s` longer, or the wheel lighter.
    /// - Judged: Largest difference between the wheel's force and its load in the second half of
    ///   the hold, over the load.
    /// - Valid: 0.006.
    /// - Wrong: 0.11 (hold of 0.02 ms).
    WHEEL_AT_REST = "wheel_at_rest": wheel_force_rel in dem fem = [0.05, 0.2];
}

/// The value that [`HEAT_STEPS`] judges, for `steps` of heat of `every` own steps; 0 where each own step is one.
pub fn heat_coarseness(every: u64, steps: u64) -> f64 {
    if every > 1 && steps > 0 {
        1.0 / steps as f64
    } else {
        0.0
    }
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

    #[test]
    fn the_points_of_a_kind_are_read_from_its_documentation() {
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
}
