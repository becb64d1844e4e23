//! The Pareto front of a study: the settings that no other setting beats both in cost and in error.

/// A setting by its cost and its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trade {
    /// Index of the setting.
    pub setting: usize,
    /// Its cost.
    pub cost: f64,
    /// Its error, at least the floor of noise.
    pub error: f64,
}

impl Trade {
    /// A setting with this cost and error.
    pub fn new(setting: usize, cost: f64, error: f64) -> Trade {
        Trade {
            setting,
            cost,
            error,
        }
    }
}

/// The settings on the front, cheapest first: each costs more and errs less than the one before it.
pub fn front(trades: &[Trade]) -> Vec<Trade> {
    let mut sorted = trades.to_vec();
    let by_error = |a: &Trade, b: &Trade| a.error.total_cmp(&b.error);
    sorted.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(by_error(a, b)));
    let mut front: Vec<Trade> = Vec::new();
    for trade in sorted {
        if front.last().is_none_or(|last| trade.error < last.error) {
            front.push(trade);
        }
    }
    front
}

/// Smallest error for logarithms.
const NOTHING: f64 = 1e-15;

/// The knee: the index of the setting farthest from the chord between the ends, on the side of less cost and less error, both as
/// logarithms. `None` if the front has fewer than three settings or nowhere bends that way.
pub fn knee(front: &[Trade]) -> Option<usize> {
    let at = |trade: &Trade| [trade.cost.ln(), trade.error.max(NOTHING).ln()];
    let (first, last) = (at(front.first()?), at(front.last()?));
    let along = [last[0] - first[0], last[1] - first[1]];
    // Twice the area below the chord: cost rises and error falls along it.
    let below = |trade: &Trade| {
        let p = at(trade);
        (p[0] - first[0]) * along[1] - (p[1] - first[1]) * along[0]
    };
    let depths = front.iter().map(below).enumerate();
    let deepest = depths.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (deepest.1 > 0.0).then_some(deepest.0)
}

/// Settings and the front of one measure.
#[derive(Clone, Debug)]
pub(super) struct MeasureFront {
    /// Name of the measure.
    pub(super) measure: String,
    /// All trusted settings.
    pub(super) trades: Vec<Trade>,
    /// Settings that are not trusted but have a cost and an error.
    pub(super) fallen: Vec<Trade>,
    /// The front.
    pub(super) front: Vec<Trade>,
    /// Index of the knee in the front.
    pub(super) knee: Option<usize>,
    /// The floor of noise.
    pub(super) floor: f64,
}

impl MeasureFront {
    /// These words at the knee, empty elsewhere.
    pub(super) fn mark(&self, index: usize, words: &str) -> String {
        let knee = self.knee == Some(index);
        if knee { words.into() } else { String::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trades(pairs: &[(f64, f64)]) -> Vec<Trade> {
        let trade = |(setting, (cost, error)): (usize, &(f64, f64))| Trade {
            setting,
            cost: *cost,
            error: *error,
        };
        pairs.iter().enumerate().map(trade).collect()
    }

    #[test]
    fn a_setting_that_another_beats_is_not_on_the_front() {
        let all = trades(&[
            (4.0, 0.1),
            (1.0, 0.5),
            (2.0, 0.6),
            (2.0, 0.2),
            (2.0, 0.3),
            (8.0, 0.1),
        ]);
        let front: Vec<usize> = front(&all).iter().map(|trade| trade.setting).collect();
        assert_eq!(front, [1, 3, 0]);
    }

    /// Along the chord from (1, 1) to (100, 0.01) cost times error is 1; (10, 0.01) is 1/10 of it and (3, 0.3) 0.9.
    #[test]
    fn the_knee_is_farthest_below_the_chord() {
        let all = trades(&[(1.0, 1.0), (3.0, 0.3), (10.0, 0.01), (100.0, 0.01 - 1e-9)]);
        assert_eq!(knee(&all), Some(2));
        assert_eq!(knee(&all[..2]), None);
        let outwards = trades(&[(1.0, 1.0), (10.0, 0.9), (100.0, 0.01)]);
        assert_eq!(knee(&outwards), None);
    }
}
