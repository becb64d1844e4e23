//! Heat in a structured body, in layers that are thin at its upper edge.
//!
//! ```text
//!   o---o---o  upper edge      vertices in the columns of the mesh; between its rows, layers no thicker than 0.2 of their depth
//!   o---o---o                  below the upper edge, down to where the rows of the mesh are as thin
//!   o---o---o
//!   |   |   |                  C (T' - T) = Q + h sum H (T_j' - T')   along a column
//!   o---o---o                             + h sum H (T_j - T)         across columns
//! ```
//! Finite volumes around the vertices (Patankar 1980, ch. 4): with H = k t w/d between two of them, no temperature leaves the range of its neighbours,
//! of the edges and of the start. Steps are implicit along the columns, so that the thinnest layer sets no limit.

use std::sync::Arc;

use kit::heat::{CapacityTable, FluxMemory, factor_at};
use kit::table::LoadTable;
use protocol::larger;
use serde::{Deserialize, Serialize};

use crate::mesh::{Edge, Mesh};

/// Thickness of a layer over the depth at which it begins, at most.
const GROWTH: f64 = 0.2;

/// Numbers of a body for its heat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatNumbers {
    /// k (W/(m K)).
    pub conductivity: f64,
    /// rho c (J/(m3 K)).
    pub capacity: f64,
    /// Thickness of the body (m).
    pub thickness: f64,
    /// Thickness of the layer at the upper edge (m).
    pub finest: f64,
}

/// Condition on an edge; without one it is insulated. Temperatures are rises above the start (K).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EdgeCondition {
    /// Held at this temperature.
    Held(f64),
    /// Flux into the body (W/m2).
    Flux(f64),
    /// A film of this conductance (W/(m2 K)) to surroundings at a temperature.
    Film([f64; 2]),
}

/// Vertices of a body, their capacities and conductances.
#[derive(Clone, Debug, Default)]
pub struct HeatBody {
    /// Vertices in a row.
    columns: usize,
    /// True where its rows count from the lower edge of the mesh.
    turned_over: bool,
    /// Abscissae of the columns (m).
    x: Vec<f64>,
    periodic: bool,
    /// Row of vertices at the upper edge of each row of elements, and at the lower edge of the body.
    firsts: Vec<usize>,
    /// Thickness of the layer below each row of vertices over its row of elements.
    shares: Vec<f64>,
    /// C (J/K).
    capacity: Vec<f64>,
    /// H to the vertex below (W/K).
    down: Vec<f64>,
    /// H to the next vertex in the row (W/K).
    right: Vec<f64>,
    /// Temperature of each vertex on a held edge, with the edge's number.
    held: Vec<Option<(usize, f64)>>,
    /// Vertex, number of the edge, flux (W).
    fluxes: Vec<(usize, usize, f64)>,
    /// Vertex, number of the edge, conductance (W/K), temperature beside it.
    films: Vec<(usize, usize, f64, f64)>,
    /// Conditions, and one more for the wheel.
    edges: usize,
    /// Longest step without overshoot across the columns (s).
    limit: f64,
    /// Factors on k over the rise (K), and on rho c.
    conductivity: LoadTable,
    heats: CapacityTable,
    wheel: Option<HeatWheel>,
}

/// A wheel of half-spaces, one for each vertex of the upper edge that it touches: a point of its surface that comes with the wheel's own temperature
/// and stays with the vertex until they part, b (T_w - T_0) = int q/sqrt(pi (t - s)) ds.
#[derive(Clone, Debug)]
struct HeatWheel {
    /// b = sqrt(k rho c) (W s^0.5/(m2 K)).
    effusivity: f64,
    /// Its temperature less the body's at the start (K).
    rise: f64,
    /// Areas of the vertices (m2).
    areas: Vec<f64>,
}

/// The part of the heat that steps change.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct HeatField {
    /// Rises of the temperatures since the start (K), row after row.
    pub rises: Vec<f64>,
    /// Heat of each vertex over its constant capacity (K), where the capacity depends on temperature.
    heats: Vec<f64>,
    /// Flux memories of the wheel at the vertices of the upper edge that it touches; empty without a wheel of half-spaces.
    wheel: Vec<Option<FluxMemory>>,
    /// Heat that waits for the next step, by vertices of the upper edge (J).
    pub upper: Vec<f64>,
    /// The same by elements, in the order of their dissipation; empty without a source there.
    pub inner: Vec<f64>,
    /// Heat that has left through each edge with a condition, and into a wheel of half-spaces (J).
    pub conducted: Vec<f64>,
    /// Highest rise on the upper edge at the end of a step (K), its abscissa (m) and time (s).
    pub peak: [f64; 3],
    /// Largest size of a rise on the upper edge so far (K), and the fall of the temperature over the first layer below it then, over this rise.
    pub extreme: [f64; 2],
    /// Lowest rise of a vertex at the end of a step (K).
    pub lowest: f64,
    /// Largest difference that a capacity which changed within a step made to a rise (K).
    pub bent: f64,
    /// Time since the start (s).
    pub time: f64,
    /// Factors of the columns for the length of the last step; a step of another length computes them again.
    #[serde(skip)]
    factors: Arc<ColumnFactors>,
}

impl HeatField {
    /// Every number that changes a later one.
    pub fn numbers(&self) -> impl Iterator<Item = &f64> {
        let waiting = self.upper.iter().chain(&self.inner);
        let wheel = self.wheel.iter().flatten().flat_map(FluxMemory::numbers);
        let vertices = self.rises.iter().chain(&self.heats);
        vertices.chain(waiting).chain(wheel)
    }
}

/// Factors of the columns for steps of one length.
#[derive(Clone, Debug, Default)]
struct ColumnFactors {
    step: f64,
    lower: Vec<f64>,
    inverse: Vec<f64>,
    upper: Vec<f64>,
    right: Vec<f64>,
}

impl HeatBody {
    /// The vertices of a structured mesh whose layers lie above its lower edge: the upper one of the body [turned over](Mesh::turned_over).
    pub fn above_bottom(
        mesh: &Mesh,
        numbers: HeatNumbers,
        conditions: &[(Edge, EdgeCondition)],
    ) -> HeatBody {
        let turned = conditions
            .iter()
            .map(|(edge, of)| (edge.turned_over(), *of));
        let turned: Vec<_> = turned.collect();
        HeatBody {
            turned_over: true,
            ..HeatBody::new(&mesh.turned_over(), numbers, &turned)
        }
    }

    /// The vertices of a structured mesh; an earlier condition takes precedence in a corner.
    pub fn new(
        mesh: &Mesh,
        numbers: HeatNumbers,
        conditions: &[(Edge, EdgeCondition)],
    ) -> HeatBody {
        let depths: Vec<f64> = (0..=mesh.rows)
            .map(|j| mesh.point(0, 0)[1] - mesh.point(0, j)[1])
            .collect();
        let layers: Vec<Vec<f64>> = depths
            .windows(2)
            .map(|ends| layers([ends[0], ends[1]], numbers.finest))
            .collect();
        let mut firsts = vec![0];
        for row in &layers {
            firsts.push(firsts[firsts.len() - 1] + row.len());
        }
        let shares: Vec<f64> = layers.into_iter().flatten().collect();
        let columns = mesh.columns + usize::from(!mesh.periodic);
        let mut body = HeatBody {
            columns,
            x: (0..columns).map(|i| mesh.point(i, 0)[0]).collect(),
            periodic: mesh.periodic,
            firsts,
            shares,
            edges: conditions.len(),
            ..HeatBody::default()
        };
        body.fill(mesh, numbers);
        for (edge, (place, condition)) in conditions.iter().enumerate() {
            body.condition(mesh, numbers.thickness, *place, (edge, *condition));
        }
        let held = &body.held;
        body.films.retain(|film| held[film.0].is_none());
        body.limit = body.longest();
        body
    }

    /// The same with factors on k and rho c over temperature (K), the start being at this one.
    pub fn over_temperature(
        mut self,
        start: f64,
        [conductivity, capacity]: [&[[f64; 2]]; 2],
    ) -> HeatBody {
        let highest = conductivity.iter().map(|[_, factor]| *factor);
        let lowest = capacity.iter().map(|[_, factor]| *factor);
        self.limit *= lowest.reduce(f64::min).unwrap_or(1.0);
        self.limit /= highest.reduce(f64::max).unwrap_or(1.0);
        self.conductivity = conductivity.iter().map(|[t, f]| [t - start, *f]).collect();
        self.heats = CapacityTable::new(capacity, start);
        self
    }

    /// The same under a wheel of half-spaces of this b (W s^0.5/(m2 K)), this much warmer than the body at the start (K).
    pub fn under_wheel(
        mut self,
        (mesh, thickness): (&Mesh, f64),
        [effusivity, rise]: [f64; 2],
    ) -> HeatBody {
        let lengths = mesh.surface(Edge::Top).1;
        self.edges += 1;
        self.wheel = Some(HeatWheel {
            effusivity,
            rise,
            areas: lengths.iter().map(|length| length * thickness).collect(),
        });
        self
    }

    /// True under a wheel of half-spaces.
    pub fn has_wheel(&self) -> bool {
        self.wheel.is_some()
    }

    /// Takes the vertices of the upper edge that a wheel touches from now on. To a vertex that it did not touch a wheel of half-spaces brings a fresh
    /// point.
    pub fn meet(&self, field: &mut HeatField, touches: impl Iterator<Item = bool>) {
        if self.wheel.is_some() {
            field.wheel.resize(self.columns, None);
            for (memory, touches) in field.wheel.iter_mut().zip(touches) {
                *memory = touches.then(|| memory.take().unwrap_or_default());
            }
        }
    }

    fn rows(&self) -> usize {
        self.shares.len() + 1
    }

    /// The column after another one; the first after the last.
    fn next(&self, column: usize) -> usize {
        if column + 1 < self.columns {
            column + 1
        } else {
            0
        }
    }

    /// Capacities and conductances, column by column.
    fn fill(&mut self, mesh: &Mesh, numbers: HeatNumbers) {
        let (columns, rows) = (self.columns, self.rows());
        let (k, t) = (numbers.conductivity, numbers.thickness);
        let gaps: Vec<f64> = (0..mesh.columns)
            .map(|i| mesh.point(i + 1, 0)[0] - mesh.point(i, 0)[0])
            .collect();
        let before = |i: usize| match i {
            0 if self.periodic => gaps[mesh.columns - 1],
            0 => 0.0,
            _ => gaps[i - 1],
        };
        let widths: Vec<f64> = (0..columns)
            .map(|i| 0.5 * (before(i) + gaps.get(i).unwrap_or(&0.0)))
            .collect();
        let thick = |i: usize, row: usize| {
            let j = self.firsts.partition_point(|first| *first <= row) - 1;
            let height = mesh.point(i, j)[1] - mesh.point(i, j + 1)[1];
            self.shares[row] * height
        };
        let around = |i: usize, row: usize| {
            let above = if row > 0 { thick(i, row - 1) } else { 0.0 };
            let below = if row + 1 < rows { thick(i, row) } else { 0.0 };
            0.5 * (above + below)
        };
        let all = (0..rows).flat_map(|row| (0..columns).map(move |i| (i, row)));
        let capacity = all
            .clone()
            .map(|(i, row)| numbers.capacity * t * widths[i] * around(i, row));
        let down = all.clone().map(|(i, row)| {
            let layer = (row + 1 < rows).then(|| thick(i, row));
            layer.map_or(0.0, |layer| k * t * widths[i] / layer)
        });
        let right = all.map(|(i, row)| {
            let next = self.next(i);
            let gap = gaps.get(i);
            gap.map_or(0.0, |gap| {
                k * t * 0.5 * (around(i, row) + around(next, row)) / gap
            })
        });
        let filled = [capacity.collect(), down.collect(), right.collect()];
        [self.capacity, self.down, self.right] = filled;
        self.held = vec![None; columns * rows];
    }

    /// Enters the condition of an edge.
    fn condition(
        &mut self,
        mesh: &Mesh,
        thickness: f64,
        place: Edge,
        (edge, condition): (usize, EdgeCondition),
    ) {
        let (columns, rows) = (self.columns, self.rows());
        let along: Vec<usize> = match place {
            Edge::Top => (0..columns).collect(),
            Edge::Bottom => ((rows - 1) * columns..rows * columns).collect(),
            Edge::Left => (0..rows).map(|row| row * columns).collect(),
            Edge::Right => (0..rows).map(|row| (row + 1) * columns - 1).collect(),
        };
        let lengths = match place {
            Edge::Top | Edge::Bottom => mesh.surface(place).1,
            Edge::Left | Edge::Right => {
                let column = if place == Edge::Left { 0 } else { mesh.columns };
                let height = mesh.point(column, 0)[1] - mesh.point(column, mesh.rows)[1];
                let all: f64 = (0..rows)
                    .map(|row| self.capacity[along[0] + row * columns])
                    .sum();
                let of = |vertex: &usize| height * self.capacity[*vertex] / all;
                along.iter().map(of).collect()
            }
        };
        for (vertex, length) in along.into_iter().zip(lengths) {
            let area = length * thickness;
            match condition {
                EdgeCondition::Held(rise) => {
                    let _ = self.held[vertex].get_or_insert((edge, rise));
                }
                EdgeCondition::Flux(flux) => self.fluxes.push((vertex, edge, flux * area)),
                EdgeCondition::Film([film, beside]) => {
                    self.films.push((vertex, edge, film * area, beside));
                }
            }
        }
    }

    fn longest(&self) -> f64 {
        let rate = |vertex: usize| {
            // The last vertex of a row conducts to the first one where the body repeats; elsewhere its conductance is 0.
            let is_first = vertex.is_multiple_of(self.columns);
            let after = if is_first {
                vertex + self.columns
            } else {
                vertex
            };
            (self.right[after - 1] + self.right[vertex]) / self.capacity[vertex]
        };
        let free = (0..self.capacity.len()).filter(|vertex| self.held[*vertex].is_none());
        1.0 / free.map(rate).fold(0.0, larger)
    }

    /// Everything at the temperature of the start, but for held edges.
    pub fn at_start(&self) -> HeatField {
        let rises = self.held.iter();
        let rises = rises.map(|held| held.map_or(0.0, |(_, rise)| rise));
        let mut conducted = vec![0.0; self.edges];
        for (held, capacity) in self.held.iter().zip(&self.capacity) {
            held.iter()
                .for_each(|(edge, rise)| conducted[*edge] -= capacity * self.heats.heat(*rise));
        }
        let rises: Vec<f64> = rises.collect();
        let heats = rises.iter().map(|rise| self.heats.heat(*rise));
        HeatField {
            heats: heats.filter(|_| !self.heats.is_constant()).collect(),
            rises,
            upper: vec![0.0; self.columns],
            conducted,
            ..HeatField::default()
        }
    }

    /// Heat that the body has gained since the start (J); held edges have theirs from the start on.
    pub fn stored(&self, field: &HeatField) -> f64 {
        let constant = self.heats.is_constant();
        let heats = if constant { &field.rises } else { &field.heats };
        let all = self.capacity.iter().zip(heats);
        all.map(|(capacity, heat)| capacity * heat).sum()
    }

    /// Largest difference of temperature between a vertex under a condition and one without beside it, over the largest rise.
    pub fn fall_at_edges(&self, field: &HeatField) -> f64 {
        let rises = &field.rises;
        let sizes = rises.iter().map(|rise| rise.abs());
        let largest = sizes.fold(f64::MIN_POSITIVE, larger);
        let mut given: Vec<bool> = self.held.iter().map(Option::is_some).collect();
        let fluxes = self.fluxes.iter().map(|(vertex, ..)| *vertex);
        let films = self.films.iter().map(|(vertex, ..)| *vertex);
        // The layers at the upper edge are judged when it is furthest from its start.
        let others = fluxes.chain(films).filter(|vertex| *vertex >= self.columns);
        others.for_each(|vertex| given[vertex] = true);
        let fall = |apart: usize| {
            let pairs = (0..rises.len() - apart).map(|vertex| [vertex, vertex + apart]);
            let beside = pairs.filter(|[a, b]| {
                let in_line = apart > 1 || a / self.columns == b / self.columns;
                in_line && given[*a] != given[*b]
            });
            let falls = beside.map(|[a, b]| (rises[a] - rises[b]).abs());
            falls.fold(0.0, larger)
        };
        larger(fall(1), fall(self.columns)) / largest
    }

    /// Rise at node (column, row) of the mesh (K).
    pub fn rise(&self, field: &HeatField, [column, row]: [usize; 2]) -> f64 {
        let row = self.firsts[self.row(row, self.firsts.len())];
        field.rises[row * self.columns + column % self.columns]
    }

    /// Its row for one of `count` rows of the mesh.
    fn row(&self, row: usize, count: usize) -> usize {
        if self.turned_over {
            count - 1 - row
        } else {
            row
        }
    }

    /// Mean rise of element (column, row) of the mesh (K).
    pub fn mean_rise(&self, field: &HeatField, [column, row]: [usize; 2]) -> f64 {
        let row = self.row(row, self.firsts.len() - 1);
        let next = self.next(column);
        let at = |row: usize| {
            let rises = &field.rises[row * self.columns..];
            0.5 * (rises[column] + rises[next])
        };
        let layers = self.firsts[row]..self.firsts[row + 1];
        layers
            .map(|layer| self.shares[layer] * 0.5 * (at(layer) + at(layer + 1)))
            .sum()
    }

    /// Rises of the upper edge (K), node by node.
    pub fn upper<'a>(&self, field: &'a HeatField) -> &'a [f64] {
        &field.rises[..self.columns]
    }

    /// Goes on by this time (s), with the heat that waits.
    pub fn advance(&self, field: &mut HeatField, time: f64) {
        let parts = (time / self.limit).ceil().max(1.0);
        let step = time / parts;
        let changes = self.changes();
        if !changes && field.factors.step != step {
            field.factors = Arc::new(self.factors(step));
        }
        let factors = Arc::clone(&field.factors);
        let mut added = vec![0.0; self.capacity.len()];
        added[..self.columns].copy_from_slice(&field.upper);
        field.upper.fill(0.0);
        self.spread(&mut field.inner, &mut added);
        added.iter_mut().for_each(|heat| *heat /= parts);
        for _ in 0..parts as u64 {
            if changes {
                self.changing_step(field, step, &added);
            } else {
                self.step(field, &factors, &added);
            }
            field.time += step;
            self.see_peak(field);
        }
    }

    /// True where a step has other factors than the one before.
    fn changes(&self) -> bool {
        !self.conductivity.is_empty() || !self.heats.is_constant() || self.wheel.is_some()
    }

    /// A step with k and rho c at the temperatures of its start, and with the wheel. A vertex keeps the heat that it gets, and has the temperature of
    /// its heat.
    fn changing_step(&self, field: &mut HeatField, step: f64, added: &[f64]) {
        let (columns, mut now, before) = (self.columns, self.clone(), field.rises.clone());
        let mean = |a: usize, b: usize| 0.5 * (before[a] + before[b]);
        let factor = |a, b| factor_at(&self.conductivity, mean(a, b));
        for (vertex, capacity) in now.capacity.iter_mut().enumerate() {
            *capacity *= self.heats.factor(before[vertex]);
            let below = (vertex + columns).min(before.len() - 1);
            now.down[vertex] *= factor(vertex, below);
            let column = vertex % columns;
            now.right[vertex] *= factor(vertex, vertex - column + self.next(column));
        }
        let wheel = self.wheel.as_ref();
        for (vertex, memory) in field.wheel.iter().enumerate() {
            if let (Some(wheel), Some(memory), None) = (wheel, memory, self.held[vertex]) {
                let [alone, slope] = memory.ahead(step).map(|rise| rise / wheel.effusivity);
                let film = wheel.areas[vertex] / slope;
                now.films
                    .push((vertex, self.edges - 1, film, wheel.rise + alone));
            }
        }
        now.step(field, &now.factors(step), added);
        for (vertex, _, film, beside) in &now.films[self.films.len()..] {
            let (rise, areas) = (field.rises[*vertex], wheel.map(|wheel| &wheel.areas));
            let memory = field.wheel[*vertex].as_mut();
            if let Some((memory, areas)) = memory.zip(areas) {
                memory.take(film * (rise - beside) / areas[*vertex], step);
            }
        }
        for (vertex, heat) in field.heats.iter_mut().enumerate() {
            let gained = now.capacity[vertex] * (field.rises[vertex] - before[vertex]);
            *heat += gained / self.capacity[vertex];
            if self.held[vertex].is_none() {
                let linear = std::mem::replace(&mut field.rises[vertex], self.heats.rise(*heat));
                field.bent = larger(field.bent, (field.rises[vertex] - linear).abs());
            }
        }
    }

    /// Spreads the heat of elements over their vertices, by the thickness of the layers.
    fn spread(&self, inner: &mut [f64], added: &mut [f64]) {
        let element_rows = self.firsts.len() - 1;
        let stride = inner.len() / element_rows;
        let elements = self.columns - usize::from(!self.periodic);
        for (row, heats) in inner.chunks_exact_mut(stride.max(1)).enumerate() {
            let j = self.row(row, element_rows);
            for (i, heat) in heats.iter_mut().enumerate().take(elements) {
                let quarter = 0.25 * std::mem::take(heat);
                let next = self.next(i);
                for layer in self.firsts[j]..self.firsts[j + 1] {
                    for (row, column) in [(0, i), (0, next), (1, i), (1, next)] {
                        added[(layer + row) * self.columns + column] +=
                            quarter * self.shares[layer];
                    }
                }
            }
        }
    }

    /// Factors of the columns for a step (s).
    fn factors(&self, step: f64) -> ColumnFactors {
        let count = self.capacity.len();
        let mut factors = ColumnFactors {
            step,
            lower: vec![0.0; count],
            inverse: vec![0.0; count],
            upper: vec![0.0; count],
            right: self.right.iter().map(|h| step * h).collect(),
        };
        let mut own = self.capacity.clone();
        for (vertex, _, conductance, _) in &self.films {
            own[*vertex] += step * conductance;
        }
        for (vertex, own) in own.into_iter().enumerate() {
            let above = vertex.checked_sub(self.columns);
            let up = above.map_or(0.0, |above| step * self.down[above]);
            let down = step * self.down[vertex];
            if self.held[vertex].is_some() {
                factors.inverse[vertex] = 1.0;
                continue;
            }
            factors.lower[vertex] = up;
            let eliminated = above.map_or(0.0, |above| up * factors.upper[above]);
            factors.inverse[vertex] = 1.0 / (own + up + down - eliminated);
            factors.upper[vertex] = down * factors.inverse[vertex];
        }
        factors
    }

    fn step(&self, field: &mut HeatField, factors: &ColumnFactors, added: &[f64]) {
        let (columns, step) = (self.columns, factors.step);
        let rises = &mut field.rises;
        let mut heat: Vec<f64> = (self.capacity.iter().zip(&*rises).zip(added))
            .map(|((capacity, rise), added)| capacity * rise + added)
            .collect();
        let rows = rises
            .chunks_exact(columns)
            .zip(heat.chunks_exact_mut(columns));
        for ((rises, heat), right) in rows.zip(factors.right.chunks_exact(columns)) {
            for i in 0..columns - usize::from(!self.periodic) {
                let next = self.next(i);
                let across = right[i] * (rises[next] - rises[i]);
                heat[i] += across;
                heat[next] -= across;
            }
        }
        for (vertex, edge, flux) in &self.fluxes {
            heat[*vertex] += step * flux;
            field.conducted[*edge] -= step * flux;
        }
        for (vertex, _, conductance, beside) in &self.films {
            heat[*vertex] += step * conductance * beside;
        }
        // What a held vertex gets beside the heat along its column leaves at once.
        for (vertex, held) in self.held.iter().enumerate() {
            if let Some((edge, rise)) = held {
                field.conducted[*edge] += heat[vertex] - self.capacity[vertex] * rise;
                heat[vertex] = *rise;
            }
        }
        for (heat, inverse) in heat.iter_mut().zip(&factors.inverse).take(columns) {
            *heat *= inverse;
        }
        for vertex in columns..heat.len() {
            heat[vertex] = (heat[vertex] + factors.lower[vertex] * heat[vertex - columns])
                * factors.inverse[vertex];
        }
        for vertex in (0..heat.len() - columns).rev() {
            heat[vertex] += factors.upper[vertex] * heat[vertex + columns];
        }
        rises.copy_from_slice(&heat);
        for (vertex, edge, conductance, beside) in &self.films {
            field.conducted[*edge] += step * conductance * (rises[*vertex] - beside);
        }
        self.along_columns(field, step);
    }

    /// Books the heat that passes along columns into held vertices.
    fn along_columns(&self, field: &mut HeatField, step: f64) {
        let rises = &field.rises;
        let pairs = self.held.iter().zip(self.held.iter().skip(self.columns));
        for (vertex, pair) in pairs.enumerate() {
            let below = vertex + self.columns;
            let down = step * self.down[vertex] * (rises[vertex] - rises[below]);
            match pair {
                (None, Some((edge, _))) => field.conducted[*edge] += down,
                (Some((edge, _)), None) => field.conducted[*edge] -= down,
                _ => {}
            }
        }
    }

    fn see_peak(&self, field: &mut HeatField) {
        let below = &field.rises[self.columns..];
        let upper = field.rises.iter().zip(below).zip(&self.held);
        for (((rise, below), held), x) in upper.zip(&self.x) {
            if *rise > field.peak[0] {
                field.peak = [*rise, *x, field.time];
            }
            if rise.abs() > field.extreme[0] {
                // The temperature of a held edge is given.
                let fall = held.map_or((rise - below) / rise, |_| 0.0);
                field.extreme = [rise.abs(), fall];
            }
        }
        let least = |low: f64, rise: &f64| if *rise >= low { low } else { *rise };
        field.lowest = field.rises.iter().fold(field.lowest, least);
    }

    /// Largest part of its heat that a vertex passes on in a time (s), and the parts that this time is taken in.
    pub fn swiftness(&self, time: f64) -> [f64; 2] {
        let mut passed = self.down.clone();
        for (vertex, _, film, _) in &self.films {
            passed[*vertex] += film;
        }
        if let Some(wheel) = &self.wheel {
            let into = wheel.effusivity * (0.25 * std::f64::consts::PI / time).sqrt();
            let upper = passed.iter_mut().zip(&wheel.areas);
            upper.for_each(|(passed, area)| *passed += area * into);
        }
        let all = passed.iter().zip(&self.capacity);
        let swift = all.map(|(passed, capacity)| time * passed / capacity);
        [swift.fold(0.0, larger), time / self.limit]
    }
}

/// Layers of a row of elements between two depths (m), each over the thickness of the row.
fn layers([from, to]: [f64; 2], finest: f64) -> Vec<f64> {
    let mut depths = vec![from];
    let mut at = from;
    while at + larger(finest, GROWTH * at) < to {
        at += larger(finest, GROWTH * at);
        depths.push(at);
    }
    // The last layer is as thick as the rule wants, or thinner: all are stretched to end with the row.
    let next = at + larger(finest, GROWTH * at);
    let (keep, end) = if next - to > to - at && depths.len() > 1 {
        (depths.len() - 1, at)
    } else {
        (depths.len(), next)
    };
    depths.truncate(keep);
    depths.push(end);
    let pairs = depths.windows(2);
    let shares = pairs.map(|pair| (pair[1] - pair[0]) / (end - from));
    shares.collect()
}
