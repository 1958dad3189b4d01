// Constants and guards against poison values.

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
