// Constants, guards against poison values, a sine without range reduction.

const PI: f32 = 3.14159265358979;
const HALF_PI: f32 = 1.57079632679490;
const TWO_PI: f32 = 6.28318530717959;

// `value` clamped to [low, high]; NaN becomes `fallback` (tested by bits: comparisons with NaN may be optimised away).
fn guarded(value: f32, low: f32, high: f32, fallback: f32) -> f32 {
    let is_nan = (bitcast<u32>(value) & 0x7fffffffu) > 0x7f800000u;
    return select(clamp(value, low, high), fallback, is_nan);
}

// Azimuth reduced to about [-pi, pi]; what is not finite or has lost its fraction counts as 0.
fn guarded_azimuth(phi: f32) -> f32 {
    let bits = bitcast<u32>(phi) & 0x7fffffffu;
    let sound = select(0.0, phi, bits < 0x49742400u); // 1e6
    return wrapped(sound);
}

// x minus the nearest multiple of 2 pi.
fn wrapped(x: f32) -> f32 {
    return x - TWO_PI * round(x / TWO_PI);
}

// sin(x) for abs(x) <= pi/2: minimax polynomial of degree 9, error below 4e-9.
fn sine(x: f32) -> f32 {
    let x2 = x * x;
    return x * (0.99999997659 + x2 * (-0.16666647634 + x2 * (0.00833289982 + x2 * (-0.00019800897 + x2 * 2.59048766e-6))));
}

// cos(x) for abs(x) <= pi/2, never negative; accurate to its last digit where it vanishes.
fn cosine(x: f32) -> f32 {
    return max(sine(HALF_PI - abs(x)), 0.0);
}

// Cosine and sine of an angle from those of its half.
fn doubled_angle(half: vec2f) -> vec2f {
    return vec2f(half.x * half.x - half.y * half.y, 2.0 * half.x * half.y);
}
