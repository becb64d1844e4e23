//! Signals and results of driven clusters and named walls.

use super::dem::Dem;

/// Components of the force of the grains (N), and of the position of a cluster (m), as parts of names.
const FORCE: [&str; 2] = ["force_x_n", "force_y_n"];
const POSITION: [&str; 2] = ["x_m", "y_m"];

impl Dem {
    /// Signals of driven clusters, then of named walls: force of the grains in the last step (N), and position of the centre of mass of a
    /// cluster (m).
    pub(super) fn force_signals(&self) -> impl Iterator<Item = (String, f64)> {
        let forces = self.stepper.on_named.iter().copied();
        self.named(forces.chain([[0.0; 2]].into_iter().cycle()))
    }

    /// Their results: mean forces of the grains with scatter and change along x, and positions at the end.
    pub(super) fn force_results(&self) -> impl Iterator<Item = (String, f64)> {
        let driven = self.bodies.clusters.driven().map(|(.., drive)| &drive.name);
        let names = driven.chain(self.bodies.named_walls.iter().map(|(name, _)| name));
        let steady = names.zip(self.progress.forces.steadiness());
        let steady = steady.flat_map(|(name, [deviation, change])| {
            let named = |what: &str, value| (format!("{name}_force_x_{what}_n"), value);
            [named("deviation", deviation), named("change", change)]
        });
        self.named(self.progress.forces.forces()).chain(steady)
    }

    /// Names and values of these forces on driven clusters and named walls, and of the positions of the clusters.
    fn named(
        &self,
        mut forces: impl Iterator<Item = [f64; 2]>,
    ) -> impl Iterator<Item = (String, f64)> {
        let (clusters, state) = (&self.bodies.clusters, &self.progress.state);
        let centre = |index: usize| Some(state.clusters[index].centre);
        let driven = clusters
            .driven()
            .map(move |(index, _, drive)| (&drive.name, centre(index)));
        let walls = self.bodies.named_walls.iter();
        let bodies = driven.chain(walls.map(|(name, _)| (name, None)));
        bodies
            .map_while(move |(name, centre)| {
                let force = FORCE.into_iter().zip(forces.next()?);
                let position = centre.map(|centre| POSITION.into_iter().zip(centre));
                let values = force.chain(position.into_iter().flatten());
                Some(values.map(move |(what, value)| (format!("{name}_{what}"), value)))
            })
            .flatten()
    }
}
