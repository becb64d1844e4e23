//! The surface line, and the weights of its nodes at a position on the line.

use super::error::MappingError;

/// Largest distance of two equal positions, over the length of the line.
const SAME_PLACE: f64 = 1e-12;

/// The surface line with its nodes in order along the chord.
pub(super) struct Line {
    origin: [f64; 2],
    chord: [f64; 2],
    /// Node index and position along the chord (m), ascending; with images of the nodes if the line is periodic.
    nodes: Vec<(usize, f64)>,
    /// The period of a periodic line.
    period: Option<Period>,
}

/// The period of a line along x.
#[derive(Clone, Copy)]
struct Period {
    /// Position of the first node (m).
    first: f64,
    /// Length (m).
    length: f64,
}

impl Line {
    pub(super) fn through(nodes: &[[f64; 2]]) -> Result<Line, MappingError> {
        let (first, last) = farthest(nodes);
        let span = [0, 1].map(|k| nodes[last][k] - nodes[first][k]);
        let length = span[0].hypot(span[1]);
        Line::along(span.map(|d| d / length), nodes[first], nodes, length)
    }

    /// The line through the nodes of one period, continued by their images: one period to the left and two to the
    /// right. A segment, at most one period long, then lies among them for any position of its centre in the period.
    pub(super) fn repeating(nodes: &[[f64; 2]], length: f64) -> Result<Line, MappingError> {
        let mut line = Line::along([1.0, 0.0], [0.0; 2], nodes, length)?;
        let own = std::mem::take(&mut line.nodes);
        let [(first, left), (last, right)] = [own[0], own[own.len() - 1]];
        let seam = left + length - right;
        if seam.abs() <= SAME_PLACE * length {
            return Err(repeated("surface nodes", [first, last], nodes));
        }
        if seam < 0.0 {
            return Err(MappingError::Longer {
                left_m: left,
                right_m: right,
                period_m: length,
            });
        }
        let images = [-1.0, 0.0, 1.0, 2.0].map(|k| k * length);
        let moved = |by: f64| {
            own.iter()
                .map(move |(node, position)| (*node, position + by))
        };
        line.nodes = images.into_iter().flat_map(moved).collect();
        line.period = Some(Period {
            first: left,
            length,
        });
        Ok(line)
    }

    /// The nodes in order along a chord from an origin; `length` is the length of the whole line.
    fn along(
        chord: [f64; 2],
        origin: [f64; 2],
        nodes: &[[f64; 2]],
        length: f64,
    ) -> Result<Line, MappingError> {
        let mut line = Line {
            origin,
            chord,
            nodes: Vec::new(),
            period: None,
        };
        let positions = nodes.iter().map(|node| line.position(*node));
        let mut sorted = Vec::from_iter(positions.enumerate());
        sorted.sort_by(|a, b| a.1.total_cmp(&b.1));
        for pair in sorted.windows(2) {
            // A chord of zero length (all nodes in one position) gives NaN positions, which also end here.
            let spacing = pair[1].1 - pair[0].1;
            if spacing.is_nan() || spacing <= SAME_PLACE * length {
                return Err(repeated("surface nodes", [pair[0].0, pair[1].0], nodes));
            }
        }
        line.nodes = sorted;
        Ok(line)
    }

    /// The position of a point along the chord (m); on a periodic line, the position of its image in the period.
    pub(super) fn position(&self, point: [f64; 2]) -> f64 {
        let s = (point[0] - self.origin[0]) * self.chord[0]
            + (point[1] - self.origin[1]) * self.chord[1];
        match self.period {
            None => s,
            Some(Period { first, length }) => s - length * ((s - first) / length).floor(),
        }
    }

    fn ends(&self) -> (f64, f64) {
        (self.nodes[0].1, self.nodes[self.nodes.len() - 1].1)
    }

    pub(super) fn check(&self, points: &[[f64; 2]], positions: &[f64]) -> Result<(), MappingError> {
        let (low, high) = self.ends();
        let margin = 1e-9 * (high - low);
        let on_line = low - margin..=high + margin;
        let Some(point) = positions.iter().position(|s| !on_line.contains(s)) else {
            return Ok(());
        };
        let [first, last] = range(positions.iter().copied());
        let line_m = [low, high].map(|s| self.origin[0] + s * self.chord[0]);
        Err(MappingError::Beyond {
            point,
            x_m: points[point][0],
            y_m: points[point][1],
            points_m: range(points.iter().map(|point| point[0])),
            line_m: range(line_m.into_iter()),
            cure: if last - first <= high - low {
                "the line is long enough, but one side is off-centre: move the body or the grains along x"
            } else {
                "the line is too short: make the body wider than the row of points"
            },
        })
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
        let right = self.nodes.partition_point(|(_, at)| *at <= low);
        for pair in self.nodes[right.saturating_sub(1)..].windows(2) {
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

    /// Plain interpolation, the limit for a segment of zero length.
    pub(super) fn interpolation(&self, s: f64) -> Vec<(usize, f64)> {
        let right = self.nodes.partition_point(|(_, at)| *at < s);
        let right = right.clamp(1, self.nodes.len() - 1);
        let ((i, a), (j, b)) = (self.nodes[right - 1], self.nodes[right]);
        let share = (s - a) / (b - a);
        vec![(i, 1.0 - share), (j, share)]
    }

    /// (point, low, high) for each point: halfway to its neighbours, which across the seam of a periodic line are
    /// images. At the ends of other lines a segment extends as far outwards as inwards; there a single point has a
    /// segment of zero length.
    pub(super) fn segments(
        &self,
        points: &[[f64; 2]],
        positions: &[f64],
    ) -> Result<Vec<(usize, f64, f64)>, MappingError> {
        let mut order: Vec<usize> = (0..positions.len()).collect();
        order.sort_by(|a, b| positions[*a].total_cmp(&positions[*b]));
        for pair in order.windows(2) {
            if self.are_one(positions[pair[1]] - positions[pair[0]]) {
                return Err(repeated("glued points", [pair[0], pair[1]], points));
            }
        }
        let last = order.len() - 1;
        let [left_end, right_end] = [positions[order[0]], positions[order[last]]];
        let beyond = |end: f64, turns: f64| self.period.map(|p| end + turns * p.length);
        let (before, after) = (beyond(right_end, -1.0), beyond(left_end, 1.0));
        if before.is_some_and(|before| self.are_one(left_end - before)) {
            return Err(repeated("glued points", [order[0], order[last]], points));
        }
        let position = |k: usize| positions[order[k]];
        let result = (0..order.len()).map(|k| {
            let s = position(k);
            let previous = k.checked_sub(1).map(position).or(before);
            let next = (k < last).then(|| position(k + 1)).or(after);
            let inner_left = previous.map(|previous| 0.5 * (s - previous));
            let inner_right = next.map(|next| 0.5 * (next - s));
            let left = inner_left.or(inner_right).unwrap_or(0.0);
            let right = inner_right.or(inner_left).unwrap_or(0.0);
            (order[k], s - left, s + right)
        });
        Ok(result.collect())
    }

    /// True if two positions at this distance are equal: on a periodic line their images are rounded.
    fn are_one(&self, distance: f64) -> bool {
        let closest = self.period.map_or(0.0, |p| SAME_PLACE * p.length);
        distance <= closest
    }
}

/// The least and the largest number.
fn range(numbers: impl Iterator<Item = f64>) -> [f64; 2] {
    numbers.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, largest], x| {
        [least.min(x), largest.max(x)]
    })
}

fn repeated(what: &'static str, [a, b]: [usize; 2], positions: &[[f64; 2]]) -> MappingError {
    MappingError::Repeated {
        what,
        first: a.min(b),
        second: a.max(b),
        x_m: positions[a][0],
        y_m: positions[a][1],
    }
}

/// Adds to the weight of a node, whose image may stand earlier in the row.
fn add(row: &mut Vec<(usize, f64)>, node: usize, weight: f64) {
    match row.iter_mut().rev().find(|(known, _)| *known == node) {
        Some((_, sum)) => *sum += weight,
        None => row.push((node, weight)),
    }
}

/// The two nodes at the ends of the line: the farthest from the first node, and the farthest from that end, ordered so
/// that the chord points towards larger coordinates.
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
