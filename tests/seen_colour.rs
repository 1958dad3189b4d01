//! Seen colour: the layout of paths agrees with the adaptive reference, and the inverse gives back what was asked for.

use balayage_render::optics::{Fibre, dual::mean_reflectance, seen::DeepHair};
use balayage_tests::{POISON, random};
use rand::Rng;

const HAIR: Fibre = Fibre {
    eta: 1.55,
    eccentricity: 1.0,
    sigma_a: [0.0; 3],
    alpha: [-0.087, 0.0436, 0.131],
    beta: [0.096, 0.048, 0.192],
    azimuthal_width: 0.2,
};

#[test]
fn one_hundred_colours_are_met_within_a_percent() {
    let hair = DeepHair::new(&HAIR).unwrap();
    let (dark, light) = hair.gamut();
    assert!(dark < 0.05 && light > 0.6, "{dark} {light}");
    let mut rng = random(6);
    let mut worst: f64 = 0.0;
    for i in 0..100 {
        let wanted: [f64; 3] = std::array::from_fn(|_| dark * (light / dark).powf(rng.random()));
        let solved = hair.solve(&wanted);
        assert!(solved.in_gamut && solved.sigma_a.iter().all(|s| (0.0..=100.0).contains(s)));
        // The independent reference integrates adaptively; it takes its time.
        let seen = if i < 3 {
            let fibre = Fibre {
                sigma_a: solved.sigma_a,
                ..HAIR
            };
            mean_reflectance(&fibre, 1e-3).unwrap()
        } else {
            hair.colour(&solved.sigma_a)
        };
        for c in 0..3 {
            let off = (seen[c] / wanted[c] - 1.0).abs();
            worst = worst.max(off);
            assert!(off < 0.01, "{wanted:?} gives {seen:?}");
        }
        let other = hair.colour(&solved.sigma_a.map(|s| 1.1 * s + 0.01));
        assert!(
            (0..3).any(|c| (other[c] / wanted[c] - 1.0).abs() > 0.01),
            "the comparison must be able to fail"
        );
    }
    println!("worst of 100 colours: {:.3} %", 100.0 * worst);
}

#[test]
fn more_absorption_is_darker() {
    let hair = DeepHair::new(&HAIR).unwrap();
    let colours: Vec<f64> = (0..150)
        .map(|i| hair.reflectance(1e-4 * 1.08_f64.powi(i)))
        .collect();
    assert!(colours.windows(2).all(|w| w[1] < w[0]));
}

#[test]
fn out_of_gamut_says_so_and_takes_the_nearest() {
    let hair = DeepHair::new(&HAIR).unwrap();
    let (dark, light) = hair.gamut();
    let solved = hair.solve(&[1.0, 0.2, 0.0]);
    assert!(!solved.in_gamut);
    assert_eq!((solved.sigma_a[0], solved.sigma_a[2]), (0.0, 100.0));
    assert!((solved.colour[1] - 0.2).abs() < 1e-4);
    assert!((solved.colour[0] - light).abs() < 1e-9 && (solved.colour[2] - dark).abs() < 1e-9);
    for poison in POISON {
        let solved = hair.solve(&[f64::from(poison); 3]);
        assert!(
            solved.sigma_a.iter().chain(&solved.colour).all(|x| x.is_finite()),
            "{poison}"
        );
        let fibre = Fibre {
            eta: f64::from(poison),
            ..HAIR
        };
        assert!(
            DeepHair::new(&fibre).map_or(true, |hair| hair.reflectance(0.5).is_finite()),
            "{poison}"
        );
    }
}
