//! Texts of scenes: the head, participants one by one, and interfaces; a scene is their [`concat`](slice::concat).
//!
//! Bars and chains consist of masses of 1 kg and springs of 1 N/m, 1 m apart, so waves run at 1 m/s and the
//! critical step of a bar is 1 s. The last argument of each function holds further keys, one per line.

/// Young's modulus of a strip (Pa).
pub const YOUNG_PA: f64 = 102.5e9;

/// Poisson's ratio of a strip.
pub const POISSON: f64 = 0.3;

/// Edge of the square elements of a strip (m).
pub const SPACING_M: f64 = 0.4e-3;

/// Keys common to all participants.
pub fn head(name: &str, thickness_m: f64, keys: &str) -> String {
    format!("[run]\nname = \"{name}\"\nthickness_m = {thickness_m:?}\n{keys}\n")
}

/// A participant of any kind.
pub fn participant(name: &str, kind: &str, keys: &str) -> String {
    format!("[[participant]]\nname = \"{name}\"\nkind = \"{kind}\"\n[participant.config]\n{keys}\n")
}

/// An explicit bar without damping, [`crate::bar`]; its left end is at x = 0 unless `x_m` is among the keys.
pub fn bar(name: &str, elements: u32, step_s: f64, keys: &str) -> String {
    let unit = "spacing_m = 1.0\nelement_mass_kg = 1.0\nelement_stiffness_n_per_m = 1.0";
    let time = format!("step_s = {step_s:?}\ndamping = 0.5");
    participant(
        name,
        "bar",
        &format!("elements = {elements}\n{unit}\n{time}\n{keys}"),
    )
}

/// Free masses behind a glued one at `x_m`, [`crate::chain`]; the keys give the mass of the glued one.
pub fn chain(name: &str, x_m: f64, count: u32, keys: &str) -> String {
    let unit = "spacing_m = 1.0\nmass_kg = 1.0\nstiffness_n_per_m = 1.0";
    participant(
        name,
        "chain",
        &format!("x_m = {x_m:?}\ncount = {count}\n{unit}\n{keys}"),
    )
}

/// A moving rigid body at `x_m` with implicit Euler steps: a chain of one mass, participant `body`.
pub fn body(x_m: f64, mass_kg: f64, velocity_m_per_s: f64, keys: &str) -> String {
    let start = format!("x_m = {x_m:?}\nvelocity_m_per_s = {velocity_m_per_s:?}");
    participant(
        "body",
        "chain",
        &format!("{start}\nglued_mass_kg = {mass_kg:?}\ntheta = 1.0\n{keys}"),
    )
}

/// An elastic strip, 4 mm wide; the keys give its time step and its loads.
pub fn strip(name: &str, [base, sides]: [&str; 2], height_m: f64, keys: &str) -> String {
    let held = format!("base = \"{base}\"\nsides = \"{sides}\"");
    let mesh =
        format!("mesh = {{ width_m = 4e-3, height_m = {height_m:?}, size_m = {SPACING_M:?} }}");
    let elastic = format!("young_pa = {YOUNG_PA:?}, poisson = {POISSON:?}");
    let material = format!("material = {{ {elastic}, density_kg_per_m3 = 7800.0 }}");
    participant(name, "fem", &format!("{held}\n{mesh}\n{material}\n{keys}"))
}

/// A row of masses on a strip, 4 mm wide and 1 mm thick, under a traction in y: [`crate::plate`], participant
/// `plate`.
pub fn plate(points: u32, traction_pa: f64, end_s: f64) -> String {
    let row = format!("points = {points}\nwidth_m = 4e-3\ny_m = 0.0\nthickness_m = 1e-3");
    let load = format!("mass_kg = 1e-5\ntraction_pa = [0.0, {traction_pa:?}]\nend_s = {end_s:?}");
    participant("plate", "plate", &format!("{row}\n{load}"))
}

/// Join of two sets.
pub fn interface(
    name: &str,
    between: [&str; 2],
    scheme: &str,
    substeps: u32,
    keys: &str,
) -> String {
    format!(
        "[[interface]]\nname = \"{name}\"\nbetween = {between:?}\nscheme = \"{scheme}\"\nsubsteps = {substeps}\n{keys}\n"
    )
}

/// The interface `glue` between the right end of `bar` and `body`.
pub fn glue(scheme: &str, substeps: u32, keys: &str) -> String {
    interface("glue", ["bar.end", "body.end"], scheme, substeps, keys)
}

/// Columns of three disks below or between strips, over these elements of a strip: base, grain and lid.
pub fn columns_between(name: &str, elements: &[usize]) -> String {
    let radius = 0.15e-3;
    let disk = |element: usize, row: usize| {
        let x = (element as f64 - 4.5) * SPACING_M;
        let y = 2.0 * radius * row as f64;
        let glued = ["glued = true", "glued = false", "glued = true, lid = true"][row];
        format!("{{ x_m = {x:e}, y_m = {y:e}, radius_m = {radius:e}, {glued} }}")
    };
    let columns = elements.iter();
    let disks: Vec<String> = columns
        .flat_map(|at| [0, 1, 2].map(|row| disk(*at, row)))
        .collect();
    let keys = format!(
        r#"
density_kg_per_m3 = 7800.0
law = {{ kind = "coulomb", friction = 0.3, contact_stiffness_pa = 1e11, tangential_stiffness_ratio = 1.0 }}
solver = {{ kind = "nsgs", tolerance = 1e-11, max_iterations = 100000, min_iterations = 1 }}
time = {{ pressure_pa = 1e6 }}
sample = {{ kind = "disks", disks = [{}] }}
"#,
        disks.join(", ")
    );
    participant(name, "dem", &keys)
}

/// Two layers between a clamped strip and a pressed free one, on four interfaces with these keys.
pub fn layers_between(lower: &str, policy: &str, end_s: f64) -> String {
    let time = "time = { step_s = 5e-8, damping = 0.5, mass_damping_per_s = 6e5 }";
    let pressed = format!("{time}\nboundary = {{ top = {{ pressure_pa = 100e6 }} }}");
    let strips = [
        strip(
            "lower",
            ["clamped", "fixed_x"],
            2e-3,
            &format!("{time}\n{lower}"),
        ),
        strip("upper", ["free", "fixed_x"], 2e-3, &pressed),
    ];
    let mut text = head("layers", 1e-3, &format!("end_s = {end_s:?}")) + &strips.concat();
    for (index, elements) in [&[0, 1, 3][..], &[6, 7, 9]].into_iter().enumerate() {
        let name = format!("layer-{index}");
        text += &columns_between(&name, elements);
        for (strip, of_layer) in [("lower.top", "base"), ("upper.bottom", "lid")] {
            let between = [strip, &format!("{name}.{of_layer}")];
            let joint = format!("{of_layer}-{index}");
            text += &interface(&joint, between, "dual-schur", 4, policy);
        }
    }
    text
}
