//! Regions of the windows of a run, and the choice of the extent of a window's run.

use std::collections::BTreeMap;
use std::sync::Arc;

use fem_kernel::integrate::region::Region;

use super::extent::{Extent, WindowInput};
use crate::model::Model;

/// Regions by numbers of steps, and the last run.
#[derive(Clone, Debug, Default)]
pub(super) struct Regions {
    /// None where a repeat takes the whole body.
    known: BTreeMap<u32, Option<Arc<Region>>>,
    /// Components on which the force of the known regions acts.
    components: Vec<usize>,
    /// Steps before the last window that ran whole, its number of steps, and its region if recorded.
    last: Option<(u64, u32, Option<Arc<Region>>)>,
    /// Windows since the last repeat: nothing is recorded for a scheme that never repeats.
    unrepeated: u32,
}

/// Windows without a repeat after which nothing is recorded until the next repeat.
const UNREPEATED_MAX: u32 = 4;

impl Regions {
    /// Extent of the next run, of a window after `steps`.
    pub(super) fn extent(&mut self, model: &Model, steps: u64, input: &WindowInput) -> Extent {
        let is_coupled = !input.interface.is_empty() && model.wheel.is_none() && !model.expands();
        let last = self.last.take();
        if !is_coupled || !input.velocity.is_empty() {
            return Extent::Whole;
        }
        let window = (steps, input.substeps);
        let repeated = last.filter(|(before, m, _)| (*before, *m) == window);
        self.unrepeated = match repeated {
            Some(_) => 0,
            None => self.unrepeated.saturating_add(1),
        };
        let recorded = repeated.and_then(|(.., region)| region);
        let is_same = |region: &Arc<Region>| region.is_of(indices(input), input.substeps);
        if let Some(region) = recorded.filter(is_same) {
            self.last = Some((steps, input.substeps, Some(region.clone())));
            return Extent::Part(region);
        }
        let records = self.unrepeated <= UNREPEATED_MAX;
        let region = records.then(|| self.region(model, input)).flatten();
        self.last = Some((steps, input.substeps, region.clone()));
        region.map_or(Extent::Whole, Extent::Recorded)
    }

    #[cfg(test)]
    pub(super) fn is_recorded(&self) -> bool {
        matches!(&self.last, Some((.., Some(_))))
    }

    /// Forgets the last run.
    pub(super) fn forget(&mut self) {
        self.last = None;
    }

    fn region(&mut self, model: &Model, input: &WindowInput) -> Option<Arc<Region>> {
        if !self.components.iter().copied().eq(indices(input)) {
            self.components = indices(input).collect();
            self.known.clear();
        }
        let (components, substeps) = (&self.components, input.substeps);
        let region = self.known.entry(substeps).or_insert_with(|| {
            let history = model.body.history_row_len(model.law.as_ref());
            Region::new(&model.body, history, components, substeps).map(Arc::new)
        });
        region.clone()
    }
}

/// Components on which the interface force of a window acts.
fn indices(input: &WindowInput) -> impl Iterator<Item = usize> + '_ {
    input.interface.iter().map(|(index, _)| *index)
}
