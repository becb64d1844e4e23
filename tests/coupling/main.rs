//! Coupled motions that are known on paper, run through the coupler in-process and over shared memory.

mod added_mass;
mod columns;
mod gmsh_interface;
mod impact;
mod main_job;
mod mapping;
mod offers;
mod one_loop;
mod policies;
mod pressed_disk;
mod reciprocating;
mod repeating;
mod report_page;
mod reports;
mod roles;
mod roles_layer;
mod schemes;
mod several;
mod split_bar;
mod stability;
mod starved;
mod static_patch;
mod two_masses;
mod two_strips;
mod velocity;
mod wheel_rail;
