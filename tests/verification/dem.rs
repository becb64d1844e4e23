//! Verification cases of dem-node.

mod dem_balance;
mod dem_bonds;
mod dem_bounds;
mod dem_clusters;
mod dem_cohesion;
mod dem_column;
mod dem_compliance;
mod dem_extremes;
mod dem_glued;
mod dem_impact;
mod dem_incline;
mod dem_keys;
mod dem_layer;
mod dem_layer_run;
mod dem_modes;
mod dem_participant;
mod dem_penetration;
mod dem_periodic;
mod dem_pyramid;
mod dem_restitution;
mod dem_solvers;
mod dem_structure;
mod dem_support;
mod dem_walls;
mod dem_wheel;
mod dem_wheel_curved;
