//! From the keys of a scenario to the types that the steps work with.
//!
//! In reading order:
//! - [`bounds`], [`mass_scaling`]: bounds on the step, and the price of scaled masses;
//! - [`prescribed_opening`]: a pair that is pulled apart.

pub mod bounds;
pub mod mass_scaling;
pub mod prescribed_opening;

use std::ops::Range;

use dem_kernel::bodies::cluster::{Cluster, Clusters};
use dem_kernel::bodies::faces::depth_behind;
use dem_kernel::bodies::feed::{Detachment, Injection, PointSource, Source};
use dem_kernel::bodies::geometry::range;
use dem_kernel::bodies::pairs::{GRAINS, Pairs, ROWS, SURFACE, WHEEL};
use dem_kernel::bodies::{ALERT, Bodies, SKIN};
use dem_kernel::law::adhesion::Adhesion;
use dem_kernel::law::cohesion::{Cohesion, HPrime};
use dem_kernel::law::healing::Healing;
use dem_kernel::law::{Law, Springs};
use dem_kernel::step::state::GrainState;
use kit::ConfigError;

use crate::config::DemConfig;
use crate::config::detachment::DetachmentConfig;
use crate::config::injection::InjectionConfig;
use crate::config::law::{self, LawConfig};
use crate::config::sample::SampleConfig;
use crate::error::DemError;
use crate::sample::surface;
use crate::sample::types::Sample;
use crate::setup::bounds::StepBounds;
use kit::keys::refuse_if;

/// Overlap of two rigid disks over the smaller radius above which a sample is refused: a repair in one step would throw them apart.
const RIGID_OVERLAP: f64 = 0.01;
/// Inertial times in which a grain off a surface grows.
const GROWTH: f64 = 100.0;

/// The bodies of a prepared sample, the last `fed` of whose free grains are in store.
pub fn bodies(config: &DemConfig, thickness: f64, sample: &Sample, fed: usize) -> Bodies {
    let disks = || sample.free.iter().chain(&sample.glued).chain(&sample.face);
    let [smallest, _] = range(disks().map(|disk| disk.radius));
    let mass = |r: f64| config.real_mass(r, thickness) * config.mass_scale;
    let mut masses: Vec<f64> = sample.free.iter().map(|disk| mass(disk.radius)).collect();
    // This comes first, while each disk has its own mass: below, the first disk of a cluster gets the cluster's mass.
    let driven = |disk: &usize| {
        let mut driven = sample.clusters.iter().filter(|c| c.drive.is_some());
        driven.any(|cluster| cluster.disks.contains(disk))
    };
    let grains = (0..masses.len()).filter(|disk| !driven(disk));
    let grains: Vec<f64> = grains.map(|disk| masses[disk]).collect();
    let injection = match (&config.injection, &config.detachment) {
        (Some(keys), _) => Some(feed(keys, config.mass_scale, fed, &grains)),
        (None, Some(keys)) => Some(source(keys, config, sample, fed, thickness)),
        (None, None) => None,
    };
    let clusters = clusters(config, sample, &masses);
    for cluster in &clusters.list {
        cluster.disks.iter().for_each(|disk| masses[*disk] = 0.0);
        masses[cluster.leader()] = cluster.mass;
    }
    let pairs_adhere = config.law.pairs.iter().filter_map(|pair| pair.adhesion);
    let ranges = pairs_adhere
        .chain(config.law.adhesion)
        .map(|own| own.range_m);
    let wheel = config.wheel.as_ref();
    let rolling = wheel.and_then(|wheel| wheel.rolling.as_ref());
    Bodies {
        injection,
        free: sample.free.len(),
        radii: disks().map(|disk| disk.radius).collect(),
        masses,
        added_mass_rel: 1.0 - 1.0 / config.mass_scale,
        clusters,
        gravity: config.gravity_m_per_s2.map(|g| g / config.mass_scale),
        reference: sample.glued.iter().map(|disk| disk.centre).collect(),
        base: sample.glued.len() - sample.lid,
        surface: sample.surface.clone(),
        lines: surface::lines(&config.sample, sample),
        ends: ends(&config.sample, sample),
        wheel_mass: wheel.map(|wheel| wheel.mass_kg),
        face: sample.face.iter().map(|disk| disk.centre).collect(),
        face_bonded: wheel.is_some_and(|wheel| wheel.bonded),
        wheel_radius: wheel.map_or(0.0, |wheel| wheel.radius_m),
        wheel_start: rolling.map_or(0.0, |rolling| rolling.start_m),
        rolls: rolling.is_some(),
        wheel_spin_mass: wheel.and_then(|wheel| {
            let inertia = wheel.rolling.as_ref()?.spin_inertia_kg_m2?;
            Some(inertia / (wheel.radius_m * wheel.radius_m))
        }),
        walls: sample.walls.clone(),
        named_walls: named_walls(&sample.wall_names),
        period: config.sample.period(),
        prescribed_velocity: None,
        law: law(&config.law, thickness),
        pairs: pairs(config, thickness, sample),
        heat: config.heat.as_ref().map(|heat| {
            let names = body_names(config, sample, None);
            heat.law(thickness, &names)
        }),
        alert: ranges.fold(ALERT * smallest, f64::max),
        // The first list must hold all pairs that are bonded.
        skin: (SKIN * smallest).max(config.law.alert_m.unwrap_or(0.0)),
    }
}

/// Ends of a sample that does not repeat: for a layer the default ends of its surface, for others the ends of their base.
fn ends(config: &SampleConfig, sample: &Sample) -> Option<[f64; 2]> {
    let [half_width, _] = config.ends().unwrap_or_default();
    if half_width > 0.0 {
        let reach = half_width + surface::REACH * surface::mean_radius(sample);
        return Some([-reach, reach].map(|x| config.middle() + x));
    }
    let base = &sample.glued[..sample.glued.len() - sample.lid];
    let row = base.first().zip(base.last());
    let apron = config.apron();
    let ends = row.map(|(first, last)| [first.centre[0] - apron, last.centre[0] + apron]);
    ends.filter(|_| config.period().is_none())
}

/// The feed of this many grains; `masses` are the scaled masses of the sample's grains (kg).
fn feed(config: &InjectionConfig, mass_scale: f64, grains: usize, masses: &[f64]) -> Injection {
    let rate = config.rate_kg_per_s * mass_scale;
    let mean = masses.iter().sum::<f64>() / masses.len() as f64;
    Injection {
        grains,
        growth: config.growth_s.unwrap_or(mean / rate),
        source: Source::Point(PointSource {
            point: [config.x_m, config.y_m],
            rate,
            start: config.start_s,
            end: config.end_s,
        }),
    }
}

/// The source of this many grains off the bare surfaces of a sample.
fn source(
    keys: &DetachmentConfig,
    config: &DemConfig,
    sample: &Sample,
    grains: usize,
    thickness: f64,
) -> Injection {
    let inertial_time = StepBounds::new(config).inertial_time;
    Injection {
        grains,
        growth: keys.growth_s.unwrap_or(GROWTH * inertial_time),
        source: Source::Surface(Detachment {
            energy: keys.energy_j_per_m2 * thickness,
            depth: keys.depth_m,
            limit: sample.surface.deepest(),
            mass: config.density_kg_per_m3 * thickness * config.mass_scale,
        }),
    }
}

/// The name of each body: grains, clusters, rows, the wheel, walls, and segments of surfaces as `surface` or as the row that they belong to.
fn body_names(config: &DemConfig, sample: &Sample, surface: Option<&str>) -> Vec<String> {
    let mut names = vec![GRAINS.to_string(); sample.free.len()];
    for cluster in &sample.clusters {
        for disk in &cluster.disks {
            names[*disk].clone_from(&cluster.name);
        }
    }
    let base = sample.glued.len() - sample.lid;
    let glued = (0..sample.glued.len()).map(|i| ROWS[usize::from(i >= base)].to_string());
    names.extend(glued);
    let parts = sample.face.len() + usize::from(config.wheel.is_some());
    names.extend(std::iter::repeat_n(WHEEL.to_string(), parts));
    names.extend(sample.wall_names.iter().cloned());
    let segments = (0..sample.surface.segments()).map(|segment| {
        let above = sample.surface.is_above(segment, [sample.glued.len(), base]);
        surface.unwrap_or(ROWS[usize::from(above)])
    });
    names.extend(segments.map(String::from));
    names
}

/// The laws by pair of the scene.
fn pairs(config: &DemConfig, thickness: f64, sample: &Sample) -> Pairs {
    let listed = config.law.pairs.iter();
    let mut laws: Vec<([String; 2], LawConfig)> = listed
        .map(|pair| (pair.between.clone(), pair.merged(&config.law)))
        .collect();
    let surface = config.sample.surface().and_then(|keys| keys.friction);
    if let Some(friction) = surface {
        // The law of the row, but for friction.
        let mut groups = body_names(config, sample, None);
        groups.truncate(sample.free.len());
        groups.sort();
        groups.dedup();
        for group in groups {
            let is_row = |between: &[String; 2]| {
                between.contains(&group) && between.iter().any(|name| name == ROWS[0])
            };
            let row = laws.iter().find(|(between, _)| is_row(between));
            let law = LawConfig {
                friction: Some(friction),
                ..row.map_or(&config.law, |(_, law)| law).clone()
            };
            laws.push(([group, SURFACE.to_string()], law));
        }
    }
    if laws.is_empty() {
        return Pairs::default();
    }
    let names = body_names(config, sample, surface.map(|_| SURFACE));
    let laws = laws.into_iter();
    let laws = laws.map(|(pair, config)| (pair, law(&config, thickness)));
    Pairs::new(&names, &laws.collect::<Vec<_>>())
}

/// Each name with the consecutive faces that have it.
fn named_walls(names: &[String]) -> Vec<(String, Range<usize>)> {
    let mut first = 0;
    let runs = names.chunk_by(|one, next| one == next).map(|run| {
        first += run.len();
        (run[0].clone(), first - run.len()..first)
    });
    runs.filter(|(name, _)| !name.is_empty()).collect()
}

fn clusters(config: &DemConfig, sample: &Sample, masses: &[f64]) -> Clusters {
    let scale = config.mass_scale;
    let disk = |i: usize| {
        let disk = &sample.free[i];
        (disk.centre, disk.radius, masses[i] / scale)
    };
    let list = sample.clusters.iter();
    let list = list.map(|members| Cluster::new(members, disk, scale));
    Clusters::new(list.collect(), sample.free.len())
}

fn law(config: &LawConfig, thickness: f64) -> Law {
    Law {
        friction: config.friction.unwrap_or(0.0),
        rolling: config.rolling.map_or(0.0, |rolling| rolling.coefficient),
        adhesion: config.adhesion.map(|adhesion| Adhesion {
            force: adhesion.pull_off_n.unwrap_or(0.0),
            by_radius: adhesion.pull_off_pa.unwrap_or(0.0) * thickness,
            range: adhesion.range_m,
        }),
        springs: config.contact_stiffness_pa.map(|stiffness| Springs {
            normal: stiffness * thickness,
            // Without friction there is no tangential force and any stiffness will do.
            tangential: stiffness * thickness * config.tangential_stiffness_ratio.unwrap_or(1.0),
            damping: config.damping.map_or(0.0, Springs::damping_ratio),
        }),
        cohesion: cohesion(config, thickness),
        healing: config.healing.map(|healing| Healing {
            time: healing.time_s,
            pressure: healing.pressure_pa,
        }),
        restitution: config.restitution,
        penetration: config.penetration(),
    }
}

fn cohesion(config: &LawConfig, thickness: f64) -> Option<Cohesion> {
    Some(Cohesion {
        normal: config.cn_pa_per_m?,
        tangential: config.ct_pa_per_m?,
        energy: config.w_j_per_m2?,
        viscosity: config.b_pa_m_s?,
        power: config.p?,
        h_prime: match config.h_prime? {
            law::HPrime::One => HPrime::One,
            law::HPrime::Adhesion => HPrime::Adhesion,
        },
        thickness,
        alert: config.alert_m?,
        bonds_min: config.bonds_min as usize,
        damping: config.bond_damping_ratio.unwrap_or(0.0),
    })
}

/// Refuses a curved wheel that no disk can reach: it would fall for ever.
pub fn refuse_idle_wheel(state: &GrainState) -> Result<(), ConfigError> {
    refuse_if(
        !state.wheel.position[1].is_finite(),
        "wheel.radius_m",
        "no disk lies under the wheel, which stands over x = 0 or wheel.rolling.start_m: it would fall for ever",
        "raise the radius, or place disks under the wheel",
    )
}

/// Refuses rigid disks that overlap at the start.
pub fn refuse_rigid_overlaps(bodies: &Bodies, state: &GrainState) -> Result<(), DemError> {
    if bodies.law.springs.is_some() {
        return Ok(());
    }
    let positions = state.positions(bodies);
    for slot in &state.list.slots {
        let (a, b) = (slot.a as usize, slot.b as usize);
        let smaller = bodies.radii[a].min(bodies.radii.get(b).copied().unwrap_or(f64::INFINITY));
        let gap = positions.proximity(a, b).gap;
        if gap < -RIGID_OVERLAP * smaller {
            let pair = match bodies.wall_of(b) {
                _ if b < bodies.radii.len() => format!("disks {a} and {b}"),
                Some(_) => format!("disk {a} and a wall"),
                None => format!("disk {a} and the wheel or a surface"),
            };
            return Err(DemError::Overlap {
                pair,
                overlap_m: -gap,
                relative: -gap / smaller,
            });
        }
    }
    Ok(())
}

/// Refuses layers that are deeper than a surface may lose.
pub fn refuse_deep_layers(config: &DemConfig, sample: &Sample) -> Result<(), ConfigError> {
    let Some(keys) = &config.detachment else {
        return Ok(());
    };
    let limit = sample.surface.deepest();
    refuse_if(
        keys.depth_m > limit || sample.surface.bare() == 0,
        "detachment.depth_m",
        format!(
            "is {:e} m, and a third of the shortest segment of a bare surface, {limit:e} m, is the most that may come off: the body below keeps its mesh",
            keys.depth_m
        ),
        "lower it with detachment.energy_j_per_m2, or raise sample.surface.spacing_m",
    )
}

/// Refuses a wall of points with all disks of the start behind it, or with some of them inside it: nothing would hold them there.
pub fn refuse_grains_behind(
    config: &DemConfig,
    bodies: &Bodies,
    state: &GrainState,
) -> Result<(), ConfigError> {
    let SampleConfig::Disks(sample) = &config.sample else {
        return Ok(());
    };
    let fed = bodies.injection.as_ref().and_then(Injection::point);
    let fed = fed.map(|source| (&source.point, &0.0));
    let centres = state.centres[..state.present(bodies)].iter();
    let grains = centres.zip(&bodies.radii).chain(fed);
    let mut first = 0;
    for (i, wall) in sample.walls.iter().enumerate() {
        let points = wall.points_m.as_deref().unwrap_or(&[[0.0; 2]; 2]);
        let faces = &bodies.walls[first..first + points.len() - 1];
        first += faces.len();
        let depth = |centre: &[f64; 2]| depth_behind(faces.iter(), *centre, 0.0);
        let closed = points.first() == points.last();
        let all = closed || grains.clone().all(|(centre, _)| depth(centre).is_some());
        let is_wrong = |(centre, radius): &(&[f64; 2], &f64)| {
            depth(centre).is_some_and(|depth| all || depth < **radius)
        };
        let wrong = grains.clone().find(is_wrong);
        refuse_if(
            wrong.is_some(),
            &format!("sample.walls[{i}].points_m"),
            format!(
                "the disk at {:?} m lies behind this wall, which holds disks on the left of its direction",
                wrong.map_or(&[0.0; 2], |(centre, _)| centre)
            ),
            "list the points in the other order, or move the disk",
        )?;
    }
    Ok(())
}
