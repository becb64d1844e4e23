//! Student's t, and the interval of a mean.

/// Quantile 0.975 for 1, 2, ... degrees of freedom.
const QUANTILES: [f64; 30] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160,
    2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056,
    2.052, 2.048, 2.045, 2.042,
];

/// Quantile 0.975 of Student's t for this many degrees of freedom, at least 1.
pub fn student(freedom: usize) -> f64 {
    QUANTILES[freedom.clamp(1, QUANTILES.len()) - 1]
}

/// Mean, standard deviation and half of the mean's 95 % interval, t s / sqrt(n); `None` for fewer than two values.
pub fn mean_of(values: &[f64]) -> Option<[f64; 3]> {
    let count = values.len() as f64;
    let freedom = values.len().checked_sub(1).filter(|freedom| *freedom > 0)?;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    let deviation = (squares / freedom as f64).sqrt();
    Some([mean, deviation, student(freedom) * deviation / count.sqrt()])
}
