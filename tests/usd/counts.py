"""Prints for every USD file given, as JSON, what usd-core finds in it: curves, control points, sigma_a as bits, what usdchecker says.

Run it on a folder of files to make the table in tests/usd.rs:  python counts.py FOLDER/*.usd*
"""
import json
import struct
import sys

from pxr import Usd, UsdGeom


def complaints(path, stage):
    """What usdchecker has to say: errors, by the checks that this usd-core has."""
    try:
        from pxr import UsdValidation
    except ImportError:
        from pxr import UsdUtils

        checker = UsdUtils.ComplianceChecker()
        checker.CheckCompliance(path)
        return checker.GetErrors() + checker.GetFailedChecks()
    registry = UsdValidation.ValidationRegistry()
    validators = [v for m in registry.GetAllValidatorMetadata() if not m.isSuite for v in [registry.GetOrLoadValidatorByName(m.name)] if v]
    assert len(validators) > 5
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    bad = [e for e in errors if e.GetType() == UsdValidation.ValidationErrorType.Error]
    return [f"{e.GetName()}: {e.GetMessage()}" for e in bad]


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
    out[path] = {"curves": curves, "points": points, "sigma_a": sigma_a, "complaints": complaints(path, stage)}
print(json.dumps(out))
