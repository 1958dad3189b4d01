"""Prints for every USD file given, as JSON, what usd-core finds in it: curves, control points, sigma_a as bits."""
import json
import struct
import sys

from pxr import Usd, UsdGeom

out = {}
for path in sys.argv[1:]:
    stage = Usd.Stage.Open(path)
    curves = points = 0
    sigma_a = []
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.BasisCurves):
            basis = UsdGeom.BasisCurves(prim)
            time = Usd.TimeCode.Default()
            value = basis.GetPointsAttr().Get(time)
            if value is None:
                time = Usd.TimeCode.EarliestTime()
                value = basis.GetPointsAttr().Get(time)
            points += len(value or [])
            curves += len(basis.GetCurveVertexCountsAttr().Get(time) or [])
            primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar("balayage:sigma_a")
            if primvar and primvar.HasValue():
                assert primvar.GetInterpolation() == "vertex"
                for sigma in primvar.Get():
                    sigma_a += struct.unpack("3I", struct.pack("3f", *sigma))
    out[path] = {"curves": curves, "points": points, "sigma_a": sigma_a}
print(json.dumps(out))
