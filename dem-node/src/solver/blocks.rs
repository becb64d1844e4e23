//! Large problems cut into blocks of consecutive bodies, which a sample numbers column by column.
//!
//! Contacts inside a block are treated block beside block in as many threads as there are, those across one after the
//! other. The cut depends on the problem only: the same bits come out of any number of threads.

use std::ops::Range;

use super::Problem;

/// Contacts per block below which threads cost more than they bring.
const LEAST: usize = 4096;
/// Most blocks; each cut makes some 0.1 % of the contacts of a square pack serial.
const MOST: usize = 8;

/// Where the bodies are cut.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    count: usize,
    per_block: usize,
    bodies: usize,
}

/// A block and what a solver keeps of it.
#[derive(Clone, Debug, Default)]
pub struct Block<T> {
    /// Its bodies.
    pub bodies: Range<usize>,
    /// What the solver keeps.
    pub work: T,
}

impl Cut {
    /// A power of two of blocks: five on two threads take as long as six.
    pub fn new(problem: &Problem) -> Cut {
        let wanted = (problem.contacts.len() / LEAST).clamp(1, MOST);
        let count = 1 << wanted.ilog2();
        let bodies = problem.movers.len();
        Cut {
            count,
            per_block: bodies.div_ceil(count).max(1),
            bodies,
        }
    }

    /// Whether there is anything to treat side by side.
    pub fn several(&self) -> bool {
        self.count > 1
    }

    /// The block that both bodies are in.
    pub fn common(&self, a: u32, b: u32) -> Option<usize> {
        let block = a as usize / self.per_block;
        (block == b as usize / self.per_block).then_some(block)
    }

    /// Gives each block its bodies.
    pub fn lay<T: Default>(&self, blocks: &mut Vec<Block<T>>) {
        blocks.resize_with(self.count, Block::default);
        for (i, block) in blocks.iter_mut().enumerate() {
            let cut = |i: usize| (i * self.per_block).min(self.bodies);
            block.bodies = cut(i)..cut(i + 1);
        }
    }
}

/// What belongs to consecutive bodies and can be cut where these are.
pub trait Items: Send + Sized {
    /// The part of the first `count` bodies, and the rest.
    fn cut(self, count: usize) -> (Self, Self);
}

impl<T: Send> Items for &mut [T] {
    fn cut(self, count: usize) -> (Self, Self) {
        self.split_at_mut(count)
    }
}

impl<A: Items, B: Items> Items for (A, B) {
    fn cut(self, count: usize) -> (Self, Self) {
        let ((a, a_rest), (b, b_rest)) = (self.0.cut(count), self.1.cut(count));
        ((a, b), (a_rest, b_rest))
    }
}

/// Work on each block with the items of its bodies; `items` are those of all of them. Halves of halves, side by side
/// where `parallel`.
pub fn each<T: Send, I: Items>(
    blocks: &mut [Block<T>],
    items: I,
    parallel: bool,
    work: &(impl Fn(&mut Block<T>, I) + Sync),
) {
    if let [block] = blocks {
        return work(block, items);
    }
    let (left, right) = blocks.split_at_mut(blocks.len() / 2);
    let (Some(first), Some(cut)) = (left.first(), right.first()) else {
        return;
    };
    let (low, high) = items.cut(cut.bodies.start - first.bodies.start);
    let lower = || each(left, low, parallel, work);
    let upper = || each(right, high, parallel, work);
    if parallel {
        rayon::join(lower, upper);
    } else {
        lower();
        upper();
    }
}
