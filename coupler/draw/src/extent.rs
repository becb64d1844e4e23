//! Rectangles of a scene.

/// A rectangle of a scene, in the unit of its positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Left and right end.
    pub x: [f64; 2],
    /// Lower and upper end.
    pub y: [f64; 2],
}

/// Half of the width of a layer's middle, over the layer's height.
const MIDDLE: f64 = 4.5;

impl Extent {
    /// The smallest rectangle around these circles, given by centres and radii; `None` without any.
    pub fn around(circles: impl Iterator<Item = ([f64; 2], f64)>) -> Option<Extent> {
        circles.fold(None, |all, (centre, radius)| {
            let [x, y] = centre.map(|at| [at - radius, at + radius]);
            let Some(Extent { x: across, y: up }) = all else {
                return Some(Extent { x, y });
            };
            let with = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
            Some(Extent {
                x: with(across, x),
                y: with(up, y),
            })
        })
    }

    /// Width.
    pub fn width(&self) -> f64 {
        self.x[1] - self.x[0]
    }

    /// Height.
    pub fn height(&self) -> f64 {
        self.y[1] - self.y[0]
    }

    /// The rectangle with margins at both sides, below and above.
    pub fn with_margin(self, side: f64, below: f64, above: f64) -> Extent {
        Extent {
            x: [self.x[0] - side, self.x[1] + side],
            y: [self.y[0] - below, self.y[1] + above],
        }
    }

    /// The common part of two rectangles.
    pub fn within(self, other: &Extent) -> Extent {
        let common = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].min(b[1])];
        Extent {
            x: common(self.x, other.x),
            y: common(self.y, other.y),
        }
    }

    /// True for a position inside.
    pub fn holds(&self, [x, y]: [f64; 2]) -> bool {
        (self.x[0]..=self.x[1]).contains(&x) && (self.y[0]..=self.y[1]).contains(&y)
    }

    /// The middle, nine times as wide as high: the part of a long layer that one map can show.
    pub fn middle(&self) -> Extent {
        let half = MIDDLE * self.height();
        let centre = 0.5 * (self.x[0] + self.x[1]);
        Extent {
            x: [centre - half, centre + half],
            ..*self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extents_contain_their_circles_and_have_common_parts() {
        let circles = [([0.0, 1.0], 1.0), ([4.0, 1.0], 2.0)];
        let all = Extent::around(circles.into_iter()).expect("there are circles");
        assert_eq!((all.x, all.y), ([-1.0, 6.0], [-1.0, 3.0]));
        let wide = all.with_margin(1.0, 2.0, 3.0);
        assert_eq!((wide.x, wide.y), ([-2.0, 7.0], [-3.0, 6.0]));
        assert_eq!(wide.within(&all), all);
        assert!(all.holds([6.0, 3.0]) && !all.holds([6.1, 3.0]));
        assert_eq!(Extent::around([].into_iter()), None);
    }
}
