//! Places of labels along an axis.

/// Round numbers within a range: multiples of 1, 2 or 5 times a power of ten, at most about `count` of them.
pub fn ticks([low, high]: [f64; 2], count: usize) -> Vec<f64> {
    let raw = (high - low) / count.max(1) as f64;
    if !(raw > 0.0 && raw.is_finite()) {
        return vec![low];
    }
    let decade = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|part| part * decade);
    let step = step.into_iter().find(|step| *step >= raw * (1.0 - 1e-9));
    let step = step.unwrap_or(10.0 * decade);
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last).map(|k| k as f64 * step).collect()
}

/// A number beside an axis whose labels are `step` apart: as many decimals as tell them apart.
pub fn label(value: f64, step: f64) -> String {
    let size = value.abs().max(step);
    if value == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e6).contains(&size) {
        let text = format!("{value:.2e}");
        return text.replace(".00e", "e").replace("0e", "e");
    }
    // Labels closer than rounding tells apart have all the digits there are.
    let decimals = -(step.max(1e-12 * size) * (1.0 + 1e-9)).log10().floor();
    let decimals = decimals.clamp(0.0, 15.0) as usize;
    format!("{value:.decimals$}")
}

/// Labels with their places.
pub fn labelled(range: [f64; 2], count: usize) -> Vec<(f64, String)> {
    let all = ticks(range, count);
    let step = all.windows(2).map(|pair| pair[1] - pair[0]).next();
    let step = step.unwrap_or(range[1] - range[0]);
    all.into_iter().map(|x| (x, label(x, step))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_round_and_told_apart() {
        let texts = |range, count| -> Vec<String> {
            labelled(range, count)
                .into_iter()
                .map(|(_, text)| text)
                .collect()
        };
        assert_eq!(
            texts([-32.5, 32.5], 8),
            ["-30", "-20", "-10", "0", "10", "20", "30"]
        );
        assert_eq!(texts([0.28, 0.33], 3), ["0.28", "0.30", "0.32"]);
        assert_eq!(texts([0.0, 1e-6], 2), ["0", "5e-7", "1e-6"]);
        assert_eq!(ticks([1.0, 1.0], 5), [1.0]);
        assert_eq!(texts([0.25, 0.25], 5).len(), 1);
        assert_eq!(texts([1.0, 1.0 + 1e-15], 5)[0], "1.000000000000");
    }
}
