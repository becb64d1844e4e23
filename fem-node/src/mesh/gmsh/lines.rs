//! Line elements of a group, joined to polylines.

use std::collections::BTreeMap;

/// The polylines that these different segments form, a closed one ending where it begins; or a node where more than two segments meet.
pub(super) fn join(segments: &[[u32; 2]]) -> Result<Vec<Vec<u32>>, u32> {
    let mut beside: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for [a, b] in segments {
        beside.entry(*a).or_default().push(*b);
        beside.entry(*b).or_default().push(*a);
    }
    if let Some((node, _)) = beside.iter().find(|(_, others)| others.len() > 2) {
        return Err(*node);
    }
    let ends = beside.iter().filter(|(_, others)| others.len() == 1);
    let ends: Vec<u32> = ends.map(|(node, _)| *node).collect();
    let mut lines: Vec<Vec<u32>> = Vec::new();
    for end in ends {
        lines.extend(walk(&mut beside, end));
    }
    while let Some(start) = beside.keys().next().copied() {
        lines.extend(walk(&mut beside, start));
    }
    Ok(lines)
}

/// Follows a line to its end and removes its nodes; `None` if the line was followed from its other end.
fn walk(beside: &mut BTreeMap<u32, Vec<u32>>, start: u32) -> Option<Vec<u32>> {
    let mut line = vec![start];
    let mut others = beside.remove(&start)?;
    let closed = others.len() == 2;
    while let Some(next) = others
        .iter()
        .find(|node| beside.contains_key(node))
        .copied()
    {
        line.push(next);
        others = beside.remove(&next).unwrap_or_default();
    }
    if closed {
        line.push(start);
    }
    Some(line)
}

/// Orders lines: an open one runs from its left to its right end, or downwards between ends at the same x; a closed one begins at its left end. Lines
/// are sorted by their beginnings.
pub(super) fn sort_from_left(lines: &mut [Vec<u32>], point: impl Fn(u32) -> [f64; 2]) {
    let left = |a: u32, b: u32| {
        let ([xa, ya], [xb, yb]) = (point(a), point(b));
        xa.total_cmp(&xb).then(yb.total_cmp(&ya))
    };
    for line in lines.iter_mut() {
        let (first, last) = (line[0], line[line.len() - 1]);
        if first == last {
            line.pop();
            let start = (0..line.len()).min_by(|a, b| left(line[*a], line[*b]));
            line.rotate_left(start.unwrap_or(0));
            line.push(line[0]);
        } else if left(last, first).is_lt() {
            line.reverse();
        }
    }
    lines.sort_by(|a, b| left(a[0], b[0]));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_in_any_order_become_lines() {
        let lines = join(&[[7, 3], [1, 2], [3, 1], [9, 8]]).expect("nothing branches");
        assert_eq!(lines, [vec![2, 1, 3, 7], vec![8, 9]]);
    }

    #[test]
    fn a_ring_ends_where_it_begins() {
        let mut lines = join(&[[1, 2], [2, 3], [3, 1]]).expect("nothing branches");
        sort_from_left(&mut lines, |node| [-f64::from(node), 0.0]);
        assert_eq!((lines[0].len(), lines[0][0], lines[0][3]), (4, 3, 3));
    }

    #[test]
    fn a_branch_is_named() {
        assert_eq!(join(&[[1, 2], [1, 3], [1, 4]]), Err(1));
    }
}
