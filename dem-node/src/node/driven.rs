//! Signals and results of driven clusters.

use super::dem::Dem;

impl Dem {
    /// Names of the signals of driven clusters.
    pub(super) fn driven_names(&self) -> Vec<String> {
        let driven = self.bodies.clusters.driven();
        let names = driven.flat_map(|(_, _, drive)| {
            ["force_x_n", "force_y_n", "x_m", "y_m"].map(|what| format!("{}_{what}", drive.name))
        });
        names.collect()
    }

    /// Signals of driven clusters in that order: force of the grains in the last step (N), position of the centre of mass (m).
    pub(super) fn driven_signals(&self) -> impl Iterator<Item = f64> {
        let driven = self.bodies.clusters.driven().enumerate();
        driven.flat_map(|(number, (index, ..))| {
            let forces = self.stepper.on_driven.get(number);
            let [fx, fy] = forces.copied().unwrap_or_default();
            let [x, y] = self.progress.state.clusters[index].centre;
            [fx, fy, x, y]
        })
    }

    /// Results of driven clusters: forces of the grains, means over the second half of a run, and positions at its end.
    pub(super) fn driven_results(&self) -> impl Iterator<Item = (String, f64)> {
        let driven = self.bodies.clusters.driven();
        let results = driven.zip(self.progress.driven.forces());
        results.flat_map(|((index, _, drive), [fx, fy])| {
            let [x, y] = self.progress.state.clusters[index].centre;
            [("force_x_n", fx), ("force_y_n", fy), ("x_m", x), ("y_m", y)]
                .map(|(what, value)| (format!("{}_{what}", drive.name), value))
        })
    }
}
