//! The surface line, and the weights of its nodes in a place on it.

use super::error::MappingError;

/// The surface line with its nodes in order along the chord.
pub(super) struct Line {
    origin: [f64; 2],
    chord: [f64; 2],
    /// Node index and place along the chord (m), ascending.
    nodes: Vec<(usize, f64)>,
}

impl Line {
    pub(super) fn through(nodes: &[[f64; 2]]) -> Result<Line, MappingError> {
        let (first, last) = farthest(nodes);
        let span = [
            nodes[last][0] - nodes[first][0],
            nodes[last][1] - nodes[first][1],
        ];
        let length = span[0].hypot(span[1]);
        let mut line = Line {
            origin: nodes[first],
            chord: [span[0] / length, span[1] / length],
            nodes: Vec::new(),
        };
        line.nodes = nodes
            .iter()
            .enumerate()
            .map(|(i, node)| (i, line.place(*node)))
            .collect();
        line.nodes.sort_by(|a, b| a.1.total_cmp(&b.1));
        for pair in line.nodes.windows(2) {
            // A chord of zero length (all nodes in one place) gives NaN places, which also end here.
            let spacing = pair[1].1 - pair[0].1;
            if spacing.is_nan() || spacing <= 1e-12 * length {
                return Err(repeated("surface nodes", [pair[0].0, pair[1].0], nodes));
            }
        }
        Ok(line)
    }

    pub(super) fn place(&self, point: [f64; 2]) -> f64 {
        (point[0] - self.origin[0]) * self.chord[0] + (point[1] - self.origin[1]) * self.chord[1]
    }

    fn ends(&self) -> (f64, f64) {
        (self.nodes[0].1, self.nodes[self.nodes.len() - 1].1)
    }

    pub(super) fn check(&self, points: &[[f64; 2]], places: &[f64]) -> Result<(), MappingError> {
        let (low, high) = self.ends();
        let margin = 1e-9 * (high - low);
        match places
            .iter()
            .position(|s| !(*s >= low - margin && *s <= high + margin))
        {
            None => Ok(()),
            Some(point) => Err(MappingError::Beyond {
                point,
                x_m: points[point][0],
                y_m: points[point][1],
            }),
        }
    }

    /// The row of a point at `s` whose segment is [low, high].
    pub(super) fn row(&self, s: f64, [low, high]: [f64; 2]) -> Vec<(usize, f64)> {
        let (first, last) = self.ends();
        let (low, high) = (low.max(first), high.min(last));
        let length = high - low;
        if length <= 1e-12 * (last - first) {
            return self.interpolation(s);
        }
        let centre = 0.5 * (low + high);
        let mut row: Vec<(usize, f64)> = Vec::new();
        let start = self
            .nodes
            .partition_point(|(_, place)| *place <= low)
            .saturating_sub(1);
        for pair in self.nodes[start..].windows(2) {
            let ((left, a), (right, b)) = (pair[0], pair[1]);
            if a >= high {
                break;
            }
            let (l, r) = (low.max(a), high.min(b));
            if r <= l {
                continue;
            }
            let share = (r - l) / length;
            let middle = (0.5 * (l + r) - a) / (b - a);
            let tilt = (s - centre) * share / (b - a);
            add(&mut row, left, share * (1.0 - middle) - tilt);
            add(&mut row, right, share * middle + tilt);
        }
        row
    }

    pub(super) fn nearest(&self, s: f64) -> Vec<(usize, f64)> {
        let row = self.interpolation(s);
        let (node, _) = if row[0].1 >= row[1].1 { row[0] } else { row[1] };
        vec![(node, 1.0)]
    }

    /// Plain interpolation, the limit of a segment without length.
    pub(super) fn interpolation(&self, s: f64) -> Vec<(usize, f64)> {
        let right = self
            .nodes
            .partition_point(|(_, place)| *place < s)
            .clamp(1, self.nodes.len() - 1);
        let ((i, a), (j, b)) = (self.nodes[right - 1], self.nodes[right]);
        let share = (s - a) / (b - a);
        vec![(i, 1.0 - share), (j, share)]
    }
}

fn repeated(what: &'static str, [a, b]: [usize; 2], places: &[[f64; 2]]) -> MappingError {
    MappingError::Repeated {
        what,
        first: a.min(b),
        second: a.max(b),
        x_m: places[a][0],
        y_m: places[a][1],
    }
}

fn add(row: &mut Vec<(usize, f64)>, node: usize, weight: f64) {
    match row.last_mut() {
        Some((last, sum)) if *last == node => *sum += weight,
        _ => row.push((node, weight)),
    }
}

/// Two nodes at the ends of the line: the farthest from the first, and the farthest from that one, ordered
/// so that the chord points along the larger coordinate.
fn farthest(nodes: &[[f64; 2]]) -> (usize, usize) {
    let from = |origin: usize| {
        let distance =
            |i: usize| (nodes[i][0] - nodes[origin][0]).hypot(nodes[i][1] - nodes[origin][1]);
        (0..nodes.len()).fold(origin, |best, i| {
            if distance(i) > distance(best) {
                i
            } else {
                best
            }
        })
    };
    let one = from(0);
    let other = from(one);
    let ascending = (nodes[one][0], nodes[one][1]) <= (nodes[other][0], nodes[other][1]);
    if ascending {
        (one, other)
    } else {
        (other, one)
    }
}

/// (point, low, high) for each point: halfway to its neighbours; at the ends as far out as in. A single point
/// has a segment without length.
pub(super) fn segments(
    points: &[[f64; 2]],
    places: &[f64],
) -> Result<Vec<(usize, f64, f64)>, MappingError> {
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|a, b| places[*a].total_cmp(&places[*b]));
    for pair in order.windows(2) {
        if places[pair[0]] == places[pair[1]] {
            return Err(repeated("glued points", [pair[0], pair[1]], points));
        }
    }
    let result = (0..order.len()).map(|k| {
        let s = places[order[k]];
        let inner_left = k.checked_sub(1).map(|j| 0.5 * (s - places[order[j]]));
        let inner_right = order.get(k + 1).map(|j| 0.5 * (places[*j] - s));
        let left = inner_left.or(inner_right).unwrap_or(0.0);
        let right = inner_right.or(inner_left).unwrap_or(0.0);
        (order[k], s - left, s + right)
    });
    Ok(result.collect())
}
