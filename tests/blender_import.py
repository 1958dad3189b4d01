"""Imports a .usda into Blender (pip install bpy) and prints, as JSON, the curves, points and attributes that it sees."""
import json
import sys

import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=sys.argv[-1], import_curves=True, attr_import_mode="ALL")
answer = {"blender": bpy.app.version_string, "objects": {}}
for thing in bpy.data.objects:
    data = thing.data
    if data is None or not hasattr(data, "curves"):
        continue
    attributes = {a.name: [a.domain, a.data_type, len(a.data)] for a in data.attributes}
    radius = data.attributes.get("radius")
    dye = data.attributes.get("balayage:sigma_a")
    answer["objects"][thing.name] = {
        "type": thing.type,
        "curves": len(data.curves),
        "points": len(data.points),
        "attributes": attributes,
        "first_radius": radius.data[0].value if radius else None,
        "first_sigma_a": list(dye.data[0].vector) if dye else None,
    }
print(json.dumps(answer))
