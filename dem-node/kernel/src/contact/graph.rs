//! Graphs of bonds and contacts: first bodies, grains that bonds connect with an anchor, agglomerates of the other grains, and bodies that contacts
//! hold.

/// For each of the first `grains` bodies, true if a chain of these bonds connects it with a body beyond them, the anchors: glued
/// disks, and a wheel with bonds of its own.
pub fn first_bodies(grains: usize, bonds: &[(u32, u32)]) -> Vec<bool> {
    let anchor = grains as u32;
    let bonds = bonds
        .iter()
        .map(|(a, b)| [*a, *b].map(|body| body.min(anchor)));
    let roots = roots(grains + 1, bonds);
    roots[..grains].iter().map(|root| *root == anchor).collect()
}

/// Number of grains in the agglomerate of each of the first `grains` bodies, connected by chains of these pairs without anchors.
pub fn agglomerates(grains: usize, pairs: impl Iterator<Item = (u32, u32)>) -> Vec<u32> {
    let pairs = pairs.filter(|(a, b)| (*a.max(b) as usize) < grains);
    let roots = roots(grains, pairs.map(|(a, b)| [a, b]));
    let mut sizes = vec![0; grains];
    roots.iter().for_each(|root| sizes[*root as usize] += 1);
    roots.iter().map(|root| sizes[*root as usize]).collect()
}

/// Numbers of bodies and contacts that remain when bodies among the first `count` with fewer than `least` contacts are removed, until there are no
/// such bodies.
pub fn backbone(count: usize, mut contacts: Vec<[usize; 2]>, least: usize) -> [usize; 2] {
    loop {
        let degrees = degrees(count, contacts.iter().copied());
        let stays = |body: &usize| degrees.get(*body).is_none_or(|count| *count >= least);
        let before = contacts.len();
        contacts.retain(|pair| pair.iter().all(stays));
        if contacts.len() == before {
            return [degrees.iter().filter(|count| **count > 0).count(), before];
        }
    }
}

/// Contacts of each of the first `count` bodies.
pub fn degrees(count: usize, contacts: impl Iterator<Item = [usize; 2]>) -> Vec<usize> {
    let mut degrees = vec![0; count];
    for body in contacts.flatten() {
        if let Some(degree) = degrees.get_mut(body) {
            *degree += 1;
        }
    }
    degrees
}

/// The bodies that these pairs connect have the same root, the highest number among them. Union-find.
fn roots(count: usize, pairs: impl Iterator<Item = [u32; 2]>) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..count as u32).collect();
    for pair in pairs {
        let [a, b] = pair.map(|body| root(&mut parent, body));
        parent[a.min(b) as usize] = a.max(b);
    }
    (0..count as u32)
        .map(|body| root(&mut parent, body))
        .collect()
}

fn root(parent: &mut [u32], mut body: u32) -> u32 {
    while parent[body as usize] != body {
        let above = parent[parent[body as usize] as usize];
        parent[body as usize] = above;
        body = above;
    }
    body
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grains_are_first_body_while_a_chain_of_bonds_holds_them() {
        // 0 - 1 - (5), 2 - 3 on their own, 4 alone; 5 and 6 are anchors.
        let chain = [(0, 1), (1, 5), (2, 3)];
        let first = first_bodies(5, &chain);
        assert_eq!(first, [true, true, false, false, false]);
        // A bridge makes all of them first body; without its foot no grain is.
        let bridge = [(0, 1), (0, 4), (1, 6), (2, 3), (3, 4)];
        assert_eq!(first_bodies(5, &bridge), [true; 5]);
        assert_eq!(
            first_bodies(5, &[(0, 1), (0, 4), (2, 3), (3, 4)]),
            [false; 5]
        );
        // A ring that closes on itself.
        let ring = [(0, 1), (0, 2), (1, 2), (2, 5)];
        assert_eq!(first_bodies(5, &ring), [true, true, true, false, false]);
    }

    #[test]
    fn an_agglomerate_is_what_a_chain_connects_without_anchors() {
        // 0 - 1 - 4 and 2 - 3; 5 is an anchor to which 3 and 1 are bonded.
        let pairs = [(0, 1), (1, 4), (1, 5), (2, 3), (3, 5)];
        assert_eq!(agglomerates(5, pairs.into_iter()), [3, 3, 2, 2, 3]);
    }
}
