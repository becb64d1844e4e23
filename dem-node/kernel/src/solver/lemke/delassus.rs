//! The Delassus operator W = H^T M^-1 H of a problem, contact by contact, with springs.

use crate::solver::contact::Contact;
use crate::solver::problem::Problem;

/// Number of blocks above which a problem is too large to be followed.
const MOST_BLOCKS: usize = 2_000_000;

/// Part of W_nn that counts as W_tt where all motion along the tangent is prescribed.
const PRESCRIBED: f64 = 1e-9;

/// A block of W, [row][column], normal before tangential (1/kg).
pub(super) type Block = [[f64; 2]; 2];

/// W by rows of blocks. Contacts that share no movable body have no block.
#[derive(Clone, Debug)]
pub(super) struct Delassus {
    /// (contact, block), in the order of the contacts.
    pub rows: Vec<Vec<(usize, Block)>>,
}

impl Delassus {
    /// W of a prepared problem with its springs and with `softening` times its diagonal; `None` if it has too many blocks. Columns are the effects of
    /// unit impulses on bodies at rest: disks, clusters, the wheel or a compliant boundary.
    pub(super) fn new(problem: &Problem, softening: f64) -> Option<Delassus> {
        let neighbours = neighbours(problem)?;
        let mut probe = problem.clone();
        for record in &mut probe.records {
            record.velocity = [0.0; 3];
        }
        let rest = vec![0.0; probe.boundary.velocity.len()];
        probe.boundary.start(&rest);
        let contacts = std::mem::take(&mut probe.contacts);
        let mut rows = vec![Vec::new(); contacts.len()];
        for (j, contact) in contacts.iter().enumerate() {
            let mut blocks = vec![Block::default(); neighbours[j].len()];
            for axis in 0..2 {
                let mut unit = [0.0; 2];
                unit[axis] = 1.0;
                probe.apply(contact, unit);
                for (block, i) in blocks.iter_mut().zip(&neighbours[j]) {
                    let u = probe.relative_velocity(&contacts[*i]);
                    (block[0][axis], block[1][axis]) = (u[0], u[1]);
                }
                for body in [contact.a, contact.b] {
                    probe.records[body as usize].velocity = [0.0; 3];
                }
                if contact.glued {
                    probe.boundary.start(&rest);
                }
            }
            for (mut block, i) in blocks.into_iter().zip(&neighbours[j]) {
                if *i == j {
                    soften(&mut block, contact, softening);
                }
                rows[*i].push((j, block));
            }
        }
        Some(Delassus { rows })
    }

    /// The block of two contacts.
    pub(super) fn block(&self, i: usize, j: usize) -> Block {
        let found = self.rows[i].binary_search_by_key(&j, |(contact, _)| *contact);
        found.map_or(Block::default(), |k| self.rows[i][k].1)
    }
}

/// D of a contact, positive even where W_tt is 0.
pub(super) fn weights(contact: &Contact) -> [f64; 2] {
    let [d_n, d_t] = contact.diagonal();
    [d_n, d_t.max(PRESCRIBED * d_n)]
}

fn soften(block: &mut Block, contact: &Contact, softening: f64) {
    let d = weights(contact);
    block[0][0] += contact.compliance[0] + softening * d[0];
    block[1][1] += contact.compliance[1] + softening * d[1];
}

/// For each contact the contacts that share a body with it, itself included, in order; `None` if they are too many.
fn neighbours(problem: &Problem) -> Option<Vec<Vec<usize>>> {
    // All glued disks of a compliant boundary are one body, which comes last.
    let mut touching = vec![Vec::new(); problem.records.len() + 1];
    let bodies = |contact: &Contact| {
        [contact.a, contact.b].map(|body| match problem.glued_index(body as usize) {
            Some(_) if problem.boundary.is_compliant() => Some(problem.records.len()),
            Some(_) => None,
            None => Some(body as usize),
        })
    };
    for (index, contact) in problem.contacts.iter().enumerate() {
        for body in bodies(contact).into_iter().flatten() {
            touching[body].push(index);
        }
    }
    let mut blocks = 0;
    let listed = problem.contacts.iter().map(|contact| {
        let mut list = Vec::new();
        for body in bodies(contact).into_iter().flatten() {
            list.extend_from_slice(&touching[body]);
        }
        list.sort_unstable();
        list.dedup();
        blocks += list.len();
        (blocks <= MOST_BLOCKS).then_some(list)
    });
    listed.collect()
}
