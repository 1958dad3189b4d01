//!use lib/maths.wgsl
// Look-ups in the host's tables (render/src/gpu/tables.rs, same constants). A pass that uses them declares
//   @group(0) @binding(n) var<storage, read> tables: array<vec4f>;

const TRUNCATION_COUNT: u32 = 64u;
const TRUNCATION_MIN: f32 = -2.0;
const TRUNCATION_MAX: f32 = 3.0;
const GAMMA_OFFSET: u32 = 1344u;
const VON_MISES_STEPS: u32 = 256u;
const VON_MISES_OFFSET: u32 = 1480u;
const COSINE_POWER_STEPS: u32 = 64u;
const COSINE_POWER_OFFSET: u32 = 1737u;
const WINDOW_OFFSET: u32 = 10187u;
const FRESNEL_STEPS: u32 = 256u;
const FRESNEL_ETA_MAX: f32 = 3.0;
const FRESNEL_OFFSET: u32 = 10317u;
const XU_ETA_STEPS: u32 = 128u;
const XU_ETA_MAX: f32 = 10.0;
const XU_THETA_STEPS: u32 = 64u;
const XU_OFFSET: u32 = 10831u;

// A place between two entries of a table.
struct Slot { index: u32, fraction: f32 }

// The slot of `x` in [0, 1] among `steps` intervals.
fn table_slot(x: f32, steps: u32) -> Slot {
    let at = clamp(x, 0.0, 1.0) * f32(steps);
    let index = min(u32(at), steps - 1u);
    return Slot(index, at - f32(index));
}

// Node and weight k of the n-point Gauss rule for exp(-x^2) on (-infinity, t]; n from 1 to 6.
fn truncated_gauss(n: u32, k: u32, t: f32) -> vec2f {
    let slot = table_slot((t - TRUNCATION_MIN) / (TRUNCATION_MAX - TRUNCATION_MIN), TRUNCATION_COUNT - 1u);
    let entry = tables[(n * (n - 1u) / 2u + k) * TRUNCATION_COUNT + slot.index];
    return entry.xy + slot.fraction * entry.zw;
}

// Node k of the n-point Gauss rule over gamma in [0, pi/2]: sin, cos, weight * cos / 2 (that is dh / 2), weight; n from 1 to 16.
fn gamma_node(n: u32, k: u32) -> vec4f {
    return tables[GAMMA_OFFSET + n * (n - 1u) / 2u + k];
}

// Quantities of the von Mises density of concentration kappa = 2 / lambda^2.
struct VonMises {
    i0e: f32,             // exp(-kappa) I0(kappa); exp(kappa (cos x - 1)) integrates to 2 pi i0e
    root: f32,            // sqrt(kappa)
    half: vec2f,          // cos(x/2), sin(x/2) of the rule with nodes {0, +-x}, exact for 1, cos x, cos 2x
    outer_weight: f32,    // weight of each outer node; the middle one has 1 - 2 outer_weight
    convolution: f32,     // g: a convolution with a narrow density kappa_2 has kappa_c = kappa / (1 + g / kappa_2)
}

// Coordinate of the tables over kappa: 0 for a direction, 1 for a uniform light.
fn concentration_coordinate(kappa: f32) -> f32 {
    return 1.0 / (1.0 + sqrt(kappa));
}

fn von_mises(kappa: f32) -> VonMises {
    let root = sqrt(kappa);
    let v = 1.0 / (1.0 + root);
    let slot = table_slot(v, VON_MISES_STEPS);
    let at = VON_MISES_OFFSET + slot.index;
    let entry = mix(tables[at], tables[at + 1u], slot.fraction);
    // From the tangent of a quarter of the outer node's angle, without a root.
    let quarter = entry.y * v;
    let half = vec2f(1.0 - quarter * quarter, 2.0 * quarter) / (1.0 + quarter * quarter);
    return VonMises(entry.x * v, root, half, entry.z, entry.w * (0.5 + kappa));
}

// The density that approximates the convolution of two; the first one's `convolution` is g.
fn convolved(kappa: f32, g: f32, kappa_2: f32) -> f32 {
    return kappa * kappa_2 / (kappa_2 + g);
}

// Means of y^1..y^8, y = abs(cos(phi/2)), over a von Mises density kappa whose centre has y = `y` (Xu 2011, Eq 14).
struct CosinePowers { low: vec4f, high: vec4f }

fn mean_cosine_powers(kappa: f32, y: f32) -> CosinePowers {
    let row = table_slot(concentration_coordinate(kappa), COSINE_POWER_STEPS);
    let column = table_slot(y, COSINE_POWER_STEPS);
    let at = COSINE_POWER_OFFSET + 2u * (row.index * (COSINE_POWER_STEPS + 1u) + column.index);
    let below = at + 2u * (COSINE_POWER_STEPS + 1u);
    return CosinePowers(
        mix(mix(tables[at], tables[at + 2u], column.fraction), mix(tables[below], tables[below + 2u], column.fraction), row.fraction),
        mix(mix(tables[at + 1u], tables[at + 3u], column.fraction), mix(tables[below + 1u], tables[below + 3u], column.fraction), row.fraction),
    );
}

// The same means over the half circle around that centre (Xu 2011, Eq 28).
fn window_cosine_powers(y: f32) -> CosinePowers {
    let column = table_slot(y, COSINE_POWER_STEPS);
    let at = WINDOW_OFFSET + 2u * column.index;
    return CosinePowers(mix(tables[at], tables[at + 2u], column.fraction), mix(tables[at + 1u], tables[at + 3u], column.fraction));
}

// Coefficients of X^0..X^7 of the reflectance at cosine X, for eta in [1, 3].
struct FresnelPolynomial { low: vec4f, high: vec4f }

fn fresnel_polynomial(eta: f32) -> FresnelPolynomial {
    let slot = table_slot((eta - 1.0) / (FRESNEL_ETA_MAX - 1.0), FRESNEL_STEPS);
    let at = FRESNEL_OFFSET + 2u * slot.index;
    return FresnelPolynomial(mix(tables[at], tables[at + 2u], slot.fraction), mix(tables[at + 1u], tables[at + 3u], slot.fraction));
}

// H_0, H_2, H_4 of TT (p = 1) or TRT (p = 2): integrals over h in [-1, 1] of Schlick's Fresnel factors times h^k, at eta and
// abs(theta_d) (Xu 2011, Eq 19 and 23).
fn xu_moments(eta: f32, theta_d: f32, p: u32) -> vec3f {
    let row = table_slot((1.0 - 1.0 / eta) / (1.0 - 1.0 / XU_ETA_MAX), XU_ETA_STEPS);
    let column = table_slot(theta_d / HALF_PI, XU_THETA_STEPS);
    let at = XU_OFFSET + 2u * (row.index * (XU_THETA_STEPS + 1u) + column.index) + p - 1u;
    let below = at + 2u * (XU_THETA_STEPS + 1u);
    let upper = mix(tables[at].xyz, tables[at + 2u].xyz, column.fraction);
    return mix(upper, mix(tables[below].xyz, tables[below + 2u].xyz, column.fraction), row.fraction);
}
