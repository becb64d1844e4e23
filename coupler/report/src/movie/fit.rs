//! The parts of a movie that fit into the size of a page: it drops frames first, then colours of grains other than pressure, then
//! elements and grains far from the contact.

/// Number of frames below which elements and grains are dropped first.
const FRAMES_LEAST: usize = 24;
/// Number of elements, next to the contact, below which grains are dropped first.
const ELEMENTS_LEAST: usize = 2_000;
/// Largest number of frames: a slider cannot tell more apart.
pub const FRAMES_MOST: usize = 600;
/// Largest number of contacts of a frame, the strongest: more lines make no readable picture.
pub const LINES_MOST: usize = 3_000;

/// Parts of a movie, or everything that a run wrote.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Content {
    /// Moments.
    pub frames: usize,
    /// Elements of all meshes.
    pub elements: usize,
    /// Grains.
    pub grains: usize,
    /// Bytes of a grain in a frame in addition to position and pressure: its other colours.
    pub colours: usize,
}

/// One of the numbers of a content.
type Part = fn(&mut Content) -> &mut usize;

impl Content {
    /// Characters of the page for these parts; `outline` is the number of nodes in the outlines of all meshes.
    pub fn characters(&self, outline: usize) -> usize {
        let elements = self.elements;
        // Elements around a point have about as many nodes, plus some at the rim.
        let nodes = elements + 4 * elements.isqrt() + outline;
        let lines = LINES_MOST.min(3 * self.grains);
        let frame = 4 * nodes + elements + (5 + self.colours) * self.grains + 9 * lines;
        let still = 4 * nodes + 16 * elements + 8 * outline + 4 * self.grains;
        (still + self.frames * frame).div_ceil(3) * 4 + 800 * self.frames
    }

    /// The parts that fit into `characters` characters.
    pub fn within(&self, characters: usize, outline: usize) -> Content {
        let fits = |content: &Content| content.characters(outline) <= characters;
        let few = self.frames.min(FRAMES_LEAST);
        let mut rest = *self;
        let steps: [(Part, usize); 6] = [
            (|rest| &mut rest.frames, few),
            (|rest| &mut rest.colours, 0),
            (|rest| &mut rest.elements, self.elements.min(ELEMENTS_LEAST)),
            (|rest| &mut rest.grains, 0),
            (|rest| &mut rest.elements, 0),
            (|rest| &mut rest.frames, 1),
        ];
        rest.frames = rest.frames.min(FRAMES_MOST);
        for (part, least) in steps {
            let most = *part(&mut rest);
            let with = |count| {
                let mut tried = rest;
                *part(&mut tried) = count;
                tried
            };
            let count = largest(least.min(most)..most, |count| fits(&with(count)));
            rest = with(count);
        }
        rest
    }
}

/// The largest number of a range, including its end, for which a condition holds that is true for all smaller ones; else the start.
fn largest(range: std::ops::Range<usize>, holds: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (range.start, range.end);
    while low < high {
        let middle = low + (high - low).div_ceil(2);
        if holds(middle) {
            low = middle;
        } else {
            high = middle - 1;
        }
    }
    low
}

/// Indices of the `count` points nearest to `centre`, in ascending order.
pub fn nearest(points: &[[f64; 2]], centre: [f64; 2], count: usize) -> Vec<usize> {
    let far = |k: &usize| (points[*k][0] - centre[0]).hypot(points[*k][1] - centre[1]);
    let mut order: Vec<usize> = (0..points.len()).collect();
    if count < points.len() {
        order.sort_by(|a, b| far(a).total_cmp(&far(b)));
        order.truncate(count);
        order.sort_unstable();
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: usize = 4_900_000;

    fn content(frames: usize, elements: usize, grains: usize) -> Content {
        Content {
            frames,
            elements,
            grains,
            colours: 2,
        }
    }

    #[test]
    fn a_movie_that_fits_stays_whole() {
        let small = content(40, 1_410, 312);
        assert_eq!(small.within(PAGE, 200), small);
    }

    #[test]
    fn frames_go_first_then_elements_then_grains() {
        let long = content(400, 5_640, 312).within(PAGE, 400);
        assert_eq!((long.elements, long.grains, long.colours), (5_640, 312, 2));
        assert!((FRAMES_LEAST..400).contains(&long.frames), "{long:?}");
        let fine = content(400, 100_000, 5_000).within(PAGE, 2_000);
        assert_eq!((fine.frames, fine.grains), (FRAMES_LEAST, 5_000));
        assert!((ELEMENTS_LEAST..100_000).contains(&fine.elements));
        let many = content(13, 20_000, 73_823).within(PAGE, 2_000);
        assert_eq!((many.frames, many.elements), (13, ELEMENTS_LEAST));
        assert!((40_000..73_823).contains(&many.grains), "{many:?}");
    }

    #[test]
    fn content_of_any_size_fits() {
        for all in [
            content(10_000, 1_000_000, 1_000_000),
            content(1, 0, 10_000_000),
        ] {
            let kept = all.within(PAGE, 10_000);
            assert!(kept.characters(10_000) <= PAGE, "{kept:?}");
            assert!(kept.frames >= 1 && kept.grains > 10_000, "{kept:?}");
        }
    }

    #[test]
    fn the_nearest_keep_their_order() {
        let points = [[3.0, 0.0], [0.0, 0.0], [1.0, 0.0], [-9.0, 0.0]];
        assert_eq!(nearest(&points, [1.0, 0.0], 2), [1, 2]);
        assert_eq!(nearest(&points, [1.0, 0.0], 9), [0, 1, 2, 3]);
    }
}
