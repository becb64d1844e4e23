//! Verification cases of fem-node: each file states its problem, the exact answer, where it is from, and where
//! the tolerance comes from.

mod fem_bodies;
mod vtk_file;

mod fem_compliance;
mod fem_cylinder;
mod fem_dispersion;
mod fem_energy;
mod fem_fields;
mod fem_follow;
mod fem_gmsh_binary;
mod fem_gmsh_contact;
mod fem_gmsh_joints;
mod fem_gmsh_patch;
mod fem_gmsh_refuse;
mod fem_gmsh_same;
mod fem_load_table;
mod fem_locking;
mod fem_manufactured;
mod fem_mesh;
mod fem_mixed;
mod fem_motion;
mod fem_motion_table;
mod fem_msh;
mod fem_newmark;
mod fem_patch;
mod fem_periodic;
mod fem_perturb;
mod fem_plastic;
mod fem_plausible;
mod fem_punch;
mod fem_rayleigh;
mod fem_refuse;
mod fem_repeat;
mod fem_rotation;
mod fem_scene;
mod fem_set_load;
mod fem_static;
mod fem_static_contact;
mod fem_static_resume;
mod fem_step_limit;
mod fem_thrown;
mod fem_wave;
mod fem_wheel;
mod fem_wheel_extremes;
