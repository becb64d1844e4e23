//! The structured mesh of the scenario: uniform in the fine zone, graded around it, under or over a crown.

use fem_kernel::mesh::{Mesh, circle_drop};
use kit::ConfigError;
use protocol::Cause;

use crate::config::choice::ContactEdge;
use crate::config::mesh::MeshConfig;

/// More elements than this count as a mistyped size: they would need some 4 GB. An explicit run of 1 000 x 1 000 one-point elastic elements peaks at
/// 432 MB, program included; 28 080 elements at 30 MB.
const ELEMENTS_MAX: f64 = 1e7;

/// The structured mesh of the scenario: with d the depth below the crown, H the height and c(x) = R - sqrt(R^2 - x^2)
/// the drop of the crown, y = -c(x) (1 - d/H) - d. The top of the crown is the origin, the base is flat. A body with the crown on its lower edge is
/// upside down, with the opposite y.
pub fn build(config: &MeshConfig) -> Result<Mesh, ConfigError> {
    check_count(config)?;
    let (x, ratio_columns) = columns(config)?;
    let (depth, ratio_rows) = rows(config)?;
    let radius = config.crown_radius_m.unwrap_or(0.0);
    check_crown(config, radius)?;
    let rows = depth.len() - 1;
    let below = |x: f64, d: f64| -circle_drop(radius, x) * (1.0 - d / config.height_m) - d;
    let mesh = Mesh::structured(x.len() - 1, rows, |i, j| match config.contact_edge {
        ContactEdge::Top => [x[i], below(x[i], depth[j])],
        ContactEdge::Bottom => [x[i], -below(x[i], depth[rows - j])],
    });
    Ok(Mesh {
        periodic: config.periodic_x,
        ratio_columns,
        ratio_rows,
        ..mesh
    })
}

fn check_count(config: &MeshConfig) -> Result<(), ConfigError> {
    let columns = config.fine_width_m.unwrap_or(config.width_m) / config.size_m
        + 2.0 * config.side_columns as f64;
    let rows =
        config.fine_depth_m.unwrap_or(config.height_m) / config.size_m + config.depth_rows as f64;
    if columns * rows <= ELEMENTS_MAX {
        return Ok(());
    }
    let problem = format!(
        "{:?} m gives about {:.1e} elements, more than {ELEMENTS_MAX:.0e}",
        config.size_m,
        columns * rows
    );
    Err(ConfigError::new("mesh.size_m", problem)
        .because(Cause::TooMany)
        .help("check the unit (m) or enlarge the size"))
}

fn check_crown(config: &MeshConfig, radius: f64) -> Result<(), ConfigError> {
    let half = 0.5 * config.width_m;
    if radius == 0.0 || (radius >= half && circle_drop(radius, half) < config.height_m) {
        return Ok(());
    }
    let problem = format!("a crown of {radius:?} m leaves no height at the edges of the body");
    Err(ConfigError::new("mesh.crown_radius_m", problem)
        .help("enlarge the radius, or leave the key out for a flat top"))
}

/// Abscissae of the columns of nodes, symmetric about 0, and the growth of the graded ones.
fn columns(config: &MeshConfig) -> Result<(Vec<f64>, f64), ConfigError> {
    let zone = Zone {
        total: ("mesh.width_m", config.width_m),
        fine: ("mesh.fine_width_m", config.fine_width_m),
        graded: ("mesh.side_columns", config.side_columns),
        sides: 2.0,
        size: config.size_m,
    };
    let (count, fine) = zone.uniform()?;
    let (side, ratio) = zone.grading(fine)?;
    let mut x: Vec<f64> = side.iter().rev().map(|s| -(0.5 * fine + s)).collect();
    x.extend((0..=count).map(|k| fine * (k as f64 / count as f64 - 0.5)));
    x.extend(side.iter().map(|s| 0.5 * fine + s));
    Ok((x, ratio))
}

/// Depths of the rows of nodes, from 0 on, and the growth of the graded ones.
fn rows(config: &MeshConfig) -> Result<(Vec<f64>, f64), ConfigError> {
    let zone = Zone {
        total: ("mesh.height_m", config.height_m),
        fine: ("mesh.fine_depth_m", config.fine_depth_m),
        graded: ("mesh.depth_rows", config.depth_rows),
        sides: 1.0,
        size: config.size_m,
    };
    let (count, fine) = zone.uniform()?;
    let (below, ratio) = zone.grading(fine)?;
    let mut depth: Vec<f64> = (0..=count)
        .map(|k| fine * (k as f64 / count as f64))
        .collect();
    depth.extend(below.iter().map(|s| fine + s));
    Ok((depth, ratio))
}

/// One direction of the mesh, with the names of its keys.
struct Zone {
    total: (&'static str, f64),
    fine: (&'static str, Option<f64>),
    graded: (&'static str, usize),
    sides: f64,
    size: f64,
}

impl Zone {
    /// Number of uniform elements and their total length.
    fn uniform(&self) -> Result<(usize, f64), ConfigError> {
        let (total_key, total) = self.total;
        let (fine_key, fine) = self.fine;
        let (graded_key, graded) = self.graded;
        let (key, length) = match fine {
            Some(length) => (fine_key, length),
            None if graded == 0 => (total_key, total),
            None => {
                let problem = format!("is required with {graded_key} = {graded}");
                return Err(ConfigError::new(fine_key, problem).help(format!(
                    "give the length of the zone of uniform size, or set {graded_key} to 0"
                )));
            }
        };
        let count = (length / self.size).round();
        if count < 1.0 || (count * self.size - length).abs() > 1e-6 * length {
            let problem = format!(
                "{length:?} m is not a whole number of elements of mesh.size_m = {:?} m",
                self.size
            );
            return Err(ConfigError::new(key, problem)
                .help(format!("write {:.6e}", count.max(1.0) * self.size)));
        }
        Ok((count as usize, length))
    }

    /// Distances of the graded nodes from the fine zone, and the ratio r. The sizes are size r^k, k = 0 .. n-1, and fill the length L beyond the fine
    /// zone: (r^n - 1)/(r - 1) = L/size.
    fn grading(&self, fine: f64) -> Result<(Vec<f64>, f64), ConfigError> {
        let (graded_key, graded) = self.graded;
        let length = (self.total.1 - fine) / self.sides;
        let relative = length / self.size;
        if graded == 0 {
            return self.nothing_left(relative);
        }
        if relative < graded as f64 - 1e-6 || (graded == 1 && relative > 1.0 + 1e-6) {
            return Err(self.no_room(length, relative));
        }
        let ratio = solve_ratio(graded, relative);
        if !ratio.is_finite() || ratio > 10.0 {
            let problem =
                format!("{graded} would have to grow {ratio:.1}-fold from one to the next");
            return Err(ConfigError::new(graded_key, problem).help("take more of them"));
        }
        let scale = length / geometric_sum(graded, ratio);
        let distances = (1..=graded).map(|k| scale * geometric_sum(k, ratio));
        Ok((distances.collect(), ratio))
    }

    fn nothing_left(&self, relative: f64) -> Result<(Vec<f64>, f64), ConfigError> {
        if relative.abs() <= 1e-6 * self.total.1 / self.size {
            return Ok((Vec::new(), 1.0));
        }
        let problem = format!(
            "without {} the fine zone must fill {}",
            self.graded.0, self.total.0
        );
        Err(ConfigError::new(self.fine.0, problem)
            .help(format!("leave it out, or set {} above 0", self.graded.0)))
    }

    fn no_room(&self, length: f64, relative: f64) -> ConfigError {
        let (key, graded) = self.graded;
        let problem = format!(
            "{graded} graded from {:?} m on do not fit the {length:.6e} m that {} leaves of {}: their sizes would shrink outwards or jump",
            self.size, self.fine.0, self.total.0
        );
        let most = relative.floor().max(0.0);
        ConfigError::new(key, problem).help(match most {
            m if m < 2.0 => format!("shorten {}", self.fine.0),
            _ => format!("take 2 to {most}, or shorten {}", self.fine.0),
        })
    }
}

/// 1 + r + ... + r^(n-1), also for r = 1.
fn geometric_sum(n: usize, ratio: f64) -> f64 {
    (0..n).fold(0.0, |sum, _| sum * ratio + 1.0)
}

/// The ratio r >= 1 whose geometric sum of n terms is `sum` >= n. r^(n-1) <= sum brackets it.
fn solve_ratio(n: usize, sum: f64) -> f64 {
    if n == 1 {
        return 1.0;
    }
    let (mut low, mut high) = (1.0, sum.max(1.0).powf(1.0 / (n as f64 - 1.0)));
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if geometric_sum(n, middle) < sum {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_kernel::mesh::Edge;

    fn strip() -> MeshConfig {
        MeshConfig {
            width_m: 4.0,
            height_m: 2.0,
            size_m: 1.0,
            fine_width_m: None,
            fine_depth_m: None,
            side_columns: 0,
            depth_rows: 0,
            contact_edge: ContactEdge::Top,
            crown_radius_m: None,
            periodic_x: false,
        }
    }

    /// c(2) = 4 - sqrt(16 - 4) at the edges of a face of radius 4.
    #[test]
    fn a_body_upside_down_has_the_crown_and_the_fine_zone_at_its_lower_edge() {
        let config = MeshConfig {
            height_m: 4.0,
            fine_depth_m: Some(1.0),
            depth_rows: 2,
            contact_edge: ContactEdge::Bottom,
            crown_radius_m: Some(4.0),
            ..strip()
        };
        let mesh = build(&config).expect("1 + 1 + 2 rows");
        let heights = |i: usize| [0, 1, 2, 3].map(|j| mesh.point(i, j)[1]);
        let middle = [4.0, 2.0, 1.0, 0.0];
        let edge = 4.0 - 12.0_f64.sqrt();
        for (k, y) in middle.into_iter().enumerate() {
            assert!((heights(2)[k] - y).abs() < 1e-12, "{:?}", heights(2));
            let exact = y + edge * (1.0 - y / 4.0);
            assert!((heights(0)[k] - exact).abs() < 1e-12, "{:?}", heights(0));
        }
    }

    #[test]
    fn a_uniform_strip_needs_three_numbers() {
        let mesh = build(&strip()).expect("4 x 2 elements");
        assert_eq!((mesh.columns, mesh.rows), (4, 2));
        assert_eq!(mesh.point(0, 0), [-2.0, 0.0]);
        assert_eq!(mesh.point(4, 2), [2.0, -2.0]);
    }

    #[test]
    fn doubling_sizes_are_found() {
        let config = MeshConfig {
            width_m: 16.0,
            fine_width_m: Some(2.0),
            side_columns: 3,
            ..strip()
        };
        let mesh = build(&config).expect("1 + 2 + 4 on each side");
        assert!((mesh.ratio_columns - 2.0).abs() < 1e-12);
        let x: Vec<f64> = mesh
            .edge(Edge::Top)
            .iter()
            .map(|n| mesh.point(n[0], n[1])[0])
            .collect();
        let expected = [-8.0, -4.0, -2.0, -1.0, 0.0, 1.0, 2.0, 4.0, 8.0];
        assert!(
            x.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12),
            "{x:?}"
        );
    }

    #[test]
    fn grading_without_room_is_refused_by_name() {
        let config = MeshConfig {
            fine_width_m: Some(2.0),
            side_columns: 2,
            ..strip()
        };
        let error = build(&config).expect_err("1 m is left on each side for 2 columns");
        assert_eq!(error.key, "mesh.side_columns");
        assert!(error.help.is_some());
    }

    #[test]
    fn a_gap_that_nothing_fills_is_refused_by_name() {
        let config = MeshConfig {
            fine_depth_m: Some(1.0),
            ..strip()
        };
        let error = build(&config).expect_err("1 m is left below");
        assert_eq!(error.key, "mesh.fine_depth_m");
    }

    #[test]
    fn a_fractional_number_of_elements_is_refused_by_name() {
        let config = MeshConfig {
            width_m: 4.3,
            ..strip()
        };
        let error = build(&config).expect_err("4.3 elements");
        assert_eq!(error.key, "mesh.width_m");
    }

    #[test]
    fn a_crown_narrower_than_the_body_is_refused() {
        let config = MeshConfig {
            crown_radius_m: Some(1.9),
            ..strip()
        };
        let error = build(&config).expect_err("half the width is 2");
        assert_eq!(error.key, "mesh.crown_radius_m");
    }
}
