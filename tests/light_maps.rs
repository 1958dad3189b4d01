//! Environment map readers: every variant that is read, every one that is refused, repairs, and damaged files.

use std::io::Cursor;
use std::ops::ControlFlow;
use std::path::Path;

use balayage_render::light::{EnvironmentMap, FitSettings, InputError, LightSet, MapReport, fit_lights};
use balayage_tests::{damage, repository, test_data};
use exr::prelude::*;
use glam::Vec3;

fn read(bytes: &[u8]) -> std::result::Result<(EnvironmentMap, MapReport), InputError> {
    EnvironmentMap::from_bytes(bytes, Path::new("test.map"))
}

/// RGBE bytes of the test picture: 16 x 2 pixels, runs and single values in both rows.
fn rgbe(x: usize, y: usize) -> [u8; 4] {
    let value = if x < 9 { 10 } else { 10 + x as u8 };
    [value, 2 * value, 100 + y as u8, 129 + u8::from(x == 15)]
}

const WIDTH: usize = 16;
const HEIGHT: usize = 2;

fn header(first_lines: &str, resolution: &str) -> Vec<u8> {
    format!("{first_lines}FORMAT=32-bit_rle_rgbe\n\n{resolution}\n").into_bytes()
}

fn plain() -> Vec<u8> {
    (0..HEIGHT)
        .flat_map(|y| (0..WIDTH).flat_map(move |x| rgbe(x, y)))
        .collect()
}

/// Every row as its first pixel, a marker for the eight that follow it, and the rest as they are.
fn old_runs() -> Vec<u8> {
    let row = |y: usize| {
        let rest = (9..WIDTH).flat_map(move |x| rgbe(x, y));
        rgbe(0, y)
            .into_iter()
            .chain([1, 1, 1, 8])
            .chain(rest)
            .collect::<Vec<u8>>()
    };
    (0..HEIGHT).flat_map(row).collect()
}

/// Every component as a run of nine and seven literals.
fn new_runs() -> Vec<u8> {
    let row = |y: usize| {
        let mut bytes = vec![2, 2, 0, WIDTH as u8];
        for component in 0..4 {
            bytes.extend([128 + 9, rgbe(0, y)[component], 7]);
            bytes.extend((9..WIDTH).map(|x| rgbe(x, y)[component]));
        }
        bytes
    };
    (0..HEIGHT).flat_map(row).collect()
}

fn expected(x: usize, y: usize) -> Vec3 {
    let [r, g, b, e] = rgbe(x, y).map(f32::from);
    Vec3::new(r, g, b) / 256.0 * (e - 128.0).exp2()
}

#[test]
fn radiance_variants_read_alike() {
    let standard = "-Y 2 +X 16";
    let comments = "#?RADIANCE\n# made by hand\nSOFTWARE=none\n";
    let heads = [
        "#?RADIANCE\n",
        "#?RGBE\n",
        "#?RADIANCE\n#?RADIANCE\n",
        comments,
        "#?RGBE\r\n",
    ];
    for head in heads {
        for pixels in [plain(), old_runs(), new_runs()] {
            let (map, report) = read(&[header(head, standard), pixels].concat()).unwrap();
            for (index, pixel) in map.pixels.iter().enumerate() {
                assert_eq!(
                    *pixel,
                    expected(index % WIDTH, index / WIDTH),
                    "{head:?} pixel {index}"
                );
            }
            assert_eq!(
                (map.width, map.height, report.negative_pixels),
                (WIDTH, HEIGHT, 0)
            );
            assert!(
                report.warnings[0].contains("twice as wide"),
                "{:?}",
                report.warnings
            );
        }
    }

    // Flipped axes put the same bytes elsewhere.
    let (map, _) = read(&[header(heads[0], "+Y 2 -X 16"), new_runs()].concat()).unwrap();
    assert_eq!(map.pixels[0], expected(WIDTH - 1, HEIGHT - 1));
}

#[test]
fn radiance_refusals_say_why() {
    let magic = "#?RADIANCE\n";
    let file = |resolution: &str, pixels: &[u8]| [header(magic, resolution), pixels.to_vec()].concat();
    let new = new_runs();
    let long_run: Vec<u8> = [&[2, 2, 0, 16, 128 + 17, 0][..], &new].concat();
    let cases: [(&str, Vec<u8>, &str); 13] = [
        ("nothing", vec![], "neither Radiance"),
        ("text", b"hello".to_vec(), "neither Radiance"),
        ("no end of header", magic.as_bytes().to_vec(), "does not end"),
        (
            "other colours",
            b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n".to_vec(),
            "xyze",
        ),
        ("columns first", file("+X 16 -Y 2", &new), "along rows"),
        ("no numbers", file("-Y two +X 16", &new), "no number"),
        ("empty", file("-Y 0 +X 16", &new), "empty"),
        ("huge", file("-Y 4000000000 +X 4000000000", &new), "more than"),
        ("too large", file("-Y 8192 +X 8192", &new), "more than"),
        ("too many rows", file("-Y 4096 +X 16", &new), "scanlines"),
        ("cut off", file("-Y 2 +X 16", &new[..new.len() - 1]), "file ends"),
        (
            "run over the edge",
            file("-Y 2 +X 16", &long_run),
            "stretch of 17",
        ),
        (
            "run of nothing",
            file("-Y 2 +X 16", &[1, 1, 1, 9, 0, 0, 0, 0]),
            "run of 9",
        ),
    ];
    for (name, bytes, reason) in cases {
        let error = read(&bytes).expect_err(name);
        assert!(error.to_string().contains(reason), "{name}: {error}");
        assert!(
            error.to_string().starts_with("test.map: ") && !error.remedy.is_empty(),
            "{name}: {error}"
        );
    }

    // Empty runs one after the other shift the next count out of every integer.
    let empty_runs = [&[5, 5, 5, 128][..], &[1, 1, 1, 0].repeat(40)].concat();
    assert!(
        read(&file("-Y 2 +X 16", &empty_runs))
            .unwrap_err()
            .reason
            .contains("run of 0")
    );
}

/// An EXR of one layer whose pixels are a function of the place.
fn exr_bytes(
    width: usize,
    height: usize,
    compression: Compression,
    pixel: impl Sync + Fn(usize, usize) -> Vec3,
) -> Vec<u8> {
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| pixel(at.x(), at.y()).into());
    let encoding = Encoding {
        compression,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new((width, height), LayerAttributes::named("rgb"), encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .expect("written to memory");
    bytes.into_inner()
}

/// An EXR of several parts with the given channels, 4 x 2 pixels; channel c of part p holds 10 p + c.
fn exr_parts(parts: &[&[(&str, bool)]]) -> Vec<u8> {
    let layer = |(p, names): (usize, &&[(&str, bool)])| {
        let channels = names.iter().enumerate().map(|(c, (name, is_half))| {
            let value = (10 * p + c) as f32;
            let samples = if *is_half {
                FlatSamples::F16(vec![f16::from_f32(value); 8])
            } else {
                FlatSamples::F32(vec![value; 8])
            };
            AnyChannel::new(*name, samples)
        });
        let attributes = LayerAttributes::named(format!("part {p}").as_str());
        Layer::new(
            (4, 2),
            attributes,
            Encoding::FAST_LOSSLESS,
            AnyChannels::sort(channels.collect()),
        )
    };
    let layers: Layers<AnyChannels<FlatSamples>> = parts.iter().enumerate().map(layer).collect();
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((4, 2)));
    let mut bytes = Cursor::new(Vec::new());
    let image = Image {
        attributes,
        layer_data: layers,
    };
    image.write().to_buffered(&mut bytes).expect("written to memory");
    bytes.into_inner()
}

#[test]
fn exr_variants_read() {
    let value = |x: usize, y: usize| Vec3::new(x as f32, y as f32, 0.5);
    for compression in [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
    ] {
        let (map, report) = read(&exr_bytes(34, 17, compression, value)).unwrap();
        for (index, pixel) in map.pixels.iter().enumerate() {
            assert_eq!(*pixel, value(index % 34, index / 34), "{compression}");
        }
        assert_eq!(report.warnings, Vec::<String>::new());
    }

    // The first part with colours is read, half and float mixed; channels are sorted by name in the file.
    let parts: [&[(&str, bool)]; 2] = [
        &[("Z", false)],
        &[("A", true), ("B", true), ("G", false), ("R", true)],
    ];
    let (map, report) = read(&exr_parts(&parts)).unwrap();
    assert_eq!(map.pixels[5], Vec3::new(13.0, 12.0, 11.0));
    assert!(
        report.warnings[0].contains("part 1 of 2"),
        "{:?}",
        report.warnings
    );
    let (map, _) = read(&exr_parts(&[&[("Y", true)]])).unwrap();
    assert_eq!(map.pixels[0], Vec3::ZERO);
    let (map, report) = read(&exr_parts(&[&[("a.B", true), ("a.G", true), ("a.R", true)]])).unwrap();
    assert_eq!(map.pixels[0], Vec3::new(2.0, 1.0, 0.0));
    assert!(report.warnings[0].contains("a.R"), "{:?}", report.warnings);
}

#[test]
fn files_of_one_pixel_and_of_one_bright_pixel_read_and_fit() {
    let fitted = |map: &EnvironmentMap, count| {
        let settings = FitSettings {
            count,
            ..FitSettings::default()
        };
        fit_lights(map, &settings, &|_| ControlFlow::Continue(())).unwrap()
    };
    let one_pixel = [header("#?RADIANCE\n", "-Y 1 +X 1"), vec![128, 64, 32, 129]].concat();
    let (map, report) = read(&one_pixel).unwrap();
    assert_eq!(
        (map.width, map.height, map.pixels[0]),
        (1, 1, Vec3::new(1.0, 0.5, 0.25))
    );
    assert!(
        report.warnings[0].contains("twice as wide"),
        "{:?}",
        report.warnings
    );
    assert_eq!(fitted(&map, 4), LightSet::uniform(map.pixels[0]));

    // A sun of one pixel: its place and energy come through the file and the fit.
    let sun = |x: usize, y: usize| Vec3::splat(if (x, y) == (20, 30) { 1e6 } else { 0.1 });
    let (map, report) = read(&exr_bytes(256, 128, Compression::ZIP16, sun)).unwrap();
    assert_eq!((map.pixels[30 * 256 + 20].x, report.warnings.len()), (1e6, 0));
    let lights = fitted(&map, 4);
    let brightest = &lights.lights[0];
    let towards = map.direction(20, 30).as_vec3();
    assert!(brightest.direction.angle_between(towards) < 0.01, "{brightest:?}");
    assert!((lights.energy() / map.energy() - 1.0).abs().max_element() < 0.01);
}

#[test]
fn exr_refusals_say_why() {
    let chroma: &[(&str, bool)] = &[("BY", true), ("RY", true), ("Y", true)];
    assert!(read(&exr_parts(&[chroma])).unwrap_err().reason.contains("chroma"));
    assert!(
        read(&exr_parts(&[&[("Z", false)]]))
            .unwrap_err()
            .reason
            .contains("no R, G, B or Y among Z")
    );

    let mut deep = exr_bytes(4, 2, Compression::ZIP1, |_, _| Vec3::ONE);
    deep[5] |= 0b1000;
    let error = read(&deep).unwrap_err();
    assert!(
        error.reason.contains("deep data") && error.remedy.contains("flatten"),
        "{error}"
    );

    // A data window that lies is refused before its pixels are allocated.
    let mut huge = exr_bytes(4, 2, Compression::ZIP1, |_, _| Vec3::ONE);
    let name = b"dataWindow\0box2i\0";
    let at = huge
        .windows(name.len())
        .position(|window| window == name)
        .unwrap()
        + name.len()
        + 4;
    huge[at + 8..at + 12].copy_from_slice(&30_000_000_i32.to_le_bytes());
    assert!(read(&huge).is_err());
}

#[test]
fn what_is_no_radiance_is_counted_and_repaired() {
    let pixel = |x: usize, y: usize| match (x, y) {
        (0, 0) => Vec3::new(f32::NAN, 1.0, -2.0),
        (1, 0) => Vec3::new(f32::INFINITY, 0.0, 0.0),
        (2, 0) => Vec3::new(f32::NEG_INFINITY, 1e31, 0.0),
        (3, 0) => Vec3::splat(-0.5),
        _ => Vec3::splat(7.0),
    };
    let (map, report) = read(&exr_bytes(4, 2, Compression::Uncompressed, pixel)).unwrap();
    assert_eq!(
        (report.nan_pixels, report.infinite_pixels, report.negative_pixels),
        (1, 2, 2)
    );
    assert_eq!(report.lowest, -2.0);
    assert_eq!(
        map.pixels[..4],
        [
            Vec3::Y,
            Vec3::new(7.0, 0.0, 0.0),
            Vec3::new(0.0, 7.0, 0.0),
            Vec3::ZERO
        ]
    );

    let (_, report) = read(&exr_bytes(4, 2, Compression::Uncompressed, |_, _| Vec3::ZERO)).unwrap();
    assert!(report.warnings[0].contains("all black"));
}

/// What a map that was read must be, whatever the file.
fn assert_sound(map: &EnvironmentMap) {
    assert_eq!(map.pixels.len(), map.width * map.height);
    assert!(
        map.pixels
            .iter()
            .all(|pixel| pixel.is_finite() && pixel.min_element() >= 0.0)
    );
}

#[test]
fn damaged_maps_are_refused_or_sound() {
    let radiance = [header("#?RADIANCE\n", "-Y 2 +X 16"), new_runs()].concat();
    let old = [header("#?RADIANCE\n", "-Y 2 +X 16"), old_runs()].concat();
    let pixel = |x: usize, y: usize| Vec3::new(x as f32, y as f32, 1.0);
    let exr = |compression| exr_bytes(16, 8, compression, pixel);
    let files = [
        (radiance, 56),
        (old, 56),
        (exr(Compression::ZIP16), 320),
        (exr(Compression::PIZ), 320),
        (exr(Compression::RLE), 320),
    ];
    for (seed, (file, header)) in files.iter().enumerate() {
        assert_sound(&read(file).unwrap().0);
        let (mut refused, mut sound) = (0, 0);
        damage(file, *header, seed as u64, |bytes| match read(bytes) {
            Ok((map, _)) => {
                assert_sound(&map);
                sound += 1;
            }
            Err(error) => {
                assert!(!error.reason.is_empty() && !error.remedy.is_empty());
                refused += 1;
            }
        });
        assert!(refused > 100, "{refused} refused, {sound} read");
    }
}

#[test]
fn sample_environments_read_clean() {
    for name in ["city", "studio", "sunrise"] {
        let (map, report) =
            EnvironmentMap::read(&repository(&format!("projects/environments/{name}.hdr"))).unwrap();
        assert_eq!((map.width, map.height), (512, 256));
        assert_eq!(report.warnings, Vec::<String>::new());
    }
}

#[test]
fn dwa_compressed_maps_read_and_negatives_are_counted() {
    let Some(path) = test_data("public/pmndrs_esplanade_negative_dwab.exr") else {
        return;
    };
    let (map, report) = EnvironmentMap::read(&path).unwrap();
    assert_sound(&map);
    assert!(
        report.negative_pixels > 0 && report.lowest < -3000.0,
        "{report:?}"
    );

    // The half-size copy of the city has the same energy as the compressed original.
    let energy = |name: &str| {
        EnvironmentMap::read(&test_data(name).unwrap())
            .unwrap()
            .0
            .energy()
    };
    let ratio =
        energy("public/blender_city_1024x512_dwab.exr") / energy("public/blender_city_256x128_zip_half.exr");
    assert!((ratio - 1.0).abs().max_element() < 0.02, "{ratio}");
}
