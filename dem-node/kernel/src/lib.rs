//! The kernel of Non-Smooth Contact Dynamics: contact laws, bodies, contacts, solvers and the step of rigid disks in the plane.
//!
//! Grains are rigid disks with unilateral contact, Coulomb friction and, if wanted, elastic contacts; steps are implicit
//! (Moreau-Jean). The crate holds the code that runs for each contact and each body of a step, and works with plain numbers. It knows neither keys of
//! a scenario nor samples nor results, so that their changes recompile nothing here.
//!
//! # Problem
//!
//! N rigid disks, or rigid clusters of disks, between walls, glued rows and a wheel. Velocities jump where grains meet, so the motion is
//! an equation of measures, integrated over a step at once: no contact is an event, all contacts of a step are one problem
//! (Moreau 1988; Jean 1999).
//!
//! ```text
//! M dv = F dt + H r               Renouf, Saulot and Berthier (2006), eqs 1 to 5
//! u    = H^T v                    relative velocities at the contacts
//! law(u, g, r) at each contact    unilateral, with friction, springs or bonds
//! ```
//!
//! # Symbols
//!
//! All values are SI; r is an impulse here, but a force in `fem-node`. The normal of a contact points from body b to body a.
//!
//! | symbol | meaning | unit | in the code |
//! |---|---|---|---|
//! | q, v | position; velocity (v_x, v_y, spin times radius) | m, m/s | [`GrainState::centres`](step::state::GrainState::centres), [`GrainState::velocities`](step::state::GrainState::velocities) |
//! | M, F | masses, `mass_scale` included; weight, loads | kg, N | [`Bodies::masses`](bodies::Bodies::masses), [`StepInput`](step::StepInput) |
//! | h, theta | step, which is the window of a coupled run; weight of the end velocity | s, - | [`StepInput::step`](step::StepInput::step), [`StepInput::theta`](step::StepInput::theta) |
//! | g | gap, below 0 where bodies overlap | m | [`Contact::gap`](solver::contact::Contact::gap) |
//! | u, U | relative velocity, u_n > 0 when separating; the same with the terms of gap and springs | m/s | [`Problem::relative_velocity`](solver::problem::Problem::relative_velocity) |
//! | r | impulse of a contact, r_n > 0 in compression | N s | [`Contact::impulse`](solver::contact::Contact::impulse) |
//! | W | Delassus operator H^T M^-1 H; its block of a contact has W_nn, W_nt, W_tt | 1/kg | [`DelassusBlock`](law::local::DelassusBlock) |
//! | mu, e | coefficients of friction and restitution | - | [`Law::friction`](law::Law::friction), [`Law::restitution`](law::Law::restitution) |
//! | kn, kt, d_t | stiffness of compliant contacts; elongation of the tangential spring | N/m, m | [`Springs`](law::Springs), [`Slot::spring`](contact::detect::Slot::spring) |
//! | a | adhesion of a bond, 1 to 0 (the paper's beta) | - | [`Bond::adhesion`](contact::bond::Bond::adhesion) |
//! | Cn, Ct, w, b, p | stiffness, surface energy, viscosity and exponent of a bond | Pa/m, J/m2, Pa m s^p, - | [`Cohesion`](law::cohesion::Cohesion) |
//! | l | area of a bond, r_1 r_2/(r_1 + r_2) t, with t the thickness | m2 | [`Bond::area`](contact::bond::Bond::area) |
//! | delta | opening of a bond since it was made | m | [`Bond::opening`](contact::bond::Bond::opening) |
//! | v_g, a_g, p, W_g | velocity of the glued disks, the same without contact forces, impulse on them, compliance of the body below | m/s, m/s, N s, 1/kg | [`CompliantBoundary`](contact::boundary::CompliantBoundary) |
//!
//! # A step
//!
//! ```text
//! q_m    = q + h (1 - theta) v    contacts are detected here
//! v_free = v + h M^-1 F
//! v'     = v_free + M^-1 H r      RSB eq 7; r from the contact problem
//! q'     = q_m + h theta v'
//! ```
//!
//! With W = H^T M^-1 H the contact problem is RSB eq 8, with one law per contact:
//!
//! ```text
//! u = H^T v_free + W r
//! rigid      U_n = u_n + max(0, g)/h           IQS: an overlap stays, and adds no speed
//!            U_n = u_n + e u_n(t_i)            where g <= 0: Newton's restitution
//! springs    U_n = u_n + g/h + r_n/(kn h^2)    signed gap
//!            U_t = u_t + d_t/h + r_t/(kt h^2)
//! Signorini  U_n >= 0,  r_n >= 0,  U_n r_n = 0
//! Coulomb    |r_t| <= mu r_n;  U_t = 0, or r_t = -+mu r_n opposed to it
//! ```
//!
//! # Bonds
//!
//! Raous, Cangemi and Cocou (1999), RSB eqs 9 and 10 with their signs corrected; here r_n is a force:
//!
//! ```text
//! r_n = -l Cn a^2 delta_n    in tension
//! r_t = -l Ct a^2 delta_t    along the contact
//! a'  = -[(1/b) (w h'(a) - a D)^-]^(1/p),   D = Cn delta_n^2 + Ct delta_t^2
//! ```
//!
//! A bond opens from delta_0 = sqrt(w/Cn) on, under the stress sqrt(w Cn). Adhesion is held while the contact problem is solved, then lowered to the
//! value of this solution, and the problem is solved again until no adhesion falls. With h < 1/(sqrt(3) omega), omega = sqrt(l Cn/m), there is only
//! one solution ([`step::stiffness::step_limit`]). In longer steps this is the first solution on the way from the intact bond, which a descent of the
//! incremental energy reaches. A bond may then withstand more than its fracture energy, and the run warns where bonds came close to their strength.
//!
//! A bond dissipates w l as it breaks, less by a part of some 0.2 h sqrt(3) omega. Its pair touches at the gap at which the bond was made until it
//! has come apart once ([`Slot::gap`](contact::detect::Slot::gap)): no new overlap or void appears.
//!
//! # The compliant base
//!
//! Glued disks have neither mass nor spin. They lie on a body that another solver moves; all they know of it is one linear relation:
//!
//! ```text
//! v_g = a_g + W_g p    a_g, W_g: given by the coupler for this window
//! ```
//!
//! Beside the disks, or in their place, the boundary may have points of a surface, on whose segments grains lie ([`bodies::surface`]). A grain with
//! the foot (1 - s, s) between two points has the velocity S v_g below it and exerts S^T p on them.
//!
//! v_g enters the sweeps like any other velocity ([`contact::boundary`]). It is both the mean velocity of the window and the end velocity of the
//! grains, which is consistent for theta = 1 only: a coupled run with another theta is refused.
//!
//! # One step, module by module
//!
//! 1. [`step::injection::feed`] adds fed grains; [`GrainState::drift`](step::state::GrainState::drift) moves to q_m; [`contact::detect`] lists pairs
//!    by linked cells and a Verlet list, whose slots remember forces and springs; [`law`] turns gaps into biases, for single grains of one law
//!    side by side.
//! 2. [`solver::nsgs`] sweeps over the contacts, each taking its impulse in closed form ([`law::local`], by packs
//!    [`law::vector`]), from the impulses of the step before. Without friction [`solver::pcg`] needs fewer iterations.
//! 3. [`solver::residual`] decides, not the change of a sweep: `|W (r - P(r - U/W))| / |W r| <= tolerance`. Sweeps that creep or circle are
//!    extrapolated, averaged, and at last replaced by pivoting.
//! 4. [`contact::bond::end_step`] and [`contact::loss::contact_loss`] record the energy that contacts stored and lost; the bodies move to q';
//!    [`step::repair`] removes overlaps of rigid grains, if asked.
//!
//! # Checks
//!
//! - Energy ([`step::ledger`]): work of loads, drives, weight and interface against kinetic energy, springs and bonds, and losses by
//!   impact, friction, dampers and decohesion, each by its own formula. The loss of the scheme, and the change that detection makes to the end of the
//!   step, are terms too.
//! - Momentum: forces on the free grains against the change of their momentum, `momentum_defect_max_n`.
//! - Rigid contacts only dissipate: energy created by friction and rebounds is summed contact by contact ([`step::ledger::GrainLedger::made`]).
//!
//! # Limits
//!
//! Disks and clusters of disks in the plane, which do not deform: compliance is in the contacts. Bonds are made at the start and by healing. With
//! friction a rigid packing may have many solutions; sweeps find one of them, the same for any number of threads.
//!
//! # Modules
//!
//! In reading order, each with a list of its own:
//! - [`law`]: the contact laws in closed form, bonds included;
//! - [`bodies`]: the bodies, their distances, and their drives;
//! - [`contact`]: pairs that may touch, bonds between grains, the compliant boundary of the glued disks;
//! - [`solver`]: the contact problem and its solvers;
//! - [`mod@step`]: one step of the scheme, the state that it advances, and the energy balance;
//! - [`random`], [`relax`]: random numbers of a seed, and packings that relax;
//! - [`error`]: reasons for which a step cannot be made.
//!
//! # Equations, functions, sources
//!
//! RSB is Renouf, Saulot and Berthier, *Third-body flow during wheel-rail interaction*, 2006; its equations 11 to 17 belong
//! to the continuum.
//!
//! | equation | function | source |
//! |---|---|---|
//! | relative velocity u = H^T v, and v += M^-1 H r | [`solver::problem::Problem::relative_velocity`], [`solver::problem::Problem::apply`] | RSB (1)-(5); Jean 1999 |
//! | theta scheme q_m = q + h (1 - theta) v, q' = q_m + h theta v' | [`step::Stepper::advance`], [`step::state::GrainState::drift`] | RSB (7); Moreau 1988; Jean 1999 |
//! | v_free = v + h M^-1 F | [`step::Stepper::free_records`] | RSB (7) |
//! | Delassus operator W = H^T M^-1 H, block of a contact | [`solver::problem::Problem::block`] | RSB (8); Jean 1999 |
//! | local problem b = u + bias - W r, U = b + W r | [`solver::problem::Problem::local_solution`] | RSB (8); Jean 1999 |
//! | Signorini and Coulomb: open, stick or slide | [`law::local::LocalLaw::impulse`] | Jean 1999 |
//! | the same for several contacts, W_nt = 0 | [`law::vector::normal_impulse`], [`law::vector::tangential_impulse`] | Jean 1999 |
//! | projection on the Coulomb sector | [`law::local::coulomb_projection`] | Alart and Curnier 1991 |
//! | natural-map residual | [`solver::residual`] | Alart and Curnier 1991 |
//! | block non-linear Gauss-Seidel, its criterion | [`solver::nsgs::solve`], [`solver::residual::Quad`] | RSB (8); Jourdan, Alart and Jean 1998; Jean 1999 |
//! | projected conjugate gradient (CPG) | [`solver::pcg::solve`] | Renouf and Alart 2005 |
//! | springs: U += g/h, W += 1/(k h^2) | [`law::Law::compliance`], [`law::Law::bias`] | LMGC90 (elastic repel) |
//! | dampers: both times 1/(1 + c/(kn h)), c = 2 zeta sqrt(kn m) | [`law::Springs::damped_share`], [`law::Springs::damping_ratio`] | Schwager and Pöschel 2007 |
//! | bonds with dampers: delta/h, delta_t/h and 1/kappa times 1/(1 + c/(k h)) | [`law::damped_share`], [`law::relaxation`] | Kelvin and Voigt |
//! | rebound damped by the step, e = exp(-pi h omega / 2) | [`step::stiffness::numerical_restitution`] | Jean 1999; this project |
//! | gap and IQS, restitution U = u_n + e u_n(t_i) | [`law::Law::bias`] | Moreau 1988; LMGC90 |
//! | split impulse and projection of positions | [`step::repair::Repair::make`] | [`step::repair`] |
//! | rolling resistance, \|M\| <= mu_r r r_n | [`solver::rolling`] | Jiang, Yu and Harris 2005; Estrada, Taboada and Radjai 2008 |
//! | attraction, r_n + N_c >= 0, \|r_t\| <= mu (r_n + N_c) | [`law::adhesion::Adhesion::attraction`], [`contact::loss::attraction_loss`] | Radjai, Preechawuttipong and Peyroux 2001 |
//! | cohesive zone: adhesion a' = -((w h' - a D)^- / b)^(1/p) | [`law::cohesion::Cohesion::adhesion_after`] | RSB (9)-(10), signs corrected; Raous, Cangemi and Cocou 1999 |
//! | healing a' = 1/T under pressure, friction beside it mu (1 - a) | [`law::healing::Healing::grown`], [`law::Law::friction_share`] | Raous and Monerie 2002; this project |
//! | cohesive force r_n = -kappa_n U, kappa = h^2 l C a^2 | [`law::local::BondLaw::impulse`] | RSB (9)-(10); Raous, Cangemi and Cocou 1999 |
//! | unique end of a step with bonds, h < 1/(sqrt(3) omega) | [`step::stiffness::step_limit`] | [`contact::bond`] |
//! | feet on a surface, v = S v_g, p = S^T f | [`bodies::surface::Foot`], [`contact::boundary::CompliantBoundary::feet`] | virtual work |
//! | compliant boundary v_g = a_g + W_g p | [`contact::boundary::CompliantBoundary::evaluate`] | Gravouil and Combescure 2001 |
//! | energy lost by a contact, by a bond | [`contact::loss::contact_loss`], [`contact::bond::end_step`] | [`step::ledger`] |
//! | energy stored: kinetic, springs, bonds | [`step::state::GrainState::energies`] | [`step::ledger`] |
//! | fed grains, Qe of the circuit | [`step::injection::feed`] | RSB, figure 1; this project |
//! | steel that comes off bare surfaces, Qs | [`step::detachment`] | Fleischer 1973 (energy density of wear); this project |
//! | relaxation of a bed (FIRE) | [`relax::Packing::relax`] | Bitzek et al. 2006 |
//!
//! # Example
//! A disk that falls on a floor and stays there:
//!
//! ```
//! use dem_kernel::bodies::disk::Disk;
//! use dem_kernel::bodies::faces::{Face, RigidWall};
//! use dem_kernel::bodies::{ALERT, Bodies, SKIN};
//! use dem_kernel::solver::criteria::{Algorithm, Criteria};
//! use dem_kernel::step::state::GrainState;
//! use dem_kernel::step::{StepInput, Stepper, WheelTurn};
//!
//! let radius = 1e-3;
//! let face = Face::HalfPlane { point: [0.0; 2], normal: [0.0, 1.0] };
//! let bodies = Bodies {
//!     free: 1,
//!     radii: vec![radius],
//!     masses: vec![0.02],
//!     gravity: [0.0, -9.81],
//!     walls: vec![RigidWall { face, velocity: [0.0; 2] }],
//!     alert: ALERT * radius,
//!     skin: SKIN * radius,
//!     ..Bodies::default()
//! };
//! let mut state = GrainState::new(&bodies, &[Disk::at_rest([0.0, 2e-3], radius)], &[]);
//! let input = StepInput {
//!     bodies: &bodies, step: 1e-4, theta: 1.0, load: 0.0, wheel_x: 0.0, turn: WheelTurn::Held, loaded: 0.0, free_velocity: &[],
//! };
//! let criteria = Criteria {
//!     algorithm: Algorithm::Nsgs, tolerance: 1e-8, max_iterations: 100, min_iterations: 1, parallel: false,
//! };
//! let mut stepper = Stepper::default();
//! for _ in 0..1000 {
//!     stepper.advance(&mut state, &input, &criteria)?;
//! }
//! assert!((state.centres[0][1] - radius).abs() < 1e-12);
//! # Ok::<(), dem_kernel::error::KernelError>(())
//! ```

pub mod bodies;
pub mod contact;
pub mod error;
pub mod law;
pub mod random;
pub mod relax;
pub mod solver;
pub mod step;
