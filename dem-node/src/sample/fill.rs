//! The disks of rectangles and rows.

use dem_kernel::random::RandomNumbers;

use crate::config::disks::{DiskConfig, DisksConfig};
use crate::config::fill::{FillConfig, RowConfig};

/// The sample with the disks of its rows and rectangles listed behind the others. Their random numbers come from their own seed, or one after the
/// other from this one.
pub fn expanded(config: &DisksConfig, seed: u64) -> DisksConfig {
    let mut all = config.clone();
    let mut common = RandomNumbers::new(seed);
    for part in &config.rows {
        let mut own = part.seed.map(RandomNumbers::new);
        all.disks
            .extend(row(part, own.as_mut().unwrap_or(&mut common)));
    }
    for part in &config.fill {
        let mut own = part.seed.map(RandomNumbers::new);
        all.disks
            .extend(fill(part, own.as_mut().unwrap_or(&mut common)));
    }
    all
}

/// The disks of a rectangle, row by row from below.
fn fill(config: &FillConfig, numbers: &mut RandomNumbers) -> Vec<DiskConfig> {
    let [columns, rows] = config.grid();
    let pitch = (config.x_m[1] - config.x_m[0]) / columns;
    let side = 2.0 * config.radius_max_m;
    let radii = config.radii();
    let squares = (0..rows as usize).flat_map(|row| (0..columns as usize).map(move |c| [c, row]));
    let disk = |[column, row]: [usize; 2]| DiskConfig {
        x_m: config.x_m[0] + (column as f64 + 0.5) * pitch,
        y_m: config.y_m[0] + (row as f64 + 0.5) * side,
        radius_m: radii.at(numbers.unit()),
        vx_m_per_s: config.speed_m_per_s * numbers.between(-1.0, 1.0),
        vy_m_per_s: config.speed_m_per_s * numbers.between(-1.0, 1.0),
        ..DiskConfig::default()
    };
    squares.map(disk).collect()
}

/// The disks of a row from left to right.
fn row(config: &RowConfig, numbers: &mut RandomNumbers) -> Vec<DiskConfig> {
    let count = config.count();
    let pitch = (config.x_m[1] - config.x_m[0]) / count;
    let radii = config.radii();
    let disk = |index: usize| DiskConfig {
        x_m: config.x_m[0] + (index as f64 + 0.5) * pitch,
        y_m: config.y_m,
        radius_m: radii.at(numbers.unit()),
        cluster: Some(config.cluster.clone()),
        ..DiskConfig::default()
    };
    (0..count as usize).map(disk).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::radii::RadiusLaw;

    #[test]
    fn a_rectangle_holds_as_many_of_the_widest_disks_as_fit_and_none_overlap() {
        let config = FillConfig {
            x_m: [0.0, 0.3],
            y_m: [1.0, 1.25],
            radius_min_m: 0.02,
            radius_max_m: 0.05,
            law: RadiusLaw::NumberUniform,
            power: None,
            speed_m_per_s: 0.0,
            seed: None,
        };
        let disks = fill(&config, &mut RandomNumbers::new(3));
        assert_eq!(disks.len(), 3 * 2);
        for (i, a) in disks.iter().enumerate() {
            assert!((0.02..0.05).contains(&a.radius_m));
            let apart =
                |b: &DiskConfig| (a.x_m - b.x_m).hypot(a.y_m - b.y_m) >= a.radius_m + b.radius_m;
            assert!(disks[..i].iter().all(apart));
        }
    }

    #[test]
    fn a_row_has_as_many_disks_as_touch_with_the_middle_radius() {
        let config = RowConfig {
            cluster: "top".into(),
            x_m: [0.0, 1.0],
            y_m: 0.0,
            radius_min_m: 0.04,
            radius_max_m: 0.06,
            law: RadiusLaw::NumberUniform,
            power: None,
            seed: None,
        };
        let disks = row(&config, &mut RandomNumbers::new(3));
        let first = disks.first().expect("there are ten");
        assert_eq!((disks.len(), first.x_m), (10, 0.05));
    }
}
