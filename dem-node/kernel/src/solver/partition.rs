//! Partition of large problems into subdomains of consecutive bodies, which a sample numbers column by column.
//!
//! Contacts inside subdomains are treated side by side by all threads, contacts across subdomains one after the other. The cut depends on the problem
//! only: any number of threads gives the same bits.

use std::ops::Range;

/// Contacts per subdomain below which threads cost more than they save.
const LEAST: usize = 4096;
/// Most subdomains; each cut leaves some 0.1 % of the contacts of a square pack to one thread.
const MOST: usize = 8;

/// Cuts between the bodies.
#[derive(Clone, Copy, Debug)]
pub struct Partition {
    count: usize,
    per_subdomain: usize,
    bodies: usize,
}

/// A subdomain and the data that a solver keeps for it.
#[derive(Clone, Debug, Default)]
pub struct Subdomain<T> {
    /// Its bodies.
    pub bodies: Range<usize>,
    /// The numbers.
    pub work: T,
}

impl Partition {
    /// The number of subdomains is a power of two: five on two threads take as long as six.
    pub fn new(contacts: usize, bodies: usize) -> Partition {
        let wanted = (contacts / LEAST).clamp(1, MOST);
        let count = 1 << wanted.ilog2();
        Partition {
            count,
            per_subdomain: bodies.div_ceil(count).max(1),
            bodies,
        }
    }

    /// True if there are several subdomains.
    pub fn several(&self) -> bool {
        self.count > 1
    }

    /// The subdomain that both bodies are in.
    pub fn common(&self, a: u32, b: u32) -> Option<usize> {
        if !self.several() {
            return Some(0);
        }
        let subdomain = a as usize / self.per_subdomain;
        (subdomain == b as usize / self.per_subdomain).then_some(subdomain)
    }

    /// Gives each subdomain its bodies.
    pub fn assign<T: Default>(&self, subdomains: &mut Vec<Subdomain<T>>) {
        subdomains.resize_with(self.count, Subdomain::default);
        for (i, subdomain) in subdomains.iter_mut().enumerate() {
            let cut = |i: usize| (i * self.per_subdomain).min(self.bodies);
            subdomain.bodies = cut(i)..cut(i + 1);
        }
    }
}

/// Items of consecutive bodies or contacts, which can be cut like these.
pub trait Cut: Send + Sized {
    /// The part of the first `count` bodies or contacts, and the rest.
    fn cut(self, count: usize) -> (Self, Self);
}

impl<T: Send> Cut for &mut [T] {
    fn cut(self, count: usize) -> (Self, Self) {
        self.split_at_mut(count)
    }
}

impl Cut for () {
    fn cut(self, _count: usize) -> ((), ()) {
        ((), ())
    }
}

impl<T: Sync> Cut for &[T] {
    fn cut(self, count: usize) -> (Self, Self) {
        self.split_at(count)
    }
}

impl<A: Cut, B: Cut> Cut for (A, B) {
    fn cut(self, count: usize) -> (Self, Self) {
        let ((a, a_rest), (b, b_rest)) = (self.0.cut(count), self.1.cut(count));
        ((a, b), (a_rest, b_rest))
    }
}

/// Results of work on pieces of `count` consecutive items, in their order. There are as many pieces as subdomains of this many contacts, for any
/// number of threads. Side by side where `parallel`.
pub fn in_pieces<I: Cut, R: Send>(
    count: usize,
    items: I,
    parallel: bool,
    work: impl Fn(Range<usize>, I) -> R + Sync,
) -> Vec<R> {
    let partition = Partition::new(count, count);
    if !partition.several() {
        return vec![work(0..count, items)];
    }
    let mut pieces: Vec<Subdomain<Option<R>>> = Vec::new();
    partition.assign(&mut pieces);
    for_each_subdomain(&mut pieces, items, parallel, &|piece, items| {
        piece.work = Some(work(piece.bodies.clone(), items));
    });
    pieces.into_iter().filter_map(|piece| piece.work).collect()
}

/// Does the work on each subdomain with the items of its bodies; `items` are the items of all bodies. By recursive halves, side by side where
/// `parallel`.
pub fn for_each_subdomain<T: Send, I: Cut>(
    subdomains: &mut [Subdomain<T>],
    items: I,
    parallel: bool,
    work: &(impl Fn(&mut Subdomain<T>, I) + Sync),
) {
    if let [subdomain] = subdomains {
        return work(subdomain, items);
    }
    let (left, right) = subdomains.split_at_mut(subdomains.len() / 2);
    let (Some(first), Some(cut)) = (left.first(), right.first()) else {
        return;
    };
    let (low, high) = items.cut(cut.bodies.start - first.bodies.start);
    let lower = || for_each_subdomain(left, low, parallel, work);
    let upper = || for_each_subdomain(right, high, parallel, work);
    if parallel {
        rayon::join(lower, upper);
    } else {
        lower();
        upper();
    }
}
