//! The modified Bessel function that circular Gaussians integrate to.

/// Where the power series hands over to the asymptotic one: both have full precision there.
const SWITCH: f64 = 25.0;

/// exp(-|x|) I0(x), scaled so that it neither overflows nor loses digits for any x.
///
/// Below [`SWITCH`] by the power series of I0 (all terms positive), above it by the asymptotic series of Hankel
/// (Abramowitz and Stegun 9.6.12 and 9.7.1), both summed to the last bit. d'Eon's ten terms (2011, Eq 15) are useless beyond x = 12.
pub fn i0e(x: f64) -> f64 {
    let x = x.abs();
    let (mut term, mut sum) = (1.0, 1.0);
    if x < SWITCH {
        let quarter = 0.25 * x * x;
        for k in 1.. {
            term *= quarter / f64::from(k * k);
            sum += term;
            if term < 1e-17 * sum {
                break;
            }
        }
        return sum * (-x).exp();
    }
    let eighth = 0.125 / x;
    for k in 1..40 {
        let odd = f64::from(2 * k - 1);
        let next = term * odd * odd * eighth / f64::from(k);
        if next < 1e-17 || next > term {
            break;
        }
        term = next;
        sum += term;
    }
    sum / (std::f64::consts::TAU * x).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition, 1/pi times the integral of exp(x (cos t - 1)) over [0, pi], by the trapezoidal rule.
    fn by_definition(x: f64) -> f64 {
        let n = 400 + (20.0 * x.sqrt()) as i32;
        (0..n)
            .map(|k| {
                let s = (std::f64::consts::PI * f64::from(k) / f64::from(n)).sin();
                (-2.0 * x * s * s).exp()
            })
            .sum::<f64>()
            / f64::from(n)
    }

    #[test]
    fn i0e_is_the_integral_it_stands_for() {
        for x in [0.0, 1e-8, 0.3, 2.0, 11.9, 12.1, 24.999, 25.001, 80.0, 1e3, 1e5] {
            let ratio = i0e(x) / by_definition(x);
            assert!((ratio - 1.0).abs() < 1e-13, "x = {x}: {ratio}");
            assert_eq!(i0e(-x), i0e(x));
        }
        // The series of d'Eon 2011, Eq 15 must not pass this test.
        let mut term = 1.0;
        let truncated: f64 = (1..=10)
            .map(|i| {
                term *= 36.0 / f64::from(i * i);
                term
            })
            .sum::<f64>()
            + 1.0;
        assert!((truncated * (-12.0_f64).exp() / by_definition(12.0) - 1.0).abs() > 1e-3);
    }
}
