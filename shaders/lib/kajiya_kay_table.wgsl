//!use lib/tables.wgsl
// The diffuse term of Kajiya and Kay 1989 under an SRBF light from the host's table (render/src/gpu/tables_kajiya_kay.rs).

const KAJIYA_KAY_STEPS: u32 = 32u;
const KAJIYA_KAY_OFFSET: u32 = 27601u;

// Integral of G cos(theta_i) over the sphere, a function of sin theta_j and s = lambda_j^2 / 2 alone. The table holds its ratio to the
// light's solid angle times sqrt((cos^2 theta_j + 2 s) / (1 + 2 s)), which has the same limits for narrow lights and is smooth in
// sqrt(1 - |sin theta_j|) and sqrt(2 s) / (1 + sqrt(2 s)).
fn kajiya_kay_diffuse(theta_j: f32, lambda: f32) -> f32 {
    let cos_theta_j = max(cos(theta_j), 0.0);
    let from_pole = table_slot(cos_theta_j * inverseSqrt(1.0 + abs(sin(theta_j))), KAJIYA_KAY_STEPS);
    let width = table_slot(lambda / (1.0 + lambda), KAJIYA_KAY_STEPS);
    let entry = tables[KAJIYA_KAY_OFFSET + width.index * KAJIYA_KAY_STEPS + from_pole.index];
    let ratio = entry.x + from_pole.fraction * entry.y + width.fraction * (entry.z + from_pole.fraction * entry.w);
    let two_s = lambda * lambda;
    return solid_angle(lambda) * ratio * sqrt((cos_theta_j * cos_theta_j + two_s) / (1.0 + two_s));
}

// Integral of an SRBF over the sphere, pi lambda^2 (1 - exp(-4 / lambda^2)).
fn solid_angle(lambda: f32) -> f32 {
    let x = 4.0 / (lambda * lambda);
    // Series where the subtraction would cancel.
    let share = select(1.0 - exp(-x), x * (1.0 - x * (0.5 - x / 6.0)), x < 0.03);
    return PI * lambda * lambda * share;
}
