"""Renders a project in Mitsuba 3 (pip install mitsuba numpy) beside Balayage: the time that either needs for one and the same error.

Usage: peers.py BALAYAGE PROJECT.json DIR [--size N] [--paths N] [--variant llvm_ad_rgb|scalar_rgb]

Both draw the same strands (the same natural cubic spline), camera and map; without head and paint, which Mitsuba's hair has not. The
fibres differ: Marschner 2003 in Balayage, Chiang 2016 in Mitsuba, of equal absorption, index, tilt and widths. So each is held
against its own long render, and the error is relative: root of the squared differences' sum over the reference's squared sum,

- of the means of 16 x 16 pixels, as `balayage bench picture` has it, whose reference is Balayage's path tracer: what the approximation
  leaves counts against Balayage there;
- of single pixels, against Balayage with many exact shadow rays and samples a pixel: what is left of noise and refinement.

Mitsuba's error falls as one over the root of its samples: powers of two are timed, the time between two of them is interpolated.
"""
import argparse
import json
import shutil
import subprocess
import sys
import time
from pathlib import Path

import mitsuba as mi
import numpy as np

TILE = 16
# Samples a pixel of Mitsuba's long render; the timed ones are independent of it (other seeds).
LONG_SAMPLES = 512
TIMED_SAMPLES = [2**k for k in range(8)]
# Shadow rays per point and light, and samples a pixel, of Balayage's long render.
LONG_RAYS, LONG_BALAYAGE_SAMPLES = 128, 32
# Fibres on a path, as in Balayage's path tracer.
MAX_DEPTH = 100


def run(balayage, *args):
    """What a subcommand of Balayage answers."""
    command = [balayage, *map(str, args), "--json"]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"peers: {' '.join(command)} ended with {done.returncode}")
    return json.loads(done.stdout)


def bare_project(source, folder):
    """The project without head and paint, its files beside it; its contents and path."""
    project = json.loads(source.read_text())
    light = project["light"]
    if "map" not in light["environment"] or "camera" not in project:
        sys.exit(f"peers: {source}: a project with a map and a camera is needed; save one from the editor")
    project["head"], project["operations"], light["hand"] = None, [], []
    for holder, key in [(project["groom"], "path"), (light["environment"], "map")]:
        copy = folder / Path(holder[key]).name
        shutil.copyfile(source.parent / holder[key], copy)
        holder[key] = copy.name
    path = folder / "bare.json"
    path.write_text(json.dumps(project))
    return project, path


def write_curves(groom, path):
    """A .hair file as Mitsuba's control points: those of the uniform cubic B-spline that is the natural spline through the points."""
    data = groom.read_bytes()
    strands, points, has, segments = np.frombuffer(data, "<u4", 4, 4)
    thickness = float(np.frombuffer(data, "<f4", 1, 20)[0])
    offset = 128

    def array(bit, dtype, count, default):
        nonlocal offset
        if not has & bit:
            return np.full(count, default)
        values = np.frombuffer(data, dtype, count, offset)
        offset += values.nbytes
        return values.astype(float)

    counts = array(1, "<u2", strands, segments).astype(int) + 1
    positions = array(2, "<f4", 3 * points, 0.0).reshape(-1, 3)
    radii = 0.5 * array(4, "<f4", points, thickness)
    ends = np.cumsum(counts)
    with path.open("w") as out:
        for count in np.unique(counts):
            # Each point is (1, 4, 1) / 6 of three control points; the second derivative vanishes at both ends.
            system = np.zeros((count + 2, count + 2))
            for i in range(count):
                system[i + 1, i : i + 3] = np.array([1, 4, 1]) / 6
            system[0, :3] = system[-1, -3:] = 1, -2, 1
            inverse = np.linalg.inv(system)[:, 1:-1]
            for end in ends[counts == count]:
                at = slice(end - count, end)
                radius = np.pad(radii[at], 1, mode="edge")[:, None]
                np.savetxt(out, np.hstack([inverse @ positions[at], radius]), fmt="%.9g")
                out.write("\n")


def mitsuba_scene(project, materials, folder, size):
    """The project as Mitsuba reads it."""
    light = project["light"]
    path = folder / light["environment"]["map"]
    linear = mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
    scale = 2.0 ** light["exposure_ev"] * np.array(light["tint"])
    mi.Bitmap((np.array(linear) * scale).astype(np.float32)).write(str(folder / "environment.exr"))
    write_curves(folder / "drawn.hair", folder / "curves.txt")
    chiang = materials["base"]["renderers"]["blender_principled_hair"]["inputs"]
    turn = mi.ScalarTransform4f()
    pose = project["camera"]
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": MAX_DEPTH, "hide_emitters": True},
        "light": {
            "type": "envmap",
            "filename": str(folder / "environment.exr"),
            "to_world": turn.rotate([0, 1, 0], light["rotation_deg"]),
        },
        "hair": {
            "type": "bsplinecurve",
            "filename": str(folder / "curves.txt"),
            "bsdf": {
                "type": "hair",
                "sigma_a": {"type": "rgb", "value": chiang["Absorption Coefficient"]},
                "longitudinal_roughness": chiang["Roughness"],
                "azimuthal_roughness": chiang["Radial Roughness"],
                "scale_tilt": float(np.degrees(chiang["Offset"])),
                "int_ior": chiang["IOR"],
            },
        },
        # Mitsuba's camera looks along +z of its frame, x to the left.
        "camera": {
            "type": "perspective",
            "fov": pose["fov_y_deg"],
            "fov_axis": "y",
            "to_world": mi.ScalarTransform4f(np.array(pose["world_from_camera"])) @ turn.scale([-1, 1, -1]),
            "film": {
                "type": "hdrfilm",
                "width": size,
                "height": size,
                "pixel_format": "rgb",
                "rfilter": {"type": "box"},
            },
        },
    }


def tiles(picture):
    """The means of whole tiles."""
    rows, columns = (side // TILE for side in picture.shape[:2])
    cut = picture[: rows * TILE, : columns * TILE]
    return cut.reshape(rows, TILE, columns, TILE, 3).mean((1, 3))


def relative(picture, reference):
    return float(np.sqrt(((picture - reference) ** 2).sum() / (reference**2).sum()))


def reached(curve, error):
    """Seconds at which a curve of (seconds, error) falls to `error`, on straight lines between the logarithms."""
    seconds, errors = np.log(np.array(curve)).T
    if np.log(error) > errors[0]:
        return f"< {curve[0][0]:.2f}"
    if np.log(error) < errors[-1]:
        # Beyond the last one the law of the noise goes on.
        return f"{curve[-1][0] * (curve[-1][1] / error) ** 2:.0f} (extrapolated)"
    return f"{np.exp(np.interp(np.log(error), errors[::-1], seconds[::-1])):.2f}"


def read(path):
    return np.array(mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("balayage")
    parser.add_argument("project", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--size", type=int, default=256, help="pixels a side")
    parser.add_argument("--paths", type=int, default=64, help="paths a pixel of Balayage's path tracer")
    parser.add_argument("--variant", default="llvm_ad_rgb")
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    mi.set_variant(args.variant)
    folder, size = args.folder, f"{args.size}x{args.size}"

    project, bare = bare_project(args.project, folder)
    run(args.balayage, "convert", bare, folder / "drawn.hair")
    run(args.balayage, "convert", bare, folder / "bare.materials.json")
    materials = json.loads((folder / "bare.materials.json").read_text())
    scene = mi.load_dict(mitsuba_scene(project, materials, folder, args.size))

    # Twice the same picture: the second one has the hair's shadows from the first, as any later view has.
    common = ["render", bare, "--size", size]
    pictures = run(args.balayage, *common, "-o", folder / "balayage-####.exr", "--frames", "1-2", "--turntable", 1)
    first, later = (sum(frame["passes_ms"].values()) / 1000 for frame in pictures["frames"])
    drawn = read(pictures["frames"][0]["picture"])

    # Mitsuba: the first picture compiles, and is not timed.
    render = lambda samples, seed: np.array(mi.render(scene, spp=samples, seed=seed))
    render(1, 0)
    timed = []
    for samples in TIMED_SAMPLES:
        start = time.perf_counter()
        picture = render(samples, samples)
        timed.append((samples, time.perf_counter() - start, picture))
    # In parts, so that no buffer holds all samples at once.
    parts = 16
    mitsuba_long = sum(render(LONG_SAMPLES // parts, 10_000 + part) for part in range(parts)) / parts

    traced = run(args.balayage, "bench", "picture", bare, "-o", folder / "traced", "--size", size, "--paths", args.paths)
    row = next(r for r in traced["tables"]["picture"] if r["light"] == "all" and r["shadows"] == "first frame")
    long_options = ["--visibility-rays", LONG_RAYS, "--samples", LONG_BALAYAGE_SAMPLES]
    run(args.balayage, *common, "-o", folder / "balayage-long.exr", *long_options)
    balayage_long = read(folder / "balayage-long.exr")
    traced_all = read(folder / "traced" / "all.exr")
    mi.util.write_bitmap(str(folder / "mitsuba-long.png"), mitsuba_long)

    by_tile = [(seconds, relative(tiles(p), tiles(mitsuba_long))) for _, seconds, p in timed]
    by_pixel = [(seconds, relative(p, mitsuba_long)) for _, seconds, p in timed]
    tile_error, pixel_error = relative(tiles(drawn), tiles(traced_all)), relative(drawn, balayage_long)
    device = next(note for note in traced["notes"] if note.startswith("device"))
    ratio = " ".join(f"{x:.2f}" for x in traced_all.mean((0, 1)) / mitsuba_long.mean((0, 1)))
    lines = [
        "# Balayage beside Mitsuba",
        "",
        f"{args.project.name} without head and paint, {size}; Mitsuba {mi.__version__} {args.variant}; Balayage on {device}.",
        f"The two path tracers' means (Balayage's over Mitsuba's, red green blue; another model of the fibre): {ratio}.",
        f"Noise of Balayage's traced reference, {args.paths} paths a pixel: {row['noise of the reference']:.3f} of tiles.",
        "",
        "| error | reference of Balayage | Balayage's error | first picture, s | later view, s | Mitsuba to the same error, s |",
        "| --- | --- | --: | --: | --: | --: |",
        f"| tiles of 16 pixels | its path tracer | {tile_error:.3f} | {first:.2f} | {later:.2f} | {reached(by_tile, tile_error)} |",
        f"| pixels | itself, {LONG_RAYS} rays, {LONG_BALAYAGE_SAMPLES} samples | {pixel_error:.3f} | {first:.2f} | {later:.2f} | {reached(by_pixel, pixel_error)} |",
        "",
        f"Mitsuba's errors against its own {LONG_SAMPLES} samples:",
        "",
        "| samples | seconds | tiles | pixels |",
        "| --: | --: | --: | --: |",
    ]
    for (samples, seconds, _), (_, tile), (_, pixel) in zip(timed, by_tile, by_pixel):
        lines.append(f"| {samples} | {seconds:.2f} | {tile:.4f} | {pixel:.4f} |")
    text = "\n".join(lines) + "\n"
    (folder / "peers.md").write_text(text)
    print(text)


main()
