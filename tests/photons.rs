//! Light traced from fibre to fibre: the same whoever traces it, read off as single scattering of what comes from all sides, blocked by heads.

use balayage_render::gpu::{CELL_VOXELS, Gpu, PHOTON_RAYS, RenderSettings, Renderer, ShadeSettings, Terms};
use balayage_render::groom::{DEFAULT_MAX_TURN_RAD, RefinedGroom};
use balayage_render::light::SrbfLight;
use balayage_render::optics::{self, Direction, Fibre, single_scattering};
use balayage_render::param::VertexParams;
use balayage_render::photon::{DIRECTIONS, Hair, LightField, Packed, Rules, Traced, part_directions};
use balayage_render::volume::{DensityVolume, Occluder, SolidVoxels, Strands, VolumeSettings};
use glam::{IVec3, Vec3};

use super::frame::{curtain, plain, renderer};

const ALL: Rules = Rules {
    is_deon: false,
    onward: true,
    turned: true,
};

/// The lights of `frame::renderer`.
fn lights() -> Vec<SrbfLight> {
    [(Vec3::new(0.3, 1.0, 1.0), 0.5), (Vec3::new(-1.0, 0.2, 0.4), 0.3)]
        .map(|(direction, bandwidth)| SrbfLight {
            direction: direction.normalize(),
            bandwidth,
            radiance: Vec3::ONE,
        })
        .to_vec()
}

fn hair(params: &[VertexParams], solid: Option<SolidVoxels>) -> Hair {
    let mut hair = Hair::new(RefinedGroom::new(&curtain(), DEFAULT_MAX_TURN_RAD), solid);
    hair.set_params(params, &[]);
    hair
}

/// A field of so many rays, and its photons.
fn traced(hair: &Hair, lights: &[SrbfLight], rules: Rules, rays: &[u64]) -> (LightField, f64) {
    traced_in(0.4, hair, lights, rules, rays)
}

fn traced_in(cell: f32, hair: &Hair, lights: &[SrbfLight], rules: Rules, rays: &[u64]) -> (LightField, f64) {
    let mut field = hair.field(cell);
    let mut done = Traced::default();
    for &rays in rays {
        hair.trace(lights, rules, rays, &mut done, &mut field, &|| false)
            .unwrap();
    }
    (field, done.photons as f64)
}

fn mean((field, photons): &(LightField, f64)) -> Vec3 {
    field.mean(*photons)
}

#[test]
fn a_field_is_the_same_with_any_number_of_threads_in_one_go_or_several() {
    let hair = hair(&plain(&curtain()), None);
    let whole = traced(&hair, &lights(), ALL, &[60_000]);
    let entries = |(field, photons): &(LightField, f64)| field.packed(*photons).radiance;
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let by_one = alone.install(|| traced(&hair, &lights(), ALL, &[60_000]));
    let in_parts = traced(&hair, &lights(), ALL, &[5_000, 30_000, 60_000]);
    assert!(entries(&whole) == entries(&by_one) && entries(&whole) == entries(&in_parts));
    assert!(
        entries(&whole) != entries(&traced(&hair, &lights(), ALL, &[90_000])),
        "the comparison can fail"
    );

    // Given up at the third question, and gone on with later.
    let mut field = hair.field(0.4);
    let mut done = Traced::default();
    let asked = std::cell::Cell::new(0);
    let stop = || {
        asked.set(asked.get() + 1);
        asked.get() == 3
    };
    assert!(
        hair.trace(&lights(), ALL, 60_000, &mut done, &mut field, &stop)
            .is_err()
    );
    assert!(done.rays > 0 && done.rays < 60_000);
    hair.trace(&lights(), ALL, 60_000, &mut done, &mut field, &stop)
        .unwrap();
    assert!(entries(&whole) == entries(&(field, done.photons as f64)));
}

#[test]
fn light_that_went_on_and_light_that_turned_are_all_light() {
    let hair = hair(&plain(&curtain()), None);
    let rays = 400_000;
    let of = |onward, turned| {
        mean(&traced(
            &hair,
            &lights(),
            Rules {
                onward,
                turned,
                ..ALL
            },
            &[rays],
        ))
    };
    let (all, onward, turned) = (of(true, true), of(true, false), of(false, true));
    assert!(
        onward.min_element() > 0.1 * all.max_element() && turned.min_element() > 0.0,
        "{onward} {turned}"
    );
    // Photons that are given up once they turn leave rays for others: the sums are not of the same photons.
    let off = ((onward + turned) / all - 1.0).abs().max_element();
    assert!(off < 0.02, "{onward} and {turned} of {all}");
    assert_eq!(of(false, false), Vec3::ZERO);
}

#[test]
fn darker_hair_passes_less_on_and_no_light_makes_none() {
    let params = |sigma: f32| {
        let mut params = plain(&curtain());
        params.iter_mut().for_each(|p| p.sigma_a = [sigma; 3]);
        params
    };
    let mut last = f32::INFINITY;
    for sigma in [0.0, 0.01, 0.1, 1.0, 10.0] {
        let got = mean(&traced(&hair(&params(sigma), None), &lights(), ALL, &[200_000])).x;
        assert!(got < last && got > 0.0, "{got} at {sigma} after {last}");
        last = got;
    }
    let hair = hair(&params(0.1), None);
    for dark in [
        vec![],
        vec![SrbfLight {
            radiance: Vec3::ZERO,
            ..lights()[0]
        }],
    ] {
        assert_eq!(mean(&traced(&hair, &dark, ALL, &[1000])), Vec3::ZERO);
    }
}

#[test]
fn poisoned_parameters_are_guarded_as_the_shaders_guard_them() {
    let mut params = plain(&curtain());
    for (k, point) in params.iter_mut().enumerate() {
        let poison = balayage_tests::POISON[k % balayage_tests::POISON.len()];
        match k % 5 {
            0 => point.sigma_a = [poison; 3],
            1 => point.alpha_rad = poison,
            2 => point.beta_rad = poison,
            3 => point.eta = poison,
            _ => point.azimuthal_width = poison,
        }
    }
    for is_deon in [false, true] {
        let got = mean(&traced(
            &hair(&params, None),
            &lights(),
            Rules { is_deon, ..ALL },
            &[100_000],
        ));
        assert!(got.is_finite() && got.min_element() > 0.0, "{got}");
    }
}

#[test]
fn a_head_stops_photons() {
    let groom = curtain();
    // A slab below the whole curtain.
    let corner = |k: usize| {
        Vec3::new(
            if k & 1 == 0 { -3.0 } else { 4.0 },
            if k & 2 == 0 { -4.5 } else { -2.8 },
            if k & 4 == 0 { -5.0 } else { 3.0 },
        )
    };
    let positions: Vec<Vec3> = (0..8).map(corner).collect();
    let triangles = [
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    let slab = Occluder {
        positions: &positions,
        triangles: &triangles,
    };
    let volume = DensityVolume::build(&Strands::from(&groom), Some(&slab), &VolumeSettings::default());
    let solid = || SolidVoxels::of(&volume);
    assert!(solid().is_some());
    let from = |y: f32| {
        vec![SrbfLight {
            direction: Vec3::new(0.0, y, 0.0),
            bandwidth: 0.1,
            radiance: Vec3::ONE,
        }]
    };
    let params = plain(&groom);
    let got = |solid, y| mean(&traced(&hair(&params, solid), &from(y), ALL, &[50_000])).x;
    let (above, below) = (got(solid(), 1.0), got(solid(), -1.0));
    let without = got(None, -1.0);
    assert!(
        above > 0.0 && below == 0.0 && without > 0.0,
        "above {above}, below {below}, without {without}"
    );
}

/// What a fibre makes of the field at `place`: every part as an SRBF light of its width, integrated in float64.
fn read_off(
    field: &LightField,
    photons: f64,
    place: Vec3,
    frame: [Vec3; 3],
    eye: Vec3,
    fibre: &Fibre,
) -> f64 {
    const WIDTH: f64 = 0.0904; // sqrt(2) times the standard deviation of the directions of a quarter of a part
    let Packed {
        grid,
        numbers,
        fibres,
        radiance,
    } = field.packed(photons);
    let cells = |asked: Vec3| {
        let (low, inside) = ((asked - 0.5).floor(), (asked - 0.5) - (asked - 0.5).floor());
        let mut around = Vec::new();
        for corner in 0..8 {
            let upper = Vec3::new(
                (corner & 1) as f32,
                (corner >> 1 & 1) as f32,
                (corner >> 2) as f32,
            );
            let cell = (low + upper).as_ivec3();
            if cell.cmplt(IVec3::ZERO).any() || cell.cmpge(grid.cells).any() {
                continue;
            }
            let number =
                numbers[(cell.x + grid.cells.x * (cell.y + grid.cells.y * cell.z)) as usize] as usize;
            if let Some([x, y, z, area]) = fibres.get(number) {
                let share = upper * inside + (1.0 - upper) * (1.0 - inside);
                around.push((number, share.element_product() * area, Vec3::new(*x, *y, *z)));
            }
        }
        around
    };
    let mean_place = |around: &[(usize, f32, Vec3)]| {
        let area: f32 = around.iter().map(|c| c.1).sum();
        around.iter().map(|c| c.1 * c.2).sum::<Vec3>() / area
    };
    let at = (place - grid.low) / grid.cell;
    let mut around = cells(at);
    let beyond = cells(at + (at - mean_place(&around)).clamp_length_max(0.5));
    if !beyond.is_empty() {
        around = beyond;
    }
    let area: f32 = around.iter().map(|c| c.1).sum();
    let angles = |w: Vec3| {
        let [u, v, n] = frame.map(|axis| f64::from(axis.dot(w)));
        Direction {
            theta: u.clamp(-1.0, 1.0).asin(),
            phi: n.atan2(v),
        }
    };
    (0..DIRECTIONS)
        .map(|part| {
            let light: f32 = around
                .iter()
                .map(|(number, weight, _)| {
                    weight
                        * half::f16::from_bits(
                            radiance[number * DIRECTIONS as usize + part as usize][0] as u16,
                        )
                        .to_f32()
                })
                .sum();
            let scattered = part_directions(part).map(|direction| {
                let lobe = optics::SrbfLight::new(angles(direction), WIDTH).unwrap();
                single_scattering(fibre, angles(eye), &lobe, 1e-3).unwrap().sum()[0]
            });
            let solid_angle = std::f64::consts::PI * WIDTH * WIDTH;
            f64::from(light * grid.scale / area) * 0.25 * scattered.iter().sum::<f64>() / solid_angle
        })
        .sum()
}

#[test]
fn points_scatter_the_field_as_the_reference_does() {
    let groom = curtain();
    let params = plain(&groom);
    let gpu = Gpu::headless().unwrap();
    let mut renderer: Renderer = renderer(&gpu, &groom);
    renderer.set_params(&params, &[]).unwrap();
    let settings = RenderSettings {
        shade: ShadeSettings {
            terms: Terms::MULTIPLE,
            ..ShadeSettings::default()
        },
        ..RenderSettings::default()
    };
    let points: Vec<u32> = (0..6).map(|k| 9 * (17 * k % 400) + 1 + k % 7).collect();
    let eye = Vec3::new(0.4, -1.0, 4.0);
    let got = renderer.radiance_of_points(&points, eye, &settings).unwrap();

    // The same photons, read off on the CPU.
    let voxel = DensityVolume::build(&Strands::from(&groom), None, &VolumeSettings::default())
        .grid
        .voxel_size;
    let hair = hair(&params, None);
    let mut field = hair.field(CELL_VOXELS * voxel);
    let mut done = Traced::default();
    hair.trace(&lights(), ALL, PHOTON_RAYS, &mut done, &mut field, &|| false)
        .unwrap();
    let refined = RefinedGroom::new(&groom, DEFAULT_MAX_TURN_RAD);
    let error = |field: &LightField, photons: f64| {
        let (mut difference, mut sum) = (0.0, 0.0);
        for (&point, got) in points.iter().zip(&got) {
            let vertex = refined
                .source_point()
                .iter()
                .position(|&source| source == point)
                .unwrap();
            let (u, v) = (refined.tangents()[vertex], refined.normals()[vertex]);
            let place = refined.positions()[vertex];
            let fibre = params[point as usize].fibre_towards(&params[point as usize], 0.0);
            let towards_eye = (eye - place).normalize();
            let want = read_off(field, photons, place, [u, v, u.cross(v)], towards_eye, &fibre);
            assert!(want > 0.0);
            difference += (f64::from(got.x) - want).abs();
            sum += want;
        }
        difference / sum
    };
    let off = error(&field, done.photons as f64);
    eprintln!("mean difference {:.2} %", 100.0 * off);
    assert!(off < 0.03, "{off}");
    // The negative control: a tenth of the photons.
    let (other, photons) = traced_in(CELL_VOXELS * voxel, &hair, &lights(), ALL, &[PHOTON_RAYS / 10]);
    assert!(error(&other, photons) > 0.03);
}
