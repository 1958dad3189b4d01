"""Makes curves.abc with Blender (pip install bpy): two curve objects under transforms, one of them hair-like."""
import sys

import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)


def curve(name, kind, splines, location, rotation_z_deg):
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions = "3D"
    for points in splines:
        spline = data.splines.new(kind)
        if kind == "BEZIER":
            spline.bezier_points.add(len(points) - 1)
            for bezier, point in zip(spline.bezier_points, points):
                bezier.co = point
                bezier.handle_left_type = bezier.handle_right_type = "AUTO"
        else:
            spline.points.add(len(points) - 1)
            for target, point in zip(spline.points, points):
                target.co = (*point, 1)
    thing = bpy.data.objects.new(name, data)
    thing.location = location
    thing.rotation_euler = (0, 0, rotation_z_deg * 3.14159265 / 180)
    bpy.context.scene.collection.objects.link(thing)


curve("poly", "POLY", [[(0, 0, 0), (0, 0, 1), (1, 0, 2)], [(0, 1, 0), (0, 1, 3)]], (1, 2, 3), 90)
curve("bezier", "BEZIER", [[(0, 0, 0), (0, 0, 1), (0, 0, 2)]], (5, 0, 0), 0)
bpy.ops.wm.alembic_export(filepath=sys.argv[-1], start=1, end=1, evaluation_mode="VIEWPORT")
